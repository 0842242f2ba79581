"""Worlds: a right trajectory written in another one is read back, and in the wrong one fails."""

import numpy
import pandas
import pytest

from tests.check.conftest import Healthy, check, refuses
from tt_precise.check.worlds import AXES, TO_Z, WORLDS, World
from tt_precise.mechanics.vectors import rotate

E = numpy.eye(3)


def matrix(hand: str, axis: str) -> numpy.ndarray:
    """The map from their coordinates to ours."""
    sign = 1 if hand == "right" else -1
    columns = [rotate(TO_Z[hand, axis], tuple(e)) for e in E]
    return sign * numpy.array(columns, float).T


def written(frame: pandas.DataFrame, world: str, axis: str) -> pandas.DataFrame:
    """The rows as an engine of that world would write them, by rotation matrices."""
    from scipy.spatial.transform import Rotation

    hand, up = WORLDS[world]
    W, B = matrix(hand, up), matrix(hand, axis)
    ours = Rotation.from_quat(frame[["qw", "qx", "qy", "qz"]], scalar_first=True).as_matrix()
    theirs = Rotation.from_matrix(W.T @ ours @ B).as_quat(scalar_first=True)
    table = {"t": frame["t"], **dict(zip(("qw", "qx", "qy", "qz"), theirs.T, strict=True))}
    for names, sign in ((("wx", "wy", "wz"), numpy.linalg.det(W)), (("vcx", "vcy", "vcz"), 1.0)):
        vectors = sign * frame[list(names)].to_numpy() @ W
        table |= dict(zip(names, vectors.T, strict=True))
    return pandas.DataFrame(table)


@pytest.mark.parametrize(("hand", "axis"), TO_Z)
def test_every_map_takes_its_axis_to_z(hand: str, axis: str) -> None:
    W = matrix(hand, axis)
    assert numpy.linalg.det(W) == pytest.approx(1 if hand == "right" else -1)
    assert W @ E["xyz".index(axis)] == pytest.approx(E[2])


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("world", WORLDS)
def test_a_world_is_read_back(healthy: Healthy, rigid_body: Healthy, world: str, axis: str) -> None:
    frame = rigid_body(healthy("reference", 101, 0.1))
    theirs = written(frame, world, axis)
    found = check(theirs, "reference", world=world, axis=axis)
    assert found.passed, str(found)
    assert (found["golden"].value or 0) > 11
    back = World.of_names(world, axis).standard({str(n): theirs[n].to_numpy() for n in theirs})
    for name in ("wx", "wy", "wz", "vcx", "vcy", "vcz"):
        assert back[name] == pytest.approx(frame[name].to_numpy(), abs=1e-12)


@pytest.mark.usefixtures("no_cause")
def test_another_world_is_not_green(healthy: Healthy, rigid_body: Healthy) -> None:
    theirs = written(rigid_body(healthy("reference", 101, 0.1)), "y-up", "y")
    for world, axis in (("z-up", "z"), ("y-up", "z"), ("left-handed-y-up", "y")):
        try:
            assert not check(theirs, "reference", world=world, axis=axis).passed
        except ValueError:  # refused as another convention
            continue
    refuses("got vectors columns, expected those of a rigid body", healthy(), world="y-up")
    refuses("world: got 'up', expected one of: z-up", theirs, world="up")
