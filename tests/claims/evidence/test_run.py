"""A run as evidence: settled values; extrema, zeros and averages with none lost between samples."""

from fractions import Fraction
from itertools import pairwise

import numpy
import pandas
import pytest

from tt_precise.claims.evidence.run import FINE, REFERENCE, Run, Span, _vertex, exact, variant
from tt_precise.integration import integrate
from tt_precise.mechanics.quantities import QUANTITIES, Quantity

SHORT = Run(variant(until="0.3"))


def test_a_variant_changes_what_it_names_and_nothing_else() -> None:
    scene = variant(mu="0.5", phi_dot="195", until="2")
    assert [scene.body.mu, scene.start.phi_dot, scene.until] == [Fraction(1, 2), 195, 2]
    assert variant(scene, mu="0.3", phi_dot="0", until="8") == variant()


def test_settled_values_agree_with_a_finer_run() -> None:
    value = SHORT.at("theta", "0.25")
    assert value.digits >= 15
    finer = integrate(SHORT.loaded, "mp", bits=160).at("0.25").theta
    assert abs(value.value - finer) < abs(finer) * 10**-28


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["reference", "below-threshold"])
def test_fine_values_are_those_of_quad(scene: str) -> None:
    """More digits than are ever printed, at the end and on the way; and the same events."""
    fine, quad = (Run(scene).trajectory(name) for name in (FINE, "quad"))
    assert quad.precision.name == "quad" != fine.precision.name
    assert fine.event_counts == quad.event_counts
    assert max(fine.drift["jellett"], quad.drift["jellett"]) < 1e-27
    for name in ("theta", "phi_dot", "E"):
        for t in (quad.t_end, quad.t_end / 3):
            values = [
                run.frame(name, times=[str(t)], numbers="exact")[name].iloc[0]
                for run in (fine, quad)
            ]
            assert abs(values[0] - values[1]) < abs(values[1]) * 10**-22


def test_extrema_are_not_missed_between_samples() -> None:
    values = SHORT.extrema("g_n")[1]
    sampled = SHORT.sampled(("g_n",), "0.0001")["g_n"]
    assert values.min() <= sampled.min()
    assert values.min() == pytest.approx(sampled.min(), rel=1e-4)


def test_double_does_not_confirm_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """If only double is fast enough, the least value has the digits of double, not 20."""
    monkeypatch.setattr("tt_precise.claims.evidence.run.confirming_precision", lambda: "double")
    assert 8 < SHORT.least("g_n").digits < 18


def test_zeros_are_those_of_the_event() -> None:
    events = [float(t) for t in REFERENCE.events("nu_y_zero")["t"]]
    zeros = REFERENCE.zeros("nu_y")
    assert len(zeros) == len(events)
    assert numpy.abs(numpy.array(zeros) - events).max() < 1e-11


def test_rises_and_falls_make_the_difference() -> None:
    span = Span(1.0, 5.0)
    rise, fall = REFERENCE.rises_and_falls("g_n", span=span)
    first, last = REFERENCE.columns(["g_n"], list(span))["g_n"]
    assert rise > abs(last - first)
    assert rise - fall == pytest.approx(last - first, abs=1e-12)


def test_average_rate_is_the_difference_over_the_time() -> None:
    for rate, whole in (("E_dot", "E"), ("E_trans_dot", "E_trans"), ("omega_3_dot", "omega_3")):
        span = REFERENCE.whole
        first, last = REFERENCE.columns([whole], list(span))[whole]
        # Gauss's rule leaves 1e-13 of E; rounding of omega_3 is of the same order
        assert REFERENCE.mean(rate) * span.length == pytest.approx(last - first, rel=1e-11)


def test_share_below_zero_is_that_of_a_fine_grid() -> None:
    times = numpy.linspace(0, 8, 40_001)
    grid = (REFERENCE.columns(["tau_y"], list(times))["tau_y"] < 0).mean()
    assert REFERENCE.share_below_zero("tau_y") == pytest.approx(grid, abs=2e-4)


@pytest.mark.parametrize("until", ["0.1", "0.3"])  # whose doubles lie behind and before them
def test_the_end_of_a_run_is_a_sample(until: str) -> None:
    times = Run(variant(until=until)).sampled(["theta"])["t"]
    assert len(times) == 1000 * float(until) + 1
    assert times.iloc[-1] == float(until)


def test_the_extreme_of_a_quantity_made_for_a_claim_is_that_of_the_event() -> None:
    own = Quantity.of(lambda q: QUANTITIES["nu_y"].evaluate(q), "m/s")
    settled = REFERENCE.extreme("nu_y", largest=True)
    when, value = REFERENCE.extremum(own, largest=True)
    times, values = REFERENCE.extrema("nu_y")
    assert value == pytest.approx(float(settled.value), rel=1e-14)
    assert when == pytest.approx(times[values.argmax()], abs=1e-12)
    assert settled.digits >= 12
    zeros = numpy.array([REFERENCE.zeros(name) for name in (own, "nu_y")])
    assert zeros.shape[1] > 10
    assert abs(zeros[0] - zeros[1]).max() < 1e-11
    # at an end it is the value there
    settled = REFERENCE.extreme("E", largest=True)
    assert float(settled.value) == pytest.approx(float(REFERENCE.at("E", "0").value), rel=1e-15)


def test_a_vertex_is_the_same_wherever_beside_it_one_looks() -> None:
    fine = SHORT.trajectory(FINE)
    times, values = SHORT.extrema("theta_dot")
    t = times[1 + values[1:-1].argmax()]
    beside = t + 2**-30
    at, again = (_vertex(fine, "theta_dot", moment) for moment in (t, beside))
    (there,) = exact(fine, "theta_dot", beside)
    assert abs(again / at - 1) < 1e-25 < 1e-15 < abs(there / at - 1)


def test_the_band_has_no_width_next_to_a_pause() -> None:
    """Between turning points that are further apart than nutations the top does not nutate."""
    times, angles = [0.0, 0.04, 0.08, 0.5, 0.54, 0.58], [0.0, 0.2, 0.1, 0.9, 0.7, 0.9]
    run = Run()
    turns = pandas.DataFrame({"t": times, "theta": angles})
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(Run, "turning_points", turns)
        band = run.band
    assert [point.t for point in band] == [0.04, 0.54]
    assert [point.width for point in band] == pytest.approx([0.15, 0.2])
    assert [point.middle for point in band] == pytest.approx([0.125, 0.8])


def test_nutations_and_the_least_in_each() -> None:
    spans = REFERENCE.nutations(span=Span(4.0, 5.0))
    least = REFERENCE.least_in(spans, "nu_x")
    for span, value in zip(spans, least, strict=True):
        grid = REFERENCE.columns(["nu_x"], list(numpy.linspace(*span, 50)))["nu_x"]
        assert value <= grid.min() < value + 1e-3
    assert min(least) > REFERENCE.extrema("nu_x")[1].min()
    spans = Run("kicked").nutations()
    assert len(spans) > 100
    assert all(a.end == b.begin for a, b in pairwise(spans))
