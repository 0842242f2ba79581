"""Series over a whole run: extrema, zeros, averages, none lost between samples."""

from itertools import pairwise

import numpy
import pytest

from tt_precise.claims import evidence
from tt_precise.claims.evidence import reference_series as series

KICKED = "kicked"


def test_zeros_are_those_of_the_event() -> None:
    events = [float(t) for t in evidence.times_of("nu_y_zero")["t"]]
    found = series.zeros("nu_y")
    assert len(found) == len(events)
    assert numpy.abs(numpy.array(found) - events).max() < 1e-11


def test_rises_and_falls_make_the_difference() -> None:
    span = series.Span(1.0, 5.0)
    rise, fall = series.rises_and_falls("g_n", span=span)
    first, last = series.columns(["g_n"], list(span))["g_n"]
    assert rise > abs(last - first)
    assert rise - fall == pytest.approx(last - first, abs=1e-12)


def test_average_rate_is_the_difference_over_the_time() -> None:
    for rate, whole in (("E_dot", "E"), ("E_trans_dot", "E_trans"), ("omega_3_dot", "omega_3")):
        span = series.whole()
        first, last = series.columns([whole], list(span))[whole]
        # Gauss's rule leaves 1e-13 of E; rounding of omega_3 is of the same order
        assert series.mean(rate) * span.length == pytest.approx(last - first, rel=1e-11)


def test_share_below_zero_is_that_of_a_fine_grid() -> None:
    times = numpy.linspace(0, 8, 40_001)
    rough = (series.columns(["tau_y"], list(times))["tau_y"] < 0).mean()
    assert series.share_below_zero("tau_y") == pytest.approx(rough, abs=2e-4)


def test_closed_in_extreme_is_that_of_the_event() -> None:
    settled = series.extreme("nu_y", largest=True)
    when, value = series.extreme_of(lambda c: c["nu_y"], ["nu_y"], largest=True)
    times, values = series.extrema("nu_y")
    assert value == pytest.approx(float(settled.value), rel=1e-14)
    # where the value is flat the time has half the digits
    assert when == pytest.approx(times[values.argmax()], abs=1e-7)
    assert settled.digits >= 12


def test_extreme_at_an_end_is_the_value_there() -> None:
    settled = series.extreme("E", largest=True)
    assert float(settled.value) == pytest.approx(float(evidence.at("E", "0").value), rel=1e-15)


def test_the_spike_is_in_the_course_and_not_in_samples() -> None:
    course = series.course(("phi_dot",), every=0.01)
    sampled = series.columns(["phi_dot"], [0.01 * k for k in range(801)])
    assert abs(course["phi_dot"]).max() > 20_000
    assert abs(sampled["phi_dot"]).max() < 10_000


def test_least_in_each_nutation_is_below_a_grid_and_above_the_whole() -> None:
    spans = series.nutations(span=series.Span(4.0, 5.0))
    least = series.least_in(spans, "nu_x")
    for span, value in zip(spans, least, strict=True):
        grid = series.columns(["nu_x"], list(numpy.linspace(*span, 50)))["nu_x"]
        assert value <= grid.min() < value + 1e-3
    assert min(least) > series.extrema("nu_x")[1].min()


def test_nutations_follow_each_other() -> None:
    spans = series.nutations(KICKED)
    assert len(spans) > 100
    assert all(a.end == b.begin for a, b in pairwise(spans))
