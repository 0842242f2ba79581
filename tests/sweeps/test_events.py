"""Zeros of polynomials, and extreme values along steps: none is missed, none depends on company."""

from typing import Any

import numpy
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.sweeps import SweepSpec, events
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.events import zeros

TERMS = 22


def found_in(polynomials: Any, single: bool = False) -> Any:
    rows = numpy.atleast_2d(polynomials)
    padded = numpy.zeros((len(rows), TERMS))
    padded[:, : rows.shape[1]] = rows
    known = numpy.full(len(rows), single)
    return zeros(padded.T, padded[:, 0], padded.sum(axis=1), known)


def by_roots(polynomial: Any) -> Any:
    roots = numpy.polynomial.Polynomial(polynomial).roots()
    inside = roots.real[(abs(roots.imag) < 1e-9) & (roots.real > 0) & (roots.real < 1)]
    return numpy.sort(inside)


def test_random_polynomials_vanish_where_their_roots_say() -> None:
    draws = numpy.random.default_rng(1).normal(size=(300, 12))
    which, places, rising = found_in(draws)
    assert len(which) == len(places) > 100
    for row, polynomial in enumerate(draws):
        mine = which == row
        assert places[mine] == pytest.approx(by_roots(polynomial), abs=1e-9)
        slopes = numpy.polynomial.Polynomial(polynomial).deriv()(places[mine])
        assert ((slopes > 0) == rising[mine]).all()
        assert (found_in(polynomial)[1] == places[mine]).all()  # company does not change a bit


@pytest.mark.parametrize(
    ("roots", "places"),
    [([0.5], [0.5]), ([0.3, 0.300001, 0.7], [0.3, 0.300001, 0.7]), ([0.4, 0.4], []), ([2.0], [])],
)
def test_zeros_close_together_are_told_apart(roots: list[float], places: list[float]) -> None:
    polynomial = numpy.polynomial.polynomial.polyfromroots(roots)
    assert found_in(polynomial)[1] == pytest.approx(places, abs=1e-10)


def test_without_halving_zeros_are_missed(monkeypatch: pytest.MonkeyPatch) -> None:
    polynomial = numpy.polynomial.polynomial.polyfromroots([0.3, 0.6])
    assert len(found_in(polynomial)[0]) == 2
    monkeypatch.setattr(events, "SUBDIVISIONS", 0)
    assert len(found_in(polynomial)[0]) == 0


def test_more_events_than_memory_has_room_for_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A row of 1e6 s rocked through the pole some ten million times, which took 4.7 GB."""
    spec = SweepSpec.of("reference", vary={"phi_dot": "0,1,2"}, until="2")
    values = numpy.array([[0.0], [1.0], [2.0]])
    before = compute(spec, values, 4)
    monkeypatch.setattr(events, "MOST_EVENTS", 0)
    monkeypatch.setattr(events, "EVENTS_OF_A_ROW", 3)
    with pytest.raises(InputError, match="until: got a time in which 3 rows have more than"):
        compute(spec, values, 4)
    monkeypatch.undo()
    after = compute(spec, values, 4)
    assert numpy.array_equal(before["t_init_A"], after["t_init_A"], equal_nan=True)
    assert (before["min_g_n"] == after["min_g_n"]).all()
