"""The content of a report without markup: sections of text, tables, figures and claims.

HTML and Markdown are two renderings of the same blocks. ``report.render`` decides the position of a
block on the page, and which blocks are folded.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from tt_precise.claims.verdicts import JudgedClaim
from tt_precise.runtime.values import Json

# The mark of each verdict, shown with its colour.
MARKS = {
    "reproduced": "✓", "rounded": "≈", "partly": "◑", "ambiguous": "?", "misprint": "M",
    "refuted": "✗", "untestable": "–",
}  # fmt: skip


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text.

    ``emphasis`` marks one that must not be overlooked; ``folded`` is the title under which the page
    folds it.
    """

    text: str
    emphasis: bool = False
    folded: str = ""
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

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, str]], caption: str = "", **how: Any) -> PageTable:
        """A table of rows that have their cells by column; a missing cell is a dash."""
        listed = list(rows)
        header = tuple(dict.fromkeys(name for row in listed for name in row))
        cells = [tuple(row.get(name, "-") for name in header) for row in listed]
        return cls(header, cells, caption, **how)


@dataclass(frozen=True)
class Panel:
    """A small graph: its name, its title, its facts, and the path in an SVG of 120 by 36."""

    name: str
    title: str
    facts: str
    path: str


@dataclass(frozen=True)
class Figure:
    """A picture as SVG text.

    The first sentence of ``caption`` is the title, the others are details. ``alt`` describes the
    picture. The page shows the ``panels``, if there are any, instead of the picture: as many beside
    each other as the window is wide.
    """

    name: str
    caption: str
    svg: str
    alt: str
    panels: Sequence[Panel] = ()
    kind: str = "figure"


@dataclass(frozen=True)
class ClaimList:
    """Claims of the paper under a ``title``; ``errata`` shows the corrections.

    ``folded``: shown only on request.
    """

    title: str
    entries: Sequence[JudgedClaim]
    errata: bool = False
    about: str = ""
    folded: bool = False
    kind: str = "claims"


Block = Text | PageTable | Figure | ClaimList


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
    """The first screen: the answer, the counts, all claims at a glance, three numbers.

    ``animation`` holds the motion of the top, see ``report.overview``; None without golden data.
    """

    answer: str
    verdict: str
    entries: Sequence[JudgedClaim]
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
