"""The content of a report without markup: sections of text, tables, figures and claims.

Sections say it once; the HTML and the Markdown are two renderings of the same blocks. Where a
block stands on the page, and what is folded, is decided by ``report.render``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from msgspec.structs import asdict

from tt_precise.claims import paper
from tt_precise.claims.committed import JudgedCheck, JudgedClaim
from tt_precise.runtime.values import Json

# a mark for each verdict, next to its colour
MARKS = {
    "reproduced": "✓", "rounded": "≈", "reading": "◐", "misprint": "M", "refuted": "✗",
    "untestable": "–",
}  # fmt: skip


class Entry(JudgedClaim, frozen=True, kw_only=True):
    """A claim whose ``section`` is a key of ``sections()``, and its ``note`` without repetitions.

    ``printed`` and ``result`` are the paper's text, and its correction or the computed result, one
    line each; ``lines`` are parts or readings, none if there is only one.
    """

    result: str
    lines: tuple[JudgedCheck, ...]

    @property
    def mark(self) -> str:
        """A sign for the verdict."""
        return MARKS[self.verdict]


def entry(claim: JudgedClaim) -> Entry:
    """The entry of a claim."""
    several = claim.form != "misprint" or claim.correction
    lines = tuple(line for line in claim.checks if line.name and several)
    printed, result = _essential(claim, lines)
    prefixes = {known.name: known.prefix for known in paper.PAPERS}
    own = {"section": prefixes[claim.paper] + claim.section, "note": claim.remark}
    return Entry(**asdict(claim) | own | {"printed": printed, "result": result, "lines": lines})


def sections() -> dict[str, str]:
    """Titles of the papers' sections by key, which are the groups on the page."""
    several = len(paper.PAPERS) > 1
    return {
        known.prefix + section.key: f"{known.name}, {section.title}" if several else section.title
        for known in paper.PAPERS
        for section in known.sections
    }


def _essential(claim: JudgedClaim, lines: Sequence[JudgedCheck]) -> tuple[str, str]:
    if claim.correction:
        return claim.printed, claim.correction
    if claim.verdict == "reading":
        holding = [line.name for line in lines if line.verdict != "refuted"]
        return claim.printed, "holds if read as: " + "; ".join(holding)
    failing = [line for line in lines if line.verdict == "refuted"]
    if claim.verdict == "refuted" and failing:
        first = failing[0]
        more = f" ({first.name})" if len(lines) > 1 else ""
        return first.printed or claim.printed, first.measured + more
    if len(lines) > 1:
        return claim.printed, f"{lines[0].measured} ({lines[0].name})"
    return claim.printed, claim.measured


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text; ``emphasis`` marks one that must not be overlooked."""

    text: str
    emphasis: bool = False
    kind: str = "text"


@dataclass(frozen=True)
class PageTable:
    """A table of texts.

    ``filters`` names the columns by which the page can filter the rows; such a table is searchable
    too. ``verdict`` names the column that colours the row's mark. ``folded``: shown only on
    request; by default this depends on the length.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    filters: Sequence[str] = ()
    verdict: str = ""
    name: str = ""
    folded: bool | None = None
    kind: str = "table"


@dataclass(frozen=True)
class Figure:
    """A picture as SVG text.

    The first sentence of ``caption`` is the title, the others are details. ``alt`` describes the
    picture.
    """

    name: str
    caption: str
    svg: str
    alt: str
    kind: str = "figure"


@dataclass(frozen=True)
class Claims:
    """Claims of the paper under a ``title``; ``errata`` shows the corrections.

    ``folded``: shown only on request.
    """

    title: str
    entries: Sequence[Entry]
    errata: bool = False
    about: str = ""
    folded: bool = False
    kind: str = "claims"


Block = Text | PageTable | Figure | Claims


@dataclass(frozen=True)
class Section:
    """A titled part of the report; ``results`` goes into results.json under ``key``."""

    key: str
    title: str
    blocks: Sequence[Block]
    results: Mapping[str, Json] = field(default_factory=dict)


@dataclass(frozen=True)
class Card:
    """A number on the first screen: its label, its value, the paper's value, and a comment.

    ``good``: whether the paper's value agrees; None if undecided.
    """

    label: str
    value: str
    paper: str
    comment: str
    good: bool | None = None


@dataclass(frozen=True)
class Overview:
    """The first screen: the verdict in a sentence, all claims at a glance, three numbers.

    ``animation`` holds the motion of the top, see ``report.overview``; None without golden data.
    """

    verdict: str
    entries: Sequence[Entry]
    cards: Sequence[Card]
    animation: Mapping[str, Json] | None
    results: Mapping[str, Json] = field(default_factory=dict)


@dataclass(frozen=True)
class Report:
    """Title, opening line, first screen, sections in order, and provenance by label."""

    title: str
    opening: str
    overview: Overview
    sections: Sequence[Section]
    provenance: Mapping[str, str]

    @property
    def figures(self) -> list[Figure]:
        """All figures, in order."""
        return [b for s in self.sections for b in s.blocks if isinstance(b, Figure)]
