"""The phases of motions whose equations change: their formulations, ends and steps."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

from tt_precise.integration.equations import Condition, Ends, Equations, Phase, rigid_ends
from tt_precise.integration.events import existing
from tt_precise.integration.precision import Precision
from tt_precise.integration.setup import Setup
from tt_precise.mechanics import compliant, flight, friction, rolling
from tt_precise.mechanics.compliant import DeepState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.friction import PolarState
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.rolling import RollingState
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.values import Adaptive, Scalar

# In units of sqrt(g R): Coulomb's law is integrated in polar form from this speed up to twice it.
SLOW_SPEED = 2.0**-4
# Speed at rest in units of eps sqrt(g R): v = 0 is less than an ulp of time away from there.
REST_SPEED = 2.0**-8
# In units of time: the first step of a flight. The height may vanish at the start, and a multiple
# root there hides other roots of its Taylor step from heyoka.
FIRST_STEP = 2.0**-20
# Bound on the relative error of the vertical acceleration in flight, in units of eps: it has some
# ten operations.
ACCELERATION_ROUNDINGS = 16


# Coulomb's law near v_A = 0, and while the top rolls because the force stays within the cone.
SLOW = Formulation("gliding", PolarState, friction.polar_rates, friction=COULOMB)
STICKING = Formulation("rolling", RollingState, rolling.rates, friction=COULOMB)
# A top in the air, with the height of its lowest point.
FLIGHT = Formulation("flight", LiftedState, flight.rates)
LINEAR = Formulation("linear", LiftedState, compliant.rates, spring="linear")
HUNT_CROSSLEY = Formulation(
    "hunt-crossley", DeepState, compliant.hunt_crossley_rates, spring="hunt-crossley"
)


def raised(spring: str = "") -> Formulation:
    """Flight with the height: above a table, or beyond the force of an elastic table."""
    return replace(FLIGHT, spring=spring)


def elastic(spring: str, law: Law) -> Formulation:
    """The formulation of contact with an elastic table, under that law of friction."""
    known = {form.spring: form for form in (LINEAR, HUNT_CROSSLEY)}
    return replace(known[spring], friction=law)


def elastic_in_time(spring: str, law: Law) -> Formulation:
    """The formulation of ``elastic`` in t, in which it may be non-smooth at height 0."""
    return replace(LINEAR, model=spring, spring=spring, friction=law)


def _fast_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """Loss of contact and a small speed."""
    functions, v = rigid_ends(equations, horizon, precision), equations.motion.state
    pole = {name: functions.pop(name) for name in ("pole",) if name in functions}
    return {**functions, "slow": v.vx * v.vx + v.vy * v.vy - SLOW_SPEED * SLOW_SPEED, **pole}


def _sticking_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """Loss of contact and slip, where the force reaches the cone."""
    q = equations.motion
    return {
        **rigid_ends(equations, horizon, precision),
        "slip": friction.cone_margin(q.body, q.state),
    }


def _slow_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """Loss of contact, rest to the last bit, a larger speed, the horizon."""
    state, context = SLOW.State(*equations.variables[: len(SLOW.columns)]), precision.context
    return {
        **rigid_ends(equations, horizon, precision),
        "stick": state.log_v - precision.number(context.log(REST_SPEED * precision.eps)),
        "fast": precision.number(context.log(2 * SLOW_SPEED)) - state.log_v,
        "complete": horizon - state.t,
    }


def _slow_tilt(body: Parameters, speed: Scalar, frequency: Scalar, decay: Scalar) -> Scalar:
    """A rate that is v times as large, at most at the highest v of slow gliding."""
    return 2 * SLOW_SPEED * frequency + body.mu * decay


def _flight_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """Landing; on an elastic table also below it, where its force begins to push."""
    q = equations.motion
    functions = {"landing": q.state.height}
    if equations.layout.form.spring:
        functions["sinking"] = compliant.pull(q.body, q.state.height, q.state.rise)
    return functions


def _landing(form: Formulation, end: str, eps: float, tolerance: float) -> Condition:
    """The callback that ignores zeros at which nothing lands.

    A landing at any speed ends a flight, unless the error of the acceleration since the start of
    the flight explains that speed: a top that takes off rises with the third power of time, so this
    error alone may bring the computed height back to 0 soon after.
    """
    if end == "sinking":
        return partial(_above, form)
    return partial(_rises, form, max(ACCELERATION_ROUNDINGS * eps, tolerance))


def _above(form: Formulation, adaptive: Adaptive, sign: int) -> bool:
    return bool(adaptive.state[form.columns.index("height")] >= 0)


def _rises(form: Formulation, error: float, adaptive: Adaptive, sign: int) -> bool:
    state = form.State(*(float(adaptive.state[i]) for i in range(len(form.columns))))
    body = form.body([float(adaptive.pars[i]) for i in range(len(form.parameters))])
    L = form.motion(body, state, math).state.L
    largest = 1 + body.alpha * dot(L, L) / body.I1**2  # acceleration in units of g
    return bool(state.rise >= -error * largest * float(adaptive.time))


def _contact_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """The normal force of an elastic table falls to zero."""
    return {"separation": equations.motion.force[2]}


def _deep_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """The depth, or the force at some depth, falls to zero; the horizon."""
    form, body = equations.layout.form, equations.motion.body
    state = form.State(*equations.variables[: len(form.columns)])
    return {
        "separation": state.zeta,
        "release": 1 - body.damping * state.rise,
        "complete": horizon - state.t,
    }


FAST_GLIDING = Phase(_fast_ends)
SLOW_GLIDING = Phase(_slow_ends, brief=True, has_clock=True, fastest=_slow_tilt)
STICKING_PHASE = Phase(_sticking_ends, brief=True)
FLIGHT_PHASE = Phase(_flight_ends, _landing, brief=True, first_step=FIRST_STEP)
LINEAR_CONTACT = Phase(_contact_ends, brief=True)
DEEP_CONTACT = Phase(_deep_ends, brief=True, has_clock=True, fastest=_slow_tilt)


def slow(setup: Setup) -> Setup:
    """Return the set-up of slow gliding under Coulomb's law."""
    return setup.but(formulation=SLOW, phase=SLOW_GLIDING)


def sticking(setup: Setup) -> Setup:
    """Return the set-up of rolling under Coulomb's law."""
    events = existing(setup.events, "rolling")
    return setup.but(formulation=STICKING, phase=STICKING_PHASE, events=events)


def in_flight(setup: Setup, spring: str = "") -> Setup:
    """Return the set-up of a flight: above a table, or beyond the force of an elastic table."""
    events = existing(setup.events, "flight")
    return setup.but(formulation=raised(spring), phase=FLIGHT_PHASE, events=events)
