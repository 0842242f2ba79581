"""The job: what an engine is asked to simulate, as one JSON object in SI."""

from __future__ import annotations

import json
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy

from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import multiplied
from tt_precise.runtime.arithmetic import Arithmetic
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene

SCHEMA = "tt_precise.engine-job/1"
SCHEMA_FILE = Path(__file__).with_name("job.schema.json")
DOUBLE = Arithmetic(numpy, float)
# about the axis: without it a quaternion read in the wrong order would be one of the same axis
TURNED = (0.8, 0.0, 0.0, 0.6)


@dataclass(frozen=True)
class Friction:
    """The friction that an engine is asked for; ``law`` "none" has no coefficient."""

    law: str
    mu: float = 0.0
    epsilon: float | None = None

    @classmethod
    def of(cls, scene: Scene) -> Friction:
        """The scene's own."""
        if scene.model == "gliding" and scene.body.mu == 0:
            return cls("none")
        epsilon = scene.body.numbers_by_name.get("epsilon")
        return cls(
            scene.body.law, float(scene.body.mu), None if epsilon is None else float(epsilon)
        )

    def as_dict(self) -> dict[str, Json]:
        """As it stands in the job."""
        known = {"law": self.law, "mu": self.mu}
        return known if self.epsilon is None else known | {"epsilon": self.epsilon}


def job(
    scene: Scene, step: Fraction, friction: Friction, *, contact: str = "rigid"
) -> dict[str, Json]:
    """The job to simulate ``scene`` with the fixed ``step`` (s) under ``friction``.

    ``contact`` is "rigid" (a horizontal table at z = 0) or "none" (free flight). The sample times
    are the scene's, the start is its start with the axis at azimuth 0 and psi = 0.
    """
    start = InitialState.in_si(scene, DOUBLE)
    q: Motion = start.motion(numpy)
    body, half = start.body, start.euler.theta / 2
    tilted = (float(numpy.cos(half)), 0.0, float(numpy.sin(half)), 0.0)
    w, x, y, z = multiplied(tilted, TURNED)
    return {
        "schema": SCHEMA,
        "body": {
            "mass": float(body.m),
            "radius": float(body.R),
            "centre_offset": float(body.alpha * body.R),
            "I1": float(body.I1),
            "I3": float(body.I3),
        },
        "gravity": float(body.g),
        "contact": contact,
        "friction": friction.as_dict(),
        "start": {
            "position": [0.0, 0.0, float(body.R * (1 - body.alpha * q.k[2]))],
            "quaternion_wxyz": [w, x, y, z],
            "quaternion_xyzw": [x, y, z, w],
            "velocity": [float(x) for x in q.s_dot],
            "angular_velocity": [float(x) for x in q.omega],
        },
        "step": float(step),
        "sample_times": [float(t) for t in scene.sample_times],
    }


def as_text(content: dict[str, Json]) -> str:
    """The job as one line of JSON."""
    return json.dumps(content) + "\n"
