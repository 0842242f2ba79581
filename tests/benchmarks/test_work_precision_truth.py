"""The truth that methods are judged by, and the judgement."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pytest

from benchmarks.work_precision.measure import METHODS
from benchmarks.work_precision.peers import Settings
from benchmarks.work_precision.problem import GoldenProblem, golden_problem
from tt_precise.integration.precision import precision_named
from tt_precise.runtime.values import InputError

DOUBLE, QUAD = precision_named("double"), precision_named("quad")


def judged(problem: GoldenProblem, name: str, settings: Settings, spoil: Any = None) -> Any:
    times = problem.clock(settings.precision, problem.times)
    run = METHODS[name].prepare(problem, settings)(times)
    states = [list(row) for row in run.states]
    if spoil is not None:
        states[-1][0] += spoil
    return problem.truth.errors(states, settings.precision, times)


@pytest.fixture(scope="module")
def short() -> GoldenProblem:
    return golden_problem("reference", "newton", "0.03")


def test_quad_agrees_with_golden_data_to_their_last_digits(short: GoldenProblem) -> None:
    found = judged(short, "heyoka", Settings(0.0, QUAD))
    # 34 decimals, a few eps of quad beside them
    assert max(found.error, found.error_on_way, found.jellett_drift) < 1e-32


def test_an_error_of_the_state_is_found(short: GoldenProblem) -> None:
    found = judged(short, "heyoka", Settings(0.0, DOUBLE), spoil=1e-9)
    # 1e-9 in the axis, and in the contact velocity what the spin of about 7 makes of it
    assert 0.99e-9 < found.error < 1e-8
    assert found.jellett_drift > 1e-12
    # the same for angles, and for a scene without a contact velocity
    euler = golden_problem("reference", "euler", "0.03")
    assert judged(euler, "heyoka", Settings(0.0, QUAD)).error < 1e-31
    assert judged(euler, "heyoka", Settings(0.0, DOUBLE), spoil=1e-9).error > 5e-10
    rolling = golden_problem("rolling", "newton", "0.03")
    assert judged(rolling, "heyoka", Settings(0.0, DOUBLE)).error < 1e-13


def test_the_rounding_of_the_time_is_no_error_of_the_method() -> None:
    problem = golden_problem("reference", "newton", "0.3")
    times = problem.clock(DOUBLE, problem.times)
    run = METHODS["heyoka"].prepare(problem, Settings(0.0, DOUBLE))(times)
    fair = problem.truth.errors(run.states, DOUBLE, times)
    shifted = [t * (1 + 1e-12) for t in times]
    assert fair.error < 1e-13
    assert problem.truth.errors(run.states, DOUBLE, shifted).error > 10 * fair.error


@pytest.mark.slow
def test_a_run_with_more_bits_goes_below_golden_data(short: GoldenProblem) -> None:
    finer = replace(short, truth_bits=260)
    settings = Settings(0.0, precision_named("mp", 200))
    assert judged(finer, "heyoka", settings).error < 1e-55
    assert judged(short, "heyoka", settings).error > 1e-36  # all that golden data can show


def test_samples_end_at_the_end() -> None:
    problem = golden_problem("reference")
    assert problem.times[-1] == problem.until == 8
    assert 20 <= len(problem.times) <= 40
    lost = golden_problem("contact-lost")
    assert lost.until < lost.scene.until
    (number,) = problem.clock(DOUBLE, [Fraction(8)])
    body = problem.scene.body
    assert number == pytest.approx(8 * float(body.g / body.R) ** 0.5, rel=1e-15)
    with pytest.raises(InputError, match="time of the golden data"):
        golden_problem("reference", "newton", "0.0123")


@pytest.mark.parametrize("entry", [0, 4, 7])
def test_what_is_not_a_number_is_infinitely_wrong(short: GoldenProblem, entry: int) -> None:
    state = short.state(DOUBLE)
    state[entry] = float("nan")
    times = short.clock(DOUBLE, short.times[-1:])
    found = short.truth.errors([state], DOUBLE, times)
    assert found.error == numpy.inf
    assert (found.jellett_drift == numpy.inf) == (entry < 6)  # lambda knows no velocity
