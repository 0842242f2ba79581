"""The pose as columns of a trajectory: names, dimensions, and its values at a row."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from tt_precise.mechanics.conversion import horizontal_length
from tt_precise.mechanics.pose import Pose, pose
from tt_precise.mechanics.quantities import RATE, SPEED, Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.scene.body import Dimension

# what stands for the pose among column names: scalar first, or last
POSE, POSE_SCALAR_LAST = "pose", "pose:xyzw"
_LAST = ("qx", "qy", "qz", "qw")
POSE_COLUMNS = {
    POSE: Pose._fields,
    POSE_SCALAR_LAST: (*_LAST, *(name for name in Pose._fields if name not in _LAST)),
}
POSE_NAMES = frozenset(Pose._fields)
_DIMENSIONS = {"q": Dimension(), "w": RATE, "v": SPEED}
_LENGTH = Dimension(0, 1, 0)
MOST_MISSED = 0.1  # rad between a quadrature's phi and the state's; a lost passage makes pi


def expanded(names: Iterable[str]) -> tuple[str, ...]:
    """``names`` with the pose's own columns in the place of what stands for them."""
    columns = (column for name in names for column in POSE_COLUMNS.get(name, (name,)))
    return tuple(dict.fromkeys(columns))


def dimension(name: str) -> Dimension:
    """The dimension of a column of the pose."""
    return _DIMENSIONS.get(name[0], _LENGTH)


def pose_of(q: Motion, recorded: Mapping[str, Scalar]) -> Pose:
    """The pose of a motion whose phi, psi, x and y are ``recorded``; one row or arrays of them.

    Raises
    ------
    InputError
        The recorded phi lost the half turn that it takes where the axis passes the vertical.
    """
    import numpy

    fn, phi = q.fn, recorded["phi"]
    pi = fn.atan2(abs(0 * phi), abs(0 * phi) - 1)  # of the arithmetic, whichever it is
    nearest = getattr(fn, "nint", None) or fn.round
    # the azimuth of the state itself, in the turn that the quadrature counted
    azimuth = fn.atan2(q.state.ky, q.state.kx)
    azimuth = azimuth + 2 * pi * nearest((phi - azimuth) / (2 * pi))
    if bool((numpy.abs(numpy.asarray(phi - azimuth, dtype=float)) > MOST_MISSED).any()):
        raise InputError(
            "pose: got an axis that is exactly vertical at some time, where phi and psi are "
            "undefined; expected another scene"
        )
    length = horizontal_length(fn, q.state.kx, q.state.ky)
    return pose(q, length, azimuth, recorded["psi"], recorded["x"], recorded["y"])
