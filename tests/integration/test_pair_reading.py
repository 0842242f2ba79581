"""Contact between rows: certain where it is far from its end, and never certain where it ends."""

import math

import numpy
import pytest

from tt_precise.integration.pair_reading import PairReading

STEP = 1.0  # of a wave with this rate, heyoka's are a fifth of it or so at any tolerance
TIMES = numpy.linspace(0, 40, 161)


def wave(lowest: float, times: numpy.ndarray = TIMES) -> PairReading:
    """A function that swings between ``lowest`` and 1, and one that stands still."""
    middle, height = (1 + lowest) / 2, (1 - lowest) / 2
    values = middle + height * numpy.cos(2 * times), -2 * height * numpy.sin(2 * times)
    still = numpy.ones_like(times), numpy.zeros_like(times)
    return PairReading(numpy.zeros_like(times), numpy.stack([*values, *still]))


@pytest.mark.parametrize("lowest", [0.02, 0.5, 1.0])
def test_contact_is_certain_where_nothing_comes_near_zero(lowest: float) -> None:
    assert wave(lowest).in_contact(TIMES, 0.2)


@pytest.mark.parametrize("lowest", [-0.3, -1e-3, 0.0])
def test_a_loss_between_two_rows_is_never_overlooked(lowest: float) -> None:
    """Also where no row shows it: every row lies some way from the minima."""
    for count in range(40, 200):
        times = numpy.linspace(0, 40, count)
        assert not wave(lowest, times).in_contact(times, 0.2)


def test_rows_too_far_apart_say_nothing() -> None:
    assert not wave(0.5).in_contact(TIMES, 0.05)
    assert not wave(0.5).in_contact(TIMES, math.nan)


def test_what_is_no_number_says_nothing() -> None:
    reading = wave(0.5)
    reading.contact[0, 7] = math.nan
    assert not reading.in_contact(TIMES, 0.2)


def test_digits_are_those_of_the_worst_entry() -> None:
    squares = numpy.array([0.25, 1e-12, 0.0, 4.0])
    found = PairReading(squares, numpy.ones((4, 4))).digits(53)
    # the first row is the start, which is exact
    assert found == pytest.approx([15.95, 6.0, 15.95, 0.0], abs=0.01)
