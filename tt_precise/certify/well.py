"""A theorem about all later times: the energy confines the solution.

The energy falls as E' = -mu g_n v^2 (regularised friction has a positive, smooth function of v for
mu), and lambda = -L.a is constant. Given both lambda and the inclination, with
z = cos theta, the energy is least, U(z), for L = L* = -lambda I a/(a.I a) and a centre of mass at
rest (``mechanics.thresholds.least_energy``), and

    E = U(z) + (L - L*).I^-1 (L - L*)/2 + m s'^2/2.

Let z0 = 1 or -1, w and v1 numbers and Y the states with this lambda, z between z1 and z0, E <= w
and |v| <= v1 (or any v, where that is not needed). Verified in balls, for z in slices from z0 to
z1:

- **W1** No tumbling motion (steady, without gliding, axis inclined) has this lambda
  (``mechanics.thresholds.tumbling_lambda_squared``: these are the stationary points of U).
- **W2** On Y the contact force is at least ``force`` > 0, and L.k is not zero.
- **W3** U(z1) > w.
- **W4** At some time t0 the solution is proved to have z between z1 and z0, E <= w and |v| < v1.
- **W5** v.v' < 0 on Y where |v| = v1: with strong friction all but slow gliding dies out.

**Theorem.** Under W1 to W5 the solution stays in Y and exists for all t >= t0, loses contact
nowhere, and tends to the vertical spin at z0: theta -> 0 or pi, v -> 0, L -> Lz z, and D, E
and E~ tend to their values there. A rate is not proved.

*Proof.* In Y E does not grow, so the solution reaches neither z1, where E >= U(z1) > w, nor |v| =
v1, and stays in the bounded set Y: it exists for ever, and by LaSalle's principle tends to the
largest invariant set in Y on which E' = 0, that is v = 0. Solutions in that set: F = g_n z, so
L' = alpha R g_n k x z, and Lz, L.k and with s'' also the horizontal velocity c of the centre of
mass are constant. In the direction e1 that the axis leans in, and e2 = z x e1, which turn with
phi_dot, v = 0 says c.e1 = R (1 - alpha cos theta) theta_dot and c.e2 = -B, with B = R sin theta
(omega_3 + (alpha - cos theta) phi_dot). As c is constant, (c.e2)' = -phi_dot c.e1, or
theta_dot (B'(theta) - phi_dot R (1 - alpha cos theta)) = 0, where phi_dot = (Lz - L.k cos theta)/
(I1 sin^2 theta). The bracket is omega_3 R (cos theta + (alpha - cos theta) I3/I1): zero in an
interval of theta only if omega_3 = 0, which W2 excludes. So theta is constant. Inclined, it needs
L' = phi_dot z x L, or phi_dot (L.k - I1 phi_dot cos theta) = -alpha m g R, hence phi_dot is not
zero; then (c.e1)' = phi_dot c.e2 = 0 makes c and B zero: a tumbling motion, which W1 excludes. So
it is vertical, at z0, with L parallel to k. ∎

``outcome_of`` says what the theorem proves about the end of a trajectory, whatever integrated it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from fractions import Fraction
from typing import Literal, NamedTuple

import flint
from flint import arb

from tt_precise.certify.balls import Balls, NotProved, ball, bounds, largest, outward, round_to
from tt_precise.certify.problem import BALLS
from tt_precise.exact.thresholds import Theorem, theorem
from tt_precise.integration import Trajectory
from tt_precise.mechanics import friction, newton
from tt_precise.mechanics.formulations import integration_form
from tt_precise.mechanics.newton import CentreState, NewtonState, contact_arm
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, jellett
from tt_precise.mechanics.thresholds import (
    BARRIERS,
    energy_excludes,
    least_energy,
    tumbling_lambda_squared,
)
from tt_precise.mechanics.vectors import added, dot, scaled
from tt_precise.runtime.values import Json, Scalar
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import InitialState, Scene

FORM = integration_form("gliding", "newton")
WELL_BITS = 128
SLICES, MOST_SLICES = 64, 1000  # from z0 to where the solution is, and to z1
# Width of a slice over that of the slice before, outside the solution's range.
WIDER = arb("1.04").mid()
SPEEDS = (None, 0.05, 0.1, 0.2, 0.4)  # Bounds v1 in units of sqrt(g R), tried in this order.
DIRECTIONS = 32  # Directions of v at which W5 is verified; each stands for an arc.
LIMITS = ("D", "E", "E_tilde", "omega_3")
# The estimate of the digits is a model, not a bound: the balls are ten times as wide.
WIDENING = 10


@dataclass(frozen=True)
class TrappingRegion:
    """A neighbourhood of the vertical spin that the solution never leaves again.

    ``pole`` is -1 (inverted) or 1 (upright), ``force`` a bound of g_n/(m g) from ``since`` (s) on,
    ``tilt`` a bound of sin theta; ``limits`` are the limits of D, E, E~ and omega_3, in SI.
    """

    pole: int
    since: Fraction
    force: arb
    tilt: arb
    limits: dict[str, arb]

    def as_dict(self) -> dict[str, Json]:
        return {
            "theta_tends_to": "pi" if self.pole < 0 else "0",
            "since_s": f"{Decimal(self.since.numerator) / self.since.denominator:f}",
            "g_n_at_least_mg": round_to(bounds(self.force)[0], ROUND_FLOOR, 4),
            "sin_theta_at_most": round_to(bounds(self.tilt)[1], ROUND_CEILING, 4),
            "limits": {name: outward(ball, 30) for name, ball in self.limits.items()},
        }


def forever(
    scene: Scene, times: Sequence[Fraction], state: Callable[[Fraction], NewtonState]
) -> dict[str, TrappingRegion]:
    """Trapping regions of the solution, from the earliest and from the last of these times on.

    ``state`` is its proved state at one of the times (s), dimensionless. The region ``held`` since
    the first time at which one is proved has the largest bounds, that ``at_the_end`` the smallest.

    Raises ``NotProved``: there is none even at the end.
    """
    with flint.ctx.workprec(WELL_BITS):
        last = first = trapping_region(scene, times[-1], state(times[-1]))
        # where there is one at one time, there is one at all later times, too
        low, high = -1, len(times) - 1
        while high - low > 1:
            middle = (low + high) // 2
            try:
                first, high = trapping_region(scene, times[middle], state(times[middle])), middle
            except NotProved:
                low = middle
        return {"held": first, "at_the_end": last}


def trapping_region(scene: Scene, time: Fraction, state: NewtonState) -> TrappingRegion:
    """Verify W1 to W5 with t0 = ``time`` (s) and the state at t0, for the nearer pole.

    Raises ``NotProved``: one of them could not be verified, with any of ``SPEEDS``.
    """
    well, why = _Well(scene, state), NotProved("W2", "nothing was tried")
    for speed in SPEEDS:
        try:
            force, tilt = well.bounds(None if speed is None else arb(speed))
        except NotProved as error:
            why = error
            if error.hypothesis not in ("W2", "W5"):
                break
        else:
            return TrappingRegion(well.pole, time, force, tilt, well.limits())
    raise why


class _Well:
    """The states that a motion may reach with an energy no higher than ``now``."""

    def __init__(self, scene: Scene, now: NewtonState):
        if scene.model != "gliding" or not scene.body.mu:
            raise NotProved("W3", "without friction nothing tends to a vertical spin")
        if scene.start.theta.at_pole:
            raise NotProved("W4", "the axis is vertical from the start, and nothing tends to it")
        if not scene.body.friction.smooth_at_rest:
            raise NotProved("W2", f"{scene.body.law} has no derivative where v = 0")
        start = InitialState.of(scene, BALLS)
        self.body, self.units, self.now = start.body, start.units, now
        self.lambda_ = arb(jellett(start.motion(Balls)))
        self.pole = 1 if now.kz > 0 else -1
        self.highest = arb(QUANTITIES["E"].evaluate(Motion(self.body, now, Balls))).upper()
        self.step = ((1 - self.pole * now.kz) / SLICES).upper().mid()

    def limits(self) -> dict[str, arb]:
        """Values of conserved and other quantities at the vertical spin, SI."""
        upright = NewtonState(0, 0, arb(self.pole), 0, 0, arb(1), 0, 0)
        # lambda is linear in Lz
        spin = self.lambda_ / jellett(Motion(self.body, upright, Balls))
        motion = Motion(self.body, upright._replace(Lz=spin), Balls)
        return {
            name: arb(QUANTITIES[name].evaluate(motion))
            * self.units.of_dimension(QUANTITIES[name].dimension)
            for name in LIMITS
        }

    def bounds(self, speed: arb | None) -> tuple[arb, arb]:
        """Bounds of the contact force and of sin theta in Y, with v1 = ``speed``.

        Raises ``NotProved``: one of W1 to W5 could not be verified.
        """
        body, pole, lambda_ = self.body, self.pole, self.lambda_
        if speed is not None and not dot(self.now.v, self.now.v) < speed * speed:
            raise NotProved("W5", "it glides faster")
        forces: list[arb] = []
        depth, step = arb(0), self.step
        for i in range(MOST_SLICES):
            beyond = (depth + step).upper().mid()
            if not beyond < 1:
                break
            z = pole * (1 - depth.union(beyond))
            depth, step = beyond, step if i < SLICES else step * WIDER
            surplus = self.highest - arb(least_energy(body, z, lambda_))
            if surplus < 0 and i > SLICES:
                return min(forces), (1 - z * z).sqrt().upper()
            if (tumbling_lambda_squared(body, z) - lambda_ * lambda_).contains(0):
                raise NotProved("W1", "a tumbling motion with this lambda is not excluded")
            forces.append(self._force(z, 2 * surplus.nonnegative_part().upper(), speed))
        raise NotProved("W3", "the energy is too high")

    def _force(self, z: arb, budget: arb, speed: arb | None) -> arb:
        """Verify W2 and W5 in one slice, where 2 (E - U(z)) <= ``budget``.

        The axis may lean towards X: all turns about the vertical are alike.
        """
        body = self.body
        k = ((1 - z * z).nonnegative_part().sqrt(), arb(0), z)
        a = contact_arm(body, k)
        turned = newton.angular_momentum(body, k, a)  # I a
        middle = scaled(-self.lambda_ / dot(a, turned), turned)
        spread = arb(0, (budget * largest([arb(body.I1), arb(body.I3)])).sqrt().upper())
        L = added(middle, (spread, spread, spread))
        if speed is None:
            any_speed = arb(0, budget.sqrt().upper())
            state = FORM.motion(body, CentreState(*k, *L, any_speed, any_speed), Balls).state
        else:
            state = NewtonState(*k, *L, arb(0, speed), arb(0, speed))
        force = arb(newton.normal_force(self._rubbed(state), state))
        if not force > 0 or dot(L, k).contains(0):
            raise NotProved("W2", "the contact force, or the spin, may vanish")
        for i in range(DIRECTIONS if speed is not None else 0):
            angle = (arb(i) / DIRECTIONS).union(arb(i + 1) / DIRECTIONS) * 2 * arb.pi()
            state = state._replace(vx=speed * angle.cos(), vy=speed * angle.sin())
            rate = newton.rates(self._rubbed(state), state)
            if not rate.vx * state.vx + rate.vy * state.vy < 0:
                raise NotProved("W5", "gliding may become faster")
        return force.lower()

    def _rubbed(self, state: NewtonState) -> Parameters:
        """The body with its friction at this velocity."""
        return friction.viscous_at(self.body, state.vx, state.vy, Balls)


class Equator(NamedTuple):
    """The passage of the axis through theta = pi/2, and its time (s), None without a passage."""

    verdict: Literal["passed", "not_passed", "never"]
    t: Scalar


class End(NamedTuple):
    """The spin that the motion approaches, with the reason, or why that is not known."""

    verdict: Literal["inverted", "upright", "not_inverted", "undecided"]
    reason: str


class Outcome(NamedTuple):
    """Three different statements about a trajectory that turns over, or does not.

    - ``theorem``: whether the condition of Theorem 1.1 holds, from the body and the start alone.
    - ``equator``: whether the axis rose through theta = pi/2 while the motion was integrated;
      "never" if energy and lambda at the end exclude this passage for all times.
    - ``end``: the steady spin that the motion approaches after its last state, stated only where
      energy and lambda prove it for every state within the estimated error of the last state; a
      motion whose energy is below the barrier before the inverted spin is "not inverted".

    The statements may differ: a top beyond the equator may settle on an inclined axis, and a top
    that inverts at 6 s has not passed the equator after 4 s.
    """

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
