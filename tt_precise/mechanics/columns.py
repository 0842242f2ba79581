"""The columns of a trajectory, each described once: unit, frame and meaning.

The inertial frame X, Y, Z is right-handed with Z up, and the table is Z = 0. Quantities that are
computed from a state (energies, g_n, ...) are described in ``quantities``.
"""

from __future__ import annotations

from typing import NamedTuple

from tt_precise.mechanics.quantities import QUANTITIES


class Description(NamedTuple):
    """Unit (SI) and meaning of a column."""

    unit: str
    meaning: str


DESCRIPTIONS = {
    "t": Description("s", "time since the start; exact where it is a plain decimal"),
    "kx": Description("1", "symmetry axis (unit vector), along the inertial X axis"),
    "ky": Description("1", "symmetry axis, along Y"),
    "kz": Description("1", "symmetry axis, along the vertical Z: cos theta"),
    "Lx": Description("kg m^2/s", "angular momentum about the centre of mass, along X"),
    "Ly": Description("kg m^2/s", "angular momentum about the centre of mass, along Y"),
    "Lz": Description("kg m^2/s", "angular momentum about the centre of mass, along Z"),
    "vx": Description("m/s", "velocity of the contact point of the body, along X"),
    "vy": Description("m/s", "velocity of the contact point of the body, along Y"),
    "height": Description("m", "height of the lowest point above the table"),
    "rise": Description("m/s", "rate of that height: vertical velocity of the lowest point"),
    "phi": Description("rad", "azimuth of the axis, counted from its start at 0"),
    "psi": Description("rad", "angle of rotation about the axis, from 0"),
    "x": Description("m", "centre of mass along X, from 0"),
    "y": Description("m", "centre of mass along Y, from 0"),
    "z": Description("m", "centre of mass above the table, R (1 - alpha cos theta)"),
    "qw": Description("1", "orientation, body to inertial frame: the quaternion's scalar part"),
    "qx": Description("1", "orientation, first component of the vector part"),
    "qy": Description("1", "orientation, second component of the vector part"),
    "qz": Description("1", "orientation, third component of the vector part"),
    "wx": Description("rad/s", "angular velocity in the inertial frame, along X"),
    "wy": Description("rad/s", "angular velocity in the inertial frame, along Y"),
    "wz": Description("rad/s", "angular velocity in the inertial frame, along Z"),
    "wbx": Description("rad/s", "angular velocity in the body frame, about its first axis"),
    "wby": Description("rad/s", "angular velocity in the body frame, about its second axis"),
    "wbz": Description("rad/s", "angular velocity in the body frame, about its third: omega_3"),
    "vcx": Description("m/s", "velocity of the centre of mass, along X"),
    "vcy": Description("m/s", "velocity of the centre of mass, along Y"),
    "vcz": Description("m/s", "velocity of the centre of mass, along the vertical Z"),
}


def described(name: str) -> Description:
    """Unit and meaning of a column or a quantity."""
    if name in DESCRIPTIONS:
        return DESCRIPTIONS[name]
    quantity = QUANTITIES[name]
    return Description(quantity.unit, quantity.meaning)
