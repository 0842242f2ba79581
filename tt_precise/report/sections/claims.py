"""The paper's claims: what has to be corrected first, then all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from tt_precise.claims import Judgement, Verdict, counts
from tt_precise.report.document import Section, Table, Text

URGENT = (Verdict.REFUTED, Verdict.MISPRINT, Verdict.READING)
ORDER = (*URGENT, Verdict.ROUNDED, Verdict.REPRODUCED, Verdict.UNTESTABLE)


def errata(judgements: Sequence[Judgement]) -> Section:
    """What a co-author would act on: refuted claims, misprints, claims that hang on a reading."""
    rows = [
        (one.id, str(one.verdict), one.claim.where, one.finding.printed, one.finding.measured,
         one.finding.note)
        for one in _sorted(judgements)
        if one.verdict in URGENT
    ]  # fmt: skip
    return Section(
        "errata",
        "Errata",
        [
            Text(
                "Statements of the paper that do not hold as printed: refuted ones, misprints "
                "(the note gives the corrected form), and those that hold only under a reading."
            ),
            Table(
                ("claim", "verdict", "where", "printed", "found", "note"),
                rows,
                verdict="verdict",
                name="errata-table",
            ),
        ],
    )


def all_claims(judgements: Sequence[Judgement], run: Mapping[str, Any]) -> Section:
    """Every claim with its verdict, failing ones first; ``run`` is what computed them."""
    tally = counts(judgements)
    legend = ", ".join(f"{tally[str(v)]} {v}" for v in ORDER)
    rows = [
        (one.id, one.claim.kind, str(one.verdict) + (", proved" if one.finding.proved else ""),
         one.claim.statement, one.claim.where, one.finding.printed, one.finding.measured,
         _note(one))
        for one in _sorted(judgements)
    ]  # fmt: skip
    return Section(
        "claims",
        "All claims",
        [
            Text(f"{len(judgements)} claims: {legend}."),
            *(Text(f"{verdict}: {verdict.meaning}.") for verdict in ORDER),
            Table(
                ("claim", "kind", "verdict", "statement", "where", "printed", "found", "note"),
                rows,
                filters=("kind", "verdict"),
                verdict="verdict",
                name="claims-table",
            ),
        ],
        {"counts": tally, "claims": [one.as_dict() for one in judgements], "run": run},
    )


def _sorted(judgements: Sequence[Judgement]) -> list[Judgement]:
    return sorted(judgements, key=lambda one: (ORDER.index(one.verdict), one.claim.order))


def _note(one: Judgement) -> str:
    parts = [one.finding.note]
    if one.claim.definition:
        parts.append(f"Definition: {one.claim.definition}")
    parts += [f"{name}: {verdict}, {found}" for name, verdict, found in one.finding.readings]
    return " ".join(part if part.endswith((".", "!", "?")) else part + "." for part in parts)
