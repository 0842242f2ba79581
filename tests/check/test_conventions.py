"""The staged search: random conventions are named, wrong physics is explained by none."""

from collections.abc import Callable
from fractions import Fraction
from functools import cache
from typing import Any

import numpy
import pandas
import pytest
from scipy.spatial.transform import Rotation

import tt_precise as tt
from tests.check.conftest import POSE, VECTORS, Engine, Healthy, check, pose, refuses
from tests.conftest import more
from tt_precise.check import conventions
from tt_precise.check.conventions import ANGLE, LENGTH, OURS, TIME, Convention, convert
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
    "vx, vy hold vy, vx": holding("vx=vy vy=vx"),
    "Lx, Ly hold Ly, Lx": holding("Lx=Ly Ly=Lx"),
    "vx, vy have the other sign": times(-1, "vx vy"),
    "kz has the other sign": times(-1, "kz"),
    "the axis points to the other end of the body": times(-1, "kx ky kz"),
    "the world is y up": holding("ky=kz kz=-ky Ly=Lz Lz=-Ly"),
    "the world is x up": holding("kx=kz ky=kx kz=ky Lx=Lz Ly=Lx Lz=Ly"),
    "the world is left-handed, or the top spins the other way": times(-1, "ky vy Lx Lz"),
    "the time is in ms": times(1e3, "t"),
    "the time is in minutes": times(1 / 60, "t"),
    "the velocities are in cm/s": times(100, "vx vy"),
    "the angular momentum is in kg mm^2/s; the velocities are in mm/s": (
        lambda frame: times(1e6, "Lx Ly Lz")(times(1e3, "vx vy")(frame))
    ),
    # what is no convention
    "": shifted,
    "-": times(1.001, "kx"),
    "--": times(1.05, "vx"),
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
        ("the angular velocities are in revolutions per minute",
         times(30 / numpy.pi, "theta_dot phi_dot omega_3")),
        ("the velocities are in mm/s", times(1e3, "nu_x nu_y")),
        ("nu_y has the other sign", times(-1, "nu_y")),
        ("the top spins the other way, or the world is left-handed",
         times(-1, "phi phi_dot omega_3 nu_y")),
    ],
)  # fmt: skip
def test_conventions_of_euler_angles_are_named(text: str, spoil: Spoil) -> None:
    run = tt.integrate("reference", record=("phi",))
    times_ = [0.005 * i for i in range(150)]
    names = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y", "phi")
    frame = run.frame(*names, times=times_, numbers="float")
    found = check(spoil(frame), "reference")
    assert [cause.text for cause in found.causes] == [text]


@pytest.mark.parametrize("since", [9.0, 0.7])
def test_a_convention_holds_in_all_rows(healthy: Healthy, since: float) -> None:
    """Exchanged columns of a part, longer than what the search looks at, are no convention."""
    rows = healthy("reference", 601, 1.2)[VECTORS]
    exchanged = SPOILT["vx, vy hold vy, vx"](rows).where(rows["t"] < since, rows)
    found = check(exchanged, "reference", friction="other", start="other")
    named = [cause.text for cause in found.causes if cause.kind == "convention"]
    assert found.verdict == "fail"
    assert named == (["vx, vy hold vy, vx"] if since > 2 else [])
