"""The start of a scene in SI and in any number of digits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tt_precise.body import Parameters
from tt_precise.exact.arithmetic import rounding_to
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene import Scene


@dataclass(frozen=True)
class ExactStart:
    """Body and state at t = 0, rounded once into an mpmath context; azimuth 0, SI.

    ``vectors`` and ``euler`` are made from the scene separately: beside the inverted pole the
    former does not go through theta = pi - offset.
    """

    context: Any
    body: Parameters
    euler: EulerState
    vectors: NewtonState
    model: str

    @classmethod
    def of(cls, scene: Scene, context: Any) -> ExactStart:
        """The start of ``scene``."""
        convert, start = rounding_to(context), scene.start
        body = scene.body.numbers(convert)
        euler = EulerState(
            start.theta.radians(context, convert),
            **{name: convert(getattr(start, name)) for name in EulerState._fields[1:]},
        )
        sine_cosine = start.theta.sine_cosine(context, convert)
        vectors = vectors_from_euler(body, euler, context, sine_cosine=sine_cosine)
        return cls(context, body, euler, vectors, scene.model)

    @property
    def motion(self) -> Motion:
        """What quantities at the start are functions of."""
        return Motion(self.body, self.vectors, self.context, self.model)
