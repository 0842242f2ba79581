"""Quantities and events of the mechanics as functions of an enclosed state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import arb

from tt_precise.certify.balls import Balls
from tt_precise.certify.interval_newton import Function
from tt_precise.certify.problem import body_of, problem_of, units_of
from tt_precise.integrate.quadratures import QUADRATURE_SCALE
from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene import Scene


def observed(scene: Scene, evaluate: Callable[[Motion], Any]) -> Function:
    """``evaluate`` of the scene's ``Motion``, dimensionless, as a function of the state's entries.

    The entries may be balls, bands or slopes of bands.
    """
    form, parameters = formulation(scene.model, "newton"), problem_of(scene).parameters

    def function(state: Sequence[Any]) -> Any:
        vectors = form.State(*state[: len(form.columns)])
        return evaluate(form.motion(body_of(scene, parameters()), vectors, Balls))

    return function


def columns_in_si(scene: Scene, state: Sequence[arb]) -> dict[str, arb | None]:
    """Vector and Euler columns and recorded quadratures of one enclosed state, in SI.

    None where a value is undefined, or not bounded (Euler angles at a pole).
    """
    size = len(formulation(scene.model, "newton").columns)
    vectors = NewtonState(*state[:size], *(0,) * (8 - size))
    body = body_of(scene, problem_of(scene).parameters())
    euler = euler_from_vectors(body, vectors, Balls)
    names = [*NewtonState._fields, *EulerState._fields, *scene.record]
    recorded = [value * QUADRATURE_SCALE for value in state[size:]]
    units = units_of(scene)
    found: dict[str, arb | None] = {}
    for name, value in zip(names, [*vectors, *euler, *recorded], strict=True):
        number = arb(value) * units.of_dimension(STATE_DIMENSIONS[name])
        found[name] = number if number.is_finite() else None
    return found
