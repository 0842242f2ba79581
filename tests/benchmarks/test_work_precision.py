"""Every method of the trade-off does what it says, and the truth shows what it does not."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from benchmarks.work_precision import long_runs, measure
from benchmarks.work_precision.__main__ import main
from benchmarks.work_precision.findings import GROWING, GROWTH, TABLE
from benchmarks.work_precision.heyoka_methods import OWN
from benchmarks.work_precision.measure import METHODS, Group, Timings, Trial, interleaved
from benchmarks.work_precision.peers import PEERS, SHAPES, Method, Settings, flat
from benchmarks.work_precision.problem import GoldenProblem, StateErrors, golden_problem
from tests.conftest import Captured, Patch
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import CHEAPER, FORMULATIONS, Formulation
from tt_precise.runtime.values import InputError

DOUBLE, QUAD, WIDE, MANY = (
    Settings(0.0, precision_named(*words))
    for words in (("double",), ("quad",), ("mp", 200), ("mp", 80))
)
EPS = float(DOUBLE.precision.eps)
SHORT = golden_problem("reference", "newton", "0.03")
DEFAULT = ("heyoka", "heyoka, contact watched", "tt_precise, tolerance")  # compile in a second
OTHERS = [
    way.name for way in OWN
    if way.name not in DEFAULT and "digits" not in way.name and "parallel" not in way.name
]  # fmt: skip
LOOSE = ("Radau", "RK45", "BDF", "odeint", "LSODA", "Adams")


def errors(problem: GoldenProblem, method: str, settings: Settings, fault: Any = 0) -> StateErrors:
    """The errors of a method at all samples, ``fault`` added to kx at the last."""
    solve = METHODS[method].prepare(problem, settings)
    times = problem.clock(settings.precision, problem.times)
    run = solve(times)
    states = [list(state) for state in run.states]
    states[-1][0] += fault
    return problem.truth.errors(states, settings.precision, None if run.published else times)


def slow(*case: Any) -> Any:
    return pytest.param(*case, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("problem", "method", "settings", "error", "least", "most"),
    [
        # dense output ends with a term of a tenth of eps of the largest entry, about 5
        *((SHORT, way, DOUBLE, "error_on_way", 0, 500 * EPS) for way in DEFAULT),
        *(slow(SHORT, way, DOUBLE, "error_on_way", 0, 500 * EPS) for way in OTHERS),
        (SHORT, "heyoka", DOUBLE._replace(tolerance=1e-6), "error_on_way", 1e-10, 1e-3),
        (SHORT, "heyoka", DOUBLE._replace(tolerance=1e-9), "error_on_way", 1e-13, 1e-6),
        # golden data have 34 decimals, and quad a few eps
        *((SHORT, "heyoka", QUAD, error, 0, 1e-32)
          for error in ("error", "error_on_way", "jellett_drift")),
        (golden_problem("reference", "euler", "0.03"), "heyoka", QUAD, "error", 0, 1e-31),
        (golden_problem("rolling", "newton", "0.03"), "heyoka", DOUBLE, "error", 0, 1e-13),
        slow(golden_problem("reference", until="0.01"), "mpmath odefun", MANY, "error", 0, 1e-15),
        # more bits go below golden data
        slow(replace(SHORT, truth_bits=260), "heyoka", WIDE, "error", 0, 1e-55),
        slow(SHORT, "heyoka", WIDE, "error", 1e-36, 1),
    ],
)  # fmt: skip
def test_errors_are_those_of_the_arithmetic_or_the_tolerance(
    problem: GoldenProblem, method: str, settings: Settings, error: str, least: float, most: float
) -> None:
    assert least <= getattr(errors(problem, method, settings), error) < most


@pytest.mark.peers
@pytest.mark.parametrize("coordinates", ["newton", "euler"])
@pytest.mark.parametrize("name", [peer.name for peer in PEERS if peer.name != "mpmath odefun"])
def test_peers_converge_to_golden_data(name: str, coordinates: str) -> None:
    missing = METHODS[name].missing
    assert not missing, f"needs {missing}; make peers installs every extra"
    problem = golden_problem("reference", coordinates, "0.05")
    tolerances = (1e-4, 1e-6) if "Radau" in name else (1e-5, 1e-9)
    coarse, fine = (
        errors(problem, name, DOUBLE._replace(tolerance=tolerance)).error_on_way
        for tolerance in tolerances
    )
    assert fine < (0.2 if any(word in name for word in LOOSE) else 1e-2) * coarse
    assert fine < 1e4 * tolerances[1]


@pytest.mark.parametrize("coordinates", ["newton", "euler"])
def test_an_error_of_the_state_is_found(coordinates: str) -> None:
    problem = golden_problem("reference", coordinates, "0.03")
    found = errors(problem, "heyoka", DOUBLE, fault=1e-9)
    # 1e-9 in the axis, and in the contact velocity what the spin of about 7 makes of it
    assert 0.5e-9 < found.error < 1e-8
    assert found.jellett_drift > 1e-12
    # max ignores NaN, which is infinitely wrong
    assert errors(problem, "heyoka", DOUBLE, fault=math.nan).error == math.inf


def test_the_rounding_of_the_time_is_no_error_of_the_method() -> None:
    problem = golden_problem("reference", "newton", "0.3")
    times = problem.clock(DOUBLE.precision, problem.times)
    states = METHODS["heyoka"].prepare(problem, DOUBLE)(times).states
    for factor, right in ((1, True), (1 + 1e-12, False)):
        given = [t * factor for t in times]
        assert (problem.truth.errors(states, DOUBLE.precision, given).error < 1e-14) == right


def test_the_horizon_is_a_golden_time() -> None:
    lost = golden_problem("contact-lost")
    assert lost.times[-1] == lost.until < lost.scene.until
    with pytest.raises(InputError, match="time of the golden data"):
        golden_problem("reference", "newton", "0.0123")


PLAN = (
    Trial("heyoka", 1e-6, until="0.03"),
    Trial("heyoka", 0.0, until="0.03"),
    Trial("SciPy DOP853, Python", 1e-9, until="0.03"),
)


@pytest.mark.evidence
def test_the_tables_are_written_and_the_findings_printed(
    tmp_path: Path, capsys: Captured, monkeypatch: Patch
) -> None:
    growth = pandas.DataFrame(
        [{"scene": "rolling", "seed": seed, "t_s": t,
          "jellett": 1e-16 * t**0.5, "energy": 1e-16 * t}
         for seed in range(3) for t in (1.0, 10.0, 1000.0)]
    )  # fmt: skip
    monkeypatch.setattr(measure, "whole", lambda: iter([Group("small", PLAN, 2, 0.1)]))
    monkeypatch.setattr(measure, "WORKLOAD_ROUNDS", 2)
    monkeypatch.setattr(long_runs, "table", lambda spans, progress: growth)
    main(["--out", str(tmp_path)])
    printed = capsys.readouterr().out
    for name, exponent in (("lambda", "0.5"), ("E", "1")):
        assert f"growth of {name}, rolling, to 1e+03 s: {exponent}" in printed
    assert len(pandas.read_csv(tmp_path / GROWTH)) == 9
    rows = pandas.read_csv(tmp_path / TABLE).dropna(subset="error")
    assert rows["method"].tolist() == [trial.method for trial in PLAN]
    assert rows["peer"].astype(str).tolist() == ["False", "False", "True"]
    loose, tight, _ = rows["error"]
    assert tight < 1e-12 < loose
    assert (rows["seconds"] > 0).all()
    assert (rows["jellett_drift"] < 1e-4).all()


def test_what_is_missing_and_what_fails_is_skipped_with_a_line(monkeypatch: Patch) -> None:
    assert {trial.method for group in measure.whole() for trial in group.trials} <= set(METHODS)
    assert len(METHODS) == len(OWN) + len(PEERS)  # a name has one method
    missing = Method(PLAN[2].method, ("nowhere",), METHODS["heyoka"].prepare)
    monkeypatch.setitem(measure.METHODS, missing.name, missing)
    monkeypatch.setattr(measure, "WORKLOAD_ROUNDS", 2)
    at_pole = Trial("heyoka", 0.0, scene="upright", coordinates="euler", until="0.03")
    plan = [Group("small", (PLAN[0], at_pole, PLAN[2]), 1, 0.1)]
    lines: list[str] = []
    measured = measure.measure(plan, lines.append)
    assert len(measured.rows) == 1
    assert lines[:2] == [f"skipped: {line}" for line in measured.skipped]
    assert measured.skipped[0].startswith("upright, heyoka")
    assert "needs nowhere" in measured.skipped[1]


def test_short_runs_of_the_long_ones_stay_within_rounding(monkeypatch: Patch) -> None:
    monkeypatch.setattr(long_runs, "LONG_SCENES", ("rolling",))
    monkeypatch.setattr(long_runs, "LANES", 2)
    growth = long_runs.table((long_runs.LongRuns(2, 10.0),))
    assert len(growth) == 2 * len(long_runs.log_spaced(10.0))
    for name in GROWING:
        assert 0 < growth[name].abs().max() < 100 * EPS


def test_actions_are_timed_in_turn_each_after_the_baseline() -> None:
    calls: list[str] = []
    a, b, baseline = (partial(calls.append, name) for name in "aby")
    times = interleaved([a, b], baseline, rounds=3, budget_s=10.0)
    assert "".join(calls) == "yayb" * 3
    assert [len(timing.seconds) for timing in times] == [3, 3]
    # a slow action has one turn
    (slow,) = interleaved([lambda: sum(range(100_000))], int, rounds=5, budget_s=1e-9)
    assert len(slow.seconds) == 1
    # the median of the ratios: the fastest over the fastest would be 2, median over median 1.5
    assert Timings([3.0, 2.0, 9.0], [1.0, 2.0, 3.0]).ratio == 3


FORMS = [*FORMULATIONS.values(), *CHEAPER.values()]
VALUES = {"alpha": 3 / 10, "I1": 131 / 350, "I3": 2 / 5, "mu": 0.07}
STATE = (0.3, -0.2, 0.9, 1.5, -0.4, 2.5, 0.11, -0.23)
bound_eps = 200  # some 120 operations, each off by half an eps, in another order


def called(form: Formulation, shape: str, parameters: list[float]) -> Any:
    """The rates at STATE by the text of a shape."""
    rates, state = flat(form, shape, parameters), STATE[: len(form.columns)]
    filled = [0.0] * len(state)
    given = {"callback": (filled, 0.0, state, parameters), "filling": (0.0, state, filled)}
    returned = rates(*given.get(shape, (0.0, state)))
    return numpy.array(filled if shape in given else returned)


@pytest.mark.parametrize("form", FORMS, ids=lambda f: f"{f.model}-{f.coordinates}-{f.columns[-1]}")
@pytest.mark.parametrize("shape", SHAPES)
def test_every_shape_gives_the_rates(form: Formulation, shape: str) -> None:
    parameters = [VALUES[name] for name in form.parameters]
    state = form.State(*STATE[: len(form.columns)])
    expected = numpy.array(form.rates(form.body(parameters), state, math))
    bound = bound_eps * EPS * numpy.abs(expected).max()
    assert numpy.abs(called(form, shape, parameters) - expected).max() < bound
    if "mu" in form.parameters:
        other = [VALUES[name] * (1 + 1e-9 * (name == "mu")) for name in form.parameters]
        assert numpy.abs(called(form, shape, other) - expected).max() > bound
