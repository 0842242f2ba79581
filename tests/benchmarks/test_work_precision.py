"""The register: every method says what it needs, and does what it says."""

import math
from functools import partial
from typing import Any

import numpy
import pytest

from benchmarks.work_precision import measure
from benchmarks.work_precision.heyoka_methods import OWN
from benchmarks.work_precision.measure import METHODS, Timings, interleaved
from benchmarks.work_precision.peers import PEERS as METHODS_OF_PEERS
from benchmarks.work_precision.peers import SHAPES, Settings, flat, source
from benchmarks.work_precision.problem import golden_problem
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import CHEAPER, FORMULATIONS, Formulation

DOUBLE = precision_named("double")
HEYOKA = [method.name for method in OWN if "digits" not in method.name]
PEERS = [method.name for method in METHODS_OF_PEERS]
SOME = ("heyoka", "heyoka, contact watched", "tt_precise, tolerance")  # compile in a second
LOOSE = ("Radau", "RK45", "BDF", "odeint", "LSODA", "Adams")


def error(
    name: str,
    tolerance: float,
    coordinates: str = "newton",
    until: str = "0.05",
    precision: Any = DOUBLE,
) -> float:
    problem = golden_problem("reference", coordinates, until)
    settings = Settings(tolerance, precision)
    solve = METHODS[name].prepare(problem, settings)
    times = problem.clock(settings.precision, problem.times)
    worst = 0.0
    for wanted in (times[-1:], times):
        run = solve(wanted)
        judged = problem.truth.errors(
            run.states, settings.precision, None if run.published else wanted
        )
        worst = max(worst, float(judged.error))
        assert run.work >= run.steps or not run.work  # some do not count
    return worst


@pytest.mark.parametrize(
    "name",
    [name if name in SOME else pytest.param(name, marks=pytest.mark.slow) for name in HEYOKA],
)
def test_heyoka_in_all_its_ways(name: str) -> None:
    if "parallel" in name:
        pytest.skip("parallel_mode: its threads do not pay in double; it runs with the trade-off")
    # rounding, and dense output whose last term is a tenth of eps of the largest entry, about 5
    assert error(name, 0.0) < 100 * 5 * float(DOUBLE.eps)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_a_tolerance_is_heeded(tolerance: float) -> None:
    assert 1e-4 * tolerance < error("heyoka", tolerance) < 1e3 * tolerance


@pytest.mark.slow
def test_odefun_in_many_digits() -> None:
    assert error("mpmath odefun", 0.0, until="0.01", precision=precision_named("mp", 80)) < 1e-15


@pytest.mark.peers
@pytest.mark.parametrize("coordinates", ["newton", "euler"])
@pytest.mark.parametrize("name", PEERS)
def test_peers_converge_to_golden_data(name: str, coordinates: str) -> None:
    if name == "mpmath odefun":
        pytest.skip("takes no tolerance; tested above")
    missing = METHODS[name].missing
    assert not missing, f"needs {missing}; make peers installs every extra"
    coarse, fine = (1e-4, 1e-6) if "Radau" in name else (1e-5, 1e-9)
    errors = [error(name, tolerance, coordinates) for tolerance in (coarse, fine)]
    assert errors[1] < (0.2 if any(one in name for one in LOOSE) else 1e-2) * errors[0]
    assert errors[1] < 1e4 * fine


def test_every_trial_of_the_plans_has_a_method() -> None:
    groups = list(measure.whole())
    trials = [trial for group in groups for trial in group.trials]
    assert len(METHODS) == len(OWN) + len(METHODS_OF_PEERS)  # a name has one method
    assert {trial.method for trial in trials} <= set(METHODS)
    assert len({group.name for group in groups}) == len(groups)


def test_actions_are_timed_in_turn_each_beside_the_baseline() -> None:
    calls: list[str] = []
    a, b, baseline = (partial(calls.append, name) for name in "aby")
    times = interleaved([a, b], baseline, rounds=3, budget_s=10.0)
    assert "".join(calls) == "yayb" * 3
    assert [len(timing.seconds) for timing in times] == [3, 3]
    # what is too slow has one turn
    (slow,) = interleaved([lambda: sum(range(100_000))], int, rounds=5, budget_s=1e-9)
    assert len(slow.seconds) == 1
    # the median of the ratios: the fastest over the fastest would be 2, median over median 1.5
    times = [Timings([3.0, 2.0, 9.0], [1.0, 2.0, 3.0])]
    assert (times[0].median, times[0].ratio) == (3.0, 3.0)


FORMS = [*FORMULATIONS.values(), *CHEAPER.values()]
VALUES = {"alpha": 3 / 10, "I1": 131 / 350, "I3": 2 / 5, "mu": 0.07}
STATE = (0.3, -0.2, 0.9, 1.5, -0.4, 2.5, 0.11, -0.23)
bound_eps = 200  # some 120 operations, each off by half an eps, in another order


def called(form: Formulation, shape: str, parameters: list[float]) -> Any:
    """The rates at STATE by the text of a shape."""
    rates, state = flat(form, shape, parameters), STATE[: len(form.columns)]
    filled = [0.0] * len(state)
    if shape == "callback":
        rates(filled, 0.0, state, parameters)
    elif shape == "filling":
        rates(0.0, state, filled)
    else:
        filled = rates(0.0, state)
    return numpy.array(filled)


@pytest.mark.parametrize("form", FORMS, ids=lambda f: f"{f.model}-{f.coordinates}-{f.columns[-1]}")
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_gives_the_rates(form: Formulation, shape: str) -> None:
    parameters = [VALUES[name] for name in form.parameters]
    state = form.State(*STATE[: len(form.columns)])
    expected = numpy.array(form.rates(form.body(parameters), state, math))
    bound = bound_eps * numpy.finfo(float).eps * numpy.abs(expected).max()
    assert numpy.abs(called(form, shape, parameters) - expected).max() < bound
    if "mu" in form.parameters:
        other = [VALUES[name] * (1 + 1e-9 * (name == "mu")) for name in form.parameters]
        assert numpy.abs(called(form, shape, other) - expected).max() > bound


def test_common_subexpressions_are_taken_out() -> None:
    text = source(FORMULATIONS["gliding", "newton"], "callback")
    assert text.count("x0") > 2
    assert "p[3]" in text
