"""The chapters of claims: no verdict or measured number is typed in, and verdicts are pinned."""

import ast
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.conftest import more
from tt_precise.claims import Verdict, claims, judge
from tt_precise.claims import rauch_rutstam as chapters
from tt_precise.claims.evidence.run import REFERENCE, Run, variant
from tt_precise.claims.rauch_rutstam import section23_curve
from tt_precise.claims.verdicts import committed
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import Scalar

MODULES = sorted(Path(chapters.__path__[0]).glob("[!_]*.py"))
every_module = pytest.mark.parametrize("module", MODULES, ids=[path.stem for path in MODULES])
UNITS = r"(?:s|m|rad|J|N|W|%|rad/s|m/s|rad/s\^2|degrees)"
TYPED = re.compile(
    rf"(?<![\w.^=]) ?\d+(?:\.\d+)? {UNITS}(?![\w(/])|\b(?:all|none) of (?:these|them inv|them los)"
)
# Numbers that the paper prints, or that the claim itself sets.
PRINTED = {"7.86 s", "7.87 s", "0.02 kg", "9.82 m/s", "0.3 rad", "40 rad/s", "20 s", "200 rad/s"}


def name_of(node: ast.expr) -> str:
    """The last word of a name: "Part" of ``part.Part``."""
    return ast.unparse(node).rpartition(".")[2]


def text_of(node: ast.AST) -> str:
    """The text of a string or an f-string, with {} for each value."""
    if isinstance(node, ast.JoinedStr):
        return "".join(map(text_of, node.values))
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return "{}"


def typed_into_notes(source: str) -> Iterator[str]:
    """Yield the measured values that are typed into the notes of a module."""
    for node in ast.walk(ast.parse(source)):
        _, _, note = text_of(node).partition("Note: ")
        for typed in TYPED.finditer(" ".join(note.lower().split())):
            if typed[0].strip() not in PRINTED:
                yield f"{note}: {typed[0].strip()!r}"


def verdicts_typed_in(source: str) -> list[str]:
    """Parts and claims made by hand, and names of verdicts outside of controls and rules."""
    lines, tree = [], ast.parse(source)
    declared = {
        part
        for word in ast.walk(tree)
        if isinstance(word, ast.keyword) and word.arg in ("control", "rule")
        for part in ast.walk(word.value)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and name_of(node.func) in ("JudgedClaim", "Part"):
            lines.append(f"line {node.lineno}: a verdict made by hand")
        if isinstance(node, ast.Name | ast.Attribute) and name_of(node) == "Verdict":
            lines.append(f"line {node.lineno}: Verdict")
        if isinstance(node, ast.Constant) and node.value in list(Verdict) and node not in declared:
            lines.append(f"line {node.lineno}: {node.value!r}")
    return lines


@every_module
def test_no_verdict_and_no_measured_number_in_a_note_is_typed_in(module: Path) -> None:
    source = module.read_text("utf-8")
    assert list(typed_into_notes(source)) == verdicts_typed_in(source) == []


@pytest.mark.parametrize(
    ("search", "spoiled"),
    [
        (typed_into_notes, "def f():\n    'So. Note: All of them invert.'"),
        (typed_into_notes, "'So. Note: None of these.'"),
        (typed_into_notes, "f'So. Note: It ends at 3.19\\n    s, {x}.'"),
        (verdicts_typed_in, "part.Part(holds=True, printed='a', measured='b')"),
        (verdicts_typed_in, "JudgedClaim(verdict=x, note='b')"),
        (verdicts_typed_in, "x = v.Verdict.REFUTED"),
        (verdicts_typed_in, "x = 'misprint'"),
    ],
)
def test_a_typed_verdict_or_number_is_found(
    search: Callable[[str], Iterable[str]], spoiled: str
) -> None:
    assert list(search(spoiled))


# Claims that take 0.3 s or more. Identities are proved in tests/exact as well.
DEAR = (
    "EQ-02", "EQ-03", "EQ-05", "EQ-19", "EQ-20", "EQ-21", "EQ-32", "EQ-34", "EQ-44", "EQ-49",
    "FIG-02", "FIG-12", "FIG-15", "FIG-19", "NUM-03", "NUM-04", "NUM-05", "NUM-06", "NUM-08",
    "NUM-10", "NUM-18", "NUM-31", "NUM-32", "QUAL-06", "QUAL-22", "QUAL-27", "QUAL-29",
    "SUM-03", "SUM-06", "SWP-08", "SWP-20", "SWP-24", "TH-01",
    "TH-03", "TH-07", "TH-09", "TH-11", "TH-14",
)  # fmt: skip


@every_module
@pytest.mark.parametrize("dear", [False, more(True)], ids=["", "dear"])
def test_every_verdict_and_that_of_every_control_is_pinned(module: Path, dear: bool) -> None:
    """The claims of a chapter share their evidence, so one test judges all of them.

    A verdict is pinned by ``results.json``, that of a control by the control.
    """
    report, flipped = committed(), []
    assert report is not None
    for claim in claims().values():
        if claim.group != f"{chapters.__name__}.{module.stem}" or (claim.id in DEAR) != dear:
            continue
        judged, before = judge(claim.id), report.by_id.get(claim.id)
        if before is None or (judged.verdict, judged.proved) != (before.verdict, before.proved):
            flipped.append(f"{claim.id}: {judged.verdict}, proved {judged.proved}")
        if claim.control == judged.verdict:
            flipped.append(f"{claim.id}: the control changes nothing")
        if claim.control:
            control = judge(claim.id, **claim.changes).verdict
            if control != claim.control:
                flipped.append(f"{claim.id}, control: {control}, expected {claim.control}")
        elif judged.verdict != "untestable":
            flipped.append(f"{claim.id}: can be tested, so it needs a control")
        assert judged.remark
        assert judged.printed
        assert not judged.definition.endswith(".")  # the page adds it
    assert flipped == []


def test_findings_point_to_claims_that_stand_for_themselves() -> None:
    every = claims()
    roots = {claim.finding for claim in every.values()}
    assert all(every[root].finding == root for root in roots)
    assert every["EQ-27"].finding == every["TH-19"].finding == "EQ-26"


@pytest.mark.parametrize(
    ("id", "changes"),
    [
        ("TH-15", {"run": Run(variant(phi_dot="-300"))}),  # leaves the table
        ("SWP-02", {"beyond": "300"}),  # no start is there
        ("SWP-22", {"limit": "-300"}),
    ],
)
def test_a_claim_without_evidence_is_refuted(id: str, changes: dict[str, Any]) -> None:
    assert judge(id, **changes).verdict == "refuted"


def test_what_only_falls_falls_at_every_instant() -> None:
    """The energy; each of the lengths that these claims are about goes back at times."""

    def square(q: Motion) -> Scalar:
        return QUANTITIES["E"].evaluate(q) ** 2

    for sign, holds in ((-1, True), (1, False)):
        parts = section23_curve.trend(square, "J", sign, REFERENCE, REFERENCE.climb)
        assert {part.holds for part in parts.values()} == {holds}


def test_contact_in_a_run_that_failed_is_not_contact_all_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = Run(variant(until="0.3"))
    assert judge("QUAL-15", run=run).verdict == "reproduced"
    monkeypatch.setattr(Run, "trajectory", lambda *_: SimpleNamespace(status="failed"))
    assert judge("QUAL-15", run=run).verdict == "refuted"
