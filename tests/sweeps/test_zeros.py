"""Along steps no zero and no peak is missed; zeros have full accuracy, and rounding no peaks."""

import math
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import zeros
from tt_precise.sweeps.rows import integrate_rows
from tt_precise.sweeps.starts import Sweep
from tt_precise.sweeps.zeros import NODES, PeakSearch, bernstein, classified, refined


def of_cosine(turn: float, phase: float, level: float) -> numpy.ndarray:
    """Return value and rate at both ends of level - cos(turn x - phase), x in [0, 1]."""
    ends = numpy.array([0.0, 1.0])
    values = level - numpy.cos(turn * ends - phase)
    rates = turn * numpy.sin(turn * ends - phase)
    return numpy.array([[values[0]], [rates[0]], [values[1]], [rates[1]]])


def test_a_failed_motion_has_no_zero_and_without_its_margin_a_cubic_hides_two(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert not classified(of_cosine(2.0, 1.0, numpy.nan))[0][0]
    assert not classified(numpy.array([[-1.0], [0.0], [numpy.nan], [numpy.nan]]))[0][0]
    assert classified(of_cosine(4.0, 2.0, 0.9))[0][0]
    monkeypatch.setattr(zeros, "MARGIN", 0.0)
    assert not classified(of_cosine(4.0, 2.0, 0.9))[0][0]


def test_no_cosine_of_a_step_hides_zeros() -> None:
    """Whatever its phase and its level: 0 and 1 zeros are counted, others are unclear."""
    x = numpy.linspace(0, 1, 4001)
    for turn in (0.5, 1.0, 2.0):
        for phase in numpy.linspace(0, 2 * numpy.pi, 25):
            for level in numpy.linspace(-1.2, 1.2, 25):
                values = level - numpy.cos(turn * x - phase)
                count = int(((values[1:] < 0) != (values[:-1] < 0)).sum())
                may, single = classified(of_cosine(turn, phase, level))
                assert may[0] or count == 0
                assert not (may[0] and single[0]) or count == 1


@pytest.mark.parametrize("root", [1e-9, 0.3, 0.999])
def test_a_zero_has_full_accuracy_and_does_not_depend_on_others(root: float) -> None:
    """Also of a triple zero, where Newton's steps shrink by a third only."""
    roots = numpy.array([root, 0.5, 0.25])
    powers = numpy.array([1, 1, 3])

    def function(at: numpy.ndarray, chosen: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        r, p = roots[chosen], powers[chosen]
        return (at - r) ** p * (1 + at), p * (at - r) ** (p - 1) * (1 + at) + (at - r) ** p

    low, high, start = numpy.zeros(3), numpy.ones(3), numpy.full(3, 0.9)
    rising, distance = numpy.ones(3, dtype=bool), numpy.ones(3)
    found = refined(function, (low, high), start, rising, distance)
    assert found[:2] == pytest.approx(roots[:2], rel=1e-15)
    assert found[2] == pytest.approx(0.25, abs=1e-7)
    alone = refined(
        lambda at, _: function(at, numpy.zeros(1, dtype=int)),
        (low[:1], high[:1]), start[:1], rising[:1], distance[:1],
    )  # fmt: skip
    assert alone[0] == found[0]


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
    monkeypatch.setattr(zeros, "REPRESENTED", math.inf)
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
            most = samples.max() + zeros.OVERSHOOT * numpy.ptp(samples)
            assert samples.max() <= numpy.cos(turn * x - phase).max() + 1e-15 <= most + 2e-15


def test_bernstein_coefficients_enclose_a_polynomial() -> None:
    coefficients = numpy.random.default_rng(3).normal(size=len(bernstein()))
    bounds = bernstein() @ coefficients
    values = numpy.polynomial.polynomial.polyval(numpy.linspace(0, 1, 999), coefficients)
    assert bounds.min() <= values.min() <= values.max() <= bounds.max()
    assert bounds[[0, -1]] == pytest.approx([coefficients[0], coefficients.sum()])
