"""The start, columns beside the state, and the distance from the scene's solution."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Healthy, check, matches, refuses
from tests.conftest import more, of_each_kind
from tests.golden.tables import edit_cell, other_digit
from tt_precise.golden import store

MINE = replace(tt.load_scene("reference"), name="mine")
# What explains a failure is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


def golden(source: Any, scene: Any = "reference", **words: Any) -> Any:
    """Return the check of the distance from the solution."""
    return check(source, scene, **words)["golden"]


# ---- the start ---------------------------------------------------------------------------------


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize(
    ("column", "value"), [("omega_3", "155.155"), ("theta", "0.1001"), ("phi_dot", "0.1")]
)
def test_another_start_fails(column: str, value: str, friction: str) -> None:
    other = tt.integrate(tt.load_scene("reference").varied(**{column: value, "until": "0.3"}))
    frame = other.frame(*VECTORS[1:], times=[0.001 * n for n in range(301)])
    found = check(frame, "reference", friction=friction)
    assert [one.name for one in found.failures] == ["start"]
    assert "another start than the scene's" in found["start"].note
    meant = check(frame, "reference", friction=friction, start="other")
    assert meant.passed, str(meant)
    assert (meant["start"].verdict, meant["golden"].verdict) == ("skipped", "skipped")
    refuses("digits: the solution has the scene's start", frame, start="other", digits=8)


def test_the_start_may_stand_at_any_time(healthy: Healthy) -> None:
    rows = healthy("reference", 301, 0.3)
    for later in (100.0, 1.7e9, -3.0):
        shifted = rows.assign(t=later + rows["t"])
        assert f"t = {later:.12g} s" in check(shifted, "reference")["start"].note


def test_a_restart_is_the_solution_at_its_own_time(healthy: Healthy) -> None:
    rows = healthy()[VECTORS].iloc[200:260]
    found = check(rows, "reference")
    assert found.passed, str(found)
    assert found["start"].note == "the solution at t = 2 s"
    assert matches(rows, "reference", digits=9).passed
    later = check(rows, "reference", friction="other")
    assert later["start"].verdict == "open"
    assert "the file begins at t = 2 s" in later["start"].note
    refuses("there is no row between", rows.drop(index=range(220, 230)), digits=9)
    # at another time it is another start
    shifted = rows.assign(t=rows["t"] - 2)
    assert [one.name for one in check(shifted, "reference").failures] == ["start"]
    assert check(shifted, "reference", start="other").passed


# ---- columns beside the state ------------------------------------------------------------------

SPOILT: dict[str, Callable[[Any], Any]] = {
    "theta": lambda v: v + 3e-5,
    "omega_3": lambda v: 1.001 * v,
    "phi_dot": lambda v: numpy.roll(v, 1),
    "nu_x": lambda v: -v,
    "phi": lambda v: 2 * v,
    "psi_dot": lambda v: v + 1,
    "wx": lambda v: v + 1e-2,
    "vcz": lambda v: -v,
}


@pytest.mark.parametrize("friction", ["scene", more("other")])
@pytest.mark.parametrize("name", SPOILT)
def test_columns_beside_the_state_agree_with_it(name: str, friction: str) -> None:
    run = tt.integrate("reference", record=("phi", "psi", "x", "y"))
    names = (*VECTORS[1:], *EULER[1:], "phi", "psi_dot", "wx", "vcz")
    frame = run.frame(*names, times=[0.001 * n for n in range(201)], numbers="float")
    right = check(frame, "reference", friction=friction)
    assert right.passed, str(right)
    assert (right["agreement"].value or 0) < 1e-10
    spoilt = frame.assign(**{name: SPOILT[name](frame[name].to_numpy())})
    wrong = check(spoilt, "reference", friction=friction)
    assert "agreement" in {one.name for one in wrong.failures}
    assert f"{name} does not agree with the vectors columns" in wrong["agreement"].note


def test_a_quaternion_beside_vectors_has_their_axis_and_turns_with_their_spin() -> None:
    run = tt.integrate("reference", record=("phi", "psi"))
    quaternion = ("qw", "qx", "qy", "qz")
    frame = run.frame(*VECTORS[1:], *quaternion, times=[0.001 * n for n in range(101)])
    assert check(frame, "reference").passed
    tilted = frame.assign(qx=frame["qx"] + 1e-3)
    assert check(tilted, "reference")["agreement"].note.startswith("the quaternion does not agree")
    half = 0.5 * numpy.arange(len(frame)) % 1.0  # turned about the axis, by another angle each
    c, s = numpy.cos(half), numpy.sin(half)
    w, x, y, z = (frame[name].to_numpy() for name in quaternion)
    turned = (w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s)
    found = check(frame.assign(**dict(zip(quaternion, turned, strict=True))), "reference")
    assert (found["agreement"].verdict, found["kinematics"].verdict) == ("open", "fail")


def test_a_column_that_nothing_determines_is_left_open() -> None:
    run = tt.integrate("reference", until="0.2")
    frame = run.frame(*EULER[1:], "Lx", "kz")
    found = check(frame, "reference", friction="other")
    assert (found["agreement"].verdict, found.failures) == ("open", ())
    assert "Lx not looked at" in found["agreement"].note
    wrong = check(frame.assign(kz=frame["kz"] + 1e-3), "reference")
    assert "kz does not agree" in wrong["agreement"].note
    without = run.frame(*VECTORS[1:7], "nu_x")
    slip = check(without, "reference", friction="other")["agreement"]
    assert (slip.verdict, slip.note) == ("open", "nu_x not looked at")


# ---- the distance ------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", of_each_kind(store.scenes()))
def test_golden_files_pass_in_double_and_with_all_their_digits(scene: str) -> None:
    path = store.home() / scene / "trajectory.csv"
    result = check(path, scene)
    assert result.passed, str(result)
    assert 15 < (result["golden"].value or 0) < 16
    assert (matches(path, scene, digits=30)["golden"].value or 0) >= 30
    assert check(path, scene, friction="other").failures == ()


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    return Path(shutil.copy(store.home() / "reference" / "trajectory.csv", tmp_path / "run.csv"))


def test_more_than_double_is_seen(copied: Path) -> None:
    edit_cell(copied, 301, "Lz", lambda cell: other_digit(cell, 29))
    found = golden(copied, digits=30)
    assert (found.verdict, found.parts["kx"]) == ("fail", 34)
    assert found.parts["Lz"] < 30
    assert golden(copied, digits=15).verdict == "pass"
    refuses("got 34, expected a number above 0 and at most 33", copied, digits=34)


@pytest.mark.parametrize(("scene", "digits"), [("reference", 6), ("track", 20), ("rolling", 9)])
def test_delivered_digits_pass_the_check(scene: str, digits: int) -> None:
    frame = tt.integrate(scene, digits=digits).frame(numbers="text")
    assert matches(frame, scene, digits=digits).passed
    # an error in the last digit asked for is found
    spoiled = frame.assign(kz=[repr(float(kz) + 3 * 10.0**-digits) for kz in frame["kz"]])
    if digits < 15:
        with pytest.raises(AssertionError, match="kz"):
            matches(spoiled, scene, digits=digits)


@pytest.mark.parametrize("scene", ["reference", "upright", more("rolling"), more("track")])
def test_digits_are_those_of_golden_compare(scene: str) -> None:
    rows = pandas.DataFrame(tt.golden.load(scene)).iloc[::20]
    rolls = {"vx", "vy", "nu_x", "nu_y"} if scene == "rolling" else set()
    names = [name for name in rows if name not in {"t", *rolls}]
    rng = numpy.random.default_rng(7)
    spoiled = rows[["t", *names]].copy()
    for name, size in zip(names, 10.0 ** rng.uniform(-13, -9, len(names)), strict=True):
        spoiled[name] += size * rng.standard_normal(len(rows))
    found, expected = golden(spoiled, scene), tt.golden.compare(spoiled, scene)
    assert found.parts == pytest.approx(dict(expected.digits.dropna()), abs=0.006)


def test_exactly_the_digits_asked_for_are_enough(healthy: Healthy) -> None:
    worst = golden(healthy()).value
    for asked, verdict in ((worst, "pass"), (numpy.nextafter(worst, numpy.inf), "fail")):
        found = golden(healthy(), digits=asked)
        assert (found.value, found.verdict) == (worst, verdict)


def test_other_bodies_and_names_are_integrated(healthy: Healthy) -> None:
    for scene in (MINE, tt.load_scene("reference").varied(mu="0.31")):
        found = golden(healthy(), scene)
        assert found.note.startswith("800 rows compared integrated in double-double")
    assert found.value < 1
    assert golden(healthy(), MINE, digits=9).verdict == "pass"


@pytest.mark.parametrize("scene", ["coulomb-flight", "elastic-linear"])
def test_a_wrong_row_of_a_top_that_lifts_is_noticed(scene: str) -> None:
    frame = pandas.DataFrame(tt.golden.load(scene))[VECTORS]
    assert check(frame, scene, digits=12).passed
    wrong = frame.assign(ky=frame["ky"] + 1e-9 * (frame.index == len(frame) // 2))
    assert [one.name for one in check(wrong, scene, digits=12).failures] == ["golden"]


@pytest.mark.parametrize("scene", ["coulomb-flight", "contact-lost"])
def test_a_run_is_compared_to_its_early_end(scene: str) -> None:
    frame = tt.integrate(scene, digits=8).frame(numbers="text")
    found = golden(frame, scene, digits=8)
    assert found.verdict == "pass"
    assert "rows after the start in all" not in found.note
    late = frame.copy()
    late.loc[len(frame) - 1, "t"] = str(1.001 * float(frame["t"].iloc[-1]))
    with pytest.raises((tt.InputError, AssertionError), match=r"could not be compared|golden: "):
        matches(late, scene, digits=8)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda frame: frame[frame["t"] <= 5], "t = 5 and 8 s"),
        (lambda frame: frame.iloc[:-1], "t = 7.99 and 8 s"),
        (lambda frame: frame[(frame["t"] < 3) | (frame["t"] > 3.02)], "t = 2.99 and 3.03 s"),
        (lambda frame: frame.iloc[::200], "t = 6 and 8 s"),
    ],
)
def test_missing_rows_are_refused(healthy: Healthy, spoil: Any, message: str) -> None:
    refuses(f"there is no row between {message}", spoil(healthy()), digits=8)


def test_rows_beyond_golden_data_and_a_blow_up_are_compared(healthy: Healthy) -> None:
    frame = healthy()
    longer = pandas.concat([frame, frame.iloc[[-1]].assign(t=8.01, kx=5.0)], ignore_index=True)
    with pytest.raises(AssertionError, match="kx 0"):
        matches(longer, "reference", digits=8)
    assert matches(longer, "reference", digits=8, until=8).passed
    frame.loc[799:, "Lx"] = numpy.nan
    with pytest.raises(AssertionError, match="Lx = nan in row 799"):
        matches(frame, "reference", digits=8)


def test_digits_over_time_say_where_to_stop(healthy: Healthy) -> None:
    """Errors that grow as those of a coarse integrator."""
    frame = healthy()
    growing = frame.assign(omega_3=frame["omega_3"] * (1 + 1e-10 * 10 ** (1.2 * frame["t"])))
    result = check(growing, "reference")
    assert result["golden"].history == (
        "6 digits until 3.33 s, 3 digits until 6.11 s, 1 digit until 7.5 s, none from 7.51 s"
    )
    assert result.as_dict()["checks"][-1]["digits_over_time"] == result["golden"].history
    assert matches(growing, "reference", digits=8, until=1.6).passed
