"""One cell of a table changed: in a file, whose lines count from 1, or in memory, from 0."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tt_precise.golden.table import Table


def edit_cell(path: Path, line: int, column: str, change: Callable[[str], str]) -> None:
    lines = [row.split(",") for row in path.read_text().splitlines()]
    place = lines[0].index(column)
    lines[line - 1][place] = change(lines[line - 1][place])
    path.write_text("".join(",".join(row) + "\n" for row in lines))


def with_cell(table: Table, row: int, column: str, change: Callable[[str], str]) -> Table:
    place = table.columns.index(column)
    rows = [list(one) for one in table.rows]
    rows[row][place] = change(rows[row][place])
    return Table(table.columns, tuple(map(tuple, rows)))


def other_digit(cell: str, place: int) -> str:
    """A printed number with another digit at ``place``, counted from 1."""
    at = cell.index(".") + place - 1
    return f"{cell[:at]}{(int(cell[at]) + 5) % 10}{cell[at + 1 :]}"


def edit_json(
    path: Path, change: Callable[[Any], object], write: Callable[[Any], str] = json.dumps
) -> None:
    content = json.loads(path.read_text("utf-8"))
    change(content)
    text = write(content)
    assert text != path.read_text("utf-8")
    path.write_text(text, "utf-8")
