"""``tt-precise columns``: the columns of a trajectory, with units, frames and conventions."""

from __future__ import annotations

import click

from tt_precise.commands.options import JSON, emit
from tt_precise.mechanics.digits import RULE
from tt_precise.runtime.values import Json

SCHEMA = "tt_precise.columns/1"
CONVENTIONS = (
    "Frames: the inertial frame X, Y, Z is right-handed, Z up, and the table is Z = 0. The body's "
    "frame has its origin at the centre of mass and the symmetry axis k as third axis. k points "
    "from the centre of mass to the centre of the sphere: theta is 0 with the centre of mass "
    "lowest, pi when inverted.",
    "Velocities: (vx, vy) is that of the contact point of the body, (vcx, vcy, vcz) that of the "
    "centre of mass. An engine whose origin is the centre of the sphere has "
    "v_centre of mass = v_origin - omega x (alpha R k).",
    "Quaternions turn the body's frame into the inertial frame. Columns may have any order; only "
    "names count: rename x, y, z, w of a scalar-last engine to qx, qy, qz, qw.",
    "Angular velocity (wx, wy, wz) is in the inertial frame. Rotate angular velocity in the body's "
    "frame (MuJoCo) by the quaternion first.",
    "Engines: `check --from mujoco` reads qpos and qvel as MuJoCo writes them, from .npz (arrays "
    "t, qpos, qvel) or .csv (t, qpos0 ... qpos6, qvel0 ... qvel5). With dart, drake, exudyn, ode "
    "(scalar first), bullet, cannon-es, jolt, newton or rapier (scalar last) it reads t, "
    "quaternion, velocity and angular_velocity (quaternion0 ... in .csv). The suffix :cm or "
    ":centre says whether the body's origin is the centre of mass or the centre of the sphere.",
    "Euler angles: orientation is Rz(phi) Ry(theta) Rz(psi), omega_3 = psi_dot + phi_dot cos "
    "theta; nu_x is the contact velocity towards the tilt of the axis, nu_y across it "
    "(z x tilt). They are undefined where the axis is vertical.",
    "height, rise and z count only where the top may leave the table: in flight and on an elastic "
    "table.",
    "Units: SI, angles in rad, time in s and strictly increasing.",
    f"Digits: {RULE}",
)


@click.command("columns")
@JSON
def command(as_json: bool) -> int:
    """List the columns that `check` reads and `run` writes, and all quantities along a motion.

    Each line has name, unit, frame and meaning. `run --columns`, `events --columns` and `frame`
    take the quantities too; `extremum:NAME` and `zero:NAME` are their events.
    """
    sets, table = column_sets(), quantities()
    lines = ["A trajectory has one of these sets of columns; others are ignored."]
    for name, columns in sets.items():
        lines += ["", name]
        lines += [f"  {key:<10} {row['unit']:<9} {meaning(row)}" for key, row in columns.items()]
    lines += ["", "quantities of `run --columns`, `events --columns` and `frame`"]
    lines += [f"  {key:<20} {row['unit']:<9} {row['meaning']}" for key, row in table.items()]
    lines += ["", *(f"- {sentence}" for sentence in CONVENTIONS)]
    content = {"schema": SCHEMA, "sets": sets, "quantities": table, "conventions": CONVENTIONS}
    emit(as_json, content, lines)
    return 0


def column_sets() -> dict[str, dict[str, dict[str, Json]]]:
    """Return the columns of each set, in order: unit, meaning and whether each is required."""
    from tt_precise.check.columns import COLUMN_SETS
    from tt_precise.mechanics.quantities import described

    return {
        name: {
            column: {
                **described(column)._asdict(), "required": column in ("t", *columns.required),
            }
            for column in ("t", *columns.names, *columns.height)
        }
        for name, columns in COLUMN_SETS.items()
    }  # fmt: skip


def quantities() -> dict[str, dict[str, Json]]:
    """Return the unit and the meaning of each quantity along a motion."""
    from tt_precise.mechanics.quantities import QUANTITIES

    return {
        name: {
            "unit": quantity.unit,
            "meaning": quantity.meaning + ("" if quantity.pole else " Undefined at the poles."),
        }
        for name, quantity in QUANTITIES.items()
    }


def meaning(column: dict[str, Json]) -> str:
    """Return the meaning of a column of ``column_sets``."""
    note = "" if column["required"] else " (if known)"
    return str(column["meaning"]).rstrip(".") + note
