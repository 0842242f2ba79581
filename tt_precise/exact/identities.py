"""Proofs that the forms of the equations in ``mechanics`` agree, and of the conservation laws.

Each identity is one entry: a function that yields residuals. Symbolic ones call the functions of
``mechanics`` on the symbols of a chart: all parameters and the whole state are symbols, so a proof
holds for every body and every state where nothing is divided by zero. Euler and vector form are
compared through ``mechanics.euler``. A chart at azimuth 0 proves an identity at this azimuth; the
identities "equations turn with the frame" and "Euler angles turn with the frame" extend the proof
to every azimuth. Other identities are exact evaluations at random rational points.

Three identities have a force of three free symbols at the contact point of a sphere whose contact
may even move vertically: they cover every friction law and every compliant contact. Identities of
the dry laws are evaluated at points where the roots of the laws are rational.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from math import isqrt
from typing import Any, TypeVar, get_type_hints

from tt_precise.exact.chart import (
    Chart,
    EulerChart,
    EulerChartAtAzimuth0,
    ForceChart,
    VectorChart,
    VectorChartAtAzimuth0,
)
from tt_precise.mechanics import euler, friction, newton, quantities, rolling
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.friction import PolarState
from tt_precise.mechanics.laws import COULOMB, REGULARISED
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.rolling import RollingEulerState, RollingState
from tt_precise.mechanics.vectors import Vector, cross, dot, scaled, subtracted
from tt_precise.runtime.values import Scalar, require_name

POINTS = 20
SEED = 2012
LARGEST = 10**6  # numerators: a false identity of degree n survives a point with odds n/LARGEST


Residuals = Callable[[Any], Iterable[Scalar]]  # of a chart, or of a random.Random


@dataclass(frozen=True)
class Identity:
    """A statement, its place in the paper, and a function for the expressions that must vanish.

    A symbolic one takes a ``chart`` of the type named in its annotation: its proof is a polynomial
    reduction, for all parameters and states at once. Another takes a ``random.Random`` and gives
    exact numbers, at another point each time.
    """

    name: str
    equation: str
    residuals: Residuals

    @property
    def statement(self) -> str:
        """The identity in words and formulas."""
        return " ".join(str(self.residuals.__doc__).split())

    def prove(self, body: Parameters | None = None) -> IdentityProof:
        """Prove or refute the identity; a symbolic one only for the exact ``body``, if given."""
        kind = get_type_hints(self.residuals).get("chart")
        if kind is not None:
            chart: Chart = kind(body)
            vanishing = [chart.vanishes(residual) for residual in self.residuals(chart)]
        else:
            draws = random.Random(SEED)
            table = [list(self.residuals(draws)) for _ in range(POINTS)]
            vanishing = [not any(column) for column in zip(*table, strict=True)]
        if not vanishing:
            raise ArithmeticError(f"{self.name}: no residuals, so nothing was proved")
        failed = tuple(i for i, vanishes in enumerate(vanishing) if not vanishes)
        return IdentityProof(self, len(vanishing), failed)


@dataclass(frozen=True)
class IdentityProof:
    """The decision on an identity: how many expressions must vanish, and which do not (from 0)."""

    identity: Identity
    residuals: int
    failed: tuple[int, ...]

    @property
    def holds(self) -> bool:
        """True if all expressions vanish."""
        return not self.failed


IDENTITIES: dict[str, Identity] = {}


def identity(name: str, equation: str) -> Callable[[Residuals], Residuals]:
    """Register a function that yields residuals; see ``Identity``."""

    def register(residuals: Residuals) -> Residuals:
        IDENTITIES[name] = Identity(name, equation, residuals)
        return residuals

    return register


def positive(draws: random.Random) -> Fraction:
    """A random positive rational number."""
    return Fraction(draws.randint(1, LARGEST), draws.randint(1, LARGEST))


def signed(draws: random.Random) -> Fraction:
    """A random rational number of either sign."""
    return positive(draws) * draws.choice((-1, 1))


def circle(draws: random.Random) -> tuple[Fraction, Fraction]:
    """A random rational point on the unit circle."""
    t = signed(draws)
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


VectorState = TypeVar("VectorState", NewtonState, RollingState)


def prove(name: str) -> IdentityProof:
    """Prove, or refute, one identity; ``InputError`` if no identity has this name."""
    require_name("identity", name, IDENTITIES)
    return IDENTITIES[name].prove()


@identity("Euler form = Newton form", "(1) to (6)")
def _euler_is_newton(chart: EulerChartAtAzimuth0) -> Iterable[Scalar]:
    """The vectors of the Euler state change as the Newton equations say."""
    vectors = chart.vectors
    by_euler = euler.rates(chart.body, chart.state, chart)
    by_newton = newton.rates(chart.body, NewtonState(*map(chart.here, vectors)))
    return _differences((chart.along(vector, by_euler) for vector in vectors), by_newton)


@identity("Euler angles turn with the frame", "section 1")
def _azimuth(chart: EulerChart) -> Iterable[Scalar]:
    """The vectors of an Euler state are those at azimuth 0, rotated about z by phi."""
    vectors = chart.vectors
    straight = NewtonState(*map(chart.at_azimuth_0, vectors))
    return _differences(vectors, _rotate(straight, (chart.C, chart.S)))


@identity("g_n Euler = g_n Newton", "(7)")
def _normal_forces(chart: EulerChart) -> Iterable[Scalar]:
    """Normal force, its numerator and its denominator are the same in both forms."""
    by_euler = euler.contact_terms(chart.body, chart.state, chart)
    by_newton = newton.contact_terms(chart.body, chart.vectors)
    yield from _differences(by_euler, by_newton)
    force = euler.normal_force(chart.body, chart.state, chart)
    yield force - newton.normal_force(chart.body, chart.vectors)


@identity("the contact keeps", "(1), (7), (13)")
def _contact(chart: VectorChart) -> Iterable[Scalar]:
    """m s_ddot = F - m g z with s_dot = v_A - omega x a, so that the contact keeps."""
    force = newton.contact_force(chart.body, chart.state)
    rates = newton.rates(chart.body, chart.state)
    return _newtons_second_law(chart, rates, Motion(chart.body, chart.state, chart), force)


@identity("rate of g_n", "(7)")
def _normal_force_slope(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """d g_n/dt times the denominator of eq (7) is the slope that finds extrema of g_n."""
    here = chart.vectors
    rates = newton.rates(chart.body, here)
    terms = newton.contact_terms(chart.body, chart.state)
    above, below = (chart.along(term, rates) for term in terms)
    slope = above - newton.normal_force(chart.body, here) * below
    yield slope - newton.normal_force_slope(chart.body, here)


@identity("the axis stays a unit vector", "(1)")
def _unit_axis(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """|k|^2 does not change, gliding or rolling."""
    gliding = newton.rates(chart.body, chart.vectors)
    for rates in (gliding, _rolling_rates(chart)):
        yield chart.along(sum(k * k for k in chart.state.k), rates)


@identity("equations turn with the frame", "(1)")
def _symmetry(draws: random.Random) -> Iterable[Scalar]:
    """Gliding and rolling equations commute with rotations about z: azimuth 0 stands for all."""
    body = Parameters(*(positive(draws) for _ in range(7)))
    (ring, height), (x, y), angle = circle(draws), circle(draws), circle(draws)
    state = NewtonState(ring * x, ring * y, height, *(signed(draws) for _ in range(5)))
    gliding = newton.rates(body, state)
    yield from _differences(newton.rates(body, _rotate(state, angle)), _rotate(gliding, angle))
    still = RollingState(*state[:6])
    rates = rolling.rates(body, still)
    yield from _differences(rolling.rates(body, _rotate(still, angle)), _rotate(rates, angle))


@identity("Euler angles there and back", "section 1")
def _there_and_back(chart: EulerChart) -> Iterable[Scalar]:
    """Vectors of an Euler state, converted back, give its rates and velocities again."""
    back = euler.euler_from_vectors(chart.body, chart.vectors, chart)
    return _differences(back, chart.state)


@identity("lambda in Euler angles", "(14)")
def _jellett_forms(chart: EulerChart) -> Iterable[Scalar]:
    """-L.a is eq (14)."""
    yield _quantity(chart, "lambda") - euler.jellett(chart.body, chart.state, chart)


@identity("lambda is constant, vectors", "(10)")
def _jellett_vectors(chart: VectorChart) -> Iterable[Scalar]:
    """d lambda/dt = 0 along the Newton equations, for every friction."""
    yield _rate(chart, "lambda")


@identity("lambda is constant, Euler angles", "(10)")
def _jellett_euler(chart: EulerChart) -> Iterable[Scalar]:
    """d lambda/dt = 0 along the Euler equations, for every friction."""
    lambda_ = euler.jellett(chart.body, chart.state, chart)
    yield chart.along(lambda_, euler.rates(chart.body, chart.state, chart))


@identity("E falls by friction", "section 1")
def _energy(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """dE/dt = v_A.F = -mu g_n v_A^2."""
    state, body = chart.vectors, chart.body
    loss = -body.mu * newton.normal_force(body, state) * (state.vx**2 + state.vy**2)
    yield _rate(chart, "E") - loss
    yield _quantity(chart, "E_dot") - loss


@identity("rates of the parts of E", "section 2.3")
def _energy_terms(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """Translational, rotational and potential energy change at their stated rates."""
    for name in ("E_trans", "E_rot", "E_pot"):
        yield _rate(chart, name) - _quantity(chart, f"{name}_dot")


@identity("Main Equation", "(17), (18)")
def _main_equation(chart: EulerChart) -> Iterable[Scalar]:
    """E~ = g(cos theta) theta_dot^2 + V(cos theta, D, lambda)."""
    yield _quantity(chart, "E_tilde") - _quantity(chart, "E_tilde_main")


@identity("rate of D", "(11)")
def _routh(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """dD/dt = gamma m/(alpha sqrt(d)) (z x a).v_A_dot along the Newton equations."""
    yield _rate(chart, "D") - _quantity(chart, "D_dot")


@identity("rate of E~", "(12)")
def _modified_rate(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """dE~/dt = m (omega x a).v_A_dot along the Newton equations."""
    yield _rate(chart, "E_tilde") - _quantity(chart, "E_tilde_dot")


@identity("omega_3_dot", "(4)")
def _spin_rate(chart: VectorChart) -> Iterable[Scalar]:
    """I3 omega_3_dot = (a x F).k, and is what the derivative of L.k says."""
    yield _rate(chart, "omega_3") - _quantity(chart, "omega_3_dot")


@identity("rolling vectors obey Newton", "(1), v_A = 0")
def _rolling_contact(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """m s_ddot = F - m g z with s_dot = -omega x a and the force of the constraint."""
    motion = _rolling_motion(chart)
    force = rolling.constraint_force(chart.body, NewtonState(*map(chart.here, motion.state)))
    return _newtons_second_law(chart, _rolling_rates(chart), motion, force)


@identity("rolling Euler = rolling vectors", "(10) to (12), v_A = 0")
def _rolling_forms(chart: EulerChartAtAzimuth0) -> Iterable[Scalar]:
    """The Euler equations made from constant lambda, D, E~ move the vectors as Newton's do."""
    still = EulerState(*chart.state[:4], 0, 0)
    vectors = RollingState(*euler.vectors_from_euler(chart.body, still, chart, chart.phi)[:6])
    by_euler = _rolling_euler_rates(chart)
    by_newton = rolling.rates(chart.body, RollingState(*map(chart.here, vectors)))
    return _differences((chart.along(vector, by_euler) for vector in vectors), by_newton)


@identity("lambda, D, E~ are constant when rolling, vectors", "(10) to (12), v_A = 0")
def _rolling_integrals(chart: VectorChartAtAzimuth0) -> Iterable[Scalar]:
    """lambda, D and E~ = E do not change along the rolling equations in vectors."""
    motion, rates = _rolling_motion(chart), _rolling_rates(chart)
    for name in ("lambda", "D", "E_tilde", "E"):
        yield chart.along(QUANTITIES[name].evaluate(motion), rates)


@identity("lambda, D, E~ are constant when rolling, Euler angles", "(10) to (12), v_A = 0")
def _rolling_euler_integrals(chart: EulerChart) -> Iterable[Scalar]:
    """lambda, D and E~ do not change along the rolling equations in Euler angles."""
    state = EulerState(*chart.state[:4], chart.field.zero, chart.field.zero)
    rates = _rolling_euler_rates(chart)
    yield chart.along(euler.jellett(chart.body, state, chart), rates)
    vectors = euler.vectors_from_euler(chart.body, state, chart)
    yield chart.along(quantities.E_tilde(Motion(chart.body, vectors, chart)), rates)
    routh = chart.body.I3 * state.omega_3 * chart.sqrt(quantities.d(chart.body, chart.c))
    yield chart.along(routh, rates)


@identity("integrals without friction", "(1), mu = 0")
def _frictionless(chart: VectorChart) -> Iterable[Scalar]:
    """With mu = 0: E, omega_3, L_z and the horizontal velocity of CM do not change."""
    smooth = replace(chart.body, mu=chart.field.zero)
    motion = Motion(smooth, chart.state, chart)
    rates = newton.rates(smooth, chart.state)
    for name in ("E", "omega_3", "L_z", "s_dot_x", "s_dot_y"):
        yield chart.along(QUANTITIES[name].evaluate(motion), rates)


def _differences(left: Iterable[Scalar], right: Iterable[Scalar]) -> list[Scalar]:
    return [value - other for value, other in zip(left, right, strict=True)]


def _quantity(chart: EulerChart | VectorChart, name: str) -> Scalar:
    return QUANTITIES[name].evaluate(Motion(chart.body, chart.vectors, chart))


def _rate(chart: VectorChart, name: str) -> Scalar:
    """Time derivative of a quantity along the Newton equations, by the chain rule."""
    value = QUANTITIES[name].evaluate(Motion(chart.body, chart.state, chart))
    return chart.along(value, newton.rates(chart.body, chart.vectors))


def _rolling_euler_rates(chart: EulerChart) -> RollingEulerState:
    return rolling.euler_rates(chart.body, RollingEulerState(*chart.state[:4]), chart)


def _rolling_motion(chart: VectorChart) -> Motion:
    state = NewtonState(*chart.state[:6], chart.field.zero, chart.field.zero)
    return Motion(chart.body, state, chart, "rolling")


def _rolling_rates(chart: VectorChart) -> RollingState:
    return rolling.rates(chart.body, RollingState(*map(chart.here, chart.state[:6])))


def _rotate(state: VectorState, angle: tuple[Fraction, Fraction]) -> VectorState:
    """A state whose vectors are rotated about z by the angle of this cosine and sine."""
    c, s = angle

    def rotate(name: str) -> dict[str, Scalar]:
        x, y = getattr(state, f"{name}x"), getattr(state, f"{name}y")
        return {f"{name}x": c * x - s * y, f"{name}y": s * x + c * y}

    parts = [name for name in "kLv" if f"{name}x" in state._fields]
    return state._replace(**{key: value for name in parts for key, value in rotate(name).items()})


def _newtons_second_law(
    chart: VectorChart, rates: NewtonState | RollingState, motion: Motion, force: Vector
) -> Iterable[Scalar]:
    """The three components of m s_ddot - F + m g z."""
    body = chart.body
    for along, component, axis in zip(motion.s_dot, force, (0, 0, 1), strict=True):
        yield body.m * chart.along(along, rates) - component + body.m * body.g * axis


@identity("lambda is constant under any contact force", "after (1)")
def _any_force_jellett(chart: ForceChart) -> Iterable[Scalar]:
    """d lambda/dt = 0 for every force F at the contact point: L_dot = a x F, k_dot = L x k/I1."""
    motion = Motion(chart.body, chart.state, chart)
    yield chart.along(quantities.jellett(motion), _forced_rates(chart))


@identity("E changes by the power of any contact force", "section 1")
def _any_force_energy(chart: ForceChart) -> Iterable[Scalar]:
    """dE/dt = v_A.F for every force F at the contact point, from m s_ddot = F - m g z."""
    q = Motion(chart.body, chart.state, chart)
    s_dot = subtracted(chart.v, newton.contact_velocity_rel_cm(chart.body, chart.state))
    # m s_dot.s_ddot + m g z.s_dot = s_dot.F
    rate = dot(s_dot, chart.force) + chart.along(quantities.E_rot(q), _forced_rates(chart))
    yield rate - dot(chart.v, chart.force)


@identity("momentum about the lowest point under any contact force", "section 1")
def _any_force_contact_momentum(chart: ForceChart) -> Iterable[Scalar]:
    """(L - a x m v)_dot, in which L_dot = a x F and m v_dot = F - m g z, does not contain F."""
    body, F = chart.body, chart.force
    a, k_dot = newton.contact_arm(body, chart.state.k), newton.axis_rate(body, chart.state)
    v = subtracted(chart.v, newton.contact_velocity_rel_cm(body, chart.state))
    moved = scaled(body.m * body.R * body.alpha, cross(k_dot, v))
    pressed = cross(a, (F[0], F[1], F[2] - body.m * body.g))
    rate = subtracted(subtracted(cross(a, F), moved), pressed)
    yield from _differences(rate, newton.contact_momentum_rate(body, a, k_dot, v))


@identity("dry friction: size, direction and loss", "section 1")
def _dry_laws(draws: random.Random) -> Iterable[Scalar]:
    """F_f opposes v_A; |F_f| sqrt(v^2 + epsilon^2) = mu g_n v; dE/dt = -|F_f| v."""
    for body, state, speed in _dry_states(draws):
        q = Motion(body, state, Roots)
        epsilon = body.numbers_by_name.get("epsilon", Fraction(0))
        g_n = q.force[2]
        size = -(q.force[0] * state.vx + q.force[1] * state.vy) / speed
        yield q.force[0] * state.vy - q.force[1] * state.vx
        yield size * Roots.sqrt(speed**2 + epsilon**2) - body.mu * g_n * speed
        yield quantities.E_dot(q) + size * speed


@identity("Coulomb's law in polar form", "(1)")
def _polar(draws: random.Random) -> Iterable[Scalar]:
    """The rates along tau are v times those along t, with v_A = v e; |e| does not change."""
    _, (body, state, speed) = _dry_states(draws)
    e = (state.vx / speed, state.vy / speed)
    plain = newton.rates(friction.viscous_at(body, state.vx, state.vy, Roots), state)
    polar = friction.polar_rates(body, PolarState(*state[:6], speed, *e, Fraction(0)), Exponential)
    yield from (own - speed * other for own, other in zip(polar[:6], plain[:6], strict=True))
    for part, turning, rate in zip(e, polar[7:9], plain[6:], strict=True):
        # v' = v (ln v)'
        yield speed * polar.log_v * part + speed * turning - speed * rate
    yield polar.ex * e[0] + polar.ey * e[1]
    yield polar.t - speed


@identity("rolling meets gliding at the cone", "(1), v_A = 0")
def _cone(draws: random.Random) -> Iterable[Scalar]:
    """With e = -F_f/(mu F_z) of rolling Coulomb's law has v_A_dot = 0; |e| = 1 on the cone."""
    _, (body, state, _) = _dry_states(draws)
    force = rolling.constraint_force(body, state)
    largest = body.mu * force[2]
    e = (-force[0] / largest, -force[1] / largest)
    rates = friction.along_direction(body, NewtonState(*state[:6], *e))
    yield from (rates.vx, rates.vy)
    yield friction.cone_margin(body, state) - largest**2 * (1 - e[0] ** 2 - e[1] ** 2)


class Roots:
    """The arithmetic of fractions, with the square roots that are fractions."""

    @staticmethod
    def sqrt(value: Fraction) -> Fraction:
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


DryState = tuple[Parameters, NewtonState, Fraction]


def _dry_states(draws: random.Random) -> tuple[DryState, DryState]:
    """A gliding state under the regularised law and under Coulomb's, and its gliding speed."""
    (ring, height), (x, y), (vx, vy), share = (circle(draws) for _ in range(4))
    length, speed = positive(draws), positive(draws)
    values = [positive(draws) for _ in range(7)]
    turning = (ring * x, ring * y, height, *(signed(draws) for _ in range(3)))
    # speed^2 + epsilon^2 is a square because cosine and sine of ``share`` are fractions
    glide = abs(share[0]) * length
    smooth = Parameters(*values, friction=REGULARISED, further=(abs(share[1]) * length,))
    dry = Parameters(*values, friction=COULOMB)
    return (
        (smooth, NewtonState(*(*turning, glide * vx, glide * vy)), glide),
        (dry, NewtonState(*(*turning, speed * vx, speed * vy)), speed),
    )


def _forced_rates(chart: ForceChart) -> NewtonState:
    torque = cross(newton.contact_arm(chart.body, chart.state.k), chart.force)
    return NewtonState(*newton.axis_rate(chart.body, chart.state), *torque, *[chart.field.zero] * 2)
