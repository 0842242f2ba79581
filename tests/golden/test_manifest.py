"""The manifest: claims from the tables alone, and the constancy of integrals."""

from typing import Any

import mpmath
import pytest

from tt_precise.golden.manifest import WORKING_DIGITS, constancies
from tt_precise.golden.store import read_files
from tt_precise.golden.table import DIGITS, Table
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene.numerals import to_mpmath


def few(scene: str, rows: int = 12) -> Table:
    table = read_files(scene).trajectory
    return Table(table.columns, table.rows[:rows])


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", {"jellett", "jellett_euler"}),
        ("upright", {"jellett"}),  # a pole: no Euler angles
        ("rocking", {"jellett"}),  # lambda = 0
    ],
)
def test_integrals_are_constant_to_all_digits(scene: str, names: set[str]) -> None:
    constant = constancies(read_files(scene).scene, few(scene))
    assert constant.keys() & {"jellett", "jellett_euler"} == names
    assert min(constant.values()) >= DIGITS - 1


@pytest.mark.parametrize("scene", ["frictionless", "rolling", "flight"])
def test_drifts_are_those_of_mpmath_row_by_row(scene: str) -> None:
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    table, loaded = few(scene, 40), read_files(scene).scene
    body = loaded.body.numbers(lambda value: to_mpmath(value, context))
    kind: Any = LiftedState if loaded.lifts else NewtonState
    columns = [list(map(context.mpf, table.column(name))) for name in kind._fields]
    states = zip(*columns, strict=True)
    motions = [Motion(body, kind(*state), context, loaded.model) for state in states]
    constant = constancies(loaded, table)
    for integral in conserved(loaded.model, loaded.body):
        # bit by bit: both arithmetics round correctly, to the same precision
        largest = max(drift(integral, motions))
        expected = min(34.0, -float(context.log10(largest))) if largest else 34.0
        assert constant[integral.name] == pytest.approx(expected, rel=1e-15)
