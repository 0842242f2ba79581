"""The outcome of a trajectory: three different statements about turning over.

- ``theorem``: whether the condition of Theorem 1.1 holds, from the body and the start alone.
- ``equator``: whether the axis rose through theta = pi/2 while the motion was integrated; "never"
  if energy and lambda at the end exclude this passage for all times.
- ``end``: the steady spin that the motion approaches after its last state, stated only where energy
  and lambda prove it for every state within the estimated error of the last state (``well``); a
  motion whose energy is below the barrier before the inverted spin is "not inverted".

The statements may differ: a top beyond the equator may settle on an inclined axis, and a top that
inverts at 6 s has not passed the equator after 4 s.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Literal, NamedTuple

import flint
from flint import arb

from tt_precise.certify.balls import Balls, NotProved, ball
from tt_precise.certify.problem import BALLS
from tt_precise.certify.well import WELL_BITS, trapping_region
from tt_precise.exact.thresholds import Theorem, theorem
from tt_precise.integration import Trajectory
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, jellett
from tt_precise.mechanics.thresholds import BARRIERS, energy_excludes, least_energy
from tt_precise.runtime.values import Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState

# The estimate of the digits is a model, not a bound: the balls are ten times as wide.
WIDENING = 10


class Equator(NamedTuple):
    """The passage of the axis through theta = pi/2, and its time (s), None without a passage."""

    verdict: Literal["passed", "not_passed", "never"]
    t: Scalar


class End(NamedTuple):
    """The spin that the motion approaches, with the reason, or why that is not known."""

    verdict: Literal["inverted", "upright", "not_inverted", "undecided"]
    reason: str


class Outcome(NamedTuple):
    """The three statements about a trajectory."""

    theorem: Theorem
    equator: Equator
    end: End


def outcome_of(trajectory: Trajectory, equator: Scalar) -> Outcome:
    """Return the three statements; ``equator`` is the time of the first crossing (s) or None."""
    end, excluded = _confinement(trajectory)
    verdict: Literal["passed", "not_passed", "never"] = "passed"
    if equator is None:
        verdict = "never" if excluded else "not_passed"
    return Outcome(theorem(trajectory.scene), Equator(verdict, equator), end)


def _confinement(trajectory: Trajectory) -> tuple[End, bool]:
    """The statement of the energy about all times after the last state, and about the equator.

    The second value says that the axis stays on its side of the equator.
    """
    scene = trajectory.scene
    if trajectory.status != "complete":
        return End("undecided", f"the motion ended: {trajectory.status}"), False
    if scene.lifts:
        return End("undecided", "the top may leave the table, or sink into it"), False
    if scene.start.theta.at_pole:
        return End("undecided", "the axis is vertical from the start"), False
    with flint.ctx.workprec(max(WELL_BITS, trajectory.precision.bits + 20)):
        body = InitialState.of(scene, BALLS).body
        state = _last_state(trajectory)
        q = Motion(body, state, Balls, scene.model)
        lambda_, energy = jellett(q), QUANTITIES["E"].evaluate(q)
        z = state.kz
        never = bool(energy_excludes(body, energy, lambda_, z))
        try:
            pole = trapping_region(scene, scene.until, state).pole
            return End("inverted" if pole < 0 else "upright", "energy and lambda confine it"), never
        except NotProved as error:
            reason = f"energy and lambda do not confine it at the end: {error.reason}"
        if energy_excludes(body, energy, lambda_, z, to=-1):
            return End("not_inverted", _barrier(body, energy, lambda_, z)), never
        return End("undecided", reason), never


def _barrier(body: Parameters, energy: Scalar, lambda_: Scalar, z: Scalar) -> str:
    """The reason why the energy excludes the way from cos theta = ``z`` to the inverted spin."""
    if least_energy(body, arb(-1), lambda_) > energy:
        return "its energy is too low for the inverted spin"
    way = [z + (-1 - z) * i / BARRIERS for i in range(BARRIERS)]
    top = max(way, key=lambda cosine: float(least_energy(body, cosine, lambda_)))
    degrees = math.degrees(math.acos(float(top)))
    return f"its energy is too low for theta = {degrees:.0f} deg, before the inverted spin"


def _last_state(trajectory: Trajectory) -> NewtonState:
    """The last state, dimensionless, in balls as wide as its estimated error.

    The digits are relative to the size of the vector k, L or v; v counts as at least sqrt(g R).
    """
    segment = trajectory.run.segments[-1]
    motion = segment.columns.motion(segment.end_row)
    numbers = [as_fraction(value) for value in NewtonState(*motion.state[:8])]
    share = WIDENING * Fraction(10) ** -int(trajectory.digits)
    components = []
    for first, last in ((0, 3), (3, 6), (6, 8)):
        size = max(Fraction(1), *map(abs, numbers[first:last]))
        components += [ball(x) + arb(0, ball(share * size)) for x in numbers[first:last]]
    return NewtonState(*components)
