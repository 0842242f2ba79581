"""Conventions: random ones are named, wrong physics is explained by none; those of engines."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest
from scipy.spatial.transform import Rotation

import tt_precise as tt
from benchmarks.engines import ENGINES as ADAPTERS
from tests.check.conftest import POSE, VECTORS, Engine, Healthy, check, pose, refuses
from tests.conftest import Said, more
from tt_precise.check import conventions
from tt_precise.check.conventions import (
    ANGLE,
    LENGTH,
    OURS,
    TIME,
    Convention,
    convert,
    engine_table,
)
from tt_precise.scene.scene import parse_scene

SCENE = tt.load_scene("reference")
BODY = SCENE.body.numbers(float)
# Rows are the file's axes in terms of ours.
WORLDS = {
    ("z", "right"): numpy.eye(3),
    ("y", "right"): numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0.0]]),
    ("x", "right"): numpy.array([[0, 0, 1], [1, 0, 0], [0, 1, 0.0]]),
    ("z", "left"): numpy.diag([1, -1, 1.0]),
    ("y", "left"): numpy.array([[1, 0, 0], [0, 0, 1], [0, 1, 0.0]]),
}
AXES = {axis: WORLDS[axis, "right"] for axis in "xyz"}
Columns = dict[str, numpy.ndarray]


@cache
def right(hertz: int, begin: float) -> pandas.DataFrame:
    return pose([begin + i / hertz for i in range(200)])


def written(frame: pandas.DataFrame, one: Convention, offset: float = 0.0) -> Columns:
    """The rows as the convention has them, by matrices, independently of ``convert``."""
    q, w, v, x = (
        frame[names.split()].to_numpy()
        for names in ("qx qy qz qw", "wx wy wz", "vcx vcy vcz", "x y z")
    )
    turn = Rotation.from_quat(q).as_matrix()
    centre = BODY.R * BODY.alpha * turn[:, :, 2]
    if one.point != "cm":
        v = v + numpy.cross(w, centre if one.point == "centre" else centre - [0, 0, BODY.R])
    x = x + centre if one.place == "centre" else x
    world = WORLDS[one.up, one.hand]
    sign = numpy.linalg.det(world)
    body = AXES[one.axis[-1]]
    body = body @ numpy.diag([1, -1, -1.0]) if one.axis[0] == "-" else body
    body = body @ numpy.diag([1, sign, 1.0])
    x, v, w = x @ world.T, v @ world.T, sign * (w @ world.T)
    turn = world @ turn @ body.T
    v = numpy.einsum("nji,nj->ni", turn, v) if one.velocity_in_body else v
    w = numpy.einsum("nji,nj->ni", turn, w) if one.in_body else w
    q = Rotation.from_matrix(turn).as_quat()[:, [3, 0, 1, 2]]
    q = q * numpy.array([1, -1, -1, -1]) if one.inverse else q
    q = q if one.order == "scalar first" else numpy.roll(q, -1, axis=1)
    t = (frame["t"].to_numpy() - frame["t"][0] + offset) / TIME[one.time]
    t = numpy.rint(t - t[0]) if one.time.startswith("rows") else t
    length = LENGTH[one.length]
    rows = (*q.T, *(w.T / ANGLE[one.angle]), *(v.T / length), *(x.T / length))
    return {"t": t, **dict(zip(POSE, rows, strict=True))}


def draw(rng: numpy.random.Generator, hertz: int, start: str) -> Convention:
    """Return a convention with at most three changes.

    A mirrored motion is one of another start.
    """
    worlds = [{"up": u, "hand": h} for u, h in WORLDS if (u, h) != ("z", "right")]
    choices: dict[str, list[dict[str, Any]]] = {
        "time": [{"time": name} for name in ("ms", "microseconds", "ns", f"rows at {hertz} Hz")],
        "length": [{"length": name} for name in ("cm", "mm", "inches")],
        "angle": [{"angle": name} for name in ("degrees", "revolutions per minute")],
        "world": [world for world in worlds if start == "scene" or world["hand"] == "right"],
        "axis": [{"axis": name} for name in ("y", "x", "-z", "-y", "-x")],
        "order": [{"order": "scalar last"}],
        "inverse": [{"inverse": True}],
        "frame": [{"in_body": True}],
        "point": [{"point": name} for name in ("centre", "contact")],
        "velocity": [{"velocity_in_body": True}],
        "place": [{"place": "centre"}],
    }
    chosen: dict[str, Any] = {}
    for group in rng.choice([*choices], int(rng.integers(1, 4)), replace=False):
        chosen |= choices[group][int(rng.integers(len(choices[group])))]
    return Convention(**chosen)


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize(
    ("seed", "count"), [(1, 3), more(2, 6), pytest.param(7, 68, marks=pytest.mark.slow)]
)
def test_random_conventions_are_named(seed: int, count: int, friction: str) -> None:
    rng, missed = numpy.random.default_rng(seed), []
    for _ in range(count):
        hertz, start = int(rng.choice([60, 1000])), str(rng.choice(["scene", "other"]))
        one = draw(rng, hertz, start)
        rows = written(right(hertz, 0.0 if start == "scene" else 3.0), one)
        found = check(rows, "reference", friction=friction, start=start)
        same = {one.words(), one.words().replace("t counts rows at 1000 Hz", "the time is in ms")}
        if not (len(found.causes) == 1 and found.causes[0].text in same):
            missed.append((hertz, start, one.words(), found.causes))
    assert missed == []


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize(("seed", "count"), [(2, 2), pytest.param(5, 50, marks=pytest.mark.slow)])
def test_wrong_physics_is_explained_by_no_convention(seed: int, count: int, friction: str) -> None:
    """Right rows against another body, by another clock, or with a spoilt column."""
    rng, explained = numpy.random.default_rng(seed), []
    for _ in range(count):
        hertz, begin = int(rng.choice([60, 1000])), float(rng.choice([0.0, 3.0]))
        frame, scene = right(hertz, begin), SCENE
        name = str(rng.choice(["R", "alpha", "I1", "I3", "g", "t", "wx", "vcx"]))
        factor = 1 + float(rng.choice([-1, 1])) * 10 ** rng.uniform(-3, -0.5)
        if name in frame:
            frame = frame.assign(**{name: factor * frame[name]})
        else:
            number = Fraction(scene.body.in_file_units()[name]) * Fraction(factor)
            scene = scene.varied(**{name: str(number)})
        found = check(frame, scene, friction=friction, start="other")
        kinds = {cause.kind for cause in found.causes}
        if "convention" in kinds or (friction == "scene" and found.passed):
            explained.append((name, factor, hertz, begin, found.causes))
    assert explained == []


@pytest.mark.parametrize("part", [-1.0, 0.5, 3.0])
def test_a_wrong_velocity_is_in_no_smaller_unit(part: float) -> None:
    """Near the vertical engines leave as much as a velocity that is almost 0."""
    frame = right(1000, 3.0)
    k = Rotation.from_quat(frame[["qx", "qy", "qz", "qw"]].to_numpy()).as_matrix()[:, :, 2]
    velocity = frame[["vcx", "vcy", "vcz"]].to_numpy()
    omega = frame[["wx", "wy", "wz"]].to_numpy()
    velocity = velocity + numpy.cross(omega, part * BODY.R * BODY.alpha * k)
    spoilt = frame.assign(vcx=velocity[:, 0], vcy=velocity[:, 1], vcz=velocity[:, 2])
    found = check(spoilt.drop(columns=["x", "y", "z"]), "reference", start="other")
    assert not found.passed
    assert "convention" not in {cause.kind for cause in found.causes}


def test_a_unit_of_an_engine_with_a_soft_contact_is_named(engine: Engine) -> None:
    frame = engine(1000, 0.25, law="soft")
    frame[["vcx", "vcy", "vcz"]] *= 1000
    found = check(frame.drop(columns=["x", "y", "z"]), "reference", friction="other")
    assert [cause.text for cause in found.causes] == ["lengths are in mm"]


def test_a_quaternion_keeps_its_length_and_turns_as_one_of_length_1() -> None:
    given = {name: right(60, 0.0)[name].to_numpy() for name in ("t", *POSE)}
    one = Convention(in_body=True, velocity_in_body=True, point="centre", place="centre")
    long, short = (
        convert({n: size * v if n[0] == "q" else v for n, v in given.items()}, one, BODY)
        for size in (2.0, 1.0)
    )
    for name in POSE:
        size = 2 if name[0] == "q" else 1
        assert long[name] == pytest.approx(size * short[name], rel=1e-14, abs=1e-14)


@pytest.mark.parametrize("axis", conventions.AXES)
@pytest.mark.parametrize("world", conventions.WORLDS)
def test_a_world_is_read_back(world: str, axis: str) -> None:
    frame = pose([0.001 * i for i in range(101)])
    theirs = written(frame, OURS.in_world(world, axis))
    found = check(theirs, "reference", world=world, axis=axis)
    assert found.passed, str(found)
    assert (found["golden"].value or 0) > 11
    ours = convert(theirs, OURS.in_world(world, axis), BODY)
    for name in POSE[4:]:
        assert ours[name] == pytest.approx(frame[name].to_numpy(), abs=1e-12)


@pytest.mark.usefixtures("no_cause")
def test_another_world_is_not_green(healthy: Healthy) -> None:
    theirs = written(pose([0.001 * i for i in range(101)]), OURS.in_world("y-up", "y"))
    for world, axis in (("z-up", "z"), ("y-up", "z"), ("left-handed-y-up", "y")):
        assert not check(theirs, "reference", world=world, axis=axis).passed
    refuses("got vectors columns, expected those of a rigid body", healthy(), world="y-up")
    refuses("world: got 'up', expected one of: z-up", theirs, world="up")


# ---- vectors and Euler angles ------------------------------------------------------------------

Spoil = Callable[[pandas.DataFrame], pandas.DataFrame]


def times(factor: float, names: str) -> Spoil:
    """Return a change of columns by a factor."""
    return lambda frame: frame.assign(**{name: factor * frame[name] for name in names.split()})


def holding(words: str) -> Spoil:
    """Return a change after which columns hold others."""
    pairs = [word.split("=") for word in words.split()]
    return lambda frame: frame.assign(
        **{ours: frame[held.lstrip("-")] * (-1 if "-" in held else 1) for ours, held in pairs}
    )


def shifted(frame: pandas.DataFrame) -> pandas.DataFrame:
    """Return velocities that are a row late."""
    return frame.assign(**{n: frame[n].shift(1).fillna(frame[n]) for n in ("vx", "vy")})


SPOILT: dict[str, Spoil] = {
    "the body's symmetry axis is -z": times(-1, "kx ky kz"),
    "the world is y up": holding("ky=kz kz=-ky Ly=Lz Lz=-Ly"),
    "the world is x up": holding("kx=kz ky=kx kz=ky Lx=Lz Ly=Lx Lz=Ly"),
    "the world is left-handed, z up, or the top spins the other way": times(-1, "ky vy Lx Lz"),
    "the time is in ms": times(1e3, "t"),
    "the time is in minutes": times(1 / 60, "t"),
    "lengths are in cm": times(100, "vx vy"),
    "lengths are in mm; the angular momentum is in kg mm^2/s": (
        lambda frame: times(1e6, "Lx Ly Lz")(times(1e3, "vx vy")(frame))
    ),
    # what is no convention
    "": shifted,
    "-": times(1.001, "kx"),
    "--": times(1.05, "vx"),
    "---": holding("vx=vy vy=vx"),
    "----": holding("Lx=Ly Ly=Lx"),
    "-----": times(-1, "kz"),
}


@pytest.fixture(scope="module")
def dry() -> pandas.DataFrame:
    """A motion with dry friction, which is not the scene's."""
    lines = SCENE.text.splitlines()
    text = "\n".join(line for line in lines if not line.startswith("mu"))
    friction = '[friction]\nlaw = "regularised"\nmu = "0.3"\nepsilon = "0.01"\n'
    run = tt.integrate(parse_scene(f"{text}\n{friction}", "dry", "dry.toml"), events=())
    return run.frame(*VECTORS[1:], times=[0.005 * i for i in range(150)], numbers="float")


@pytest.mark.parametrize("text", SPOILT)
def test_conventions_of_vectors_are_named(
    dry: pandas.DataFrame, healthy: Healthy, text: str
) -> None:
    for frame, friction in ((dry, "other"), (healthy("reference", 151, 0.75)[VECTORS], "scene")):
        found = check(SPOILT[text](frame), "reference", friction=friction)
        named = [cause.text for cause in found.causes if cause.kind == "convention"]
        assert (found.verdict, named) == ("fail", [text] if text.strip("-") else [])
    assert check(dry, "reference", friction="other").passed


@pytest.mark.parametrize(
    ("text", "spoil"),
    [
        ("the angles are in degrees", times(180 / numpy.pi, "theta phi")),
        ("the angular velocity is in revolutions per minute",
         times(30 / numpy.pi, "theta_dot phi_dot omega_3")),
        ("lengths are in mm", times(1e3, "nu_x nu_y")),
        ("", times(-1, "nu_y")),
        ("the world is left-handed, z up, or the top spins the other way",
         times(-1, "phi phi_dot omega_3 nu_y")),
    ],
)  # fmt: skip
def test_conventions_of_euler_angles_are_named(text: str, spoil: Spoil) -> None:
    run = tt.integrate("reference", record=("phi",))
    times_ = [0.005 * i for i in range(150)]
    names = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y", "phi")
    frame = run.frame(*names, times=times_, numbers="float")
    found = check(spoil(frame), "reference")
    assert [cause.text for cause in found.causes] == [text] * bool(text)


@pytest.mark.parametrize("since", [9.0, 0.7])
def test_a_convention_holds_in_all_rows(healthy: Healthy, since: float) -> None:
    """The world of a part, longer than what the search looks at, is no convention."""
    rows = healthy("reference", 601, 1.2)[VECTORS]
    spoilt = SPOILT["the world is y up"](rows).where(rows["t"] < since, rows)
    found = check(spoilt, "reference", friction="other", start="other")
    named = [cause.text for cause in found.causes if cause.kind == "convention"]
    assert found.verdict == "fail"
    assert named == (["the world is y up"] if since > 2 else [])


# ---- engines -----------------------------------------------------------------------------------

# The conventions of engines' documentations; dart and exudyn have ode's, the others bullet's.
OF_CENTRE: dict[str, Any] = {"point": "centre", "place": "centre"}
DOCUMENTED = {
    "mujoco": Convention(**OF_CENTRE, in_body=True),
    "drake": Convention(**OF_CENTRE),
    "ode": Convention(),
    "bullet": Convention(order="scalar last"),
}


def state(engine: str, **changed: Any) -> Columns:
    """Return the arrays that an engine writes of the first 0.2 s."""
    columns = written(right(1000, 0.0), replace(DOCUMENTED[engine], **changed))
    q, w, v, x = (
        numpy.array([columns[name] for name in names]).T
        for names in (POSE[:4], POSE[4:7], POSE[7:10], POSE[10:])
    )
    if engine == "mujoco":
        return {"t": columns["t"], "qpos": numpy.hstack([x, q]), "qvel": numpy.hstack([v, w])}
    return {"time": columns["t"], "quaternion": q, "velocity": v, "angular_velocity": w}


def test_every_engine_of_the_adapters_has_a_convention() -> None:
    assert {engine.name.lower() for engine in ADAPTERS} == {*conventions.ENGINES}


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("engine", DOCUMENTED)
def test_each_engine_passes_in_its_own_convention_only(
    engine: str, tmp_path: Path, said: Said
) -> None:
    numpy.savez(tmp_path / "run.npz", **state(engine))  # type: ignore[arg-type]
    options = f"--scene reference --until 0.199 --digits 9 --from {engine}"
    said("check", tmp_path / "run.npz", options, status=0)
    arrays = state(engine)
    clock = arrays.pop("time", arrays.pop("t", None))
    renamed: Any = {"engine": engine, "columns": {"clock": "t"}}
    assert check({"clock": clock, **arrays}, "reference", **renamed).passed
    other = "mujoco:cm" if engine == "mujoco" else "ode" if engine == "bullet" else "rapier"
    assert not check(state(engine), "reference", engine=other).passed
    of_cm = state("mujoco", point="cm", place="cm")
    assert check(of_cm, "reference", engine="mujoco:cm").passed


@pytest.mark.parametrize("form", ["{}{}", "{}_{}"])
def test_numbered_columns_are_arrays(form: str, tmp_path: Path) -> None:
    table = pandas.DataFrame({"t": right(1000, 0.0)["t"], "extra": 1.0})
    for name in ("qpos", "qvel"):
        for column, values in enumerate(state("mujoco")[name].T):
            table[form.format(name, column)] = values
    table.to_csv(tmp_path / "run.csv", index=False)
    assert check(tmp_path / "run.csv", "reference", engine="mujoco").passed


@pytest.mark.parametrize("engine", ["bullet", "drake"])
def test_components_may_have_their_own_names(engine: str) -> None:
    """The letters say the order of the quaternion, whatever the engine's."""
    columns = written(right(1000, 0.0), replace(DOCUMENTED[engine], order="scalar first"))
    table = engine_table({name.replace("vc", "v"): columns[name] for name in columns}, engine, {})
    ours = convert(table.load(table.names), DOCUMENTED[engine], BODY)
    expected = {name: right(1000, 0.0)[name].to_numpy() for name in POSE}
    cosine = numpy.sum([ours[name] * expected[name] for name in POSE[:4]], axis=0)
    assert abs(cosine) == pytest.approx(numpy.ones(200), abs=1e-12)
    for name in POSE[4:]:
        assert ours[name] == pytest.approx(expected[name], rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("engine", "changed", "message"),
    [
        ("havok", {}, "--from: got 'havok', expected one of: mujoco, drake"),
        ("mujoco:peg", {}, "--from: got 'mujoco:peg'"),
        ("mujoco", {"qvel": None}, "no qvel among the columns t, qpos; expected an array of 6"),
        ("mujoco", {"t": None}, "no array t or time among the columns qpos, qvel"),
        ("mujoco", {"qpos": numpy.zeros((200, 6))}, r"qpos: got shape \(200, 6\)"),
    ],
)
def test_what_cannot_be_read(engine: str, changed: dict[str, Any], message: str) -> None:
    arrays = {name: x for name, x in (state("mujoco") | changed).items() if x is not None}
    refuses(message, arrays, engine=engine)


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(("length", "failing"), [(0.0, "quaternion_norm"), (numpy.inf, "finite")])
def test_a_row_that_blew_up_is_left_to_the_checks(length: float, failing: str) -> None:
    arrays = state("mujoco")
    arrays["qpos"][9, 3:] = length
    found = check(arrays, "reference", engine="mujoco")
    assert failing in {each.name for each in found.failures}
    assert found["finite"].holds == (failing != "finite")
