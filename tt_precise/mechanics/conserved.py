"""The conserved quantities of each model, one entry each, with the scale of its drift.

Values are functions of a ``Motion``. The drift of an integral is its change since the start divided
by its scale at the start, so a horizontal momentum that starts at zero also has a drift.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from tt_precise.mechanics import quantities
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Vector, dot, scaled
from tt_precise.runtime.values import Scalar


@dataclass(frozen=True)
class Integral:
    """A conserved value: name, function, scale, models and bodies, and source.

    ``azimuth`` marks integrals that need the direction of the axis; an Euler state leaves it open.
    ``quantities`` are the quantities with this value, up to a constant factor.
    """

    name: str
    evaluate: Callable[[Motion], Scalar]
    scale: Callable[[Motion], Scalar]
    holds: Callable[[str, Parameters], bool]
    meaning: str
    azimuth: bool = False
    quantities: tuple[str, ...] = ()


def _in(model_of_scene: str) -> Callable[[str, Parameters], bool]:
    return lambda model, body: model == model_of_scene


def _frictionless(model: str, body: Parameters) -> bool:
    return model == "flight" or (model == "gliding" and body.mu == 0)


def _angular_momentum(q: Motion) -> Scalar:
    return q.fn.sqrt(dot(q.state.L, q.state.L))


def _momentum(q: Motion) -> Scalar:
    return q.body.m * q.body.R * q.fn.sqrt(dot(q.omega, q.omega))


def _energy_holds(model: str, body: Parameters) -> bool:
    rigid = not body.spring  # an elastic table stores and damps
    return rigid and (_frictionless(model, body) or model == "rolling")


_ALL = (
    Integral("jellett", quantities.jellett,
             lambda q: abs(quantities.jellett(q)) or q.body.R * _angular_momentum(q),
             lambda *_: True, "lambda = -L.a; after eq (1)", quantities=("lambda",)),
    Integral("axis_norm", lambda q: dot(q.k, q.k), lambda q: 1, lambda *_: True, "k.k = 1"),
    Integral("energy", quantities.E, lambda q: abs(quantities.E(q)), _energy_holds,
             "E, where no contact force does work", quantities=("E",)),
    Integral("spin", lambda q: dot(q.state.L, q.k), _angular_momentum, _frictionless,
             "L.k = I3 omega_3; eq (4) with mu = 0", quantities=("omega_3",)),
    Integral("vertical_angular_momentum", quantities.L_z, _angular_momentum, _frictionless,
             "L.z; eq (1) with mu = 0", quantities=("L_z",)),
    Integral("momentum_x", lambda q: q.body.m * q.s_dot[0], _momentum, _frictionless,
             "m s_dot.X; eq (1) with mu = 0", azimuth=True, quantities=("s_dot_x",)),
    Integral("momentum_y", lambda q: q.body.m * q.s_dot[1], _momentum, _frictionless,
             "m s_dot.Y; eq (1) with mu = 0", azimuth=True, quantities=("s_dot_y",)),
    Integral("angular_momentum_x", lambda q: q.state.Lx, _angular_momentum, _in("flight"),
             "L.X; no torque in flight", azimuth=True),
    Integral("angular_momentum_y", lambda q: q.state.Ly, _angular_momentum, _in("flight"),
             "L.Y; no torque in flight", azimuth=True),
    Integral("rotational_energy", quantities.E_rot, lambda q: abs(quantities.E_rot(q)),
             _in("flight"), "omega.L/2; no torque in flight", quantities=("E_rot",)),
    Integral("routh", quantities.D, _angular_momentum, _in("rolling"), "D; eq (9), rolling",
             quantities=("D",)),
    Integral("modified_energy", quantities.E_tilde, lambda q: abs(quantities.E_tilde(q)),
             _in("rolling"), "E~; eq (8), rolling", quantities=("E_tilde", "E_tilde_main")),
)  # fmt: skip
# The names of the integrals by those of their quantities, as the paper calls them.
OF_QUANTITY = {name: integral.name for integral in _ALL for name in integral.quantities}
OF_FLIGHT = ("angular_momentum_x", "angular_momentum_y", "rotational_energy")
INTEGRALS = {integral.name: integral for integral in _ALL}


def conserved(model: str, body: Parameters) -> tuple[Integral, ...]:
    """The integrals of a correct motion of ``body`` under ``model``."""
    return tuple(integral for integral in INTEGRALS.values() if integral.holds(model, body))


def drift(integral: Integral, motions: list[Motion]) -> list[Scalar]:
    """Relative change of the integral at each motion since the first one."""
    first = integral.evaluate(motions[0])
    scale = integral.scale(motions[0]) or 1
    return [abs(integral.evaluate(q) - first) / scale for q in motions]


def contact_force(q: Motion, acceleration: Vector) -> Vector:
    """F = m (dv_CM/dt + g z): the contact force for this acceleration."""
    x, y, z = scaled(q.body.m, acceleration)
    return (x, y, z + q.body.m * q.body.g)
