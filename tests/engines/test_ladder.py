"""Order, floor and verdicts, from motions whose errors are known."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy
import pytest

from tt_precise.engines.ladder import STEP_SIZES, LadderTest, judge_runs, ladder_tests
from tt_precise.engines.protocol import ProgramRun, SampledMotion
from tt_precise.engines.results import VERDICTS
from tt_precise.mechanics.laws import COULOMB, LAWS, VISCOUS, Law


@pytest.fixture(scope="module")
def flight() -> LadderTest:
    return ladder_tests()[0]


def off(test: LadderTest, error: float) -> ProgramRun:
    """The reference with an angular velocity that is off by this share of the spin."""
    truth = test.truth
    assert truth is not None
    t = numpy.linspace(0, 1, len(truth.k))[:, None]
    return ProgramRun(
        "done", "", SampledMotion(truth.k, truth.omega + error * test.spin * t, truth.s_dot)
    )


def judged(test: LadderTest, error: Any, promised: float | None = None) -> Any:
    runs = [off(test, error(float(step))) for step in STEP_SIZES]
    return judge_runs("mine", test, STEP_SIZES, runs, promised)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_order_constant_and_no_floor(flight: LadderTest, order: int) -> None:
    found = judged(flight, lambda h: 50 * h**order)
    assert found.verdict == "converges"
    assert found.order == pytest.approx(order, abs=1e-3)
    # the three components of the angular velocity are off together
    assert found.constant == pytest.approx(50 * 3**0.5, rel=1e-3)
    assert found.floor < 1e-3 * found.errors[-1]
    assert found.limit == pytest.approx(2 * found.errors[-1], rel=0.01)


@pytest.mark.parametrize(
    ("error", "promised", "verdict"),
    [
        (lambda h: 50 * h, 4.0, "slow"),  # than it should converge
        (lambda h: 50 * h**2, 4.0, "slow"),
        (lambda h: 50 * h**4, 4.0, "converges"),
        (lambda h: 50 * h, 1.0, "converges"),
        (lambda h: 50 * h**4, 1.0, "converges"),
        (lambda h: 1e-3 * (round(1 / h) % 3), None, "no order"),
        (lambda h: 1e-3, None, "no order"),
        (lambda h: 1e-16, None, "rounding"),
    ],
)
def test_verdicts(flight: LadderTest, error: Any, promised: float | None, verdict: str) -> None:
    assert judged(flight, error, promised).verdict == verdict


def test_a_floor_is_seen_below_the_step_error_of_the_coarse_runs(flight: LadderTest) -> None:
    found = judged(flight, lambda h: 3e3 * h**2 + 1e-3)
    assert found.verdict == "floor"
    assert found.order == pytest.approx(2, abs=1e-3)
    assert found.floor == pytest.approx(1e-3 * 3**0.5, rel=1e-2)


def test_an_order_that_a_blown_up_coarse_run_shows_is_not_believed(flight: LadderTest) -> None:
    found = judged(flight, lambda h: 160 * h**2 + 0.1 * (h > 9e-4))
    assert found.order > 10
    assert found.verdict == "converges"
    # the error of the smallest step, and what halving the step changed, with order 4
    error, change = 1e-5 * 3**0.5, 3e-5 * 3**0.5
    assert found.floor == pytest.approx(error - change / 15, rel=1e-3)
    assert found.constant == pytest.approx(change / 15 / 2.5e-4**4, rel=1e-3)
    assert found.resolved == pytest.approx(change, rel=1e-3)


def test_a_run_that_was_no_run_is_no_pass(flight: LadderTest) -> None:
    good = off(flight, 1e-9)
    for status, verdict in (("refused", "refused"), ("stopped", "failed"), ("diverged", "failed")):
        found = judge_runs("mine", flight, STEP_SIZES, [good, good, ProgramRun(status, "why")])
        assert found.verdict == verdict
        assert found.message.endswith("why")
        assert not found.digits
    assert {"rounding", "converges", "floor", "no order", "refused", "failed"} < set(VERDICTS)


def test_every_test_has_a_reference_that_conserves() -> None:
    """But for the inversion under dry friction, which has none."""
    for test in (*ladder_tests(), *ladder_tests(VISCOUS)):
        if test.truth is None:
            assert (test.name, test.scene.body.friction) == ("inversion", COULOMB)
            continue
        run = ProgramRun("done", "", test.truth)
        found = judge_runs("truth", test, STEP_SIZES, [run, run, run])
        assert found.verdict == "rounding"
        assert set(found.drift) == set(test.conserved)
        # rounding of some thousand steps; the angular momentum is made of k and omega
        assert max(max(values) for values in found.drift.values()) < 1e-12, test.name
        if test.name == "inversion":  # of the golden top
            assert test.scene.until == 8
            assert found.equator[-1] is not None
            assert "jellett" in found.drift


def test_flight_is_the_closed_form_of_the_example(flight: LadderTest) -> None:
    # the period of precession 2 pi I1/|L| comes back to the start's axis
    q = flight.start
    L = numpy.linalg.norm(numpy.array(q.state.L, dtype=float))
    period = 2 * numpy.pi * q.body.I1 / L
    scene = flight.scene.varied(until=str(Fraction(period)), sample_every=str(Fraction(period)))
    assert flight.reference is not None
    there = flight.reference(scene)
    assert there.k[-1] == pytest.approx(there.k[0], abs=1e-12)
    assert there.omega[-1] == pytest.approx(there.omega[0], rel=1e-12, abs=1e-12 * flight.spin)


@pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
def test_an_engine_is_asked_for_its_own_law_alone(law: Law) -> None:
    asked = [test.job(STEP_SIZES[0])["friction"] for test in ladder_tests(law)]
    assert {friction["law"] for friction in asked} == {"none", law.name}
    names = {parameter.name for parameter in law.parameters}
    assert any(friction.keys() == {"law", *names} for friction in asked)
