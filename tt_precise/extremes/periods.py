"""Scenes whose inclination swings for ever: frictionless and rolling, and their exact period.

From rest at theta(0) both are motions in a potential, theta_dot^2 M(theta)/2 + V(theta) = E, with
a period that is an integral and owes nothing to an integrator of differential equations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from tt_precise.integration.precision import precision_named
from tt_precise.mechanics import quantities
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.scene import load_scene

STEP = "1e-3"  # rad; the potentials of the scenes have one valley, far wider


@dataclass(frozen=True)
class ThetaSwing:
    """One swing of theta and back, in SI: its ``period``, and theta_ddot at its turning point."""

    period: Fraction
    acceleration: float


@cache
def swing(scene: str) -> ThetaSwing:
    """The swing of a shipped scene that starts with theta_dot = 0, to 30 digits."""
    working = precision_named("mp", 140)
    fn, start = working.context, InitialState.of(load_scene(scene), working.arithmetic)
    mass, potential = (_rolling if scene == "rolling" else _frictionless)(fn, start)
    low = start.euler.theta
    energy = potential(low)

    def rate(theta: Scalar) -> Scalar:
        return fn.sqrt(2 * (energy - potential(theta)) / mass(theta))

    force = -fn.diff(potential, low)
    step = fn.mpf(STEP) * fn.sign(force)
    high = low + step
    while potential(high) < energy:
        high += step
    # the nearer end of the bracket is not the start, which is a root too
    nearer = high - step if high - step != low else low + step / 1000
    high = fn.findroot(lambda x: energy - potential(x), (nearer, high), solver="anderson")
    middle, half = (low + high) / 2, (high - low) / 2

    def moment(s: Scalar) -> Scalar:
        # theta = middle - half cos s takes the square root out of the ends
        return abs(half) * fn.sin(s) / rate(middle - half * fn.cos(s))

    period = (
        2 * fn.quad(moment, fn.linspace(0, fn.pi, 9), method="gauss-legendre") * start.units.time
    )
    numerator, denominator = int(fn.nint(period * fn.mpf(10) ** 35)), 10**35
    return ThetaSwing(
        Fraction(numerator, denominator), float(force / mass(low) / start.units.time**2)
    )


Function = Callable[[Scalar], Scalar]


def _frictionless(fn: Functions, start: InitialState) -> tuple[Function, Function]:
    """L.z and omega_3 are constant, and the centre of mass only rises and sinks; eq (1)."""
    body, spin = start.body, start.body.I3 * start.euler.omega_3
    vertical = start.vectors.Lz

    def mass(theta: Scalar) -> Scalar:
        return body.I1 + body.alpha**2 * fn.sin(theta) ** 2

    def potential(theta: Scalar) -> Scalar:
        s, c = fn.sin(theta), fn.cos(theta)
        return (vertical - spin * c) ** 2 / (2 * body.I1 * s * s) - body.alpha * c

    return mass, potential


def _rolling(fn: Functions, start: InitialState) -> tuple[Function, Function]:
    """The Main Equation E~ = g(cos theta) theta_dot^2 + V(cos theta, D, lambda); eq (17)."""
    motion = Motion(start.body, start.vectors, fn, "rolling")
    routh, jellett = quantities.D(motion), quantities.jellett(motion)

    def mass(theta: Scalar) -> Scalar:
        return 2 * quantities.effective_mass(start.body, fn.cos(theta))

    def potential(theta: Scalar) -> Scalar:
        return quantities.effective_potential(start.body, fn.cos(theta), routh, jellett, fn)

    return mass, potential
