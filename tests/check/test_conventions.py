"""The staged search: random conventions are found, wrong physics is explained by none."""

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy
import pandas
import pytest
from scipy.spatial.transform import Rotation

import tt_precise as tt
from tests.check.conftest import Engine, Healthy, check, refuses
from tests.check.test_force_free import POSE
from tests.conftest import more
from tt_precise.check import conventions
from tt_precise.check.conventions import (
    ANGLE,
    LENGTH,
    OURS,
    TIME,
    Convention,
    FoundConvention,
    Given,
    convert,
    fit,
    search,
)
from tt_precise.check.force_free_flow import axis_of
from tt_precise.mechanics.newton import contact_arm
from tt_precise.mechanics.vectors import dot

BODY = tt.load_scene("reference").body.numbers(float)
# Rows are the file's axes in terms of ours.
WORLDS = {
    ("z", "right"): numpy.eye(3),
    ("y", "right"): numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0.0]]),
    ("x", "right"): numpy.array([[0, 0, 1], [1, 0, 0], [0, 1, 0.0]]),
    ("z", "left"): numpy.diag([1, -1, 1.0]),
    ("y", "left"): numpy.array([[1, 0, 0], [0, 0, 1], [0, 1, 0.0]]),
}
AXES = {"z": WORLDS["z", "right"], "y": WORLDS["y", "right"], "x": WORLDS["x", "right"]}
FLIP = numpy.diag([1, -1, -1.0])


@cache
def right(hertz: int, begin: float) -> Given:
    run = tt.integrate("reference", events=(), record=("phi", "psi", "x", "y"))
    times = [begin + i / hertz for i in range(200)]
    frame = run.frame(*POSE, times=times, numbers="float")

    return Given.of_columns({"t": numpy.array(times), **{n: frame[n].to_numpy() for n in POSE}})


@cache
def jellett() -> float:
    start = right(60, 0.0).part(slice(0, 1)).rows(BODY)
    return float(-dot(tuple(start.L), contact_arm(BODY, axis_of(start.q)))[0])


def written(given: Given, one: Convention, offset: float) -> Given:
    """The rows as the convention has them, by matrices, independently of ``convert``."""
    rotation = Rotation.from_quat(given.q[[1, 2, 3, 0]].T)
    turn = rotation.as_matrix()
    k = turn[:, :, 2]
    assert given.v is not None
    x = numpy.zeros((len(given.t), 3)) if given.x is None else given.x.T
    t, w, v = given.t, given.w.T, given.v.T
    centre = BODY.R * BODY.alpha * k
    if one.point != "cm":
        arm = centre if one.point == "centre" else centre - [0, 0, BODY.R]
        v = v + numpy.cross(w, arm)
    if one.place == "centre":
        x = x + centre
    world = WORLDS[one.up, one.hand]
    sign = numpy.linalg.det(world)
    body = AXES[one.axis[-1]]
    if one.axis[0] == "-":
        body = body @ FLIP
    if sign < 0:
        body = body @ numpy.diag([1, -1, 1.0])
    x, v, w = x @ world.T, v @ world.T, sign * (w @ world.T)
    turn = world @ turn @ body.T
    if one.velocity_in_body:
        v = numpy.einsum("nji,nj->ni", turn, v)
    if one.in_body:
        w = numpy.einsum("nji,nj->ni", turn, w)
    q = Rotation.from_matrix(turn).as_quat()[:, [3, 0, 1, 2]]
    q = q * numpy.array([1, -1, -1, -1]) if one.inverse else q
    q = q if one.order == "scalar first" else numpy.roll(q, -1, axis=1)
    t = (t - t[0] + offset) / TIME[one.time]
    if one.time.startswith("rows"):
        t = numpy.rint(t - t[0])
    length = LENGTH[one.length]
    return Given(t, q.T, w.T / ANGLE[one.angle], v.T / length, x.T / length)


def draw(rng: numpy.random.Generator, hertz: int) -> Convention:
    """At most three groups at once."""
    choices: dict[str, list[dict[str, object]]] = {
        "time": [{"time": name} for name in ("ms", "microseconds", "ns", f"rows at {hertz} Hz")],
        "length": [{"length": name} for name in ("cm", "mm", "inches")],
        "angle": [{"angle": name} for name in ("degrees", "revolutions per minute")],
        "world": [{"up": u, "hand": h} for u, h in WORLDS if (u, h) != ("z", "right")],
        "axis": [{"axis": name} for name in ("y", "x", "-z", "-y", "-x")],
        "order": [{"order": "scalar last"}],
        "inverse": [{"inverse": True}],
        "frame": [{"in_body": True}],
        "point": [{"point": name} for name in ("centre", "contact")],
        "velocity": [{"velocity_in_body": True}],
        "place": [{"place": "centre"}],
    }
    chosen: dict[str, object] = {}
    for group in rng.choice([*choices], int(rng.integers(1, 4)), replace=False):
        chosen |= choices[group][int(rng.integers(len(choices[group])))]
    return Convention(**chosen)  # type: ignore[arg-type]


class Tried(NamedTuple):
    wanted: Convention
    found: list[FoundConvention]


def tries(seed: int, count: int) -> list[Tried]:
    rng = numpy.random.default_rng(seed)
    done = []
    for _ in range(count):
        hertz, begin = int(rng.choice([60, 1000])), float(rng.choice([0.0, 3.0]))
        one = draw(rng, hertz)
        given = written(right(hertz, begin), one, float(rng.choice([0.0, 100.0])))
        _, found = search(given, BODY, {}, jellett())
        done.append(Tried(one, found))
    return done


def wrong(tried: Tried) -> str:
    """Neither found first nor tied; rows at 1000 Hz are ms."""
    same = {tried.wanted, *_tied(tried.wanted)}
    first = {one.convention for one in tried.found if _alike(one, tried)}
    return "" if same & first else str((tried.wanted, tried.found[:1]))


def _alike(one: FoundConvention, tried: Tried) -> bool:
    return one.exactly and one.convention.changes == tried.found[0].convention.changes


def _tied(one: Convention) -> list[Convention]:
    pairs = {"rows at 1000 Hz": "ms", "ms": "rows at 1000 Hz"}
    return [replace(one, time=pairs[one.time])] if one.time in pairs else []


@pytest.mark.parametrize(
    ("seed", "count"), [(1, 4), more(1, 8), pytest.param(7, 180, marks=pytest.mark.slow)]
)
def test_random_conventions_are_found(seed: int, count: int) -> None:
    assert [text for text in map(wrong, tries(seed, count)) if text] == []


def wrong_physics(seed: int, count: int) -> list[str]:
    """Right rows against another body, or by another clock, that some convention explains."""
    rng, explained = numpy.random.default_rng(seed), []
    for _ in range(count):
        hertz, begin = int(rng.choice([60, 1000])), float(rng.choice([0.0, 3.0]))
        given, body = right(hertz, begin), BODY
        name = str(rng.choice(["m", "R", "alpha", "I1", "I3", "g", "t", "wx", "vcx"]))
        factor = 1 + float(rng.choice([-1, 1])) * 10 ** rng.uniform(-3, -0.5)
        if name == "t":
            given = given._replace(t=factor * given.t)
        elif name in ("wx", "vcx"):  # a component of the file
            changed = numpy.array([[factor], [1.0], [1.0]])
            part = given.w if name == "wx" else given.v
            assert part is not None
            given = given._replace(**{"w" if name == "wx" else "v": changed * part})
        else:
            body = replace(body, **{name: factor * getattr(body, name)})
        _, found = search(given, body, {}, jellett())
        if found:
            text = f"{name} {factor:.4f} at {hertz} Hz from {begin} s: "
            explained.append(text + found[0].convention.words())
    return explained


@pytest.mark.parametrize(("seed", "count"), [(2, 3), pytest.param(5, 50, marks=pytest.mark.slow)])
def test_wrong_physics_is_explained_by_no_convention(seed: int, count: int) -> None:
    assert wrong_physics(seed, count) == []


def _of_point(given: Given, part: float) -> Given:
    """The rows with the velocity of the point at a part of the way to the sphere's centre."""
    arm = part * BODY.R * BODY.alpha * numpy.array(axis_of(given.q))
    assert given.v is not None
    return given._replace(v=given.v + numpy.cross(given.w, arm, axis=0), x=None)


@pytest.mark.parametrize("part", [-1.0, 0.5, 3.0])
def test_a_wrong_velocity_is_in_no_smaller_unit(part: float) -> None:
    """Near the vertical engines leave as much as a velocity that is almost 0."""
    upright = right(1000, 3.0)
    assert search(_of_point(upright, part), BODY, {}, jellett())[1] == []
    (found, *_) = search(_of_point(upright, 1.0), BODY, {}, jellett())[1]
    assert found.convention.words() == "the velocity is that of the sphere's centre"


def test_a_unit_of_an_engine_with_a_soft_contact_is_named(engine: Engine) -> None:
    """Near the vertical, too."""
    frame = engine(1000, 0.25, law="soft")
    given = Given.of_columns({str(name): frame[name].to_numpy() for name in frame})
    assert given.v is not None
    in_mm = given._replace(v=1000 * given.v, x=None)
    found = search(in_mm, BODY, {}, jellett())[1][0]
    assert (found.convention.words(), found.exactly) == ("lengths are in mm", False)


def test_what_is_right_is_not_searched() -> None:
    as_given, found = search(right(60, 0.0), BODY, {}, jellett())
    assert as_given.passes
    assert found == []
    assert OURS.words() == ""


def test_another_place_of_the_mass_is_no_convention() -> None:
    """The hundredth of alpha shows in lift, height and momentum."""
    body = replace(BODY, alpha=1.01 * BODY.alpha)
    assert not fit(body, right(60, 0.0), {}).passes
    assert search(right(60, 0.0), body, {}, jellett())[1] == []
    assert conventions.LIMITS["lift"] < 1e-5


@pytest.mark.parametrize(("up", "hand"), WORLDS)
def test_every_world_has_its_vertical_and_its_hand(up: str, hand: str) -> None:
    still = numpy.tile([[1.0], [0.0], [0.0], [0.0]], 3)
    one = Convention(up=up, hand=hand)
    ours = convert(Given(numpy.arange(3.0), still, numpy.eye(3), numpy.eye(3)), one, BODY)
    assert ours.v is not None
    assert ours.v == pytest.approx(WORLDS[up, hand].T)
    assert numpy.linalg.det(ours.v) * ours.w == pytest.approx(ours.v)


def test_a_quaternion_keeps_its_length_and_turns_as_one_of_length_1() -> None:
    given = right(60, 0.0)
    one = Convention(in_body=True, velocity_in_body=True, point="centre", place="centre")
    long, short = (convert(given._replace(q=size * given.q), one, BODY) for size in (2.0, 1.0))
    assert numpy.array_equal(long.q, 2 * short.q)
    assert all(numpy.allclose(a, b, rtol=1e-14) for a, b in zip(long[2:5], short[2:5], strict=True))


def in_world(frame: pandas.DataFrame, world: str, axis: str) -> Given:
    """The rows as an engine of that world would write them."""
    given = Given.of_columns({str(name): frame[name].to_numpy() for name in frame})
    return written(given, OURS.in_world(world, axis), 0.0)._replace(x=None)


@pytest.mark.parametrize("axis", conventions.AXES)
@pytest.mark.parametrize("world", conventions.WORLDS)
def test_a_world_is_read_back(healthy: Healthy, rigid_body: Healthy, world: str, axis: str) -> None:
    frame = rigid_body(healthy("reference", 101, 0.1))
    theirs = in_world(frame, world, axis)
    found = check(theirs.columns, "reference", world=world, axis=axis)
    assert found.passed, str(found)
    assert (found["golden"].value or 0) > 11
    ours = convert(theirs, OURS.in_world(world, axis), BODY).columns
    for name in ("wx", "wy", "wz", "vcx", "vcy", "vcz"):
        assert ours[name] == pytest.approx(frame[name].to_numpy(), abs=1e-12)


@pytest.mark.parametrize(
    ("world", "axis", "given", "named"),
    [
        ("z-up", "z", "y-up", "without world, axis"),
        ("y-up", "z", "y-up", 'with world="y-up"'),
        # right-handed, it is the motion in a mirror
        ("left-handed-y-up", "y", "left-handed-z-up", 'with world="left-handed-y-up" axis="y"'),
    ],
)
def test_the_world_that_is_meant_is_named_instead_of_the_one_given(
    healthy: Healthy, rigid_body: Healthy, world: str, axis: str, given: str, named: str
) -> None:
    theirs = in_world(rigid_body(healthy("reference", 101, 0.1)), world, axis)
    found = check(theirs.columns, "reference", world=given, axis="y")
    assert [one.text for one in found.causes] == [f"it is read {named}"]


def test_a_rounded_file_of_another_world_is_a_rounded_file(
    healthy: Healthy, rigid_body: Healthy
) -> None:
    """Columns that sum others do not show their decimals."""
    theirs = in_world(rigid_body(healthy("reference", 101, 0.1)), "y-up", "z").columns
    rounded = {name: numpy.round(values, 6) for name, values in theirs.items()}
    found = check(rounded, "reference", world="y-up")
    assert found.passed, str(found)
    assert found.written == "qw qx qy qz wx wy wz vcx vcy vcz: 6 decimals"
    (cause,) = check(rounded, "reference").causes
    assert cause.text == 'the world is y up: add world="y-up"'


@pytest.mark.usefixtures("no_cause")
def test_another_world_is_not_green(healthy: Healthy, rigid_body: Healthy) -> None:
    theirs = in_world(rigid_body(healthy("reference", 101, 0.1)), "y-up", "y").columns
    for world, axis in (("z-up", "z"), ("y-up", "z"), ("left-handed-y-up", "y")):
        try:
            assert not check(theirs, "reference", world=world, axis=axis).passed
        except ValueError:  # refused as another convention
            continue
    refuses("got vectors columns, expected those of a rigid body", healthy(), world="y-up")
    refuses("world: got 'up', expected one of: z-up", theirs, world="up")
