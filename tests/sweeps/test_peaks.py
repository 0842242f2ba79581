"""Extreme values along steps: no peak is missed, however narrow, and rounding is none."""

import math
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import peaks
from tt_precise.sweeps.peaks import NODES, PeakSearch, bernstein
from tt_precise.sweeps.rows import integrate_rows
from tt_precise.sweeps.starts import Sweep

# The axis passes the pole at 0.5229 s: all samples of the step lie on the shoulders of the peak.
HIDDEN = {
    "theta_dot": -4.44430617852, "phi_dot": -197.175915291,
    "nu_x": 0.108429116962, "nu_y": -0.0257519235174,
}  # fmt: skip


def row_of(start: dict[str, float], record: str, until: str) -> dict[str, Any]:
    plan = Sweep(load_scene("reference").varied(until=until), (*start,), (record,))
    return integrate_rows(plan, numpy.array([[*start.values()]]), 4)


def single(start: dict[str, float], quantity: str, until: str) -> numpy.ndarray:
    """Return a quantity at its extrema along a trajectory."""
    scene = load_scene("reference").varied(**start, until=until)
    run = tt.integrate(scene, events=(f"extremum:{quantity}",))
    values: numpy.ndarray = run.event_table((quantity,))[quantity]
    return values.astype(float)


def test_a_peak_between_the_nodes_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the rule of the tail it is missed."""
    (least,) = row_of(HIDDEN, "min_nu_x", "0.6")["min_nu_x"]
    assert least == pytest.approx(single(HIDDEN, "nu_x", "0.6").min(), rel=0, abs=1e-12)
    monkeypatch.setattr(peaks, "REPRESENTED", math.inf)
    assert least < -0.1642 < row_of(HIDDEN, "min_nu_x", "0.6")["min_nu_x"][0]


def test_the_spike_of_phi_dot_beside_the_pole_is_found() -> None:
    """Some 40 microseconds wide near 3.19 s on the reference scene, where steps take 5 ms."""
    spike = single({"mu": 0.3}, "phi_dot", "4").min()
    assert spike < -1e3
    (least,) = row_of({"mu": 0.3}, "min_phi_dot", "4")["min_phi_dot"]
    assert least == pytest.approx(spike, rel=1e-9)


@pytest.mark.parametrize("start", [{"theta": 1e-200, "mu": 1000.0}, {"mu": 1000.0}])
def test_rounding_errors_have_no_extrema(start: dict[str, float]) -> None:
    """Friction stops the contact point, and its velocity is rounding, which nothing resolves."""
    parts = []

    class Counting(PeakSearch):
        def _sampled(self, series: Any, row: Any, since: Any) -> Any:
            parts.append(since.shape[1])
            return super()._sampled(series, row, since)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("tt_precise.sweeps.rows.PeakSearch", Counting)
        rows = row_of(start, "max_nu_x", "0.01")
    assert 0 <= rows["max_nu_x"][0] < (1e-198 if "theta" in start else 1)
    assert sum(parts) < 8 * rows["steps"][0] + 100


def test_between_nodes_a_smooth_function_exceeds_them_by_less_than_the_overshoot() -> None:
    x = numpy.linspace(0, 1, 2001)
    for turn in (0.1, 1.0, 2.0, 3.0):
        for phase in numpy.linspace(0, 2 * math.pi, 37):
            samples = numpy.cos(turn * NODES - phase)
            most = samples.max() + peaks.OVERSHOOT * numpy.ptp(samples)
            assert samples.max() <= numpy.cos(turn * x - phase).max() + 1e-15 <= most + 2e-15


def test_bernstein_coefficients_enclose_a_polynomial() -> None:
    coefficients = numpy.random.default_rng(3).normal(size=len(bernstein()))
    bounds = bernstein() @ coefficients
    values = numpy.polynomial.polynomial.polyval(numpy.linspace(0, 1, 999), coefficients)
    assert bounds.min() <= values.min() <= values.max() <= bounds.max()
    assert bounds[[0, -1]] == pytest.approx([coefficients[0], coefficients.sum()])
