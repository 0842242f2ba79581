"""The paper's claims: what has to be corrected first, then all of them."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import to_builtins

from tt_precise.claims import Judgement, Verdict, counts
from tt_precise.claims.committed import Committed, JudgingRun
from tt_precise.report.document import Claims, Section, Text
from tt_precise.report.entries import Entry, entry, sections

ERRATA = {
    Verdict.MISPRINT: (
        "Misprints",
        "What is printed does not hold; what stands right of the arrow does, and differs by what "
        "is marked.",
    ),
    Verdict.REFUTED: ("Refuted", "Right of the arrow: what was found instead."),
    Verdict.READING: (
        "Claims that depend on how they are read",
        "They hold under one reading of the paper's words and not under another.",
    ),
}


def entries(judgements: Sequence[Judgement]) -> list[Entry]:
    """All claims as entries, in the order of the list."""
    return [entry(one.record) for one in judgements]


def errata(judgements: Sequence[Judgement]) -> Section:
    """What a co-author would act on: misprints, refuted claims, claims that depend on a reading."""
    every = entries(judgements)
    groups = [
        Claims(
            f"{title} ({len(some)})",
            some,
            errata=True,
            about=about,
            folded=verdict is Verdict.READING,
        )
        for verdict, (title, about) in ERRATA.items()
        if (some := [one for one in every if one.verdict == verdict])
    ]
    found = sum(len(group.entries) for group in groups)
    return Section("errata", "Errata", [Text(_counted(found)), *groups])


def all_claims(judgements: Sequence[Judgement], run: JudgingRun) -> Section:
    """Every claim with its verdict, by section of the paper; ``run`` is what computed them."""
    tally, every = counts(judgements), entries(judgements)
    legend = "; ".join(f"{tally[str(one)]} {one}: {one.meaning}" for one in Verdict)
    proved = sum(one.proved for one in every)
    return Section(
        "claims",
        "All claims",
        [
            Text(f"{len(every)} claims, {proved} of them settled by a proof. {legend}."),
            *(
                Claims(title, some)
                for key, title in sections().items()
                if (some := [one for one in every if one.section == key])
            ),
        ],
        to_builtins(
            Committed(claims=tuple(one.record for one in judgements), counts=tally, run=run)
        ),
    )


def _counted(number: int) -> str:
    return (
        f"{number} statements of the paper that do not hold as they stand, one line each; a click "
        "shows the reason, the definition used, and every reading that was tried."
    )
