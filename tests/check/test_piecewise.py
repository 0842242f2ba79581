"""Motions in pieces: height and its rate, what each row obeys, and the energy where pieces join."""

import random
from collections.abc import Callable
from functools import cache
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.conftest import more
from tt_precise.check.result import Result
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.pose import Pose
from tt_precise.runtime.values import InputError
from tt_precise.scene.start import LIFTED

# Hundreds of wrong files: what explains them is tested elsewhere.
pytestmark = pytest.mark.usefixtures("no_cause")

LIFTING = ("coulomb-flight", "elastic-linear", "elastic-hunt-crossley")
STRICT = dict.fromkeys(("energy", "energy_balance", "equations"), 1e-8)
SETS = {
    "vectors": (*NewtonState._fields, *LIFTED),
    "Euler": (*EulerState._fields, *LIFTED),
    "rigid body": tuple(name for name in Pose._fields if not name.startswith("wb")),
}


def rows(scene: str, names: tuple[str, ...] = SETS["vectors"]) -> pandas.DataFrame:
    return trajectory(scene).frame(*names)


@cache
def trajectory(scene: str) -> tt.Trajectory:
    return tt.integrate(scene, events=(), record=("x", "y", "phi", "psi"))


def checked(frame: pandas.DataFrame, scene: str | tt.Scene, **words: Any) -> Result:
    return tt.check.conservation(frame, scene, limits=STRICT, **words)


@pytest.mark.parametrize("columns", SETS)
@pytest.mark.parametrize("scene", ["elastic-linear", "flight", *map(more, LIFTING[::2])])
def test_height_and_rate_are_read_in_every_column_set(scene: str, columns: str) -> None:
    found = checked(rows(scene, SETS[columns]), scene)
    assert found.passed, str(found)
    names = ["energy", "equations", *(["energy_balance"] if scene != "flight" else [])]
    assert {name: found[name].verdict for name in names} == dict.fromkeys(names, "pass")
    # beside a pole Euler angles lose some, and where the table is touched a height is small
    assert {found["golden"].parts[name] > 9 for name in LIFTED} == {True}, found["golden"].parts


@pytest.mark.parametrize("scene", ["elastic-linear", *map(more, LIFTING[::2])])
def test_without_the_height_its_checks_are_open(scene: str) -> None:
    """Rows that stand still are found without it: the inclination has a rate."""
    found = checked(rows(scene).drop(columns=[*LIFTED]), scene)
    for name in ("energy", "energy_balance", "equations", "normal_force"):
        assert found[name].verdict == "open"
        assert found[name].note == "needs the height of the lowest point: columns height, rise"
    with pytest.raises(InputError, match="has height but not rise, expected all of the height"):
        checked(rows(scene).drop(columns="rise"), scene)
    angles = rows(scene, EulerState._fields)
    still = angles.iloc[[9] * len(angles)].reset_index(drop=True).assign(t=angles.t)
    assert (checked(angles, scene).passed, checked(still, scene).passed) == (True, False)


SPOILT: dict[str, Callable[[pandas.DataFrame], pandas.DataFrame]] = {
    "height off by a micrometre": lambda f: f.assign(height=f.height + 1e-6),
    "sign of its rate": lambda f: f.assign(rise=-f.rise),
    "sign of the height": lambda f: f.assign(height=-f.height),
    "a piece left out": lambda f: pandas.concat(
        [f.iloc[:12], f.iloc[17:].assign(t=f.t.iloc[17:] - (f.t.iloc[17] - f.t.iloc[12]))]
    ),
}


@pytest.mark.parametrize("scene", ["flight", "elastic-linear", *map(more, LIFTING[::2])])
def test_a_wrong_height_fails(scene: str) -> None:
    frame, flies = rows(scene), scene == "flight"
    assert checked(frame, scene, digits=9).passed
    for fault in list(SPOILT)[: 2 if flies else None]:
        names = {one.name for one in checked(SPOILT[fault](frame), scene, digits=9).failures}
        assert names >= ({"golden"} if flies else {"equations", "golden"}), fault


@pytest.mark.parametrize("scene", ["elastic-linear", more("elastic-hunt-crossley")])
def test_what_an_elastic_table_holds_counts_as_energy(scene: str) -> None:
    """Without it the energy rises wherever the spring pushes the top up."""
    found: Any = checked(rows(scene), scene)["energy"]
    assert found.value < 1e-14
    assert checked(rows(scene), "coulomb-flight")["energy"].verdict == "fail"


@pytest.mark.parametrize(
    ("factor", "name"), [more(1 + 3e-5, "energy"), (1 - 3e-4, "energy_balance")]
)
def test_energy_that_jumps_where_the_top_sticks_is_noticed(factor: float, name: str) -> None:
    """The interval that holds the stick: what gliding cannot take from the energy is an error."""
    scene = "coulomb-stick-slip"
    frame = rows(scene, SETS["vectors"][:8])
    stuck = int(((frame.vx == 0) & (frame.vy == 0)).to_numpy().argmax())
    assert stuck > 0
    assert checked(frame, scene).passed
    frame.loc[stuck:, ["Lx", "Ly", "Lz"]] *= factor
    found = checked(frame, scene)
    assert found[name].verdict == "fail"
    assert (found["energy_balance"].verdict, found["equations"].verdict) == ("fail", "fail")
    # the states after it are hardly wrong
    assert found["equations"].at == frame.t[stuck]


@pytest.mark.parametrize("every", [45, pytest.param(9, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("scene", "columns"),
    [
        (scene, columns) if columns == "vectors" or "linear" in scene else more(scene, columns)
        for scene in (*LIFTING, "coulomb-stick-slip")
        for columns in SETS
    ],
)
def test_a_motion_that_stands_still_fails_at_every_row(
    scene: str, columns: str, every: int
) -> None:
    frame = rows(scene, tuple(n for n in SETS[columns] if scene in LIFTING or n not in LIFTED))
    for row in range(0, len(frame), every):
        still = frame.iloc[[row] * 12].reset_index(drop=True).assign(t=frame.t[:12])
        assert checked(still, scene, start="other")["equations"].verdict == "fail", row


@pytest.mark.parametrize(("off", "passes"), [(1e-3, True), (-1e-3, False)])
def test_a_flight_ends_at_the_table(off: float, passes: bool) -> None:
    """Its equations do not contain the height, below which there is no flight."""
    frame = rows("flight")
    found = checked(frame.assign(height=frame.height + off), "flight")
    assert found.passed == passes, str(found)
    assert (found["equations"].verdict == "pass") == passes


@pytest.mark.evidence
def test_a_slip_and_a_stick_between_two_rows_at_rest_are_joints() -> None:
    """The contact rests at 0.16 and at 0.18 s, and glides in between."""
    scene = tt.load_scene("coulomb-stick-slip").varied(
        theta="1.907", phi_dot="11.55", omega_3="-146.2", nu_y="-0.094", mu="0.421", until="0.2"
    )
    frame = tt.integrate(scene, events=(), record=()).frame(*SETS["vectors"][:8]).iloc[::10]
    found = checked(frame, scene)
    assert found.passed, str(found)


def test_a_row_just_behind_a_loss_of_contact_is_not_on_the_table() -> None:
    """It is 6 pm above it at 0.0865 s, where the table would have to pull: a joint, both sides."""
    scene = tt.load_scene("coulomb-flight").varied(
        theta="1.236", phi_dot="16.65", omega_3="152", nu_y="-0.08", mu="0.322",
        until="0.0895", sample_every="0.0005",
    )  # fmt: skip
    frame = tt.integrate(scene, events=(), record=()).frame(*SETS["vectors"])
    assert 0 < frame.height[173] < 1e-11 < frame.height[174]
    found = checked(frame, scene)
    assert found.passed, str(found)
    frame.loc[173:, "vx"] += 1e-4 * (frame.t[173:] - 0.0865)
    assert not checked(frame, scene).passed


@pytest.mark.slow
def test_no_healthy_run_is_flagged() -> None:
    """Sixty starts by lot, with rows of six spacings."""
    draws, flagged, looked_at = random.Random(1), [], 0
    for _ in range(60):
        name = draws.choice([*LIFTING, "coulomb-stick-slip", "coulomb-gliding"])
        scene = tt.load_scene(name).varied(
            theta=f"{draws.uniform(0.05, 2.9):.3f}", phi_dot=f"{draws.uniform(-20, 20):.2f}",
            omega_3=f"{draws.uniform(-180, 180):.1f}", nu_y=f"{draws.uniform(-0.1, 0.1):.3f}",
            mu=f"{draws.uniform(0.02, 0.5):.3f}", until="0.2", sample_every="0.0005",
        )  # fmt: skip
        try:
            run = tt.integrate(scene, events=(), record=())
        except InputError:
            continue  # a start that is not pressed to the table
        frame = run.frame(*SETS["vectors"][: 10 if scene.lifts else 8])
        for stride in (1, 2, 4, 10, 20, 40):
            looked_at += 1
            failures = checked(frame.iloc[::stride], scene).failures
            flagged += [(scene, stride, str(one)) for one in failures]
    assert (flagged, looked_at > 300) == ([], True)


def test_numbers_in_another_unit_ask_for_no_hours() -> None:
    """With a momentum in another unit the top turns 500 times from row to row."""
    wrong = rows("elastic-linear").head(4)
    wrong[["Lx", "Ly", "Lz"]] *= 1e4
    found = checked(wrong, "elastic-linear")
    assert found.verdict == "fail"
    assert "0 of 3 possible changes of the equations looked at" in found["equations"].note
