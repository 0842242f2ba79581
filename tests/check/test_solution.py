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
from tests.check.conftest import EULER, VECTORS, check, matches, refuses, solved, vectors
from tests.conftest import more, of_each_kind
from tests.golden.tables import edit_cell, other_digit
from tt_precise.golden import store

# What explains a failure is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")


def golden(source: Any, scene: Any = "reference", **words: Any) -> Any:
    """Return the check of the distance from the solution."""
    return check(source, scene, **words)["golden"]


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize(
    ("column", "value"), [("omega_3", "155.155"), ("theta", "0.1001"), ("phi_dot", "0.1")]
)
def test_another_start_fails(column: str, value: str, friction: str) -> None:
    other = tt.integrate(tt.load_scene("reference").varied(**{column: value, "until": "0.3"}))
    frame = other.frame(*VECTORS[1:], times=[0.001 * n for n in range(301)])
    wrong = check(frame, "reference", friction=friction)
    assert [each.name for each in wrong.failures] == ["start"]
    assert "another start than the scene's" in wrong["start"].note
    meant = check(frame, "reference", friction=friction, start="other")
    assert meant.passed, str(meant)
    assert (meant["start"].verdict, meant["golden"].verdict) == ("skipped", "skipped")


@pytest.mark.parametrize(("size", "verdict"), [(0.9, "pass"), (1.1, "fail")])
def test_a_start_is_the_same_to_the_digits_of_32_bits(size: float, verdict: str) -> None:
    """The limit is 1e-5, and 16 times the rounding of the file."""
    frame = vectors(101)
    for rows, limit in ((frame, 1e-5), (frame.round(8), 1e-5 + 16 * 1e-5)):
        moved = rows.assign(kx=rows["kx"] + size * limit)
        moved["kz"] = numpy.sqrt(1 - moved["kx"] ** 2 - moved["ky"] ** 2)
        assert check(moved, "reference")["start"].verdict == verdict


SPOILT: dict[str, Callable[[Any], Any]] = {
    "theta": lambda v: v + 3e-5,
    "omega_3": lambda v: 1.001 * v,
    "phi_dot": lambda v: numpy.roll(v, 1),
    "nu_x": lambda v: -v,
    "phi": lambda v: 2 * v,
    "psi_dot": lambda v: v + 1,
    "wx": lambda v: v + 1e-2,
    "vcz": lambda v: -v,
    "the quaternion": lambda v: v + 1e-3,
}


@pytest.mark.parametrize("friction", ["scene", more("other")])
@pytest.mark.parametrize("name", SPOILT)
def test_columns_beside_the_state_agree_with_it(name: str, friction: str) -> None:
    column = "qx" if name == "the quaternion" else name
    names = ("qw", "qx", "qy", "qz") if column == "qx" else (*EULER[1:], "psi_dot", "wx", "vcz")
    frame = solved([*VECTORS, *names, "phi", "psi", "x", "y"], 201, 1000)
    right = check(frame, "reference", friction=friction)
    assert right.passed, str(right)
    assert (right["agreement"].value or 0) < 1e-10
    spoilt = frame.assign(**{column: SPOILT[name](frame[column].to_numpy())})
    wrong = check(spoilt, "reference", friction=friction)
    assert "agreement" in {each.name for each in wrong.failures}
    assert f"{name} does not agree with the vectors columns" in wrong["agreement"].note


def test_a_quaternion_beside_vectors_turns_with_their_spin() -> None:
    quaternion = ("qw", "qx", "qy", "qz")
    frame = solved([*VECTORS, *quaternion], 101, 1000)
    half = 0.5 * numpy.arange(len(frame)) % 1.0  # turned about the axis, by another angle each
    c, s = numpy.cos(half), numpy.sin(half)
    w, x, y, z = (frame[name].to_numpy() for name in quaternion)
    turned = (w * c - z * s, x * c + y * s, y * c - x * s, z * c + w * s)
    result = check(frame.assign(**dict(zip(quaternion, turned, strict=True))), "reference")
    assert (result["agreement"].verdict, result["kinematics"].verdict) == ("open", "fail")


@pytest.mark.parametrize(
    ("columns", "unseen"),
    [([*EULER, "Lx", "kz"], "Lx not looked at"), ([*VECTORS[:7], "nu_x"], "nu_x not looked at")],
)
def test_a_column_that_nothing_determines_is_left_open(columns: list[str], unseen: str) -> None:
    result = check(solved(columns, 201, 1000), "reference", friction="other")
    assert (result["agreement"].verdict, result["agreement"].note) == ("open", unseen)


@pytest.mark.parametrize("scene", of_each_kind(store.scenes()))
def test_golden_files_pass_in_double_and_with_all_their_digits(scene: str) -> None:
    path = store.home() / scene / "trajectory.csv"
    result = check(path, scene)
    assert result.passed, str(result)
    assert 15 < (result["golden"].value or 0) < 16
    assert (matches(path, scene, digits=30)["golden"].value or 0) >= 30
    assert check(path, scene, friction="other").failures == ()


def test_more_than_double_is_seen(tmp_path: Path) -> None:
    path = Path(shutil.copy(store.home() / "reference" / "trajectory.csv", tmp_path / "run.csv"))
    edit_cell(path, 301, "Lz", lambda cell: other_digit(cell, 29))
    wide = golden(path, digits=30)
    assert (wide.verdict, wide.parts["kx"]) == ("fail", 34)
    assert wide.parts["Lz"] < 30
    assert golden(path, digits=15).verdict == "pass"


@pytest.mark.parametrize(
    ("scene", "digits"),
    [("reference", 6), ("track", 20), ("rolling", 9), ("coulomb-flight", 8), ("contact-lost", 8)],
)
def test_delivered_digits_pass_the_check(scene: str, digits: int) -> None:
    frame = tt.integrate(scene, digits=digits).frame(numbers="text")
    assert matches(frame, scene, digits=digits).passed
    # an error in the last digit asked for is found
    spoilt = frame.assign(kz=[repr(float(kz) + 3 * 10.0**-digits) for kz in frame["kz"]])
    if digits < 15:
        with pytest.raises(AssertionError, match="kz"):
            matches(spoilt, scene, digits=digits)


@pytest.mark.parametrize("scene", ["reference", "upright", more("rolling"), more("track")])
def test_digits_are_those_of_golden_compare(scene: str) -> None:
    rows = pandas.DataFrame(tt.golden.load(scene)).iloc[::20]
    rolls = {"vx", "vy", "nu_x", "nu_y"} if scene == "rolling" else set()
    names = [name for name in rows if name not in {"t", *rolls}]
    rng = numpy.random.default_rng(7)
    spoilt = rows[["t", *names]].copy()
    for name, size in zip(names, 10.0 ** rng.uniform(-13, -9, len(names)), strict=True):
        spoilt[name] += size * rng.standard_normal(len(rows))
    expected = tt.golden.compare(spoilt, scene).digits.dropna()
    assert golden(spoilt, scene).parts == pytest.approx(dict(expected), abs=0.006)


def test_exactly_the_digits_asked_for_are_enough() -> None:
    worst = golden(vectors()).value
    for asked, verdict in ((worst, "pass"), (numpy.nextafter(worst, numpy.inf), "fail")):
        result = golden(vectors(), digits=asked)
        assert (result.value, result.verdict) == (worst, verdict)


@pytest.mark.parametrize(("changes", "digits"), [({"mu": "0.31"}, 0), ({}, 12)])
def test_other_bodies_and_names_are_integrated(changes: dict[str, str], digits: int) -> None:
    mine = replace(tt.load_scene("reference").varied(**changes), name="mine")
    result = golden(vectors(), mine)
    assert result.note.startswith("800 rows compared integrated in double-double")
    assert int(result.value) == digits


@pytest.mark.parametrize("scene", ["coulomb-flight", "contact-lost"])
def test_rows_behind_the_end_of_the_motion_are_no_solution(scene: str) -> None:
    frame = tt.integrate(scene, digits=8).frame(numbers="text")
    frame.loc[len(frame) - 1, "t"] = str(1.001 * float(frame["t"].iloc[-1]))
    with pytest.raises((tt.InputError, AssertionError), match=r"could not be compared|golden: "):
        matches(frame, scene, digits=8)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda frame: frame[frame["t"] <= 5], "t = 5 and 8 s"),
        (lambda frame: frame.iloc[:-1], "t = 7.99 and 8 s"),
        (lambda frame: frame[(frame["t"] < 3) | (frame["t"] > 3.02)], "t = 2.99 and 3.03 s"),
        (lambda frame: frame[200:260].drop(index=range(220, 230)), "t = 2.19 and 2.3 s"),
    ],
)
def test_missing_rows_are_refused(spoil: Any, message: str) -> None:
    refuses(f"there is no row between {message}", spoil(vectors()), digits=8)


def test_rows_beyond_golden_data_and_a_blow_up_are_compared() -> None:
    frame = vectors()
    longer = pandas.concat([frame, frame.iloc[[-1]].assign(t=8.01, kx=5.0)], ignore_index=True)
    blown = frame.assign(Lx=frame["Lx"].where(frame["t"] < 7.985))
    for wrong, message in ((longer, "kx 0"), (blown, "Lx = nan in row 799")):
        with pytest.raises(AssertionError, match=message):
            matches(wrong, "reference", digits=8)
    assert matches(longer, "reference", digits=8, until=8).passed


def test_digits_over_time_say_where_to_stop() -> None:
    """Errors grow as those of a coarse integrator."""
    frame = solved(EULER)
    growing = frame.assign(omega_3=frame["omega_3"] * (1 + 1e-10 * 10 ** (1.2 * frame["t"])))
    result = check(growing, "reference")
    assert result["golden"].history == (
        "6 digits until 3.33 s, 3 digits until 6.11 s, 1 digit until 7.5 s, none from 7.51 s"
    )
    assert result.as_dict()["checks"][-1]["digits_over_time"] == result["golden"].history
    assert matches(growing, "reference", digits=8, until=1.6).passed
