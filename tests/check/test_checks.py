"""Healthy trajectories pass; every check has been seen failing."""

from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, POSE, VECTORS, Engine, check, rows_of, solved, vectors
from tests.conftest import Patch, more
from tt_precise.check import checks, residuals
from tt_precise.check.checks import CHECKS
from tt_precise.check.residuals import StepResiduals, torque_unit

# Causes are tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")

# Double holds the integrals to some eps (2e-16); the state passed 1,400 steps of one eps each,
# the sums over 801 rows add as much again.
DOUBLE = 1e-13
RELATIVE = [one.name for one in CHECKS if one.sense == "at most"]


@pytest.mark.parametrize("columns", [VECTORS, EULER], ids=["vectors", "Euler"])
@pytest.mark.parametrize("scene", ["reference", "frictionless", "rolling", "phi-dot-195"])
def test_a_healthy_trajectory_passes_at_the_limit_of_double(scene: str, columns: list[str]) -> None:
    result = check(solved(columns, scene=scene), scene, limits=dict.fromkeys(RELATIVE, DOUBLE))
    assert result.passed, str(result)
    assert result.rows == 801
    passed = {each.name for each in result.checks if each.verdict == "pass"}
    assert passed >= {"jellett", "energy", "contact"}
    if scene == "rolling":
        assert passed >= {"routh", "modified_energy", "contact_velocity"}
    if scene == "frictionless":
        assert passed >= {"spin", "vertical_angular_momentum"}
        assert ("momentum_x" in passed) == (columns is VECTORS)


def spoilt(frame: pandas.DataFrame, name: str, factor: float) -> pandas.DataFrame:
    """Return a table with the second half of a column multiplied."""
    frame.loc[len(frame) // 2 :, name] *= factor
    return frame


@pytest.mark.parametrize(
    ("scene", "column", "name"),
    [
        ("reference", "Lz", "jellett"),
        ("upright", "kz", "axis_norm"),
        ("reference", "Lz", "equations"),
        ("reference", "vx", "energy_balance"),
        ("frictionless", "Lz", "energy"),
        ("frictionless", "Lz", "spin"),
        ("frictionless", "Lz", "vertical_angular_momentum"),
        ("frictionless", "vx", "momentum_x"),
        ("rolling", "Lz", "routh"),
        ("rolling", "Lz", "modified_energy"),
    ],
)
def test_a_small_error_fails(scene: str, column: str, name: str) -> None:
    limits, frame = {name: 1e-9}, vectors(scene=scene)
    assert check(frame, scene, limits=limits)[name].verdict == "pass"
    wrong = check(spoilt(frame, column, 1 + 1e-7), scene, limits=limits)[name]
    assert wrong.verdict == "fail"
    assert 1e-9 < (wrong.value or 0) < 1e-5
    assert (wrong.at or 0) >= 4


LIFTING = ("flight", "elastic-linear", "elastic-hunt-crossley", "coulomb-flight")


@pytest.mark.parametrize("scene", LIFTING)
def test_rounded_rows_of_a_top_that_lifts_pass(scene: str) -> None:
    """Six decimals of the height are fewer digits than those of the velocities."""
    rows = solved(POSE, 80, 1000, scene).round(6)
    assert check(rows, scene).passed
    rows.loc[40:, "vcz"] += 0.01
    assert check(rows, scene).verdict == "fail"


def backwards(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Return the same states in the other order of time: their rates change sign."""
    back = frame.iloc[::-1].reset_index(drop=True)
    back["t"] = back["t"][0] - back["t"]
    rates = [*VECTORS[4:], *POSE[5:11]]
    return back.assign(**{name: -back[name] for name in rates if name in back})


def test_energy_may_fall_but_not_rise() -> None:
    there = vectors()
    assert check(there, "reference")["energy"].value == 0
    back = backwards(there)[1:]
    rise = check(pandas.concat([there, back.assign(t=back["t"] + 8)]), "reference")["energy"]
    assert rise.verdict == "fail"
    assert rise.value == pytest.approx(0.618, rel=1e-2)


@pytest.mark.parametrize(("hertz", "asked"), [(1600, True), (1700, False)])
def test_dense_rows_under_another_force_do_not_ask_the_scene(hertz: int, asked: bool) -> None:
    assert checks.obeys_scene(rows_of(solved(POSE, 20, hertz), friction="other")) == asked
    soft = solved(POSE, 20, 2000, "stribeck")  # a kink of its friction is never dense
    assert checks.obeys_scene(rows_of(soft, "stribeck", friction="other"))


@pytest.mark.parametrize(("pull", "verdict"), [(0.9e-3, "pass"), (1.1e-3, "fail")])
def test_a_table_may_not_pull(pull: float, verdict: str) -> None:
    """A row falls faster than gravity makes it fall, by a part ``pull``."""
    frame = solved(POSE, 100, 960)
    frame.loc[50, "vcz"] = float(frame["vcz"][49]) - (1 + pull) * 9.82 / 960
    assert check(frame, "reference", friction="other")["normal_force"].verdict == verdict


def test_a_pulling_table_and_a_gliding_point_of_a_rolling_top_fail() -> None:
    frame = pandas.DataFrame(tt.golden.load("contact-lost"))[EULER]  # until g_n vanishes
    for change, verdict in ((0.0, "pass"), (1e-6, "fail")):
        wrong = frame.assign(theta=frame["theta"] * (1 + change * (frame.index == 134)))
        assert check(wrong, "contact-lost")["contact"].verdict == verdict
    gliding = vectors(scene="rolling").assign(vx=1e-3)
    assert check(gliding, "rolling")["contact_velocity"].verdict == "fail"


def test_another_friction_law_is_held_to_what_every_law_keeps() -> None:
    result = check(vectors(), "reference", friction="other")
    done = {each.name for each in result.checks if each.verdict in ("pass", "fail")}
    always = {"finite", "jellett", "energy", "axis_norm", "start", "agreement"}
    assert done == always | {"kinematics", "contact_momentum"}


def test_limits_have_the_name_of_the_check_or_of_the_quantity() -> None:
    zero = check(vectors(), "reference", limits={"lambda": 0.0, "contact": -1e-9})
    assert [(each.name, each.limit) for each in zero.failures] == [("jellett", 0.0)]
    assert zero["contact"].limit == -1e-9


@pytest.mark.parametrize("name", ["fall", "routh", "energy_balance"])
def test_a_demanded_limit_fails_where_its_check_is_not_made(name: str) -> None:
    rows = vectors(101)[VECTORS[:7]] if name == "energy_balance" else vectors(101)
    with pytest.raises(AssertionError, match=f"{name}: a limit was given"):
        tt.check.assert_conserves(rows, "reference", **dict[str, Any]({name: 1e-6}))


def test_the_callers_table_is_left_alone() -> None:
    frame = vectors()
    check(frame, "reference")
    pandas.testing.assert_frame_equal(frame, vectors())


@pytest.mark.parametrize(
    ("name", "columns", "roundings"),
    [
        ("jellett", ["Lx", "Ly", "Lz"], 4),
        ("axis_norm", ["kx", "ky", "kz"], 2),
        ("equations", ["vx"], 2 + 155 * 0.1),  # rates turn the error of a row for 0.1 s
    ],
)
def test_written_digits_hide_little(name: str, columns: list[str], roundings: float) -> None:
    frame = vectors(101, 1000).round(8)
    rounding = rows_of(frame).rounding
    for part, verdict in ((0.3, "open"), (1.7, "fail")):
        wrong = frame.copy()
        scale = 0.02 * 155 if name == "equations" else wrong.loc[100, columns]
        wrong.loc[100, columns] += part * roundings * rounding * scale
        assert check(wrong.round(8), "reference")[name].verdict == verdict


FAULTS = ("damped motion", "no gyroscopic term", "normal force is the weight", "friction pushes")


@pytest.mark.parametrize("hertz", [240, more(60), more(960)])
@pytest.mark.parametrize("fault", FAULTS)
def test_planted_faults_of_an_engine_fail(engine: Engine, fault: str, hertz: int) -> None:
    rows = engine(hertz, 0.5, fault=fault)
    assert check(rows, "reference").verdict == "fail"
    assert check(rows, "reference", friction="other").verdict != "pass"


@pytest.mark.parametrize("law", ["viscous", "regularised", more("stribeck"), more("soft")])
def test_right_engines_of_every_law_pass(engine: Engine, law: str) -> None:
    rows = engine(960, 0.25, law)
    rows.loc[::2, ["qw", "qx", "qy", "qz"]] *= -1  # the same rotations
    limits = {"contact_velocity": 0.01} if law == "soft" else {}
    result = check(rows, "reference", friction="other", limits=limits)
    assert not result.failures, str(result)
    assert (check(rows, "reference").verdict == "fail") == (law != "viscous")


ALONE = numpy.eye(100)[50]
FIRST = 1.0 * (numpy.arange(100) < 9)  # A mean over fewer than ten intervals is no more than these.


@pytest.mark.parametrize(
    ("name", "part", "values", "value", "verdict"),
    [
        ("kinematics", "rotation", 0.9e-3 * ALONE, 0.9e-2, "pass"),
        ("kinematics", "rotation", 1.1e-3 * ALONE, 1.1e-2, "fail"),
        ("kinematics", "rotation", 1.1e-4, 1.1e-2, "fail"),  # the sum
        ("contact_momentum", "momentum", 0.9e-4 * ALONE, 0.9e-4, "pass"),
        ("contact_momentum", "momentum", 1.1e-4 * ALONE, 1.1e-4, "fail"),
        ("contact_momentum", "momentum", 0.6e-4, 1.2e-4, "fail"),  # the mean
        ("contact_momentum", "momentum", 0.6e-4 * FIRST, 1.2e-4 * 9 / 11, "pass"),
        ("contact_momentum", "bound", 0.29, 0.0, "pass"),
        ("contact_momentum", "bound", 0.31, 0.0, "open"),
        # a fault may hide in any interval
        ("contact_momentum", "bound", numpy.where(ALONE, numpy.inf, 0), 0.0, "open"),
    ],
)
def test_intervals_and_sums_count_by_their_factors(
    name: str, part: str, values: Any, value: float, verdict: str, monkeypatch: Patch
) -> None:
    """An interval of the attitude counts ten times, the mean torque twice."""
    rows, quantities = rows_of(vectors(101), friction="other"), ("rotation", "position", "momentum")
    residual = {quantity: numpy.zeros((3, 100)) for quantity in quantities}
    bounds = {quantity: numpy.zeros(100) for quantity in quantities}
    changed = bounds["momentum"] if part == "bound" else residual[part][0]
    changed += values * (torque_unit(rows.body) * 0.01 if name == "contact_momentum" else 1.0)
    none: Any = dict.fromkeys(("energy", "least", "state"), numpy.empty((0, 100)))
    steps = StepResiduals(**residual, bounds=bounds, **none)
    monkeypatch.setattr(checks, "obeys_scene", lambda rows: False)
    monkeypatch.setattr(residuals, "by_any_force", lambda rows: steps)
    (row_check,) = (each for each in CHECKS if each.name == name)
    result = row_check.result(rows, row_check.limit)
    assert result.verdict == verdict
    assert result.value == pytest.approx(value, rel=1e-6, abs=1e-12)
    if part == "bound" and verdict == "pass":
        assert result.bound == pytest.approx(values, rel=1e-6)


@pytest.mark.parametrize(
    ("depth", "noted", "passes"),
    [(0.5e-6, False, True), (2e-6, True, True), (0.09, True, True), (0.11, False, False)],
)
def test_a_table_gives_way_by_a_tenth_of_R(depth: float, noted: bool, passes: bool) -> None:
    """Under another force; a depth is named, and no reason to allow a vertical velocity."""
    frame = solved(POSE, 100, 960)
    sunk = frame.assign(z=frame["z"] - depth * 0.02)
    result = check(sunk, "reference", friction="other")
    assert (result["kinematics"].verdict != "fail") == passes
    assert ("a soft contact" in result["contact_velocity"].note) == noted
    assert (check(sunk, "reference")["kinematics"].verdict == "fail") == (depth > 1e-2)
    falling = sunk.assign(z=sunk["z"] - 1e-4 * frame["t"], vcz=frame["vcz"] - 1e-4)
    assert check(falling, "reference", friction="other")["contact_velocity"].verdict == "fail"
