"""What printed rows conserve, and in which row they do not."""

from __future__ import annotations

from typing import Any

import mpmath
import pytest

from tt_precise.golden.invariants import CONSTANT_TO, WORKING_DIGITS, Constancy, constancies
from tt_precise.golden.store import read
from tt_precise.golden.table import Table
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.lifted import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene.numerals import to_mpmath


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


@pytest.mark.parametrize("scene", ["reference", "frictionless", "rolling", "flight"])
def test_drifts_are_those_of_mpmath_row_by_row(scene: str) -> None:
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    table, known = few(scene, 40), read(scene).scene
    body = known.body.numbers(lambda value: to_mpmath(value, context))
    kind: Any = LiftedState if known.lifts else NewtonState
    columns = [list(map(context.mpf, table.column(name))) for name in kind._fields]
    motions = [Motion(body, kind(*row), context, known.model) for row in zip(*columns, strict=True)]
    constant = found(scene, table)
    for integral in conserved(known.model, known.body):
        drifts = drift(integral, motions)
        worst = max(range(len(drifts)), key=drifts.__getitem__)
        digits = min(34.0, float(-context.log10(drifts[worst]))) if drifts[worst] else 34.0
        # bit by bit: both arithmetics round correctly, to the same precision
        assert constant[integral.name] == Constancy(integral.name, digits, worst)
