"""``integrate``: how runs end, that they repeat, and what is refused."""

import math
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tests.conftest import Patch
from tests.integration.conftest import Spoiler, motion_at
from tt_precise.integration import Trajectory, heyoka_backend, integrate, solution, zeros
from tt_precise.integration.precision import KINDS
from tt_precise.mechanics import newton
from tt_precise.runtime.terminal import silent
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene


def assert_never_nan(run: Trajectory) -> None:
    """Nothing that leaves it is NaN or infinite, and nothing lies beyond its end."""
    values = [run.t_end, *run.state.values.values(), *run.drift.values()]
    if run.precision.name != "quad":  # the reference run of quad takes seconds
        values += run.error_estimate.values()
    assert all(value is None or abs(value) < math.inf for value in values)
    frame = run.frame("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy", numbers="exact")
    assert numpy.isfinite(frame.astype(float).to_numpy()).all()
    assert float(frame["t"].iloc[-1]) <= float(run.t_end)


def test_double_agrees_with_triple_double(double: Trajectory, fine: Trajectory) -> None:
    assert (double.status, fine.status) == ("complete", "complete")
    assert double.t_end == fine.t_end == 8
    pairs = zip(*(motion_at(run, 8).state for run in (double, fine)), strict=True)
    # the bar, absolute, dimensionless. Measured: 1e-14
    assert 0 < max(abs(mpmath.mpf(a) - b) for a, b in pairs) < 1e-13


@pytest.mark.parametrize("precision", ["double", "triple-double", "quad"])
def test_a_run_repeats_bit_by_bit(half: Scene, precision: str) -> None:
    """The second time by heyoka's compiled code, after an interruption, the third compiled anew."""
    first, second = integrate(half, precision), integrate(half, precision)

    def interrupt(fraction: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        integrate(half, precision, progress=interrupt)
    third = integrate(half, precision)
    heyoka_backend._idle.cache_clear()
    assert first.state == second.state == third.state == integrate(half, precision).state
    assert (first.steps, first.t_end) == (second.steps, second.t_end)
    other = integrate(half, precision, until=half.until + Fraction(1, 10**13))
    assert other.state.values != first.state.values


@pytest.fixture(scope="module")
def lost_in_quad(rough: Scene) -> Trajectory:
    return integrate(rough, "quad")


@pytest.mark.parametrize(
    ("precision", "formulation"),
    [
        ("double", "newton"),
        ("double-double", "newton"),
        ("double-double", "euler"),
        ("quad", "newton"),
    ],
)
def test_contact_is_lost_at_one_time_in_every_arithmetic_and_form(
    rough: Scene, lost_in_quad: Trajectory, precision: str, formulation: str
) -> None:
    lost = integrate(rough, precision, formulation=formulation)
    assert lost.status == "contact_lost"
    assert "contact_lost" in repr(lost)
    assert abs(lost.t_end - Fraction("0.6577188")) < 5e-8
    eps, context = float(lost.precision.eps), lost.precision.context
    assert abs(lost_in_quad.precision.context.mpf(lost.t_end) - lost_in_quad.t_end) < 100 * eps
    times = [context.mpf(lost.t_end) * (1 - context.mpf(10) ** -k) for k in (1, 3, 6, 9)]
    g_n = lost.frame("g_n", times=[0, *times, lost.t_end], numbers="float")["g_n"]
    assert (g_n.iloc[:-1] > 0).all()
    assert abs(g_n.iloc[-1]) < 1000 * eps * 0.02 * 9.82
    if formulation == "newton":
        assert_never_nan(lost)


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_contact_lost_later_is_reported_when_it_is_ignored(rough: Scene, precision: str) -> None:
    """The guarded run ends where g_n reaches 0; the other goes on and says that it was there."""
    for until, status in (("0.66", "contact_ignored"), ("0.6", "complete")):
        ignored = integrate(rough, precision, until=until, contact="bilateral")
        assert (ignored.status, float(ignored.t_end)) == (status, float(until))


def test_singular_contact_behind_lost_contact(rough: Scene) -> None:
    """On a table that pulls too (g_n < 0) the denominator of g_n reaches 0: a blow-up."""
    end = integrate(rough, "double-double", contact="bilateral")
    assert end.status == "singular_contact"
    assert end.error_estimate["t_end"] < 1e-15
    assert_never_nan(end)
    numerator, denominator = newton.contact_terms(end.start.body, motion_at(end, end.t_end).state)
    assert numerator < 0 < denominator < 2e-6 * end.start.body.I1


@pytest.mark.parametrize("precision", ["double-double", "quad"])
def test_a_run_in_euler_angles_ends_at_the_pole(toppling: Scene, precision: str) -> None:
    fallen = integrate(toppling, precision, formulation="euler")
    assert fallen.status == "pole"
    assert abs(fallen.t_end - Fraction("0.09470405")) < 5e-9
    assert abs(fallen.state.theta) < 100 * fallen.precision.eps
    # the vectors go through the same point unharmed
    vectors = integrate(toppling, precision)
    assert vectors.status == "complete"
    assert abs(vectors.at(fallen.t_end).theta) < 100 * fallen.precision.eps
    left, right = (vectors.at(fallen.t_end * (1 + side)).kx for side in (-1e-9, 1e-9))
    assert right < 0 < left


@pytest.mark.parametrize("precision", ["double", "double-double", "quad"])
def test_a_hopeless_start_fails_loudly(reference: Scene, precision: str) -> None:
    failed = integrate(reference.varied(mu="1e300"), precision)
    assert (failed.status, failed.t_end, failed.steps) == ("failed", 0, 0)
    assert "failed" in repr(failed)
    assert failed.frame()["t"].tolist() == [0]
    assert_never_nan(failed)
    with pytest.raises(InputError, match="failed"):
        failed.at("0.001")


def test_a_failure_under_way_ends_at_the_last_good_step(
    reference: Scene, double: Trajectory, spoiled_rates: Spoiler
) -> None:
    """Equations that know no square root of cos theta < 0."""
    spoiled_rates("newton", lambda s, rates: rates._replace(kx=rates.kx * s.kz**0.5 / s.kz**0.5))
    failed = integrate(reference)
    assert failed.status == "failed"
    assert abs(failed.t_end - double.inversion.equator) < 0.02  # a step is some 5 ms
    frame = failed.frame()
    assert numpy.isfinite(frame.to_numpy()).all()
    assert frame["kz"].iloc[-1] == pytest.approx(failed.state.kz)


def test_a_hopeless_run_is_given_up(reference: Scene, monkeypatch: Patch) -> None:
    monkeypatch.setitem(KINDS, "quad", KINDS["quad"]._replace(steps=40))
    stuck = integrate(reference.varied(mu="1e50"), "quad")
    assert stuck.status == "failed"
    assert 0 < stuck.t_end < 1e-40
    assert_never_nan(stuck)
    honest = integrate(reference, "quad", until="0.5")
    assert honest.status == "complete"
    assert honest.steps > 40


@pytest.mark.parametrize(
    ("scene", "precision"),
    [
        *(("reference", one) for one in ("double", "double-double", "quad")),
        ("coulomb-stick-slip", "double"), ("elastic-linear", "quad"),
    ],
)  # fmt: skip
def test_a_horizon_of_zero_is_the_start(scene: str, precision: str) -> None:
    still = integrate(scene, precision, until=0, progress=silent)
    assert (still.status, still.t_end, still.steps) == ("complete", 0, 0)
    assert still.at(0) == still.state
    assert still.state.theta_dot == 0
    assert len(still.frame()) == 1
    assert still.events.empty
    # no more than the numbers hold
    assert 14 < still.digits < still.precision.bits * 0.30104


@pytest.mark.parametrize(
    ("scene", "arguments", "message"),
    [
        ("no-such-scene", {}, "got 'no-such-scene'"),
        ("reference", {"precision": "single"}, "expected one of: double"),
        ("reference", {"bits": 200}, "only with mp"),
        *(("reference", {"precision": "mp", "bits": n}, "bits: got") for n in (53, 20_001, 200.5)),
        ("reference", {"formulation": "lagrange"}, "expected one of: newton, euler"),
        *(
            ("reference", {"tolerance": one}, r"expected 0 .* of double, or a number from 1\.4e-17")
            for one in (-1e-9, 1.0, math.nan, "few", None, 1e-17, 1e-300)  # of order 346, for hours
        ),
        ("reference", {"contact": "none"}, "contact: got 'none', expected one of"),
        ("reference", {"record": ("theta",)}, "expected one of: phi, psi, x, y"),
        ("upright", {"record": ("psi",)}, "at a pole"),
        ("upright", {"formulation": "euler"}, "expected newton for theta = 0, which is a pole"),
        ("inverted", {"formulation": "euler"}, "theta = pi, which is a pole"),
    ],
)
def test_refusals(scene: str, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        integrate(scene, **arguments)


def test_too_many_events_are_refused(half: Scene, monkeypatch: Patch) -> None:
    monkeypatch.setattr(zeros, "MOST_EVENTS", 10)
    assert len(integrate(half, "double-double", events=("equator",)).events) == 0
    # four parts of steps, and 14 events
    names = ("theta_min", "theta_max", "phi_dot_zero")
    for precision, events in (("double-double", names), ("double", "theta_max")):
        with pytest.raises(InputError, match="events: got more than"):
            integrate(half, precision, events=events)


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_run_with_too_many_steps_is_refused(monkeypatch: Patch, precision: str) -> None:
    """mu/epsilon = 2e12 asked for 1e9 steps and said nothing."""
    monkeypatch.setattr(solution, "MOST_STEPS", 1000)
    monkeypatch.setitem(KINDS, "double", KINDS["double"]._replace(steps=500))
    stiff = load_scene("regularised-1e-2").varied(mu="1e12", epsilon="0.5", until="0.1")
    with pytest.raises(InputError, match="until: got more than 1000 Taylor steps"):
        integrate(stiff, precision, events=(), record=())
