"""Rows carried to the next ones: error bounds hold, and the smallest errors are seen."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Engine, Healthy, check
from tests.conftest import more
from tt_precise.check import equations
from tt_precise.check.columns import COLUMN_SETS, CheckSetup
from tt_precise.check.equations import (
    APART,
    FEW,
    FEW_STEPS,
    Differences,
    _added_up,
    _gone,
    differences,
    through_switches,
)
from tt_precise.check.flow import MOST_STEPS, FlowEnd, flow
from tt_precise.check.sources import open_source

# What explains a failure is tested elsewhere.
without_causes = pytest.mark.usefixtures("no_cause")


def apart(frame: pandas.DataFrame, columns: str, scene: str = "reference") -> Differences:
    setup = CheckSetup(tt.load_scene(scene), COLUMN_SETS[columns], True)
    block = open_source(frame).load(("t", *setup.columns.names))
    return differences(setup.samples(block))


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
@pytest.mark.parametrize("rows", [41, 161, 801, 1601])
def test_the_error_bound_holds(healthy: Healthy, columns: str, rows: int) -> None:
    found = apart(healthy("reference", rows), columns)
    resolved = found.bound < 1e-6
    error = numpy.abs(numpy.vstack((found.state, found.energy)))[:, resolved].max(axis=0)
    assert (error <= found.bound[resolved] + 1e-12).all()
    assert resolved.all()


@without_causes
def test_dense_rows_are_all_looked_at(healthy: Healthy) -> None:
    """A cell of one of 20,001 rows 25 us apart; a drift of one column that is as small in each."""
    frame = healthy("reference", 20001, 0.5)[VECTORS]
    found = apart(frame, "vectors")
    assert len(found.bound) == 20000
    assert abs(found.state).max() < 1e-13
    assert found.bound.sum() < 1e-10
    size = abs(frame["Lz"]).max()
    frame.loc[7001, "Lz"] += 2e-6 * size
    cell = check(frame, "reference", limits={"jellett": 1.0, "energy": 1.0})["equations"]
    assert (cell.verdict, cell.at) == ("fail", frame["t"][7001])
    drift = healthy("reference", 20001, 0.5)[VECTORS]
    drift["Lz"] += 2e-6 * size * drift["t"] / 0.5
    seen = check(drift, "reference")["equations"].value or 0.0
    assert 2e-6 < seen < 1e-5  # what glides wrongly by it counts as well
    # the same at every spacing
    coarse = drift.iloc[::400].reset_index(drop=True)
    assert check(coarse, "reference")["equations"].value == pytest.approx(seen, rel=0.15)


def test_the_spacing_that_would_do_is_the_shortest_that_was_reached() -> None:
    bound, reached = numpy.array([1e-12, 1.0, 1.0, 1e-12]), numpy.array([1.0, 0.58, 0.73, 1.0])
    none = numpy.zeros((1, 4))
    found = Differences(none, none, none[0], bound, reached, none[0])
    note = _added_up(none, found, 1e-6).note
    assert note.endswith("; 2 of 4 intervals too wide; rows 0.5 s apart would suffice")
    nothing = found._replace(reached=numpy.zeros(4))
    assert _added_up(none, nothing, 1e-6).note.endswith("intervals too wide")


@without_causes
@pytest.mark.evidence
def test_coarse_rows_are_reported_with_the_spacing_that_would_do(healthy: Healthy) -> None:
    result = check(healthy("reference", 9), "reference")
    equations = result["equations"]
    assert (equations.verdict, result.passed) == ("open", True)
    assert equations.note.startswith("rows too far apart; ")
    assert "7 of 8 intervals too wide; rows 0.5 s apart would suffice" in equations.note
    closer = check(healthy("reference", 17), "reference")["equations"]
    assert (closer.verdict, "too wide" in closer.note) == ("pass", False)


@without_causes
def test_equations_are_open_where_most_intervals_are_too_wide(healthy: Healthy) -> None:
    """The last four rows are of a top that has stopped gliding, at once."""
    few = healthy().iloc[[0, 1, 2, *range(200, 801, 200)]].copy()
    few.loc[200:, ["vx", "vy"]] = 0.0
    result = check(few[VECTORS], "reference")
    for name in ("equations", "energy_balance"):
        assert result[name].verdict == "open"
        assert "; 4 of 6 intervals too wide" in result[name].note


@without_causes
@pytest.mark.parametrize(("name", "columns"), [("Ly", VECTORS), ("theta_dot", EULER)])
@pytest.mark.parametrize("size", [1e-3, more(1e6), 1e30])
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
    assert result["equations"].since == frame["t"][row]
    (cause,) = result.causes
    here = f"the row at t = {frame['t'][row]:.6g} s (number {row + 1}) alone"
    # a top that lifts has no solution to compare the columns with
    said = f"{here} is wrong" if scene == "flight" else f"in {here} {name} is "
    assert cause.text.startswith(said)
    assert scene == "flight" or cause.text.endswith("every other column is right to 12 digits")
    for finding in result.checks:
        assert "leaves the table" not in finding.note
        assert "--friction other" not in finding.note


@without_causes
def test_the_series_of_a_far_row_leaves_no_table(healthy: Healthy) -> None:
    frame = healthy("reference", 161)[VECTORS]
    note = check(frame.assign(t=1.5 * frame["t"]), "reference")["equations"].note
    assert note.startswith("error bound")
    assert "leaves the table" not in note


@without_causes
@pytest.mark.parametrize("every_ms", [1, more(2), more(5), more(10), 20])
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


@without_causes
def test_between_sticking_and_slipping_other_equations_are_found() -> None:
    scene = tt.load_scene("coulomb-stick-slip")
    frame = pandas.DataFrame(tt.golden.load(scene.name))[VECTORS]
    healthy = check(frame, scene)["equations"]
    assert (healthy.verdict, "interval" in healthy.note) == ("pass", False)
    assert "apart would suffice" not in healthy.note
    for name in ("mu", "I3"):
        more = {name: getattr(scene.body, name) * Fraction("1.001")}
        other = replace(scene, body=replace(scene.body, **more))
        assert check(frame, other)["equations"].verdict == "fail", name


@without_causes
@pytest.mark.parametrize(
    ("columns", "names", "factor", "rows", "more"),
    [
        (EULER, "theta", 1.0, 41, 40 * MOST_STEPS),
        (EULER, "theta_dot phi_dot omega_3", 57.3, 801, FEW * FEW_STEPS),
        (VECTORS, "vx vy", 100.0, 801, FEW * FEW_STEPS),
        (VECTORS, "t", 1.05, 81, FEW * MOST_STEPS),
    ],
)
def test_rows_that_have_left_the_equations_are_not_carried_in_many_steps(
    healthy: Healthy,
    monkeypatch: pytest.MonkeyPatch,
    columns: list[str],
    names: str,
    factor: float,
    rows: int,
    more: int,
) -> None:
    """Coarse rows that are right; rates in degrees, velocities in cm/s, coarse rows too slow."""
    asked: list[int] = []

    def counted(*given: Any, most: int = MOST_STEPS, **words: Any) -> Any:
        asked.append(len(given[3]) * most)
        return flow(*given, most=most, **words)

    monkeypatch.setattr(equations, "flow", counted)
    frame = healthy("reference", rows)[columns]
    frame[names.split()] *= factor
    found = check(frame, "reference")
    assert sum(asked) == rows - 1 + more
    assert (found.verdict == "fail") == (factor != 1)


@without_causes
def test_a_limit_of_any_size_decides_about_rows_that_have_left_the_equations() -> None:
    """Coarse rows of another mu: not all are carried, unless the limit asks for it."""
    rubbed = tt.load_scene("reference").varied(mu="0.31")
    frame = tt.integrate(rubbed).frame(*VECTORS[1:], times=[i / 10 for i in range(81)])
    usual = check(frame, "reference")
    for name in ("equations", "energy_balance"):
        assert usual[name].verdict == "fail"
        assert "48 of 80 intervals not looked at" in usual[name].note
        assert "too wide" not in usual[name].note
    limits = {"equations": 0.1, "energy_balance": 0.1}
    allowed = check(frame, "reference", limits=limits)
    for name, least in (("equations", 0.05), ("energy_balance", 0.01)):
        assert allowed[name].verdict == "pass"
        assert least < (allowed[name].value or 0.0) < 0.1
        assert allowed[name].note == "error bound 7e-09"


@pytest.mark.parametrize(("bound", "gone"), [(4e-4, True), (6e-4, False)])
def test_rows_are_gone_only_beyond_the_bounds(bound: float, gone: bool) -> None:
    """Four intervals leave by 2e-3 in all."""
    none, error = numpy.zeros(4), numpy.array([bound, bound, bound, numpy.inf])
    end = FlowEnd(numpy.zeros((8, 4)), error, none, none, none)
    assert _gone(numpy.full((12, 4), 8e-4), end, APART) == gone


def test_where_equations_may_change_no_interval_is_left_out() -> None:
    """An interval that the flow does not reach is integrated, however far the rows have left."""
    frame = pandas.DataFrame(tt.golden.load("coulomb-stick-slip"))[::5][VECTORS]
    frame[["vx", "vy"]] *= 100
    found = apart(frame, "vectors", "coulomb-stick-slip")
    assert (found.left, found.joints) == (0, (5, 5))


def test_a_contact_point_that_leaves_rest_may_come_to_rest_at_once() -> None:
    """Its speed is 0 again before the first step ends."""
    row = numpy.array(
        [0.10016434322361982, -0.04748278923863743, 0.9938372548222874, 4.921118421627991e-05,
         -1.9907265666317183e-05, 0.00046564049859854897, 0.0, 0.0]
    )  # fmt: skip
    end, reached, _ = through_switches(tt.load_scene("coulomb-gliding"), row, 0.005)
    assert reached == pytest.approx(0.005)
    assert numpy.isfinite(end).all()
    assert not end[6:].any()
