"""How motions begin and end within a run: fast and slow gliding, sticking, flight, contact."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from tt_precise.integration.equations import Condition, Ends, Equations, Phase, terminal_functions
from tt_precise.integration.events import existing
from tt_precise.integration.precision import Precision
from tt_precise.integration.setup import Setup
from tt_precise.mechanics import compliant, friction
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import dot
from tt_precise.nonsmooth.formulations import SLOW, STICKING, raised
from tt_precise.runtime.values import Adaptive, Scalar
from tt_precise.scene.initial_state import InitialState

# In units of sqrt(g R): Coulomb's law is integrated in polar form from this speed up to twice it.
SLOW_SPEED = 2.0**-4
REST_SPEED = 2.0**-8  # of eps; v = 0 is less than an ulp of time away from there
LONGEST_REGULARISED_TIME = 2.0**40  # where the state ends the propagation
# In units of time: the first step of a flight. The height may vanish at the start, and a multiple
# root there hides other roots of its Taylor step from heyoka.
FIRST_STEP = 2.0**-20
# Bound on the relative error of the vertical acceleration in flight, in units of eps: it has some
# ten operations.
ACCELERATION_ROUNDINGS = 16


@dataclass(frozen=True)
class FastGliding(Phase):
    """Gliding under Coulomb's law, until the contact point is slow."""

    def ends(self, equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
        """Loss of contact and a small speed."""
        functions, q = super().ends(equations, horizon, precision), equations.motion
        pole = {name: functions.pop(name) for name in ("pole",) if name in functions}
        square = q.state.vx * q.state.vx + q.state.vy * q.state.vy
        return {**functions, "slow": square - SLOW_SPEED * SLOW_SPEED, **pole}


@dataclass(frozen=True)
class Sticking(Phase):
    """Rolling under Coulomb's law, until the force reaches the cone."""

    brief: ClassVar[bool] = True

    def ends(self, equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
        """Loss of contact and slip."""
        functions, q = super().ends(equations, horizon, precision), equations.motion
        return {**functions, "slip": friction.cone_margin(q.body, q.state)}


@dataclass(frozen=True)
class Flight(Phase):
    """Flight above a table, or beyond the force of an elastic table."""

    brief: ClassVar[bool] = True

    def ends(self, equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
        """Landing; on an elastic table also below it, where its force begins to push."""
        q = equations.motion
        functions = {"landing": q.state.height}
        if equations.layout.form.spring:
            functions["sinking"] = compliant.reach(q.body, q.state.height, q.state.rise)
        return functions

    def condition(self, form: Formulation, end: str, eps: float, tolerance: float) -> Condition:
        """Return the callback that ignores zeros at which nothing lands.

        A landing at any speed ends a flight, unless the error of the acceleration since the start
        of the flight explains that speed: a top that takes off rises with the third power of time,
        so this error alone may bring the computed height back to 0 soon after.
        """
        if end == "sinking":
            return partial(_above, form)
        return partial(_rises, form, max(ACCELERATION_ROUNDINGS * eps, tolerance))

    def goals(self, start: InitialState, until: Scalar, precision: Precision) -> list[Scalar]:
        """Begin with a short step: the height may vanish at the start and hide another zero."""
        first = precision.number(precision.context.mpf(FIRST_STEP))
        (last,) = super().goals(start, until, precision)
        return [first, last] if first < last else [last]


def _above(form: Formulation, adaptive: Adaptive, sign: int) -> bool:
    return bool(adaptive.state[form.columns.index("height")] >= 0)


def _rises(form: Formulation, error: float, adaptive: Adaptive, sign: int) -> bool:
    state = form.State(*(float(adaptive.state[i]) for i in range(len(form.columns))))
    body = form.body([float(adaptive.pars[i]) for i in range(len(form.parameters))])
    L = form.motion(body, state, math).state.L
    largest = 1 + body.alpha * dot(L, L) / body.I1**2  # acceleration in units of g
    return bool(state.rise >= -error * largest * float(adaptive.time))


@dataclass(frozen=True)
class Contact(Phase):
    """Contact with an elastic table whose force is linear, until it would pull."""

    brief: ClassVar[bool] = True

    def ends(self, equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
        """The normal force falls to zero."""
        return {"separation": equations.motion.force[2]}


@dataclass(frozen=True)
class InRegularisedTime(Phase):
    """A motion whose state contains the time, integrated along another variable."""

    brief: ClassVar[bool] = True
    has_clock: ClassVar[bool] = True

    def goals(self, start: InitialState, until: Scalar, precision: Precision) -> list[Scalar]:
        """Return a value that is never reached: the state ends the propagation."""
        longest = precision.number(precision.context.mpf(LONGEST_REGULARISED_TIME))
        return super().goals(start, longest if until is None else until, precision)

    def fastest(self, body: Parameters, speed: Scalar, frequency: Scalar, decay: Scalar) -> Scalar:
        """Return a rate that is v times as large, at most at the highest v of slow gliding."""
        return 2 * SLOW_SPEED * frequency + body.mu * decay


@dataclass(frozen=True)
class SlowGliding(InRegularisedTime):
    """Gliding under Coulomb's law in polar form, until it rests or is fast again."""

    def ends(self, equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
        """Loss of contact, rest to the last bit, a larger speed, the horizon."""
        state, context = SLOW.State(*equations.variables[: len(SLOW.columns)]), precision.context
        rest = precision.number(context.log(REST_SPEED * precision.eps))
        fast = precision.number(context.log(2 * SLOW_SPEED))
        return {
            **terminal_functions(SLOW, equations.motion, None),
            "stick": state.log_v - rest,
            "fast": fast - state.log_v,
            "complete": horizon - state.t,
        }


@dataclass(frozen=True)
class DeepContact(InRegularisedTime):
    """Contact with an elastic table whose force is Hunt and Crossley's."""

    def ends(self, equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
        """The depth, or the force at some depth, falls to zero; the horizon."""
        form, body = equations.layout.form, equations.motion.body
        state = form.State(*equations.variables[: len(form.columns)])
        return {
            "separation": state.zeta,
            "release": 1 - body.damping * state.rise,
            "complete": horizon - state.t,
        }


def slow(setup: Setup) -> Setup:
    """Return the set-up of slow gliding under Coulomb's law."""
    return setup.but(formulation=SLOW, phase=SlowGliding())


def sticking(setup: Setup) -> Setup:
    """Return the set-up of rolling under Coulomb's law."""
    events = existing(setup.events, "rolling")
    return setup.but(formulation=STICKING, phase=Sticking(), events=events)


def in_flight(setup: Setup, spring: str = "") -> Setup:
    """Return the set-up of a flight: above a table, or beyond the force of an elastic table."""
    events = existing(setup.events, "flight")
    return setup.but(formulation=raised(spring), phase=Flight(), events=events)
