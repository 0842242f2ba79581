"""Where the blocks of a section stand on the page, and what is folded.

A section leads with its picture; beside it stand its texts and a table that fits there. Long and
wide tables, and the other pictures, are folded.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from tt_precise.report.document import Claims, Figure, PageTable, Section, Text
from tt_precise.report.entries import Entry, sections

LONGEST_ROWS = 14  # of a table that is shown unasked
LONGEST_TEXT = 480  # characters of a paragraph, likewise
BESIDE_ROWS, BESIDE_COLUMNS = 12, 3

Choices = list[tuple[str, list[tuple[str, str]]]]

_SENTENCE = re.compile(r"(?<![ (]eq)(?<!Figs)(?<!Fig)(?<!Sec)\. (?=[A-Z])")


@dataclass(frozen=True)
class Page:
    """The blocks of a section by place.

    ``texts`` are pairs: what is shown, and what of it is folded. ``choices`` are the filters of the
    section's claims.
    """

    picture: Figure | None
    texts: Sequence[tuple[Text, str]]
    beside: Sequence[PageTable]
    tables: Sequence[PageTable]
    pictures: Sequence[Figure]
    claims: Sequence[Claims]
    choices: Choices


def laid_out(section: Section) -> Page:
    """The page of a section."""
    figures = [block for block in section.blocks if isinstance(block, Figure)]
    tables = [block for block in section.blocks if isinstance(block, PageTable)]
    claims = [block for block in section.blocks if isinstance(block, Claims)]
    beside = [one for one in tables if figures and _fits_beside(one)][:1]
    entries = [entry for block in claims for entry in block.entries]
    return Page(
        picture=figures[0] if figures else None,
        texts=[_parted(block) for block in section.blocks if isinstance(block, Text)],
        beside=beside,
        tables=[one for one in tables if one not in beside],
        pictures=figures[1:],
        claims=claims,
        choices=_choices_of(entries),
    )


def folds(table: PageTable) -> bool:
    """Whether a table is shown on request only."""
    return len(table.rows) > LONGEST_ROWS if table.folded is None else table.folded


def choices(table: PageTable) -> Choices:
    """The values that a table's rows can be chosen by."""
    columns = {name: table.header.index(name) for name in table.filters}
    return [
        (name, [(value, value) for value in dict.fromkeys(row[at] for row in table.rows)])
        for name, at in columns.items()
    ]


def lead(text: str) -> str:
    """The first sentence."""
    return _SENTENCE.split(text, maxsplit=1)[0].rstrip(".") + "." if text else ""


def rest(text: str) -> str:
    """All but the first sentence."""
    return _SENTENCE.split(text, maxsplit=1)[1] if _SENTENCE.search(text) else ""


def _parted(text: Text) -> tuple[Text, str]:
    """A text and what of it is folded: the sentences beyond the first few."""
    if text.emphasis or len(text.text) <= LONGEST_TEXT:
        return text, ""
    shown, *others = _SENTENCE.split(text.text)
    while others and len(shown) + len(others[0]) < LONGEST_TEXT:
        shown += ". " + others.pop(0)
    return Text(shown + "." if others else shown), ". ".join(others)


def _fits_beside(table: PageTable) -> bool:
    return (
        not table.folded and len(table.rows) <= BESIDE_ROWS and len(table.header) <= BESIDE_COLUMNS
    )


def _choices_of(entries: Sequence[Entry]) -> Choices:
    verdicts, kinds = (
        [(value, value) for value in dict.fromkeys(getattr(one, name) for one in entries)]
        for name in ("verdict", "kind")
    )
    chapters = list(sections().items())
    return [("verdict", sorted(verdicts)), ("section", chapters), ("kind", kinds)]
