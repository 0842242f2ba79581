"""The balance of changes and rates, and solutions followed over a span: error bounds hold."""

import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from math import comb
from types import SimpleNamespace
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Engine, Healthy, check
from tt_precise.check.columns import COLUMN_SETS, CheckSetup
from tt_precise.check.equations import (
    EPS,
    MOST_STEPS,
    EquationResidual,
    SummedResidual,
    follow,
    integral,
)
from tt_precise.check.sources import open_source


def balance(frame: pandas.DataFrame, columns: str, scene: str = "reference") -> tuple[Any, Any]:
    setup = CheckSetup(tt.load_scene(scene), COLUMN_SETS[columns], True)
    block = open_source(frame).read(("t", *setup.columns.names))
    samples = setup.samples(block)
    return EquationResidual(setup, samples).balance(samples), samples


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
@pytest.mark.parametrize("rows", [41, 161, 801, 1601])
def test_the_error_bound_holds(healthy: Healthy, columns: str, rows: int) -> None:
    found, _ = balance(healthy("reference", rows), columns)
    resolved = found.bound < 1e-6
    error = numpy.abs(numpy.vstack((found.state, found.energy)))[:, resolved].max(axis=0)
    # the states themselves are rounded, and the coarser the steps, the larger their powers
    assert (error <= found.bound[resolved] + 1e-12).all()
    assert resolved.mean() > (0.99 if rows > 80 else 0.2)


def test_dense_rows_are_passed_over_and_nothing_is_lost(healthy: Healthy) -> None:
    frame = healthy("reference", 20001, 0.5)
    found, samples = balance(frame, "vectors")
    assert len(found.ends) < len(samples.t) / 5
    assert found.ends[-1] == len(samples.t) - 1
    change = frame["Lz"].iloc[len(samples.t) - 1] - frame["Lz"].iloc[0]
    assert abs(change) > 1e-8
    assert abs(found.state).max() < 1e-13


def test_coarse_rows_are_reported_with_the_spacing_that_would_do(healthy: Healthy) -> None:
    result = check(healthy("reference", 9), "reference")
    equations = result["equations"]
    assert (equations.verdict, result.passed) == ("open", True)
    assert equations.note.startswith("rows too far apart; ")
    assert "8 of 8 intervals too wide; rows 0.1 s apart would do" in equations.note
    closer = check(healthy("reference", 81), "reference")["equations"]
    assert (closer.verdict, "too wide" in closer.note) == ("pass", False)


def test_a_few_resolved_intervals_do_not_vouch_for_the_others(healthy: Healthy) -> None:
    """The last ten rows are of a top that has stopped gliding, at once."""
    few = healthy().iloc[[0, 1, 2, *range(80, 801, 80)]].copy()
    few.loc[80:, ["vx", "vy"]] = 0.0
    result = check(few[VECTORS], "reference")
    for name in ("equations", "energy_balance"):
        assert result[name].verdict == "open"
        assert "; 10 of 12 intervals too wide" in result[name].note


@pytest.mark.parametrize(("name", "columns"), [("Ly", VECTORS), ("theta_dot", EULER)])
@pytest.mark.parametrize("size", [1e-3, 1e6, 1e30])
def test_a_wrong_first_row_fails_however_wrong_it_is(
    healthy: Healthy, name: str, columns: list[str], size: float
) -> None:
    """Nothing can be followed from it, and it says what the others are measured in."""
    frame = healthy("reference", 801)[columns]
    frame.loc[0, name] += size * abs(frame[name]).max()
    found = check(frame, "reference")["equations"]
    assert (found.verdict, "too wide" in found.note) == ("fail", False)


@pytest.mark.parametrize(
    ("scene", "name", "row"),
    [("contact-lost", "ky", 104), ("kicked", "Ly", 401), ("flight", "height", 7)],
)
def test_a_wrong_row_is_named_and_nothing_else_is_blamed(scene: str, name: str, row: int) -> None:
    """A solution through it would leave the table, and its balance returns to 0 behind it."""
    height = ("height", "rise") if scene == "flight" else ()
    frame = tt.integrate(scene).frame(*VECTORS[1:], *height)
    frame.loc[row, name] += abs(frame[name]).max()
    result = check(frame, scene)
    assert [cause.text for cause in result.causes] == [
        f"the row at t = {frame['t'][row]:.6g} s (number {row + 1}) alone is wrong"
    ]
    for finding in result.checks:
        assert "leaves the table" not in finding.note
        assert "--friction other" not in finding.note


def test_the_series_of_a_far_row_leaves_no_table(healthy: Healthy) -> None:
    frame = healthy("reference", 161)[VECTORS]
    note = check(frame.assign(t=1.5 * frame["t"]), "reference")["equations"].note
    assert note.startswith("error bound")
    assert "leaves the table" not in note


@pytest.mark.parametrize("every_ms", [1, 2, 5, 10, 20])
def test_a_wrong_term_is_found_at_every_spacing(engine: Engine, every_ms: int) -> None:
    def found(**words: Any) -> Any:
        return check(engine(1000, 0.2, **words)[::every_ms], "reference", until=0.2)["equations"]

    # the engine is off by 1e-8; the terms by what the 1 ms rows say, within a factor
    healthy = found()
    assert healthy.verdict == "pass"
    assert healthy.value < 1e-6 / 5
    for words, size in (({"fault": "no gyroscopic term"}, 1e-3), ({"mu": 0.3003}, 2e-5)):
        wrong = found(**words)
        assert wrong.verdict == "fail"
        assert size / 4 < wrong.value < 4 * size, words


def test_between_sticking_and_slipping_other_equations_are_found() -> None:
    scene = tt.load_scene("coulomb-stick-slip")
    frame = pandas.DataFrame(tt.golden.load(scene.name))[VECTORS]
    healthy = check(frame, scene)["equations"]
    assert (healthy.verdict, "interval" in healthy.note) == ("pass", False)
    assert "apart would do" not in healthy.note
    for name in ("mu", "I3"):
        more = {name: getattr(scene.body, name) * Fraction("1.001")}
        other = replace(scene, body=replace(scene.body, **more))
        assert check(frame, other)["equations"].verdict == "fail", name


def test_what_was_summed_so_far_goes_on_in_the_next_block() -> None:
    """Two blocks of one interval each, off by 1 and by 2."""
    residual: Any = SimpleNamespace(setup=SimpleNamespace(joins=False))
    total = SummedResidual(residual, "state", 0.5)
    samples: Any = SimpleNamespace(t=numpy.array([0.0, 1.0]))
    nothing, ends = numpy.zeros(1), numpy.array([1])
    for off, expected in ((1.0, 1.0), (2.0, 3.0)):
        found = SimpleNamespace(bound=nothing, within=nothing, ends=ends, state=[[off]] * ends)
        residual.balance = lambda _, found=found: found
        assert total(samples).tolist() == pytest.approx([0, expected])


def test_hermites_rule_is_exact_up_to_its_degree_and_not_beyond() -> None:
    for terms in (1, 2, 3, 5, 8, 13):
        for degree, exact in ((2 * terms - 1, True), (2 * terms, False)):
            # h^degree about 0 and about 1, over [0, 1]; its integral is 1/(degree + 1)
            left = numpy.zeros((1, 2 * terms + 1, 1))
            left[0, degree] = 1
            right = numpy.array([[[comb(degree, j)] for j in range(degree + 1)]], float)
            found = integral(left[:, :terms], right[:, :terms], numpy.ones(1), terms)[0, 0]
            error = abs(found * (degree + 1) - 1)
            # the weights alternate: their sum loses up to 2^terms eps
            assert (error < 2 ** (2 * terms) * EPS) == exact, (terms, degree, error)


# Solutions followed over a span: closed forms, and an error that is not beyond its bound.

ONE = numpy.ones(1)


def oscillator(y: tuple[Any, ...]) -> list[Any]:
    return [y[1], -y[0]]


def growing(y: tuple[Any, ...]) -> list[Any]:
    return [1.0 * y[0]]


def test_every_row_ends_after_its_own_span() -> None:
    spans = numpy.array([0.1, 1.0, 15.0])
    start = numpy.array([[1.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
    found = follow(oscillator, start, spans, numpy.ones(2), 1e-9)
    wanted = numpy.array([start[0] * numpy.cos(spans), -start[0] * numpy.sin(spans)])
    assert (abs(found.state - wanted) <= found.error).all()
    assert (found.error < 100 * EPS).all()  # 24 steps of a motion in which nothing grows
    assert (found.reached == spans).all()


@pytest.mark.parametrize("span", [1.0, 5.0, 10.0])
def test_the_error_bound_grows_as_the_solution_does(span: float) -> None:
    found = follow(growing, numpy.array([[1.0]]), span * ONE, ONE, 1e-6)
    assert abs(found.state[0, 0] - math.exp(span)) <= found.error[0]
    assert 4 * EPS * math.exp(span) < found.error[0] < 400 * EPS * math.exp(span)


@pytest.mark.parametrize(
    ("rates", "start", "span", "least", "most"),
    [
        # 4 eps e^t passes 1e-9 at t = 14; some eps a step come on top
        (growing, [1.0], 30.0, 8.0, 14.0),
        # x = 1/(1 - t)
        (lambda y: [y[0] * y[0]], [1.0], 2.0, 0.9, 1.0),
        (growing, [math.nan], 1.0, 0.0, 0.0),
        # a step is some e^-2 of the radius that twenty terms show: 20!^(1/20) = 8.3
        (oscillator, [1.0, 0.0], 1e6, 1.01 * MOST_STEPS, 1.24 * MOST_STEPS),
    ],
)
def test_what_cannot_be_followed_is_given_up_where_it_cannot(
    rates: Callable[..., Any], start: list[float], span: float, least: float, most: float
) -> None:
    y = numpy.array(start)[:, None]
    with numpy.errstate(all="ignore"):
        found = follow(rates, y, span * ONE, numpy.ones(len(y)), 1e-6 if len(y) > 1 else 1e-9)
    assert found.error[0] == numpy.inf
    assert least <= found.reached[0] <= most
