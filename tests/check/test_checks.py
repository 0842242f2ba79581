"""Healthy trajectories pass; every check has been seen failing."""

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Engine, Healthy, check, pose, refuses, rows_of
from tests.conftest import Patch, more
from tt_precise.check import checks
from tt_precise.check.checks import CHECKS, chosen_limits
from tt_precise.check.residuals import StepResiduals, torque_unit
from tt_precise.check.rows import Rows
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.runtime.values import Check

# Causes are tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")

# Double holds the integrals to some eps (2e-16); the state passed 1,400 steps of one eps each,
# the sums over 801 rows add as much again.
DOUBLE = 1e-13
RELATIVE = [one.name for one in CHECKS if one.sense == "at most"]


@pytest.mark.parametrize("columns", [VECTORS, EULER], ids=["vectors", "Euler"])
@pytest.mark.parametrize("scene", ["reference", "frictionless", "rolling", "phi-dot-195"])
def test_a_healthy_trajectory_passes_at_the_limit_of_double(
    healthy: Healthy, scene: str, columns: list[str]
) -> None:
    result = check(healthy(scene)[columns], scene, limits=dict.fromkeys(RELATIVE, DOUBLE))
    assert result.passed, str(result)
    assert result.rows == 801
    passed = {f.name for f in result.checks if f.verdict == "pass"}
    assert passed >= {"time", "jellett", "energy", "contact"}
    if scene == "rolling":
        assert passed >= {"routh", "modified_energy", "contact_velocity"}
    if scene == "frictionless":
        assert passed >= {"spin", "vertical_angular_momentum"}
        assert ("momentum_x" in passed) == (columns is VECTORS)


@pytest.mark.parametrize("scene", ["upright", "inverted"])
def test_a_vertical_axis_is_no_obstacle_and_keeps_its_length(healthy: Healthy, scene: str) -> None:
    frame = healthy(scene, 81)
    assert check(frame, scene).passed
    assert check(spoiled(frame, "kz", 1 + 1e-5), scene)["axis_norm"].verdict == "fail"


def test_every_integral_of_mechanics_is_checked() -> None:
    assert set(INTEGRALS) <= {one.name for one in CHECKS}


def spoiled(frame: pandas.DataFrame, name: str, factor: float) -> pandas.DataFrame:
    """The second half of a column, multiplied."""
    frame = frame.copy()
    frame.loc[len(frame) // 2 :, name] *= factor
    return frame


@pytest.mark.parametrize(
    ("scene", "column", "name"),
    [
        ("reference", "Lz", "jellett"),
        ("reference", "kz", "axis_norm"),
        ("reference", "Lz", "equations"),
        ("reference", "vx", "energy_balance"),
        ("frictionless", "Lz", "energy"),
        ("frictionless", "Lz", "spin"),
        ("frictionless", "Lz", "vertical_angular_momentum"),
        ("frictionless", "vx", "momentum_x"),
        ("frictionless", "vy", "momentum_y"),
        ("rolling", "Lz", "routh"),
        ("rolling", "Lz", "modified_energy"),
    ],
)
def test_a_small_error_fails(healthy: Healthy, scene: str, column: str, name: str) -> None:
    limits, frame = {name: 1e-9}, healthy(scene)[VECTORS]
    assert check(frame, scene, limits=limits)[name].verdict == "pass"
    found = check(spoiled(frame, column, 1 + 1e-7), scene, limits=limits)[name]
    assert found.verdict == "fail"
    assert 1e-9 < (found.value or 0) < 1e-5
    assert (found.at or 0) >= 4


def test_energy_may_fall_but_not_rise(healthy: Healthy) -> None:
    frame = healthy()[VECTORS]
    # run backwards in time the same states gain energy: L and v change sign with the time
    back = frame.iloc[::-1].reset_index(drop=True)
    back["t"] = 8 - back["t"]
    back[VECTORS[4:]] *= -1
    assert check(frame, "reference")["energy"].value == 0
    found = check(back, "reference")["energy"]
    assert found.verdict == "fail"
    assert found.value == pytest.approx(2.6, rel=0.5)


def test_a_pulling_table_and_a_gliding_point_of_a_rolling_top_fail(healthy: Healthy) -> None:
    frame = healthy()[EULER]
    frame.loc[700, "theta_dot"] = 200.0  # swings over the top faster than gravity pulls
    found = check(frame, "reference")["contact"]
    assert (found.verdict, found.at) == ("fail", 7.0)
    gliding = healthy("rolling")[VECTORS].assign(vx=1e-3)
    assert check(gliding, "rolling")["contact_velocity"].verdict == "fail"


def test_another_friction_law_is_held_to_what_every_law_keeps(healthy: Healthy) -> None:
    result = check(healthy()[VECTORS], "reference", friction="other")
    done = {finding.name for finding in result.checks if finding.verdict in ("pass", "fail")}
    always = {"finite", "time", "jellett", "energy", "axis_norm", "start", "agreement"}
    assert done == always | {"kinematics", "contact_momentum"}
    assert result["friction_power"].verdict == "open"  # rows 10 ms apart do not resolve the force
    refuses("friction: got 'mine', expected one of: scene, other", healthy(), friction="mine")


def test_without_velocity_what_needs_it_is_open(healthy: Healthy) -> None:
    result = check(healthy()[VECTORS[:7]], "reference")
    assert result["jellett"].verdict == "pass"
    for name in ("energy", "energy_balance", "equations", "contact"):
        assert result[name].verdict == "open"
        assert result[name].note == "needs the velocity: columns vx, vy"
    refuses("no vy, expected all columns of the velocity", healthy()[VECTORS[:-1]])


def test_until_cuts_a_tail_off(healthy: Healthy) -> None:
    frame = spoiled(healthy()[VECTORS], "Lz", 2)
    frame.loc[700, "kx"] = numpy.nan
    result = check(frame, "reference", until=3.9)
    assert (result.passed, result.t_last) == (True, 3.9)
    assert not check(frame, "reference", until=6).passed


def test_limits_are_checked(healthy: Healthy) -> None:
    message = "limit: got 'jelett', expected one of: time, jellett"
    refuses(message, healthy(), limits={"jelett": 1})
    refuses("limit of jellett: got -1e-09, expected 0 or", healthy(), limits={"jellett": -1e-9})
    assert check(healthy(), "reference", limits={"contact": -1e-9}).passed
    zero = check(healthy(), "reference", limits={"jellett": 0.0})
    assert [one.name for one in zero.failures] == ["jellett"]
    # of a check that the scene has not
    with pytest.raises(AssertionError, match=r"fall: a limit was given, but .* of flight only"):
        tt.check.assert_conserves(healthy(), "reference", fall=1e-6)


def test_a_trajectory_can_be_checked_and_the_callers_table_is_left_alone(healthy: Healthy) -> None:
    assert check(tt.integrate("rolling"), "rolling").passed
    frame = healthy()
    check(frame, "reference")
    pandas.testing.assert_frame_equal(frame, healthy())


def test_a_limit_may_have_the_name_of_the_quantity() -> None:
    for quantity, check_name in (("lambda", "jellett"), ("E", "energy"), ("D", "routh")):
        assert chosen_limits({quantity: 1e-9}) == chosen_limits({check_name: 1e-9})
    with pytest.raises(tt.InputError, match="limit: got E, energy, expected each check once"):
        chosen_limits({"E": 1e-9, "energy": 1e-6})
    with pytest.raises(tt.InputError, match=r"limit: got 'jelet', .*; did you mean 'jellett'"):
        chosen_limits({"jelet": 1e-9})


FAULTS = ("damped motion", "no gyroscopic term", "normal force is the weight", "friction pushes")


@pytest.mark.parametrize(
    ("fault", "hertz"),
    [
        *((fault, 240) for fault in FAULTS),
        *(more(fault, hertz) for fault in FAULTS for hertz in (60, 960)),
    ],
)
def test_planted_faults_of_an_engine_fail(engine: Engine, fault: str, hertz: int) -> None:
    rows = engine(hertz, 0.5, fault=fault)
    assert check(rows, "reference").verdict == "fail"
    assert check(rows, "reference", friction="other").verdict != "pass"


@pytest.mark.parametrize("law", ["viscous", "regularised", more("stribeck"), more("soft")])
def test_right_engines_of_every_law_pass(engine: Engine, law: str) -> None:
    rows = engine(960, 0.25, law)
    limits = {"contact_velocity": 0.01} if law == "soft" else {}
    found = check(rows, "reference", friction="other", limits=limits)
    assert not found.failures, str(found)
    assert (check(rows, "reference").verdict == "fail") == (law != "viscous")


def residuals_of(rows: Rows, **parts: float | numpy.ndarray) -> StepResiduals:
    """Return residuals that are 0 but for ``parts``, about x; ``bound`` is that of the momentum."""
    count = len(rows.t) - 1
    bounds = {name: numpy.zeros(count) for name in ("rotation", "position", "momentum")}
    bounds["momentum"] = bounds["momentum"] + parts.pop("bound", 0.0)
    values = {name: numpy.zeros((3, count)) for name in bounds}
    for name, value in parts.items():
        values[name][0] = value
    empty = numpy.empty((0, count))
    rotation, position, momentum = values.values()
    return StepResiduals(rotation, position, momentum, bounds, empty, empty, empty)


def test_intervals_and_sums_count_by_their_factors(healthy: Healthy, monkeypatch: Patch) -> None:
    """An interval of the attitude counts ten times, the mean torque twice."""
    rows = rows_of(healthy("reference", 101, 1)[VECTORS], friction="other")
    monkeypatch.setattr(checks, "obeys_scene", lambda rows: False)
    unit = torque_unit(rows.body) * float(numpy.diff(rows.t)[0])
    alone = numpy.zeros(100)
    alone[50] = 1.0
    first = numpy.zeros(100)
    first[:9] = 1.0  # a mean over fewer than ten intervals says no more than they do
    gap = numpy.where(alone > 0, numpy.inf, 0.0)

    def judged(name: str, **parts: float | numpy.ndarray) -> Check:
        monkeypatch.setattr(
            checks, "deciding_steps", lambda rows: (residuals_of(rows, **parts), 0.0)
        )
        (check,) = (one for one in checks.CHECKS if one.name == name)
        return check.result(rows, check.limit)

    for name, parts, value, verdict in (
        ("kinematics", {"rotation": 0.9e-3 * alone}, 0.9e-2, "pass"),
        ("kinematics", {"rotation": 1.1e-3 * alone}, 1.1e-2, "fail"),
        ("kinematics", {"rotation": 1.1e-4}, 1.1e-2, "fail"),  # the sum
        ("contact_momentum", {"momentum": 0.9e-4 * unit * alone}, 0.9e-4, "pass"),
        ("contact_momentum", {"momentum": 1.1e-4 * unit * alone}, 1.1e-4, "fail"),
        ("contact_momentum", {"momentum": 0.6e-4 * unit}, 1.2e-4, "fail"),  # the mean
        ("contact_momentum", {"momentum": 0.6e-4 * unit * first}, 1.2e-4 * 9 / 11, "pass"),
        ("contact_momentum", {"bound": 0.29 * unit}, 0.0, "pass"),
        ("contact_momentum", {"bound": 0.31 * unit}, 0.0, "open"),
        ("contact_momentum", {"bound": gap}, 0.0, "open"),  # a fault may hide in any interval
    ):
        check = judged(name, **parts)
        assert check.verdict == verdict, (name, parts)
        assert check.value == pytest.approx(value, rel=1e-6, abs=1e-12)
    assert judged("contact_momentum", bound=0.29 * unit).bound == pytest.approx(0.29, rel=1e-6)


@pytest.mark.parametrize(("depth", "verdict"), [(0.09, "pass"), (0.11, "fail")])
def test_a_table_may_give_way_by_a_tenth_of_the_radius(depth: float, verdict: str) -> None:
    frame = pose([n / 960 for n in range(100)])
    sunk = frame.assign(z=frame["z"] - depth * 0.02)
    found = check(sunk, "reference", friction="other")
    assert (found["kinematics"].verdict == "fail") == (verdict == "fail")
    assert check(sunk, "reference")["kinematics"].verdict == "fail"


@pytest.mark.parametrize(("deep", "noted"), [(0.5e-6, False), (2e-6, True)])
def test_a_depth_is_named_and_not_allowed_for(deep: float, noted: bool) -> None:
    frame = pose([n / 960 for n in range(100)])
    found = check(frame.assign(z=frame["z"] - deep * 0.02), "reference", friction="other")
    assert ("a soft contact" in found["contact_velocity"].note) == noted
    falling = frame.assign(z=frame["z"] - 1e-4 * frame["t"], vcz=frame["vcz"] - 1e-4)
    assert check(falling, "reference", friction="other")["contact_velocity"].verdict == "fail"


def test_the_scenes_law_is_asked_first_on_leading_rows(monkeypatch: Patch) -> None:
    """Rows that leave the scene's law at once are not compared with it to their end."""
    monkeypatch.setattr(checks, "LEADING", 50)
    frame, lengths = pose([n / 960 for n in range(100)]), list[int]()
    by_law = checks.by_law

    def counting(rows: Rows) -> StepResiduals:
        lengths.append(len(rows.t))
        return by_law(rows)

    monkeypatch.setattr(checks, "by_law", counting)
    for since, compared in ((10, {50}), (70, {50, 100})):
        kicked = frame.assign(vcx=frame["vcx"] + 1e-3 * (frame.index >= since))
        lengths.clear()
        assert not checks.obeys_scene(rows_of(kicked, friction="other"))
        assert {*lengths} == compared
    assert checks.obeys_scene(rows_of(frame, friction="other"))
