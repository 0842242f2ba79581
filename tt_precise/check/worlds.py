"""``World``: conversion of rigid-body columns with another vertical, handedness or body axis.

Our world is right-handed, z is up, and the symmetry axis is the body's z. Let W map coordinates of
the engine's world to ours, and B coordinates of the engine's body to ours. Both are rotations, or
both are reflections, since a left-handed engine has left-handed frames of world and body. Then the
attitude is R = W R' B^T, a velocity or a position is W v', and an angular velocity, an axial
vector, is det(W) W omega'.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from tt_precise.mechanics.vectors import Quaternion, Vector, multiplied, rotate, scaled
from tt_precise.runtime.values import Array, require_name

HALF = math.sqrt(0.5)
# Rotations that take their axis to our z, by hand and axis: W for the vertical, B for the body's
# axis. A reflection of the left hand is -1 times the rotation written here.
TO_Z: dict[tuple[str, str], Quaternion] = {
    ("right", "z"): (1.0, 0.0, 0.0, 0.0),
    ("right", "y"): (HALF, HALF, 0.0, 0.0),  # (a, -c, b)
    ("right", "x"): (0.5, -0.5, -0.5, -0.5),  # (b, c, a)
    ("left", "z"): (0.0, 0.0, 1.0, 0.0),  # (a, -b, c)
    ("left", "y"): (0.0, 0.0, HALF, -HALF),  # (a, c, b)
    ("left", "x"): (0.0, HALF, 0.0, -HALF),  # (c, b, a)
}
WORLDS = {
    "z-up": ("right", "z"),
    "y-up": ("right", "y"),
    "left-handed-z-up": ("left", "z"),
    "left-handed-y-up": ("left", "y"),
}
AXES = ("z", "y", "x")
QUATERNION, OMEGA = ("qw", "qx", "qy", "qz"), ("wx", "wy", "wz")
POLAR = (("vcx", "vcy", "vcz"), ("x", "y", "z"))


class World(NamedTuple):
    """The handedness and the vertical of a world, and the symmetry axis of the body."""

    hand: str = "right"
    up: str = "z"
    axis: str = "z"

    @classmethod
    def of_names(cls, world: str, axis: str) -> World:
        """Return the world with this name, and the body's axis.

        Raises ``InputError``: there is none.
        """
        for what, got, known in (("world", world, WORLDS), ("axis", axis, AXES)):
            require_name(what, got, known)
        return cls(*WORLDS[world], axis)

    @property
    def is_ours(self) -> bool:
        """True if the columns need no conversion."""
        return self == World()

    def standard(self, columns: Mapping[str, Array]) -> dict[str, Array]:
        """Convert rigid-body columns of this world to ours."""
        world, body = TO_Z[self.hand, self.up], TO_Z[self.hand, self.axis]
        back = (body[0], -body[1], -body[2], -body[3])
        w, x, y, z = (columns[name] for name in QUATERNION)
        attitude = multiplied(multiplied(world, (w, x, y, z)), back)
        found = {**columns, **dict(zip(QUATERNION, attitude, strict=True))}
        sign = 1 if self.hand == "right" else -1
        for names in (OMEGA, *POLAR):
            if all(name in columns for name in names):
                vector: Vector = (columns[names[0]], columns[names[1]], columns[names[2]])
                there = scaled(1 if names == OMEGA else sign, rotate(world, vector))
                found |= dict(zip(names, there, strict=True))
        return found
