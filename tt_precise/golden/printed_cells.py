"""Which cells of a golden table are no printed numbers, so that nothing can be computed of them."""

from __future__ import annotations

import re

from tt_precise.golden.digits import PRINTED
from tt_precise.golden.table import Table
from tt_precise.mechanics.newton import NewtonState

_FORMS = {
    "name": re.compile(r"\w+", re.ASCII),
    "t": re.compile(rf"{PRINTED.pattern}|\d+(?:\.\d+)?", re.ASCII),
    "direction": re.compile(r"[+-]?1|0", re.ASCII),
}
# Euler columns are undefined at the poles, others nowhere
NEVER_EMPTY = {*_FORMS, *NewtonState._fields}


def misprinted(file: str, table: Table, *, empty: bool = True) -> list[str]:
    """A line for each cell that is none, in order; ``empty`` ones where there must be a number."""
    return [
        f"{file}, line {line}, {name}: got {cell[:50]!r}, expected a printed number"
        for line, row in enumerate(table.rows, start=2)
        for name, cell in zip(table.columns, row, strict=True)
        if not _FORMS.get(name, PRINTED).fullmatch(cell)
        and (cell or (empty and name in NEVER_EMPTY))
    ]
