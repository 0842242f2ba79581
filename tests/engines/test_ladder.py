"""Test order, floor and verdicts on motions whose errors are known."""

from fractions import Fraction
from typing import Any

import numpy
import pytest

from tt_precise.engines.ladder import LadderResult, LadderTest, judge_runs, ladder_tests
from tt_precise.engines.protocol import ProgramRun
from tt_precise.mechanics.laws import COULOMB, LAWS, VISCOUS, Law

STEPS = (Fraction(1, 1000), Fraction(1, 2000), Fraction(1, 4000))


@pytest.fixture(scope="module")
def flight() -> LadderTest:
    return ladder_tests()[0]


def with_error(test: LadderTest, error: float) -> ProgramRun:
    """Return the reference with an angular velocity that is off by a growing share of the spin."""
    assert test.truth is not None
    t = numpy.linspace(0, 1, len(test.truth.k))[:, None]
    omega = test.truth.omega + error * test.spin * t
    return ProgramRun("done", "", test.truth._replace(omega=omega))


def judge(test: LadderTest, error: Any, promised: float | None = None) -> LadderResult:
    runs = [with_error(test, error(float(step))) for step in STEPS]
    return judge_runs("mine", test, STEPS, runs, promised)


@pytest.mark.parametrize(
    ("error", "promised", "verdict", "order", "floor"),
    [
        (lambda h: 50 * h, None, "converges", 1, 0),
        (lambda h: 50 * h**4, 4.0, "converges", 4, 0),
        (lambda h: 50 * h**4, 1.0, "converges", 4, 0),
        (lambda h: 50 * h**2, 4.0, "slow", 2, 0),
        # a floor below the step error of the coarse runs
        (lambda h: 3e3 * h**2 + 1e-3, None, "floor", 2, 1e-3),
        (lambda h: 1e-3, None, "no order", None, 1e-3),
        (lambda h: 1e-16, None, "rounding", None, 0),
        # the order of a coarse run that blew up is bounded by 4: a fifteenth of the last change
        (lambda h: 160 * h**2 + 0.1 * (h > 9e-4), None, "converges", 11.7, 1e-5 - 3e-5 / 15),
    ],
)
def test_verdicts(
    flight: LadderTest, error: Any, promised: Any, verdict: str, order: Any, floor: Any
) -> None:
    result = judge(flight, error, promised)
    assert result.verdict == verdict
    assert result.order == pytest.approx(order, abs=0.1) if order else True
    # three components of omega are off together
    assert (result.floor or 0) == pytest.approx((floor or 0) * 3**0.5, rel=0.01, abs=2e-8)


@pytest.mark.parametrize(
    ("status", "verdict"), [("refused", "refused"), ("stopped", "failed"), ("diverged", "failed")]
)
def test_a_run_without_rows_is_no_pass(flight: LadderTest, status: str, verdict: str) -> None:
    good = with_error(flight, 1e-9)
    result = judge_runs("mine", flight, STEPS, [good, good, ProgramRun(status, "why")])
    assert (result.verdict, result.digits) == (verdict, ())
    assert result.message.endswith("why")


@pytest.mark.parametrize("law", [COULOMB, VISCOUS])
def test_every_reference_conserves(law: Law) -> None:
    for test in ladder_tests(law):
        if test.truth is None:
            assert (test.name, law) == ("inversion", COULOMB)
            continue
        result = judge_runs("truth", test, STEPS, [ProgramRun("done", "", test.truth)] * 3)
        assert result.verdict == "rounding"
        assert set(result.drift) == set(test.conserved)
        # rounding of some thousand steps; the angular momentum is made of k and omega
        assert max(max(values) for values in result.drift.values()) < 1e-12, test.name


def test_drift_and_equator_of_another_motion(flight: LadderTest) -> None:
    result = judge(flight, lambda h: 1e-6)
    assert max(result.drift["angular_momentum"]) > 1e-7  # the control of the test above
    test = next(test for test in ladder_tests(VISCOUS) if test.name == "inversion")
    assert test.truth is not None
    upright = test.truth._replace(k=abs(test.truth.k))
    runs = [ProgramRun("done", "", motion) for motion in (test.truth, test.truth, upright)]
    t = float(test.scene.sample_times[int((test.truth.k[:, 2] < 0).argmax())])
    message = judge_runs("mine", test, STEPS, runs).message
    assert message == f"axis horizontal at {t:.2f}, {t:.2f}, never s"


def test_flight_returns_after_a_period_of_precession(flight: LadderTest) -> None:
    q = flight.start
    period = 2 * numpy.pi * q.body.I1 / numpy.linalg.norm(numpy.array(q.state.L, dtype=float))
    scene = flight.scene.varied(until=str(Fraction(period)), sample_every=str(Fraction(period)))
    assert flight.reference is not None
    motion = flight.reference(scene)
    assert motion.k[-1] == pytest.approx(motion.k[0], abs=1e-12)
    assert motion.omega[-1] == pytest.approx(motion.omega[0], abs=1e-12 * flight.spin)


@pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
def test_a_job_has_the_law_of_the_engine_or_none(law: Law) -> None:
    frictions = [test.job(STEPS[0])["friction"] for test in ladder_tests(law)]
    assert {friction["law"] for friction in frictions} == {"none", law.name}
    names = {parameter.name for parameter in law.parameters}
    assert any(friction.keys() == {"law", *names} for friction in frictions)
