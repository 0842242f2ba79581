"""Quantities and events of the mechanics as functions of an enclosed state."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import flint
from flint import arb

from tt_precise.certify.balls import Balls
from tt_precise.certify.interval_newton import Function
from tt_precise.certify.problem import body_of, form_of, problem_of, units_of
from tt_precise.integration.equations import QUADRATURE_SCALE
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene


class Observer:
    """A scene's dimensionless ``Motion`` at entries of its state: balls, bands or slopes of bands.

    Functions of one observer share what they compute of the state that they saw last.
    """

    def __init__(self, scene: Scene):
        self.form, self._parameters = form_of(scene), problem_of(scene).parameters
        self._scene = scene
        self._last: tuple[Sequence[Scalar], int, Motion] | None = None

    def motion(self, state: Sequence[Scalar]) -> Motion:
        """The motion; a state is not to be changed after it was seen."""
        precision = flint.ctx.prec
        if self._last is None or self._last[0] is not state or self._last[1] != precision:
            body = body_of(self._scene, self._parameters())
            vectors = self.form.State(*state[: len(self.form.columns)])
            self._last = state, precision, self.form.motion(body, vectors, Balls)
        return self._last[2]

    def of(self, evaluate: Callable[[Motion], Scalar]) -> Function:
        """``evaluate`` as a function of the state's entries."""
        return lambda state: evaluate(self.motion(state))


def observed(scene: Scene, evaluate: Callable[[Motion], Scalar]) -> Function:
    """``evaluate`` of the scene's ``Motion`` as a function of the state's entries."""
    return Observer(scene).of(evaluate)


def columns_in_si(scene: Scene, state: Sequence[arb]) -> dict[str, arb | None]:
    """Vector and Euler columns and recorded quadratures of one enclosed state, in SI.

    None where a value is undefined, or not bounded (Euler angles at a pole).
    """
    motion = Observer(scene).motion(state)
    names = [*NewtonState._fields, *EulerState._fields, *scene.record]
    recorded = [value * QUADRATURE_SCALE for value in state[len(form_of(scene).columns) :]]
    units = units_of(scene)
    found: dict[str, arb | None] = {}
    for name, value in zip(names, [*motion.state, *motion.euler, *recorded], strict=True):
        number = arb(value) * units.of_dimension(STATE_DIMENSIONS[name])
        found[name] = number if number.is_finite() else None
    return found
