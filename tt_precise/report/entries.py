"""A claim as the report shows it: in one line, and in full."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from tt_precise.runtime.untyped import Json

# by section of the paper, which are the groups on the page
SECTIONS = {
    "1": "Section 1: the model",
    "2.1": "Section 2.1: the reference solution",
    "2.2": "Section 2.2: other starts",
    "2.3": "Section 2.3: energy, torque, potential",
    "3": "Section 3: summary",
}
_EQUATIONS = {"1": range(1, 21), "2.1": range(21, 22), "2.3": range(22, 30)}
_FIGURES = {"1": (1,), "2.1": (2, 3), "2.3": (4, 5, 6, 7), "2.2": (8,)}
# a mark for each verdict, beside its colour
MARKS = {
    "reproduced": "✓", "rounded": "≈", "reading": "◐", "misprint": "M", "refuted": "✗",
    "untestable": "–",
}  # fmt: skip
_SAID_BY_TABLE = re.compile(r" ?(?:Holds read as: .*|What fails: [^.]*\.)$")


@dataclass(frozen=True)
class Line:
    """One reading or part of a claim: its name, verdict, what is printed, what was found."""

    name: str
    verdict: str
    printed: str
    measured: str


@dataclass(frozen=True)
class Entry:
    """A claim, all as plain text.

    Attributes
    ----------
    section
        A key of ``SECTIONS``.
    printed, found
        The essential in one line: what the paper has, and what it should have or what was found.
    lines
        Readings or parts; empty where there is one thing only.
    note
        Without what ``lines`` and ``found`` say already.
    """

    id: str
    kind: str
    verdict: str
    proved: bool
    section: str
    where: str
    statement: str
    quote: str
    definition: str
    printed: str
    found: str
    corrected: bool
    lines: tuple[Line, ...]
    note: str

    @property
    def mark(self) -> str:
        """A sign for the verdict."""
        return MARKS[self.verdict]


def entry(claim: Mapping[str, Json]) -> Entry:
    """The entry of a claim, given as ``Judgement.as_dict`` gives it."""
    lines = tuple(
        Line(one["reading"], one["verdict"], "", one["measured"]) for one in claim["readings"]
    ) or tuple(
        Line(one["part"], one["verdict"], one["printed"], one["measured"]) for one in claim["parts"]
    )
    printed, found = _essential(claim, lines)
    note = claim["note"]
    if claim["correction"]:
        note = note.removeprefix(f"Should read {claim['correction']}.").strip()
    if lines:
        note = _SAID_BY_TABLE.sub("", note)
    return Entry(
        id=claim["id"],
        kind=claim["kind"],
        verdict=claim["verdict"],
        proved=claim["proved"],
        section=paper_section(claim["where"]),
        where=claim["where"],
        statement=claim["statement"],
        quote=claim["quote"],
        definition=claim["definition"],
        printed=printed,
        found=found,
        corrected=bool(claim["correction"]),
        lines=lines,
        note=note,
    )


def paper_section(where: str) -> str:
    """The section of the paper that a place lies in, such as "2.1" for "Fig. 3, caption"."""
    if found := re.search(r"Sec\. (\d(?:\.\d)?)", where):
        return "2.1" if found[1] == "2" else found[1]
    if found := re.search(r"eqs? \((\d+)\)", where):
        return next(key for key, numbers in _EQUATIONS.items() if int(found[1]) in numbers)
    if found := re.search(r"Figs? (\d)|Fig\. (\d)", where):
        number = int(found[1] or found[2])
        return next(key for key, numbers in _FIGURES.items() if number in numbers)
    return "3" if "Summary" in where else "1"


def _essential(claim: Mapping[str, Json], lines: tuple[Line, ...]) -> tuple[str, str]:
    if claim["correction"]:
        return claim["printed"], claim["correction"]
    if claim["verdict"] == "reading":
        holding = [one.name for one in lines if one.verdict != "refuted"]
        return claim["printed"], "holds read as: " + "; ".join(holding)
    failing = [one for one in lines if one.verdict == "refuted"]
    if claim["verdict"] == "refuted" and failing:
        first = failing[0]
        more = f" ({first.name})" if len(lines) > 1 else ""
        return first.printed or claim["printed"], first.measured + more
    if len(lines) > 1:
        return claim["printed"], f"{lines[0].measured} ({lines[0].name})"
    return claim["printed"], claim["measured"]
