"""The smallest normal force of a step: no peak is missed, and none depends on its company."""

from typing import Any

import numpy
import pytest

from tests.sweeps.test_step_polynomials import height_columns
from tt_precise.sweeps import min_normal_force
from tt_precise.sweeps.axis_height import bounds
from tt_precise.sweeps.min_normal_force import (
    EQUAL_PEAKS,
    lowest_states,
    lowest_steps,
    may_be_lowest,
    reaches,
)

ORDER = 21
WIDTHS = numpy.array([0.1, 0.5, 2.0])


def heights(*curvatures: Any) -> Any:
    """Series whose second derivatives on [0, 1] have these coefficients, a row of each."""
    found = numpy.zeros((len(curvatures), ORDER + 1))
    for row, given in enumerate(curvatures):
        power = numpy.arange(len(given))
        found[row, 2 : 2 + len(given)] = numpy.array(given) / ((power + 1) * (power + 2))
    return found


def steps(series: Any, width: float = 1.0) -> tuple[Any, Any]:
    """Steps with k.z alone, as the second of two entries, the first is the time since; lengths."""
    time = numpy.zeros_like(series)
    time[:, 1] = 1
    found = numpy.stack([time, series * width ** -numpy.arange(ORDER + 1.0)])
    return found.swapaxes(1, 2).copy(), numpy.full(len(series), width)


def peaks(series: Any) -> Any:
    return lowest_states(*steps(series), numpy.arange(len(series)), 1)[0][:, 0]


def by_roots(given: Any) -> float:
    """The largest value on [0, 1], by NumPy's roots of the derivative."""
    polynomial = numpy.polynomial.Polynomial(given)
    roots = polynomial.deriv().roots()
    inside = roots.real[(abs(roots.imag) < 1e-6) & (roots.real > 0) & (roots.real < 1)]
    return float(max(polynomial(x) for x in (0.0, 1.0, *inside)))


def test_random_polynomials_are_largest_where_their_roots_say() -> None:
    draws = numpy.random.default_rng(1)
    given = draws.normal(size=(300, 19)) * draws.choice([0.1, 1, 10], size=(300, 19))
    for row, place in zip(given, peaks(heights(*given)), strict=True):
        value = numpy.polynomial.Polynomial(row)(place)
        assert value == pytest.approx(by_roots(row), rel=1e-13, abs=1e-13)


@pytest.mark.parametrize(
    ("curvature", "place"),
    [
        ([1.0], 0),
        ([0.0], 0),
        ([0, 1.0], 1),
        ([0, -1.0], 0),
        ([0, 1, -1.0], 0.5),
        ([-0.09, 0.6, -1.0], 0.3),
        # two peaks, x (1 - x) ((x - 1/2)^2 + tilt x): the higher one is found on either side
        (numpy.polymul([-1, 1, 0], [1, -1.1, 0.25])[::-1], None),
        (numpy.polymul([-1, 1, 0], [1, -0.9, 0.25])[::-1], None),
    ],
)
def test_peaks_of_known_polynomials(curvature: Any, place: float | None) -> None:
    (found,) = peaks(heights(curvature))
    if place is not None:
        assert found == pytest.approx(place, abs=1e-7)  # the root of eps
    value = numpy.polynomial.Polynomial(curvature)(found)
    assert value == pytest.approx(by_roots(curvature), rel=1e-14)


def test_without_halving_a_peak_is_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(min_normal_force, "HALVINGS", 0)
    assert peaks(heights([0, 1, -1.0]))[0] in (0, 1)


def test_company_does_not_change_a_bit() -> None:
    given = heights(*numpy.random.default_rng(2).normal(size=(40, 19)))
    owner = numpy.arange(40)
    together, _ = lowest_states(*steps(given, 0.3), owner, 1)
    alone = [lowest_states(*steps(given[[row]], 0.3), owner[:1], 1)[0][0] for row in owner]
    assert numpy.array_equal(together, numpy.array(alone))


def test_no_steps_have_no_states() -> None:
    assert lowest_states(*steps(heights()), numpy.arange(0), 1)[0].size == 0


def test_of_many_equal_peaks_the_highest_few_stay() -> None:
    tops = numpy.random.default_rng(4).permutation(50)
    given = steps(heights(*[[0.0, 4 * top, -4.0 * top] for top in tops]))
    assert list(lowest_steps(*given, 1)) == list(numpy.flatnonzero(tops >= 50 - EQUAL_PEAKS))
    owner = numpy.arange(50) // 25
    states, owners = lowest_states(*given, owner, 1)
    assert list(owners) == [0] * EQUAL_PEAKS + [1] * EQUAL_PEAKS
    assert numpy.allclose(states[:, 0], 0.5, atol=1e-7)


def may_be(series: Any, widths: Any, owner: Any, highest: Any) -> Any:
    read = bounds(height_columns(series, widths))
    return may_be_lowest(read, widths, owner, highest)


def test_only_steps_that_may_be_the_lowest_stay() -> None:
    low, peak, high = [0.0, 0.1], [0, 4, -4.0], [0.5, 0.2]  # largest: 0.1, 1 in the middle, 0.7
    series = heights(low, peak, high)[:, :, None]
    highest = numpy.array([-numpy.inf])
    step, lane, ceiling = may_be(series, numpy.ones((3, 1)), numpy.zeros((3, 1), int), highest)
    assert highest == pytest.approx(0.7)  # at an end; the peak is looked for later
    assert list(step) == [1, 2]
    assert list(lane) == [0, 0]
    assert ceiling[0] >= 1
    assert not reaches(ceiling[1], 1.0)


def test_steps_that_were_not_taken_do_not_count() -> None:
    series = heights([5.0], [numpy.nan], [1.0])[:, :, None]
    highest = numpy.array([-numpy.inf])
    widths = numpy.array([[0.0], [1.0], [1.0]])
    step, _, _ = may_be(series, widths, numpy.zeros((3, 1), int), highest)
    assert list(step) == [2]
    assert highest == [1.0]


def test_what_overflows_does_not_count() -> None:
    """Each coefficient is finite, their sum is not."""
    series = heights([1e308] * 19, [1.0])[:, :, None]
    highest = numpy.array([-numpy.inf])
    step, _, _ = may_be(series, numpy.ones((2, 1)), numpy.zeros((2, 1), int), highest)
    assert list(step) == [1]
    assert highest == [1.0]


def test_owners_are_separate() -> None:
    """Two lanes; in the second one another row begins."""
    series = numpy.stack([heights([2.0], [1.0]), heights([1.0], [3.0])], axis=2)
    highest = numpy.full(3, -numpy.inf)
    step, lane, _ = may_be(series, numpy.ones((2, 2)), numpy.array([[0, 1], [0, 2]]), highest)
    assert list(highest) == [2, 1, 3]
    assert sorted(zip(lane.tolist(), step.tolist(), strict=True)) == [(0, 0), (1, 0), (1, 1)]


def test_widths_scale_the_series() -> None:
    for width in WIDTHS:
        ((time, _),), _ = lowest_states(*steps(heights([0, 1, -1.0]), width), numpy.zeros(1), 1)
        assert time == pytest.approx(width / 2, rel=1e-7)
