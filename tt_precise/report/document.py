"""What a report is made of: sections of text, tables, figures and cards, in no markup yet.

Sections say it once; the HTML and the Markdown are two renderings of the same blocks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Text:
    """A paragraph of plain text; ``emphasis`` marks one that must not be overlooked."""

    text: str
    emphasis: bool = False
    kind: str = "text"


@dataclass(frozen=True)
class Card:
    """One number a person sees first: a label, a value, a comment, and whether it is good."""

    label: str
    value: str
    comment: str
    good: bool | None = None


@dataclass(frozen=True)
class Cards:
    """The numbers at the top."""

    cards: Sequence[Card]
    kind: str = "cards"


@dataclass(frozen=True)
class Table:
    """A table of texts.

    ``filters`` names the columns whose values can be chosen from in the HTML; with any, the table
    is searchable too. ``verdict`` names the column whose value colours the row's mark.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    filters: Sequence[str] = ()
    verdict: str = ""
    name: str = ""
    kind: str = "table"

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.header):
                raise ValueError(f"table row: got {len(row)} cells, expected {len(self.header)}")


@dataclass(frozen=True)
class Figure:
    """A picture as SVG text; ``alt`` says in words what it shows, ``caption`` what it bears on."""

    name: str
    caption: str
    svg: str
    alt: str
    kind: str = "figure"


Block = Text | Cards | Table | Figure


@dataclass(frozen=True)
class Section:
    """A titled part of the report; ``results`` goes into results.json under ``key``."""

    key: str
    title: str
    blocks: Sequence[Block]
    results: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Report:
    """Title, opening line, sections in order, and provenance (label, value) at the foot."""

    title: str
    opening: str
    sections: Sequence[Section]
    provenance: Sequence[tuple[str, str]]

    @property
    def figures(self) -> list[Figure]:
        """All figures, in order."""
        return [b for s in self.sections for b in s.blocks if isinstance(b, Figure)]
