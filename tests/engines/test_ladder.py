"""Order, floor and verdicts, from motions whose errors are known."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy
import pytest

from tt_precise.engines.ladder import STEPS, VERDICTS, Rung, measured, rungs
from tt_precise.engines.protocol import ProgramRun, States
from tt_precise.scene.laws import LAWS, VISCOUS, Law


@pytest.fixture(scope="module")
def flight() -> Rung:
    return rungs()[0]


def off(rung: Rung, error: float) -> ProgramRun:
    """The reference with an angular velocity that is off by this share of the spin."""
    truth = rung.truth
    assert truth is not None
    t = numpy.linspace(0, 1, len(truth.k))[:, None]
    return ProgramRun("done", "", States(truth.k, truth.omega + error * rung.spin * t, truth.s_dot))


def judged(rung: Rung, error: Any, promised: float | None = None) -> Any:
    runs = [off(rung, error(float(step))) for step in STEPS]
    return measured("mine", rung, STEPS, runs, promised)


@pytest.mark.parametrize("order", [1, 2, 4])
def test_order_constant_and_no_floor(flight: Rung, order: int) -> None:
    found = judged(flight, lambda h: 50 * h**order)
    assert found.verdict == "converges"
    assert found.order == pytest.approx(order, abs=1e-3)
    # the three components of the angular velocity are off together
    assert found.constant == pytest.approx(50 * 3**0.5, rel=1e-3)
    assert found.floor < 1e-3 * found.errors[-1]
    assert found.limit == pytest.approx(2 * found.errors[-1], rel=0.01)


@pytest.mark.parametrize(("order", "verdict"), [(1, "slow"), (2, "slow"), (4, "converges")])
def test_a_method_that_converges_more_slowly_than_it_should(
    flight: Rung, order: int, verdict: str
) -> None:
    assert judged(flight, lambda h: 50 * h**order, 4.0).verdict == verdict
    assert judged(flight, lambda h: 50 * h**order, 1.0).verdict == "converges"


def test_a_floor_is_seen_below_the_step_error_of_the_coarse_runs(flight: Rung) -> None:
    found = judged(flight, lambda h: 3e3 * h**2 + 1e-3)
    assert found.verdict == "floor"
    assert found.order == pytest.approx(2, abs=1e-3)
    assert found.floor == pytest.approx(1e-3 * 3**0.5, rel=1e-2)


def test_no_order_where_smaller_steps_do_not_help(flight: Rung) -> None:
    assert judged(flight, lambda h: 1e-3 * (round(1 / h) % 3)).verdict == "no order"
    assert judged(flight, lambda h: 1e-3).verdict == "no order"


def test_rounding(flight: Rung) -> None:
    assert judged(flight, lambda h: 1e-16).verdict == "rounding"


def test_a_run_that_was_no_run_is_no_pass(flight: Rung) -> None:
    good = off(flight, 1e-9)
    for status, verdict in (("refused", "refused"), ("stopped", "failed"), ("diverged", "failed")):
        found = measured("mine", flight, STEPS, [good, good, ProgramRun(status, "why")])
        assert found.verdict == verdict
        assert found.message.endswith("why")
        assert not found.digits
    assert {"rounding", "converges", "floor", "no order", "refused", "failed"} < set(VERDICTS)


def test_every_rung_has_a_reference_that_conserves(flight: Rung) -> None:
    for rung in rungs():
        if rung.truth is None:
            assert rung.name == "inversion"
            continue
        run = ProgramRun("done", "", rung.truth)
        found = measured("truth", rung, STEPS, [run, run, run])
        assert found.verdict == "rounding"
        assert set(found.drift) == set(rung.conserved)
        # rounding of some thousand steps; the angular momentum is made of k and omega
        assert max(max(values) for values in found.drift.values()) < 1e-12, rung.name


def test_flight_is_the_closed_form_of_the_example() -> None:
    # the period of precession 2 pi I1/|L| comes back to the start's axis
    rung = rungs()[0]
    q = rung.start
    L = numpy.linalg.norm(numpy.array(q.state.L, dtype=float))
    period = 2 * numpy.pi * q.body.I1 / L
    scene = rung.scene.varied(until=str(Fraction(period)), sample_every=str(Fraction(period)))
    assert rung.reference is not None
    there = rung.reference(scene)
    assert there.k[-1] == pytest.approx(there.k[0], abs=1e-12)
    assert there.omega[-1] == pytest.approx(there.omega[0], rel=1e-12, abs=1e-12 * rung.spin)


@pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
def test_an_engine_is_asked_for_its_own_law_alone(law: Law) -> None:
    asked = [rung.job(STEPS[0])["friction"] for rung in rungs(law)]
    assert {friction["law"] for friction in asked} == {"none", law.name}
    names = {parameter.name for parameter in law.parameters}
    assert any(friction.keys() == {"law", *names} for friction in asked)


def test_a_viscous_engine_inverts_the_golden_top() -> None:
    rung = next(one for one in rungs(VISCOUS) if one.name == "inversion")
    truth = rung.truth
    assert truth is not None
    assert rung.scene.until == 8
    run = ProgramRun("done", "", truth)
    found = measured("truth", rung, STEPS, [run, run, run])
    assert found.verdict == "rounding"
    assert found.equator[-1] is not None
    assert max(found.drift["jellett"]) < 1e-12
