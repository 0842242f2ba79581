"""How much of a trajectory must have been compared, at the bounds of what is enough."""

from __future__ import annotations

import numpy
import pytest

from tt_precise.check.evidence import ALIKE, FEWEST, HOLE, UNEVEN_HOLE, Evidence

Times = numpy.ndarray
EVERY = 0.5  # s; steps and sums of them are exact in binary


def even(rows: int, first: int = 0) -> Times:
    return EVERY * numpy.arange(first, first + rows)


def seen(*blocks: Times, lost: int = 0) -> Evidence:
    """Blocks of rows of which the last ``lost`` were not compared."""
    found = Evidence()
    left = sum(map(len, blocks)) - lost
    for block in blocks:
        compared = numpy.arange(len(block)) < left
        found.add(block, compared, block == 0)
        left -= len(block)
    return found


@pytest.mark.parametrize("cut", [0, 1, 7, 20, 21])
def test_even_rows_are_enough_in_whatever_blocks_they_come(cut: int) -> None:
    t = even(21)
    found = seen(t[:cut], t[cut:])
    assert (found.rows, found.compared, found.first, found.last) == (20, 20, 0, 10)
    assert found.lacking(10, 20) == ""


def test_the_start_vouches_for_nothing() -> None:
    assert seen(even(1)).lacking(0, 0) == "only 0 of 0 rows after the start could be compared"
    assert seen(even(2)).lacking(EVERY, 1) == ""
    assert (seen(even(5, 1)).rows, seen(even(5, 1)).compared) == (5, 5)


@pytest.mark.parametrize(("lost", "enough"), [(0, True), (2, True), (3, False)])
def test_nine_rows_of_ten_must_have_been_compared(lost: int, enough: bool) -> None:
    found = seen(even(21), lost=lost)
    assert (found.lacking(10, 20) == "") == enough
    if not enough:
        assert found.lacking(10, 20).startswith("only 17 of 20 rows after the start")


@pytest.mark.parametrize(
    ("rows", "most", "enough"),
    [(FEWEST + 1, 100, True), (FEWEST, 100, False), (FEWEST, FEWEST - 1, True), (3, 2, True)],
)
def test_ten_rows_where_golden_data_have_as_many(rows: int, most: int, enough: bool) -> None:
    t = even(rows)
    assert (seen(t).lacking(t[-1], most) == "") == enough


@pytest.mark.parametrize(("first", "enough"), [(0, True), (1, True), (2, False)])
def test_the_start_may_be_left_out_but_no_row_after_it(first: int, enough: bool) -> None:
    found = seen(even(21, first)).lacking(10, 20)
    assert found == ("" if enough else "the first row is at t = 1 s, expected the start")


def test_a_first_row_may_be_late_by_a_rounding() -> None:
    t = even(21, 1)
    for late, enough in ((0.5, True), (2.0, False)):
        t[0] = EVERY * (1 + late * ALIKE)
        assert (seen(t).lacking(10, 20) == "") == enough


@pytest.mark.parametrize(("end", "enough"), [(10.0, True), (10.49, True), (10.5, False)])
def test_the_rows_go_on_to_the_last_that_fits(end: float, enough: bool) -> None:
    found = seen(even(21)).lacking(end, 20)
    assert (found == "") == enough
    if not enough:
        assert found.startswith("the rows end at t = 10 s, expected them to go on to 10.5 s")
        assert "--until 10" in found


@pytest.mark.parametrize("cut", [0, 10, 11, 12])
@pytest.mark.parametrize(("left_out", "enough"), [(0, True), (1, False)])
def test_even_rows_have_no_hole(cut: int, left_out: int, enough: bool) -> None:
    """Also not between two blocks; named is where it is."""
    t = numpy.delete(even(41), slice(11, 11 + left_out))
    found = seen(t[:cut], t[cut:]).lacking(20, 40)
    assert found == ("" if enough else "there is no row between t = 5 and 6 s")


def test_a_hole_is_wider_than_one_and_a_half_intervals() -> None:
    for wide, enough in ((HOLE, True), (HOLE + 0.01, False)):
        t = even(41)
        t[11:] += (wide - 1) * EVERY
        assert (seen(t).lacking(float(t[-1]), 40) == "") == enough


@pytest.mark.parametrize("unit", [1.0, 2.0**-7])
@pytest.mark.parametrize(("wide", "enough"), [(UNEVEN_HOLE, True), (UNEVEN_HOLE + 0.01, False)])
def test_uneven_rows_have_no_hole_of_a_tenth_of_the_span(
    wide: float, enough: bool, unit: float
) -> None:
    steps = numpy.where(numpy.arange(64) % 2, 0.5, 1.0) * unit
    steps[40] = 0.0
    steps[40] = wide * steps.sum() / (1 - wide)
    t = numpy.concatenate(([0.0], steps.cumsum()))
    # a hair more, as the bound itself is met in roundings
    found = seen(t).lacking(float(t[-1]) * (1 + 1e-9), 64)
    assert (found == "") == enough


def test_nothing_but_a_start_far_away_is_nothing() -> None:
    found = seen(numpy.array([]), even(1, 4))
    assert (found.rows, found.first) == (1, 2)
    assert found.lacking(2, 1) == "the first row is at t = 2 s, expected the start"
