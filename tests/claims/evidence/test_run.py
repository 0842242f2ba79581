"""A run as evidence: settled values, extrema that none misses, and what proofs say about it."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
import pandas
import pytest

from tests.conftest import more
from tt_precise.claims import judge
from tt_precise.claims.evidence import run
from tt_precise.claims.evidence.run import (
    FINE,
    REFERENCE,
    Run,
    Span,
    _vertex,
    exact,
    number_between,
    precession,
    proofs_of,
    reversal,
    sign_of_precession,
    variant,
)
from tt_precise.golden import proofs, store
from tt_precise.golden.proofs import PROOF, Interval
from tt_precise.integration import integrate
from tt_precise.mechanics.quantities import QUANTITIES, Quantity

SHORT = Run(variant(until="0.3"))


def test_confirmed_digits_are_those_of_a_finer_run() -> None:
    value = SHORT.at("theta", "0.25")
    assert value.digits >= 20
    finer = integrate(SHORT.loaded, "mp", bits=160).at("0.25").theta
    assert abs(value.value - finer) < abs(finer) * 10**-28
    assert 8 < SHORT.least("g_n").digits < 18  # against double


@pytest.mark.slow
def test_fine_values_are_those_of_quad() -> None:
    """More digits than are ever printed, at the end and on the way; and the same events."""
    fine, quad = (REFERENCE.trajectory(name) for name in (FINE, "quad"))
    assert fine.event_counts == quad.event_counts
    for name in ("theta", "phi_dot", "E"):
        for t in (quad.t_end, quad.t_end / 3):
            value, other = (exact(run, name, str(t))[0] for run in (fine, quad))
            assert abs(value - other) < abs(other) * 10**-22


def test_extrema_are_not_missed_between_samples() -> None:
    least = SHORT.extrema("g_n")[1].min()
    sampled = SHORT.sampled(("g_n",), "0.0001")["g_n"].min()
    assert least <= sampled
    assert least == pytest.approx(sampled, rel=1e-4)


def test_rises_and_falls_make_the_difference() -> None:
    span = Span(1.0, 5.0)
    rise, fall = REFERENCE.rises_and_falls("g_n", span=span)
    first, last = REFERENCE.column("g_n", span)
    assert rise > abs(last - first)
    assert rise - fall == pytest.approx(last - first, abs=1e-12)


@pytest.mark.parametrize("whole", ["E", "E_trans", "omega_3"])
def test_average_rate_is_the_difference_over_the_time(whole: str) -> None:
    span = REFERENCE.whole
    first, last = REFERENCE.column(whole, span)
    # Gauss's rule leaves 1e-13 of E; rounding of omega_3 is of the same order
    assert REFERENCE.mean(f"{whole}_dot") * span.length == pytest.approx(last - first, rel=1e-11)


def test_share_below_zero_is_that_of_a_fine_grid() -> None:
    grid = (REFERENCE.column("tau_y", numpy.linspace(0, 8, 40_001)) < 0).mean()
    assert REFERENCE.share_below_zero("tau_y") == pytest.approx(grid, abs=2e-4)


@pytest.mark.parametrize("until", ["0.1", "0.3"])  # doubles behind and before the decimal
def test_the_end_of_a_run_is_a_sample(until: str) -> None:
    times = Run(variant(until=until)).sampled(["theta"])["t"]
    assert len(times) == 1000 * float(until) + 1
    assert times.iloc[-1] == float(until)


def test_a_quantity_made_for_a_claim_has_the_extreme_and_the_zeros_of_the_event() -> None:
    own = Quantity.of(lambda q: QUANTITIES["nu_y"].evaluate(q), "m/s")
    when, value = REFERENCE.extremum(own, largest=True)
    confirmed = REFERENCE.extreme("nu_y", largest=True)
    assert confirmed.digits >= 18
    assert value == pytest.approx(float(confirmed), rel=1e-14)
    assert when == pytest.approx(REFERENCE.extremum("nu_y", largest=True)[0], abs=1e-12)
    assert REFERENCE.zeros(own) == pytest.approx(REFERENCE.zeros("nu_y"), abs=1e-11)
    # at an end it is the value there
    first = float(REFERENCE.at("E", "0"))
    assert float(REFERENCE.extreme("E", largest=True)) == pytest.approx(first, rel=1e-15)


def test_a_vertex_is_the_same_from_each_point_near_it() -> None:
    fine, (times, values) = SHORT.trajectory(FINE), SHORT.extrema("theta_dot")
    t = times[1 + values[1:-1].argmax()]
    at, near = (_vertex(fine, "theta_dot", moment) for moment in (t, t + 2**-30))
    assert abs(near / at - 1) < 1e-25


def test_the_band_has_no_width_next_to_a_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between turning points that are further apart than nutations the top does not nutate."""
    times, angles = [0.0, 0.04, 0.08, 0.5, 0.54, 0.58], [0.0, 0.2, 0.1, 0.9, 0.7, 0.9]
    monkeypatch.setattr(Run, "turning_points", pandas.DataFrame({"t": times, "theta": angles}))
    band = Run().band
    assert [point.t for point in band] == [0.04, 0.54]
    assert [point.width for point in band] == pytest.approx([0.15, 0.2])
    assert [point.middle for point in band] == pytest.approx([0.125, 0.8])


def test_nutations_and_the_least_in_each() -> None:
    spans = REFERENCE.nutations(span=Span(4.0, 5.0))
    assert all(a.end == b.begin for a, b in pairwise(spans))
    for span, value in zip(spans, REFERENCE.least_in(spans, "nu_x"), strict=True):
        grid = REFERENCE.column("nu_x", numpy.linspace(*span, 50))
        assert value <= grid.min() < value + 1e-3


@pytest.mark.parametrize("id", ["NUM-20", more("NUM-04")])
@pytest.mark.parametrize(
    ("old", "new"), [('"g_n_positive": true', '"g_n_positive": false'), (None, None)]
)
def test_a_claim_is_proved_with_its_proof_only(
    id: str, old: str, new: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the proof, or with an edited one, the computed verdict stands."""
    assert judge(id).proved
    file = shutil.copytree(store.home() / "reference", tmp_path / "reference") / PROOF
    if old:
        file.write_text(file.read_text().replace(old, new))
    else:
        file.unlink()
    monkeypatch.setattr(store, "home", lambda: tmp_path)
    proofs_of.cache_clear()
    judged = judge(id)
    why = proofs_of("reference").why
    proofs_of.cache_clear()
    assert (judged.proved, judged.verdict) == (False, "rounded")
    assert (f"{PROOF}: " if old else "golden certify reference") in why


def test_an_interval_that_is_too_wide_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    wide = Interval(Fraction("0.001"), Fraction("0.009"))
    monkeypatch.setattr(proofs.Established, "potential_energy", lambda *_: wide)
    judged = judge("NUM-20")
    assert (judged.proved, judged.verdict) == (False, "rounded")


def span(low: float, high: float) -> Interval:
    return Interval(Fraction(low), Fraction(high))


def event(phi_dot: float, begin: float, end: float | None = None) -> dict[str, Interval]:
    return {"t": span(begin, end or begin), "phi_dot": span(phi_dot, phi_dot)}


@pytest.fixture
def establish(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Proofs of these events, of a climb that begins in (1, 1.5) and ends in (5, 5.5)."""
    climb = {"t_init": span(1, 1.5), "t_end": span(5, 5.5)}

    def establish(**events: Any) -> None:
        known = SimpleNamespace(events=events.get, moment=lambda _, which: climb[which])
        monkeypatch.setattr(run, "proofs_of", lambda _: known)

    return establish


@pytest.mark.parametrize(
    ("zeros", "equator", "sign"),
    [
        ([(0.5,), (6,)], (2, 3), 1),
        ([(0.5,), (6,)], (-2, 3), -1),
        ([(0.5,), (6,)], (0, 3), 0),  # no sign
        ([(0.5, 1.25)], (2, 3), 0),  # a zero that may lie in the climb
        ([(5.25, 6)], (2, 3), 0),
        ([(4,)], (2, 3), 0),
        ([], (2, 1.25, 3), 0),  # an equator that may lie before the climb, or after it
        ([], (2, 3, 5.25), 0),
        (None, (2, 3), 0),
    ],
)
def test_the_sign_of_the_precession_needs_a_climb_without_zeros(
    establish: Callable[..., None], zeros: Any, equator: tuple[float, ...], sign: int
) -> None:
    known = None if zeros is None else [event(0, *zero) for zero in zeros]
    establish(phi_dot_zero=known, equator=[event(*equator)])
    assert sign_of_precession("any") == sign


@pytest.mark.parametrize(
    ("turns", "expected"),
    [
        ([(-3, 0.5), (-7, 0.75), (9, 2), (5, 3)], [-7, 9]),
        ([(-7, 0.75), (8, 1.25), (9, 2)], [None, None]),  # on which side of the moment?
        ([(-7, 0.75), (8, 0.8, 1.25), (9, 2)], [None, None]),
        ([(-7, 0.75), (8, 1.25, 2), (9, 3)], [None, None]),
        ([(-7, 0.75)], [None, None]),
        ([(9, 2)], [None, None]),
    ],
)
def test_a_reversal_needs_turning_points_that_are_surely_before_and_after(
    establish: Callable[..., None], turns: list[tuple[float, ...]], expected: list[float | None]
) -> None:
    establish(theta_min=[event(*turn) for turn in turns])
    pair = reversal("any", "theta_min", "t_init")
    assert [phi_dot and phi_dot.low for phi_dot in pair] == expected


def test_the_precession_at_the_begin_is_that_of_the_only_event_there(
    establish: Callable[..., None],
) -> None:
    establish(Lk_equals_Lz=[event(70, 0.5), event(80, 1.25)])
    (phi_dot, *_) = precession("any")
    assert phi_dot is not None
    assert phi_dot.low == phi_dot.high == 80
    establish(Lk_equals_Lz=[event(70, 0.5, 1), event(80, 1.25)])
    assert precession("any")[0] is None


@pytest.mark.parametrize(
    ("low", "high", "number"), [("0.5", "3.5", (3, 3)), ("1.05", "3.05", (1, 3))]
)
def test_enclosed_events_are_counted_surely_and_possibly(
    low: str, high: str, number: tuple[int, int]
) -> None:
    events = [{"theta": Interval(Fraction(k), k + Fraction(1, 10))} for k in range(1, 5)]
    assert tuple(map(int, number_between(events, "theta", Fraction(low), Fraction(high)))) == number
