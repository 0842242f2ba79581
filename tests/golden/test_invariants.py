"""What printed rows conserve, and in which row they do not."""

from __future__ import annotations

import pytest

from tt_precise.golden.invariants import CONSTANT_TO, Constancy, constancies
from tt_precise.golden.store import read
from tt_precise.golden.table import Table


def few(scene: str, rows: int = 12) -> Table:
    table = read(scene).trajectory
    return Table(table.columns, table.rows[:rows])


def found(scene: str, table: Table) -> dict[str, Constancy]:
    return {one.name: one for one in constancies(read(scene).scene, table)}


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", {"jellett", "jellett_euler"}),
        ("upright", {"jellett"}),  # a pole: no Euler angles
        ("rocking", {"jellett"}),  # passes through one
    ],
)
def test_what_is_conserved_is_so_to_all_digits(scene: str, names: set[str]) -> None:
    constant = found(scene, few(scene))
    assert names <= constant.keys()
    assert ("jellett_euler" in constant) == ("jellett_euler" in names)
    assert all(one.worst_row < 12 for one in constant.values())
    assert min(one.digits for one in constant.values()) >= CONSTANT_TO


@pytest.mark.parametrize(("column", "name"), [("Lz", "jellett"), ("phi_dot", "jellett_euler")])
def test_the_row_of_a_wrong_digit_is_named(column: str, name: str) -> None:
    table = few("reference")
    place = table.columns.index(column)
    rows = [list(row) for row in table.rows]
    cell = rows[7][place]
    at = cell.index(".") + 12
    rows[7][place] = f"{cell[:at]}{(int(cell[at]) + 5) % 10}{cell[at + 1 :]}"
    wrong = found("reference", Table(table.columns, tuple(map(tuple, rows))))[name]
    assert (wrong.worst_row, wrong.digits < 20) == (7, True)
