"""Quantities and events of the mechanics as functions of an enclosed state."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import arb

from tt_precise.arithmetic import Scalar
from tt_precise.certify.balls import Balls
from tt_precise.certify.interval_newton import Function
from tt_precise.certify.problem import body_of, form_of, problem_of, units_of
from tt_precise.integrate.quadratures import QUADRATURE_SCALE
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene import Scene


def observed(scene: Scene, evaluate: Callable[[Motion], Scalar]) -> Function:
    """``evaluate`` of the scene's ``Motion``, dimensionless, as a function of the state's entries.

    The entries may be balls, bands or slopes of bands.
    """

    def function(state: Sequence[Scalar]) -> Scalar:
        return evaluate(_motion(scene, state))

    return function


def columns_in_si(scene: Scene, state: Sequence[arb]) -> dict[str, arb | None]:
    """Vector and Euler columns and recorded quadratures of one enclosed state, in SI.

    None where a value is undefined, or not bounded (Euler angles at a pole).
    """
    motion = _motion(scene, state)
    names = [*NewtonState._fields, *EulerState._fields, *scene.record]
    recorded = [value * QUADRATURE_SCALE for value in state[len(form_of(scene).columns) :]]
    units = units_of(scene)
    found: dict[str, arb | None] = {}
    for name, value in zip(names, [*motion.state, *motion.euler, *recorded], strict=True):
        number = arb(value) * units.of_dimension(STATE_DIMENSIONS[name])
        found[name] = number if number.is_finite() else None
    return found


def _motion(scene: Scene, state: Sequence[Scalar]) -> Motion:
    form = form_of(scene)
    body = body_of(scene, problem_of(scene).parameters())
    return form.motion(body, form.State(*state[: len(form.columns)]), Balls)
