"""A run as evidence: settled values; extrema, zeros and averages with none lost between samples."""

from itertools import pairwise

import numpy
import pandas
import pytest

from tt_precise.claims.evidence.run import FINE, REFERENCE, Run, Span, _vertex, exact, variant
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
