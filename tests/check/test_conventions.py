"""Conventions: random ones are named, wrong physics is explained by none; those of engines."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest
from scipy.spatial.transform import Rotation

import tt_precise as tt
from benchmarks.engines import ENGINES as ADAPTERS
from tests.check.conftest import EULER, POSE, VECTORS, check, matches, refuses, solved
from tests.conftest import more
from tt_precise.check import conventions
from tt_precise.check.conventions import ANGLE, LENGTH, TIME, Convention

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


def written(frame: pandas.DataFrame, convention: Convention) -> Columns:
    """Return the rows as the convention has them, by matrices, independently of ``convert``."""
    q, w, v, x = (
        frame[names.split()].to_numpy()
        for names in ("qx qy qz qw", "wx wy wz", "vcx vcy vcz", "x y z")
    )
    turn = Rotation.from_quat(q).as_matrix()
    centre = BODY.R * BODY.alpha * turn[:, :, 2]
    if convention.point != "cm":
        arm = centre if convention.point == "centre" else centre - [0, 0, BODY.R]
        v = v + numpy.cross(w, arm)
    x = x + centre if convention.place == "centre" else x
    world = WORLDS[convention.up, convention.hand]
    sign = numpy.linalg.det(world)
    body = AXES[convention.axis[-1]]
    body = body @ numpy.diag([1, -1, -1.0]) if convention.axis[0] == "-" else body
    turn = world @ turn @ (body @ numpy.diag([1, sign, 1.0])).T
    x, v, w = x @ world.T, v @ world.T, sign * (w @ world.T)
    v = numpy.einsum("nji,nj->ni", turn, v) if convention.velocity_in_body else v
    w = numpy.einsum("nji,nj->ni", turn, w) if convention.in_body else w
    q = Rotation.from_matrix(turn).as_quat()[:, [3, 0, 1, 2]]
    q = q * numpy.array([1, -1, -1, -1]) if convention.inverse else q
    q = q if convention.order == "scalar first" else numpy.roll(q, -1, axis=1)
    t = (frame["t"].to_numpy() - frame["t"][0]) / TIME[convention.time]
    t = numpy.rint(t) if convention.time.startswith("rows") else t
    length = LENGTH[convention.length]
    rows = (*q.T, *(w.T / ANGLE[convention.angle]), *(v.T / length), *(x.T / length))
    return dict(zip(POSE, (t, *rows), strict=True))


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
        "point": [{"point": name} for name in ("centre", "contact")],
        "order": [{"order": "scalar last"}],
        "place": [{"place": "centre"}],
        **{name: [{name: True}] for name in ("inverse", "in_body", "velocity_in_body")},
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
        convention = draw(rng, hertz, start)
        rows = written(solved(POSE, 200, hertz, begin=0.0 if start == "scene" else 3.0), convention)
        causes = check(rows, "reference", friction=friction, start=start).causes
        words = convention.words()
        same = {words, words.replace("t counts rows at 1000 Hz", "the time is in ms")}
        if not (len(causes) == 1 and causes[0].text in same):
            missed.append((hertz, start, words, causes))
    assert missed == []


WRONG = ("R", "alpha", "I1", "I3", "g", "t", "wx", "vcx")


@pytest.mark.parametrize("friction", ["scene", "other"])
@pytest.mark.parametrize("name", ["wx", *(more(name) for name in WRONG)])
def test_wrong_physics_is_explained_by_no_convention(name: str, friction: str) -> None:
    """Right rows against another body, by another clock, or with a spoilt column."""
    for hertz, begin, factor in ((60, 0.0, 1.003), (1000, 3.0, 0.8)):
        frame, scene = solved(POSE, 200, hertz, begin=begin), SCENE
        if name in frame:
            frame[name] *= factor
        else:
            number = Fraction(SCENE.body.in_file_units()[name]) * Fraction(factor)
            scene = SCENE.varied(**{name: str(number)})
        result = check(frame, scene, friction=friction, start="other")
        assert "convention" not in {cause.kind for cause in result.causes}
        assert friction == "other" or not result.passed


@pytest.mark.parametrize("axis", conventions.AXES)
@pytest.mark.parametrize("world", conventions.WORLDS)
def test_a_file_passes_in_its_own_world_only(world: str, axis: str, no_cause: None) -> None:
    theirs = written(solved(POSE, 101, 1000), Convention().in_world(world, axis))
    own = check(theirs, "reference", world=world, axis=axis)
    assert own.passed, str(own)
    assert (own["golden"].value or 0) > 11
    other = {"z": "y", "y": "x", "x": "z"}[axis]
    assert not check(theirs, "reference", world=world, axis=other).passed


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


PHI = [*EULER, "phi"]


MIRRORED = "the world is left-handed, z up, or the top spins the other way"
Y_UP = holding("ky=kz kz=-ky Ly=Lz Lz=-Ly")


@pytest.mark.parametrize(
    ("columns", "text", "spoil"),
    [
        (VECTORS, "the body's symmetry axis is -z", times(-1, "kx ky kz")),
        (VECTORS, "the world is y up", Y_UP),
        (VECTORS, MIRRORED, times(-1, "ky vy Lx Lz")),
        (VECTORS, "the time is in ms", times(1e3, "t")),
        (VECTORS, "lengths are in cm", times(100, "vx vy")),
        more(VECTORS, "lengths are in mm; the angular momentum is in kg mm^2/s",
         lambda frame: times(1e6, "Lx Ly Lz")(times(1e3, "vx vy")(frame))),
        (PHI, "the angles are in degrees", times(180 / numpy.pi, "theta phi")),
        (PHI, "the angular velocity is in revolutions per minute",
         times(30 / numpy.pi, "theta_dot phi_dot omega_3")),
        more(PHI, "lengths are in mm", times(1e3, "nu_x nu_y")),
        (PHI, MIRRORED, times(-1, "phi phi_dot omega_3 nu_y")),
        (VECTORS, None, lambda f: f),
        (PHI, None, lambda f: f),
        # no conventions
        (VECTORS, "", lambda f: f.assign(vx=f["vx"].shift(1).fillna(f["vx"]))),
        (VECTORS, "", times(1.001, "kx")),
        (VECTORS, "", times(-1, "kz")),
        (PHI, "", times(-1, "nu_y")),
    ],
)  # fmt: skip
def test_conventions_of_vectors_and_angles(
    columns: list[str], text: str | None, spoil: Spoil
) -> None:
    """Rows of the scene's friction, and rows of another friction than the scene's."""
    for name, mu, friction in (("reference", "0.3", "scene"), ("regularised-1e-2", "0.2", "other")):
        frame, scene = solved(columns, 151, 200, name), tt.load_scene(name).varied(mu=mu)
        result = check(spoil(frame), scene, friction=friction)
        named = [cause.text for cause in result.causes if cause.kind == "convention"]
        assert (result.passed, named) == (text is None, [text] * bool(text))


@pytest.mark.parametrize("since", [9.0, 0.7])
def test_a_convention_holds_in_all_rows(since: float) -> None:
    """The world of a part, longer than what the search looks at, is no convention."""
    rows = solved(VECTORS, 601, 500)
    spoilt = Y_UP(rows).where(rows["t"] < since, rows)
    result = check(spoilt, "reference", friction="other", start="other")
    named = [cause.text for cause in result.causes if cause.kind == "convention"]
    assert (result.verdict, named) == ("fail", ["the world is y up"] * (since > 2))


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
    columns = written(solved(POSE, 200, 1000), replace(DOCUMENTED[engine], **changed))
    q, w, v, x = (
        numpy.array([columns[name] for name in names]).T
        for names in (POSE[1:5], POSE[5:8], POSE[8:11], POSE[11:])
    )
    if engine == "mujoco":
        return {"t": columns["t"], "qpos": numpy.hstack([x, q]), "qvel": numpy.hstack([v, w])}
    return {"time": columns["t"], "quaternion": q, "velocity": v, "angular_velocity": w}


def test_every_engine_of_the_adapters_has_a_convention() -> None:
    assert {engine.name.lower() for engine in ADAPTERS} == {*conventions.ENGINES}


@pytest.mark.parametrize("engine", DOCUMENTED)
def test_engines_pass_in_their_own_convention_only(engine: str, no_cause: None) -> None:
    arrays = state(engine)
    arrays["clock"] = arrays.pop("t" if engine == "mujoco" else "time")
    renamed: Any = {"engine": engine, "columns": {"clock": "t"}, "until": 0.199}
    assert matches(arrays, "reference", digits=9, **renamed).passed
    other = "mujoco:cm" if engine == "mujoco" else "ode" if engine == "bullet" else "rapier"
    assert not check(state(engine), "reference", engine=other).passed
    of_cm = state("mujoco", point="cm", place="cm")
    assert check(of_cm, "reference", engine="mujoco:cm").passed


def test_numbered_columns_are_arrays() -> None:
    arrays = state("mujoco")
    table: Any = {"t": arrays.pop("t"), "extra": 0}
    for name, values in arrays.items():
        table |= {f"{name}_{i}": column for i, column in enumerate(values.T)}
    assert check(table, "reference", engine="mujoco").passed


def test_letters_say_the_order_of_a_quaternion() -> None:
    columns = written(solved(POSE, 200, 1000), DOCUMENTED["ode"])
    table = {name.replace("vc", "v"): columns[name] for name in columns}
    assert check(table, "reference", engine="bullet").passed


@pytest.mark.parametrize(
    ("engine", "changed", "message"),
    [
        ("havok", {}, "got 'havok', expected one of: mujoco, drake"),
        ("mujoco", {"qvel": None}, "no qvel among the columns t, qpos"),
        ("mujoco", {"qpos": numpy.zeros((200, 6))}, r"qpos: got shape \(200, 6\)"),
    ],
)
def test_refused_arrays(engine: str, changed: dict[str, Any], message: str) -> None:
    arrays = {name: x for name, x in (state("mujoco") | changed).items() if x is not None}
    refuses(message, arrays, engine=engine)


@pytest.mark.parametrize(
    ("rows", "length", "failures"),
    [(slice(99), 1 + 1e-5, "quaternion_norm"), (9, 0.0, "equations"), (9, numpy.nan, "finite")],
)
def test_a_quaternion_keeps_its_length(
    rows: Any, length: float, failures: str, no_cause: None
) -> None:
    """It rotates like one of length 1; a row that blew up is left to the checks."""
    arrays = state("mujoco")
    arrays["qpos"][rows, 3:] *= length
    result = check(arrays, "reference", engine="mujoco")
    assert failures in {each.name for each in result.failures}
    assert len(result.failures) == 1 or length == 0
