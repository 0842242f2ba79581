"""The fewest digits over rows that were measured, in whatever blocks they come."""

from __future__ import annotations

import numpy
import pytest

from tt_precise.golden.fewest import FewestDigits
from tt_precise.golden.measuring import Measured

NAN = numpy.nan


def measured(t: list[float], **columns: list[tuple[float, float]]) -> Measured:
    """Columns as (error, bound) for each row; what is NaN in all of them was not compared."""
    errors = {name: numpy.array([e for e, _ in rows]) for name, rows in columns.items()}
    bounds = {name: numpy.array([b for _, b in rows]) for name, rows in columns.items()}
    compared = ~numpy.all([numpy.isnan(one) for one in errors.values()], axis=0)
    times = numpy.array(t)
    return Measured(times, errors, bounds, compared, times == 0)


def taken(*blocks: Measured) -> FewestDigits:
    found = FewestDigits()
    for block in blocks:
        found.add(block)
    return found


START = (0.0, 0.0)
ROWS = [START, (1e-3, 0.0), (NAN, NAN), (1e-5, 1e-4), (1e-7, 0.0)]


@pytest.mark.parametrize("cut", range(6))
def test_the_largest_error_that_is_not_within_its_bound_counts(cut: int) -> None:
    t = [0.0, 1.0, 2.0, 3.0, 4.0]
    other = [START, (1e-6, 0.0), (NAN, NAN), (1e-9, 1e-4), (1e-8, 0.0)]
    found = taken(
        measured(t[:cut], kx=ROWS[:cut], ky=other[:cut]),
        measured(t[cut:], kx=ROWS[cut:], ky=other[cut:]),
    )
    assert found.digits == {"kx": pytest.approx(3), "ky": pytest.approx(6)}
    assert found.worst == pytest.approx(3)
    assert found.at == 1.0
    assert (found.rows, found.exactly) == (4, 2)


def test_where_most_rows_lie_between_there_are_at_least_so_many() -> None:
    """What the comparison itself cannot resolve limits what it can vouch for."""
    between = [(1e-9, 1e-5)] * 3
    few = measured([0.0, 1.0, 1.5, 1.6], kx=[START, (1e-7, 0.0), *between[:2]])
    assert (few.compared.sum(), taken(few).exactly) == (4, 1)
    assert taken(few).digits == {"kx": pytest.approx(5)}  # 4 rows, of which 2 at golden times
    exact = measured([0.0, 1.0, 2.0], kx=[START, (1e-7, 0.0), (1e-8, 0.0)])
    one = measured([2.5], kx=between[:1])
    assert taken(exact, one).digits == {"kx": pytest.approx(7)}  # most are: the bound is no matter
    assert taken(exact, one, measured([2.6, 2.7, 2.8], kx=between)).digits["kx"] == pytest.approx(5)


def test_a_row_counts_as_exact_if_any_of_its_columns_is() -> None:
    found = taken(measured([1.0, 2.0], kx=[(1e-7, 0.0), (NAN, NAN)], ky=[(NAN, NAN), (1e-7, 0.0)]))
    assert (found.rows, found.exactly) == (2, 2)


def test_the_start_counts_as_a_row_and_not_as_evidence() -> None:
    found = taken(measured([0.0], kx=[START]))
    assert (found.rows, found.exactly, found.at) == (1, 0, 0.0)
    assert found.digits == {"kx": 34}


def test_of_equal_errors_the_first_is_named() -> None:
    found = taken(measured([1.0, 2.0], kx=[(1e-3, 0.0)] * 2), measured([3.0], kx=[(1e-3, 0.0)]))
    assert found.at == 1.0


def test_a_column_without_a_number_has_no_digits() -> None:
    found = taken(measured([1.0], kx=[(1e-3, 0.0)], phi_dot=[(NAN, NAN)]))
    assert list(found.digits) == ["kx"]
    assert taken(measured([1.0], kx=[(NAN, NAN)])).at is None
