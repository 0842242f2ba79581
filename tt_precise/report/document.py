"""The content of a report without markup: sections of text, tables, figures and claims.

The words stand in ``templates/words.md``. There ``# key: Title`` begins a section, whose paragraphs
have the order of the page: ``[name] caption`` places a figure, a table or a list of claims,
``> Title: text`` is folded, ``! text`` must not be overlooked. ``## name`` begins a figure: its
caption, then its description. A number in braces has its digits as in the notes of claims.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from tt_precise.claims.claim import fill
from tt_precise.claims.verdicts import JudgedClaim
from tt_precise.runtime.values import Json

# The mark of each verdict, shown with its colour.
MARKS = {
    "reproduced": "✓", "rounded": "≈", "partly": "◑", "ambiguous": "?", "misprint": "M",
    "refuted": "✗", "untestable": "–",
}  # fmt: skip
TEMPLATES = Path(__file__).parent / "templates"
_PLACED = re.compile(r"\[([\w-]+)\] ?(.*)")
_FOLDED = re.compile(r"> ([^:]+): (.*)")


@dataclass(frozen=True)
class Text:
    """A paragraph; ``emphasis``: not to be overlooked; ``folded``: the title above its fold."""

    text: str
    emphasis: bool = False
    folded: str = ""
    kind: str = "text"


@dataclass(frozen=True)
class PageTable:
    """A table of texts; ``folded``: shown only on request, by default if it is long.

    ``filters`` names the columns by which the page can filter and search the rows, ``verdict`` the
    column that colours the row's mark.
    """

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    name: str = ""
    filters: Sequence[str] = ()
    verdict: str = ""
    folded: bool | None = None
    kind: str = "table"

    @classmethod
    def of(cls, rows: Iterable[Mapping[Any, str]], **settings: Any) -> PageTable:
        """Return a table of rows that have their cells by column; a missing cell is a dash."""
        listed = list(rows)
        header = tuple(dict.fromkeys(name for row in listed for name in row))
        cells = [tuple(row.get(name, "-") for name in header) for row in listed]
        return cls(header, cells, **settings)


@dataclass(frozen=True)
class Panel:
    """A small graph: its name, its title, its facts, and the path in an SVG of 120 by 36."""

    name: str
    title: str
    facts: str
    path: str


@dataclass(frozen=True)
class Figure:
    """A picture as SVG text; ``alt`` describes it, the caption's first sentence is its title.

    The page shows the ``panels``, if there are any, instead of the picture: as many beside each
    other as the window is wide.
    """

    name: str
    svg: str
    caption: str
    alt: str
    panels: Sequence[Panel] = ()
    kind: str = "figure"

    @classmethod
    def of(
        cls, name: str, svg: str, numbers: Mapping[str, Any], panels: Sequence[Panel] = ()
    ) -> Figure:
        """Return a picture with its words, filled with ``numbers``."""
        caption, alt = (fill(text, numbers) for text in words()["##", name])
        return cls(name, svg, caption, alt, panels)


@dataclass(frozen=True)
class ClaimList:
    """Claims of the paper; ``errata`` shows the corrections, ``folded``: only on request."""

    entries: Sequence[JudgedClaim]
    title: str = ""
    about: str = ""
    errata: bool = False
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

    @classmethod
    def of(
        cls,
        key: str,
        blocks: Mapping[str, Block],
        results: Mapping[str, Json],
        **numbers: Any,
    ) -> Section:
        """Return the section of this key in the words, which place the ``blocks`` by name.

        ``numbers`` fill the texts. A paragraph without a text or a block is left out.
        """
        title, *paragraphs = words()["#", key]
        made = (_block(paragraph, blocks, numbers) for paragraph in paragraphs)
        return cls(key, title, [block for block in made if block is not None], results)

    @classmethod
    def of_figures(cls, key: str, *figures: Figure) -> Section:
        """Return the section of this key, which has figures alone."""
        return cls.of(key, {figure.name: figure for figure in figures}, {})


@dataclass(frozen=True)
class Card:
    """A number on the first screen, the paper's value, and the verdict of the claim with it."""

    label: str
    value: str
    paper: str
    comment: str
    verdict: str = ""


@dataclass(frozen=True)
class Overview:
    """The first screen: the answer, the counts, all claims, three numbers by claim, the motion."""

    cards: Mapping[str, Card]
    animation: Mapping[str, Json]
    results: Mapping[str, Json]
    answer: str = ""
    verdict: str = ""
    entries: Sequence[JudgedClaim] = ()


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


@cache
def words() -> Mapping[tuple[str, str], Sequence[str]]:
    """Return the paragraphs of ``words.md`` by level and name; a section's first is its title."""
    text = (TEMPLATES / "words.md").read_text("utf-8")
    parts = re.split(r"^(##?) ([\w-]+)(?:: (.+))?\n", text, flags=re.MULTILINE)[1:]
    entries = {}
    for level, name, title, body in zip(*(parts[i::4] for i in range(4)), strict=True):
        paragraphs = body.strip().split("\n\n")
        if not paragraphs[0].startswith("|"):  # the lines of a table stay apart
            paragraphs = [" ".join(paragraph.split()) for paragraph in paragraphs]
        entries[level, name] = [title, *paragraphs] if title else paragraphs
    return entries


def table(name: str) -> PageTable:
    """Return the table that stands in the words."""
    lines = words()["#", name][1].splitlines()
    header, _, *rows = ([cell.strip() for cell in line.split("|")[1:-1]] for line in lines)
    return PageTable(header, rows)


def _block(paragraph: str, blocks: Mapping[str, Block], numbers: Mapping[str, Any]) -> Block | None:
    if placed := _PLACED.fullmatch(paragraph):
        name, caption = placed[1], fill(placed[2], numbers)
        block = blocks.get(name)
        if isinstance(block, PageTable):
            return replace(block, name=name, caption=caption)
        if isinstance(block, ClaimList):
            title, _, about = caption.partition(": ")
            return replace(block, title=title, about=about)
        return block
    if folded := _FOLDED.fullmatch(paragraph):
        return Text(fill(folded[2], numbers), folded=folded[1])
    text = fill(paragraph.removeprefix("! "), numbers)
    return Text(text, emphasis=paragraph.startswith("! ")) if text else None
