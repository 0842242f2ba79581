"""Proofs for friction laws other than the paper's: what holds for any force, and for each law.

The first two are about a force of three free symbols at the contact point of a sphere whose
contact may even move vertically: they cover every friction law and every compliant contact. The
others are exact evaluations at random rational points, where the roots of the laws are rational.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from fractions import Fraction
from math import isqrt

from tt_precise.exact.chart import ForceChart
from tt_precise.exact.proof import RATIONAL_POINTS, circle, identity, positive, signed
from tt_precise.mechanics import friction, newton, polar, quantities, rolling
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.polar import PolarState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot, subtracted
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.body import Parameters
from tt_precise.scene.laws import COULOMB, LAWS


@identity("lambda is constant under any contact force", "after (1)")
def _jellett(chart: ForceChart) -> Iterable[Scalar]:
    """d lambda/dt = 0 for every force F at the contact point: L_dot = a x F, k_dot = L x k/I1."""
    yield chart.along(quantities.jellett(_motion(chart)), _rates(chart))


@identity("E changes by the power of any contact force", "section 1")
def _energy(chart: ForceChart) -> Iterable[Scalar]:
    """dE/dt = v_A.F for every force F at the contact point, from m s_ddot = F - m g z."""
    q = _motion(chart)
    s_dot = subtracted(chart.v, newton.swing(chart.body, chart.state))
    # m s_dot.s_ddot + m g z.s_dot = s_dot.F
    rate = dot(s_dot, chart.force) + chart.along(quantities.E_rot(q), _rates(chart))
    yield rate - dot(chart.v, chart.force)


@identity("dry friction: size, direction and loss", "section 1", RATIONAL_POINTS)
def _dry_laws(draws: random.Random) -> Iterable[Scalar]:
    """F_f opposes v_A; |F_f| sqrt(v^2 + epsilon^2) = mu g_n v; dE/dt = -|F_f| v."""
    for body, state, speed in _gliding(draws):
        q = Motion(body, state, Roots)
        epsilon = body.numbers_by_name.get("epsilon", Fraction(0))
        g_n = q.force[2]
        size = -(q.force[0] * state.vx + q.force[1] * state.vy) / speed
        yield q.force[0] * state.vy - q.force[1] * state.vx
        yield size * Roots.sqrt(speed**2 + epsilon**2) - body.mu * g_n * speed
        yield quantities.E_dot(q) + size * speed


@identity("Coulomb's law in polar form", "(1)", RATIONAL_POINTS)
def _polar(draws: random.Random) -> Iterable[Scalar]:
    """The rates along tau are v times those along t, with v_A = v e; |e| does not change."""
    _, (body, state, speed) = _gliding(draws)
    e = (state.vx / speed, state.vy / speed)
    plain = newton.rates(friction.viscous_at(body, state.vx, state.vy, Roots), state)
    found = polar.rates(body, PolarState(*state[:6], speed, *e, Fraction(0)), Exponential)
    yield from (one - speed * other for one, other in zip(found[:6], plain[:6], strict=True))
    for part, turning, rate in zip(e, found[7:9], plain[6:], strict=True):
        # v' = v (ln v)'
        yield speed * found.log_v * part + speed * turning - speed * rate
    yield found.ex * e[0] + found.ey * e[1]
    yield found.t - speed


@identity("rolling meets gliding at the cone", "(1), v_A = 0", RATIONAL_POINTS)
def _cone(draws: random.Random) -> Iterable[Scalar]:
    """With e = -F_f/(mu F_z) of rolling Coulomb's law has v_A_dot = 0; |e| = 1 on the cone."""
    _, (body, state, _) = _gliding(draws)
    force = rolling.constraint_force(body, state)
    largest = body.mu * force[2]
    e = (-force[0] / largest, -force[1] / largest)
    rates = polar.along_direction(body, NewtonState(*state[:6], *e))
    yield from (rates.vx, rates.vy)
    yield friction.cone_margin(body, state) - largest**2 * (1 - e[0] ** 2 - e[1] ** 2)


class Roots:
    """The arithmetic of fractions, with the square roots that are fractions."""

    @staticmethod
    def sqrt(value: Fraction) -> Fraction:
        """The root of the square of a fraction."""
        root = Fraction(isqrt(value.numerator), isqrt(value.denominator))
        if root * root != value:
            raise ValueError(f"{value} is not the square of a fraction")
        return root


class Exponential(Roots):
    """Fractions in which exp is the identity: what holds for every exp(ln v) holds for every v."""

    @staticmethod
    def exp(value: Fraction) -> Fraction:
        """The speed, which stands in the place of its logarithm."""
        return value


def _gliding(
    draws: random.Random,
) -> tuple[tuple[Parameters, NewtonState, Fraction], tuple[Parameters, NewtonState, Fraction]]:
    """A gliding state under the regularised law and under Coulomb's, and its gliding speed."""
    (ring, height), (x, y), (vx, vy), share = (circle(draws) for _ in range(4))
    length, speed = positive(draws), positive(draws)
    values = [positive(draws) for _ in range(7)]
    turning = (ring * x, ring * y, height, *(signed(draws) for _ in range(3)))
    # speed^2 + epsilon^2 is a square because cosine and sine of ``share`` are fractions
    glide = abs(share[0]) * length
    smooth = Parameters(*values, friction=LAWS["regularised"], further=(abs(share[1]) * length,))
    return (
        (smooth, NewtonState(*(*turning, glide * vx, glide * vy)), glide),
        (
            Parameters(*values, friction=COULOMB),
            NewtonState(*(*turning, speed * vx, speed * vy)),
            speed,
        ),
    )


def _motion(chart: ForceChart) -> Motion:
    return Motion(chart.body, chart.state, chart)


def _rates(chart: ForceChart) -> NewtonState:
    torque = cross(newton.arm(chart.body, chart.state.k), chart.force)
    zero = chart.field.zero
    return NewtonState(*newton.axis_rate(chart.body, chart.state), *torque, zero, zero)
