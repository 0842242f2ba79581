"""The manifest: claims from the tables alone, and the constancy of integrals."""

from typing import Any

import mpmath
import pytest

from tests.golden.conftest import Small
from tt_precise.golden.manifest import WORKING_DIGITS, Constancy, constancies, derive
from tt_precise.golden.store import EVENTS, TRAJECTORY, read_files
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import CONSTANT_TO
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene.numerals import to_mpmath


def test_tables_without_computed_numbers_claim_no_digits(small: Small) -> None:
    tables = {
        TRAJECTORY: Table(("t", "kx"), (("0", "0"), ("0.01", ""))),
        EVENTS: Table(("name", "t", "kx"), ()),
    }
    assert derive(small.scene, small.scene.text, tables)["digits"] == 0


def few(scene: str, rows: int = 12) -> Table:
    table = read_files(scene).trajectory
    return Table(table.columns, table.rows[:rows])


def by_name(scene: str, table: Table) -> dict[str, Constancy]:
    return {constancy.name: constancy for constancy in constancies(read_files(scene).scene, table)}


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", {"jellett", "jellett_euler"}),
        ("upright", {"jellett"}),  # a pole: no Euler angles
        ("rocking", {"jellett"}),  # lambda = 0
    ],
)
def test_integrals_are_constant_to_all_digits(scene: str, names: set[str]) -> None:
    constant = by_name(scene, few(scene))
    assert constant.keys() & {"jellett", "jellett_euler"} == names
    assert min(each.digits for each in constant.values()) >= CONSTANT_TO


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
    constant = by_name(scene, table)
    for integral in conserved(loaded.model, loaded.body):
        # bit by bit: both arithmetics round correctly, to the same precision
        expected = Constancy.of(integral.name, drift(integral, motions), context)
        assert constant[integral.name] == expected


def test_the_worst_row_is_named() -> None:
    drifts = [mpmath.mpf(x) for x in ("0", "1e-40", "1e-20", "1e-30")]
    constancy = Constancy.of("energy", drifts, mpmath)
    assert constancy.digits == pytest.approx(20)
    assert constancy.worst_row == 2
    assert Constancy.of("energy", drifts[:2], mpmath).digits == 34
