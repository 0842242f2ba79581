"""Rows against the true ones at their times: errors count by the size of their column."""

from decimal import Decimal
from typing import Any

import numpy
import pytest

from tt_precise.golden import measuring
from tt_precise.golden.digits import EXACTLY
from tt_precise.golden.measuring import RowDistances, TrueRows
from tt_precise.golden.store import read_files
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState

ROWS = numpy.array([40, 100, 250])
ERROR = 1e-6
VECTORS = NewtonState._fields


@pytest.mark.parametrize("name", ["kz", "Lz", "Lx", "vy"])
def test_a_relative_error_is_found_as_it_was_made(name: str) -> None:
    stored = read_files("reference")
    true = TrueRows.of_table(stored.scene, stored.trajectory)
    rows = {one: numpy.array(stored.trajectory.floats(one))[ROWS] for one in VECTORS}
    values: dict[str, Any] = {one: rows[one].copy() for one in VECTORS}
    values[name] += ERROR * sizes(stored.scene.body.numbers(float), rows, numpy)[name]
    found = true.measure(
        true.times[ROWS],
        values,
        lambda row, names: [repr(float(values[one][row])) for one in names],
    )
    assert found.compared.all()
    assert not found.start.any()
    assert found.errors[name] == pytest.approx([ERROR] * len(ROWS), rel=1e-3)
    assert (found.worst() == found.errors[name]).all()
    for other in set(values) - {name}:
        assert (found.errors[other] <= numpy.fmax(found.bounds[other], 1e-15)).all()
    between = true.measure(true.times[ROWS] + 0.003, values, lambda row, names: [])
    assert not between.compared.any()


@pytest.mark.parametrize(("wrong", "digits"), [("0", 33), ("1e-25", 24)])
def test_whole_turns_of_an_angle_cost_no_digit(wrong: str, digits: int) -> None:
    stored = read_files("track")
    true = TrueRows.of_table(stored.scene, stored.trajectory)
    turns = EXACTLY.multiply(measuring.REVOLUTION, 3)
    cells = [
        str(EXACTLY.add(EXACTLY.subtract(Decimal(cell), turns), Decimal(wrong)))
        for cell in stored.trajectory.column("phi")
    ]
    values = {"phi": numpy.array(cells, float)}
    measured = true.measure(true.times, values, lambda row, names: [cells[row]])
    assert digits <= measured.digits()["phi"].min() < digits + 2


NAN = numpy.nan


def measured(t: list[float], **columns: list[tuple[float, float]]) -> RowDistances:
    """Columns as (error, bound) for each row; what is NaN in all of them was not compared."""
    errors = {name: numpy.array([e for e, _ in rows]) for name, rows in columns.items()}
    bounds = {name: numpy.array([b for _, b in rows]) for name, rows in columns.items()}
    compared = ~numpy.all([numpy.isnan(one) for one in errors.values()], axis=0)
    times = numpy.array(t)
    return RowDistances(times, errors, bounds, compared, times == 0)


START = (0.0, 0.0)


def test_the_largest_error_that_is_not_within_its_bound_counts() -> None:
    t = [0.0, 1.0, 2.0, 3.0, 4.0]
    rows = [START, (1e-3, 0.0), (NAN, NAN), (1e-5, 1e-4), (1e-7, 0.0)]
    other = [START, (1e-6, 0.0), (NAN, NAN), (1e-9, 1e-7), (1e-8, 0.0)]
    found = measured(t, kx=rows, ky=other)
    assert found.fewest() == {"kx": pytest.approx(3), "ky": pytest.approx(6)}
    assert found.at == 1.0
    assert found.compared.sum() == 4


def test_what_the_comparison_cannot_resolve_limits_the_digits() -> None:
    few = measured([0.0, 1.0, 1.5, 1.6], kx=[START, (1e-7, 0.0), *[(1e-9, 1e-5)] * 2])
    assert few.fewest() == {"kx": pytest.approx(5)}
    exact = measured([0.0, 1.0, 2.0], kx=[START, (1e-7, 0.0), (1e-8, 0.0)])
    assert exact.fewest() == {"kx": pytest.approx(7)}


def test_what_counts_and_as_what() -> None:
    none, coarse, fine = (NAN, NAN), (1e-3, 0.0), (1e-7, 0.0)
    found = measured([1.0, 2.0], kx=[fine, none], ky=[none, fine])
    assert found.compared.sum() == 2
    found = measured([0.0], kx=[START])
    assert (found.compared.sum(), found.at) == (1, 0.0)
    assert found.fewest() == {"kx": 34}
    # of equal errors the first is named
    assert measured([1.0, 2.0, 3.0], kx=[coarse] * 3).at == 1.0
    # a column without a number has no digits
    assert list(measured([1.0], kx=[coarse], phi_dot=[none]).fewest()) == ["kx"]
    assert measured([1.0], kx=[none]).at is None


def test_the_remedy_for_rows_beyond_an_early_end_is_a_time_before_it() -> None:
    assert "--until 1.33," in measuring.ending("contact_lost", 1.33692)
    assert measuring.ending("landed", 0.0099999).endswith("--until 0.00999")
    assert measuring.ending("landed", 0.0).endswith("--until 0")
