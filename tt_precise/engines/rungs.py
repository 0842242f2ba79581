"""The rungs of the ladder: what each isolates, its scene, and the reference for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy

from tt_precise.engines.job import DOUBLE, Friction, job
from tt_precise.integration import integrate
from tt_precise.mechanics import flight
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import turned
from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene, load_scene

UNTIL, INVERSION_UNTIL = "0.5", "4"
STEPS = (Fraction(1, 1000), Fraction(1, 2000), Fraction(1, 4000))  # s


@dataclass(frozen=True)
class States:
    """A motion at the sample times: axis, angular velocity, velocity of CM, each (rows, 3); SI."""

    k: Array
    omega: Array
    s_dot: Array

    def distance(self, other: States, spin: float, radius: float) -> Array:
        """Largest of |dk|, |d omega|/spin, |d s_dot|/(radius spin), row by row."""
        return numpy.max(
            [
                numpy.linalg.norm(self.k - other.k, axis=1),
                numpy.linalg.norm(self.omega - other.omega, axis=1) / spin,
                numpy.linalg.norm(self.s_dot - other.s_dot, axis=1) / (radius * spin),
            ],
            axis=0,
        )


@dataclass(frozen=True)
class Rung:
    """One test: a scene, the friction asked for, and where its reference comes from.

    ``friction`` is None where the scene's own is asked for. ``conserved`` names what an exact
    motion keeps: entries of ``ladder.DRIFTS``. ``reference`` is None where no law has a motion
    that all engines could be held against.
    """

    name: str
    meaning: str
    scene: Scene
    conserved: tuple[str, ...]
    reference: Callable[[Scene], States] | None
    friction: Friction | None = None
    contact: str = "rigid"

    @property
    def asked(self) -> Friction:
        """The friction in the job."""
        return self.friction or Friction.of(self.scene)

    def job(self, step: Fraction) -> dict[str, Json]:
        """The job for one step size."""
        return job(self.scene, step, self.asked, contact=self.contact)

    @cached_property
    def start(self) -> Motion:
        """The start, SI, double."""
        return InitialState.in_si(self.scene, DOUBLE).motion(numpy)

    @property
    def spin(self) -> float:
        """|omega| at the start in rad/s: the unit of differences."""
        return float(numpy.linalg.norm(numpy.array(self.start.omega, dtype=float)))

    @cached_property
    def truth(self) -> States | None:
        """The reference at the sample times."""
        return self.reference(self.scene) if self.reference else None


def flown(scene: Scene) -> States:
    """Free flight from the scene's start, in closed form."""
    content = job(scene, STEPS[0], Friction("none"), contact="none")
    start, body = content["start"], InitialState.in_si(scene, DOUBLE).body
    begun = RigidBodyState(
        *start["quaternion_wxyz"], *start["angular_velocity"], *start["velocity"]
    )
    rows = [flight.flown(body, begun, t, numpy) for t in content["sample_times"]]
    table = numpy.array(rows, dtype=float)
    axes = [turned(row[:4], (0, 0, 1)) for row in rows]
    return States(numpy.array(axes, dtype=float), table[:, 4:7], table[:, 7:10])


def integrated(scene: Scene) -> States:
    """The scene's solution, integrated in double to its full accuracy.

    Raises
    ------
    ArithmeticError
        The solution ends before the scene's horizon.
    """
    trajectory = integrate(scene, events=(), record=())
    if trajectory.status != "complete":
        raise ArithmeticError(f"{scene.name}: the reference ended as {trajectory.status}")
    frame = trajectory.frame(*NewtonState._fields, numbers="float")
    body = InitialState.in_si(scene, DOUBLE).body
    columns = [frame[name].to_numpy() for name in NewtonState._fields]
    q = Motion(body, NewtonState(*columns), numpy, scene.model)
    return States(*(_rows(vector) for vector in (q.k, q.omega, q.s_dot)))


def standing(scene: Scene) -> States:
    """A steady spin about the vertical: the start for ever."""
    q, rows = InitialState.in_si(scene, DOUBLE).motion(numpy), len(scene.sample_times)
    return States(
        *(numpy.tile([float(x) for x in vector], (rows, 1)) for vector in (q.k, q.omega, q.s_dot))
    )


def _rows(vector: Array) -> Array:
    return numpy.stack(numpy.broadcast_arrays(*vector), axis=1).astype(float)


def rungs(law: str = "coulomb") -> tuple[Rung, ...]:
    """The ladder for an engine whose own friction is ``law``."""
    short: dict[str, Any] = {"until": UNTIL, "record": (), "events": ()}
    gliding = load_scene("coulomb-gliding" if law == "coulomb" else GLIDING[law]).varied(**short)
    coulomb = load_scene("coulomb-gliding").varied(**short)
    tilted = {"theta": "0.3", **short}
    return (
        Rung(
            "flight", "inertia, gyroscopic term, frames: no contact, closed form",
            load_scene("frictionless").varied(theta="0.5", theta_dot="40", **short),
            ("angular_momentum", "rotational_energy"), flown, contact="none",
        ),
        Rung(
            "sleeping upright", "a spin about the vertical that contact and friction leave alone",
            load_scene("upright").varied(**short), ("jellett", "energy"), standing,
            Friction("coulomb", 0.3),
        ),
        Rung(
            "sleeping inverted", "the same with the centre of mass above the centre",
            load_scene("inverted").varied(**short), ("jellett", "energy"), standing,
            Friction("coulomb", 0.3),
        ),
        Rung(
            "ice", "the normal force alone: mu = 0",
            load_scene("frictionless").varied(**tilted), ("jellett", "energy"), integrated,
        ),
        Rung(
            "gliding", "the engine's own friction while the contact glides", gliding,
            ("jellett",), integrated,
        ),
        Rung(
            "rolling", "a contact that sticks: mu = 1, more than rolling needs",
            load_scene("rolling").varied(**tilted), ("jellett", "energy"), integrated,
            Friction("coulomb", 1.0),
        ),
        Rung(
            "inversion", "the whole motion: does the top turn over, and when",
            coulomb.varied(
                theta="0.1", nu_y="0.27", omega_3="180", mu="0.1", until=INVERSION_UNTIL,
                m="0.006", R="0.015", alpha="1/5", I1="16/27", I3="14/27", g="9.81",
            ),
            ("jellett",), None,
        ),
    )  # fmt: skip


GLIDING = {"viscous": "reference", "regularised": "regularised-1e-2"}
