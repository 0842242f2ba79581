"""Series of steps: every zero is found, once, and none depends on its company."""

from typing import Any

import numpy
import pytest

from tt_precise.sweeps import step_polynomials
from tt_precise.sweeps.axis_height import bounds
from tt_precise.sweeps.step_polynomials import halves, horner, states_in, zeros

ORDER = 21


def height_columns(heights: Any, widths: Any) -> Any:
    """Columns of k.z from its series, shape (steps, order + 1, lanes), with the rates at starts."""
    coefficients = heights[:, 1:].transpose(1, 0, 2)
    rates = coefficients[:1]
    return numpy.concatenate([coefficients, widths[None], rates, rates])


def columns(*rates: Any, width: float = 1.0) -> Any:
    """Stretches of k.z whose rates on [0, 1] have these coefficients; lengths are ``width``."""
    heights = numpy.zeros((len(rates), ORDER + 1, 1))
    for row, given in enumerate(rates):
        power = numpy.arange(1, len(given) + 1)
        heights[row, power, 0] = numpy.array(given) / (power * width ** (power - 1.0))
    found = height_columns(heights, numpy.full((len(rates), 1), width))
    for row, given in enumerate(rates):
        found[-1, row, 0] = sum(given)
    return found


def found_in(given: Any) -> tuple[Any, Any, Any]:
    changes = bounds(given).changes[:, 0]
    may = numpy.flatnonzero(changes)
    owner, place, rising = zeros(given[:, may, 0], changes[may])
    return may[owner], place, rising


def by_roots(given: Any) -> list[float]:
    roots = numpy.polynomial.Polynomial(given).roots()
    real = roots.real[numpy.abs(roots.imag) < 1e-9]
    return sorted(float(one) for one in real if 0 < one < 1)


def test_random_polynomials_have_the_zeros_that_numpy_finds() -> None:
    draws = numpy.random.default_rng(1)
    given = draws.normal(size=(300, 8)) * draws.choice([0.1, 1, 10], size=(300, 8))
    owner, place, rising = found_in(columns(*given))
    for row, polynomial in enumerate(given):
        mine = owner == row
        assert place[mine] == pytest.approx(by_roots(polynomial), abs=1e-9)
        slope = numpy.polynomial.Polynomial(polynomial).deriv()
        assert list(rising[mine]) == [slope(x) > 0 for x in place[mine]]
    assert len(owner) > 100
    assert max(numpy.bincount(owner)) >= 2  # not only single ones


def test_a_pair_is_found_by_halving_only(monkeypatch: pytest.MonkeyPatch) -> None:
    close = numpy.polymul([1, -0.3], [1, -0.301])[::-1]
    _, place, rising = found_in(columns(close))
    assert place == pytest.approx([0.3, 0.301], rel=1e-12)
    assert list(rising) == [False, True]
    monkeypatch.setattr(step_polynomials, "HALVINGS", 3)
    assert len(found_in(columns(close))[0]) == 0


def test_where_newton_leads_away_it_is_bisected() -> None:
    """A steep cubic with a flat part, where the tangent points far outside."""
    flat = numpy.polymul([1, -0.9], [1, -1, 0.2501])[::-1]
    _, place, _ = found_in(columns(flat))
    assert place == pytest.approx([0.9], abs=1e-14)


def test_zeros_at_the_bounds_belong_to_one_side() -> None:
    """0 counts as positive: what falls from 0 is found at the start, what falls to 0 is not."""
    falls_from, rises_from, falls_to, rises_to = [0.0, -1], [0.0, 1], [1.0, -1], [-1.0, 1]
    owner, place, rising = found_in(columns(falls_from, rises_from, falls_to, rises_to))
    assert list(owner) == [0, 3]
    assert list(place) == [0, 1]
    assert list(rising) == [False, True]


def test_times_are_those_of_the_step() -> None:
    for width in (0.1, 0.5, 2.0):
        _, since, _ = found_in(columns([-0.3, 1.0], width=width))
        assert since == pytest.approx(0.3 * width, rel=1e-14)


def test_company_does_not_change_a_bit() -> None:
    given = columns(*numpy.random.default_rng(2).normal(size=(60, ORDER)), width=0.3)
    owner, place, _ = found_in(given)
    alone = [found_in(given[:, [row]])[1] for row in range(60)]
    assert numpy.array_equal(place, numpy.concatenate(alone))
    assert len(set(owner.tolist())) > 20
    read = bounds(given)
    for row in range(60):
        mine = bounds(given[:, [row]].copy())
        for one, other in zip(read[1:], mine[1:], strict=True):
            assert one[row] == other


def test_bounds_enclose_and_follow() -> None:
    draws = numpy.random.default_rng(3)
    given = draws.normal(size=(50, 6))
    read = bounds(columns(*given))
    x = numpy.linspace(0, 1, 101)
    for row, polynomial in enumerate(given):
        rate = numpy.polynomial.Polynomial(polynomial)
        curvature = rate.deriv()(x)
        assert read.curvature[row, 0] >= curvature.max() - 1e-12
        assert read.at_ends[row, 0] == pytest.approx(max(curvature[0], curvature[-1]), rel=1e-12)
        crossed = numpy.count_nonzero(numpy.diff(numpy.sign(rate(x))))
        assert read.changes[row, 0] >= crossed
        assert (read.changes[row, 0] - crossed) % 2 == 0
    assert read.finite.all()
    spoiled = columns(*given)
    spoiled[3, 7] = numpy.nan
    assert list(numpy.flatnonzero(~bounds(spoiled).finite)) == [7]


def test_states_are_the_polynomials() -> None:
    draws = numpy.random.default_rng(4)
    given, since = draws.normal(size=(5, 3, 7)), draws.uniform(size=5)
    flat = numpy.vstack([given.reshape(5, 21).T, since])
    found = states_in(flat, 3)
    assert found.shape == (5, 3)
    for row in range(5):
        for entry in range(3):
            expected = horner(given[row, entry], since[row])
            assert found[row, entry] == pytest.approx(expected, rel=1e-14, abs=1e-15)
    assert states_in(flat[:, :0], 3).shape == (0, 3)


def test_halves_meet() -> None:
    given = numpy.random.default_rng(5).normal(size=(4, 6))
    lower, upper = halves(given)
    assert numpy.array_equal(lower[:, 0], given[:, 0])
    assert numpy.array_equal(upper[:, -1], given[:, -1])
    assert numpy.array_equal(lower[:, -1], upper[:, 0])
