"""Depth 1: seeded states under every law of friction, and each term of the equations there.

A trajectory that drifts does not say which term is wrong; these numbers do. Inputs have 50 digits,
so that rounding them does not show in the 34 of what is expected.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from tt_precise.arithmetic import Functions, Scalar
from tt_precise.body import TippeTop
from tt_precise.dry_friction import top_with_friction
from tt_precise.exact.arithmetic import arithmetic_of, decimal, own_context
from tt_precise.initial_state import InitialState
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.friction import viscous_at
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.pose import Pose, pose
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Vector, cross, scaled
from tt_precise.scene import Scene, Start
from tt_precise.untyped import Json

SEED = 2013
STATES = 5  # of each law
LAWS = ("viscous", "regularised", "coulomb", "rolling", "none")
INPUT_DIGITS, DIGITS, WORKING_DIGITS = 50, 34, 80
AGREEMENT = 40  # digits in which two formulations have to agree


@dataclass(frozen=True)
class StateCase:
    """One state: a top, its law, and a start turned about the vertical by a rational angle.

    ``law`` is that of friction, "rolling" (v_A = 0, by whatever force it takes) or "none"
    (free flight). ``half`` is (cos, sin) of half the azimuth.
    """

    name: str
    law: str
    scene: Scene
    half: tuple[Fraction, Fraction]

    @cached_property
    def context(self) -> Functions:
        """The arithmetic that everything is computed in."""
        return own_context(WORKING_DIGITS)

    @cached_property
    def start(self) -> InitialState:
        """The start before it is turned, in SI."""
        return InitialState.in_si(self.scene, arithmetic_of(self.context))

    def turned(self, vector: Vector) -> Vector:
        """A vector turned about the vertical to the case's azimuth."""
        c, s = self.half
        cosine, sine = self.number(c * c - s * s), self.number(2 * c * s)
        x, y, z = vector
        return (cosine * x - sine * y, sine * x + cosine * y, z)

    def number(self, value: Fraction) -> Scalar:
        """An exact number in the working arithmetic."""
        return arithmetic_of(self.context).exact(value)

    def pose_of(self, q: Motion, phi: Scalar = 0, psi: Scalar = 0) -> Pose:
        """Orientation and velocities of a motion that has turned by ``phi`` since the start."""
        fn = self.context
        azimuth = 2 * fn.atan2(self.number(self.half[1]), self.number(self.half[0])) + phi
        return pose(q, fn.hypot(q.k[0], q.k[1]), azimuth, psi, 0, 0)


def cases() -> Iterator[StateCase]:
    """The seeded states: ``STATES`` for each law, with g_n > 0 where there is contact."""
    draws = random.Random(SEED)
    for law in LAWS:
        found = 0
        while found < STATES:
            case = StateCase(f"{law}-{found + 1}", law, _scene(law, draws), _half_angle(draws))
            if law == "none" or _pressed(case):
                found += 1
                yield case


def _decimal(draws: random.Random, low: str, high: str) -> str:
    a, b = Fraction(low), Fraction(high)
    return str(float(a + (b - a) * Fraction(draws.randint(0, 1000), 1000)))


def _scene(law: str, draws: random.Random) -> Scene:
    body = {
        "m": _decimal(draws, "0.005", "0.05"), "R": _decimal(draws, "0.01", "0.04"),
        "alpha": _decimal(draws, "0.1", "0.4"), "I1": _decimal(draws, "0.3", "0.6"),
        "I3": _decimal(draws, "0.3", "0.5"), "g": "9.81",
    }  # fmt: skip
    friction = {"law": "viscous", "mu": "0"}
    if law in ("viscous", "regularised", "coulomb"):
        friction = {"law": law, "mu": _decimal(draws, "0.1", "0.6")}
    if law == "regularised":
        friction["epsilon"] = _decimal(draws, "0.001", "0.1")
    top: TippeTop = top_with_friction(body, friction)
    glides = {name: _decimal(draws, "-1", "1") for name in ("nu_x", "nu_y")}
    start = Start(
        theta=Fraction(_decimal(draws, "0.1", "3")),  # type: ignore[arg-type]
        theta_dot=Fraction(_decimal(draws, "-5", "5")),
        phi_dot=Fraction(_decimal(draws, "-8", "8")),
        omega_3=Fraction(_decimal(draws, "-200", "200")),
        **({} if law == "rolling" else {name: Fraction(one) for name, one in glides.items()}),
    )
    model = "rolling" if law == "rolling" else "gliding"
    return Scene(law, model, top, start, until=Fraction(1, 100), sample_every=Fraction(1, 100))


def _half_angle(draws: random.Random) -> tuple[Fraction, Fraction]:
    t = Fraction(draws.randint(-9, 9), 10)
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


def _pressed(case: StateCase) -> bool:
    q = case.start.motion(case.context)
    return bool(q.force[2] > q.body.m * q.body.g / 10)


def state_file() -> list[dict[str, Json]]:
    """The entries of ``states.json``.

    Raises
    ------
    ArithmeticError
        Two formulations do not agree; there is nothing to publish then.
    """
    return [_entry(case) for case in cases()]


def _entry(case: StateCase) -> dict[str, Json]:
    q = case.start.motion(case.context)
    body = {
        name: _shown(case, getattr(q.body, name), INPUT_DIGITS)
        for name in ("m", "R", "alpha", "I1", "I3", "g")
    }
    law: dict[str, Json] = {"law": case.law}
    if case.law in ("viscous", "regularised", "coulomb"):
        law["mu"] = _shown(case, q.body.mu, INPUT_DIGITS)
    if case.law == "regularised":
        law["epsilon"] = _shown(case, getattr(q.body, "epsilon"), INPUT_DIGITS)  # noqa: B009
    state = {
        name: _vector(case, case.turned(getattr(q, name)), INPUT_DIGITS)
        for name in ("k", "omega", "s_dot")
    }
    posed = case.pose_of(q)
    four = [_shown(case, part, INPUT_DIGITS) for part in posed[:4]]
    given = {"quaternion_wxyz": four, "quaternion_xyzw": [*four[1:], four[0]], **state}
    return {
        "name": case.name,
        "body": body,
        "friction": law,
        "state": given,
        "expected": {
            name: _vector(case, value, DIGITS)
            if isinstance(value, tuple)
            else _shown(case, value, DIGITS)
            for name, value in expected(case).items()
        },
    }


def expected(case: StateCase) -> dict[str, Scalar | Vector]:
    """Every term at the case's state, at its azimuth; vectors as tuples, SI.

    Raises
    ------
    ArithmeticError
        Newton's and Euler's equations do not agree.
    """
    fn, body = case.context, case.start.body
    vectors = _turned_state(case)
    if case.law == "none":
        force: Vector = (fn.mpf(0), fn.mpf(0), fn.mpf(0))
        q = Motion(body, vectors, fn)
    else:
        q = Motion(body, vectors, fn, case.scene.model)
        force = q.force
        _agree(case, q)
    torque = cross(q.a, force)
    v_dot = newton.contact_acceleration(body, vectors, force)
    omega_dot = newton.spin_response(body, q.k, torque)
    spin = q.state.L[0] * q.k[0] + q.state.L[1] * q.k[1] + q.state.L[2] * q.k[2]
    k_dot = newton.axis_rate(body, vectors)
    turning = spin / body.I3 - spin / body.I1
    return {
        "L": q.state.L,
        "a": q.a,
        "v_A": (vectors.vx, vectors.vy, fn.mpf(0)),
        "g_n": force[2],
        "F": force,
        "torque": torque,
        "k_dot": k_dot,
        "L_dot": torque,
        "omega_dot": tuple(x + turning * y for x, y in zip(omega_dot, k_dot, strict=True)),
        "s_ddot": tuple(
            part - body.g * axis
            for part, axis in zip(scaled(1 / body.m, force), (0, 0, 1), strict=True)
        ),
        "v_A_dot": v_dot,
    }


def _turned_state(case: StateCase) -> NewtonState:
    v = case.start.vectors
    parts = [*case.turned(v.k), *case.turned(v.L), *case.turned(v.v)[:2]]
    return NewtonState(*parts)


def _agree(case: StateCase, q: Motion) -> None:
    """The force by the vectors is the one by Euler angles, or keeps the contact at rest."""
    fn, body, here = case.context, case.start.body, case.start.euler
    if case.law == "rolling":
        size = abs(q.force[2]) / body.m
        still = newton.contact_acceleration(body, q.state, q.force)
        worst = max(abs(part) for part in still) / size
    else:
        plain = EulerState(*here)
        viscous = viscous_at(body, here.nu_x, here.nu_y, fn)
        worst = abs(euler.normal_force(viscous, plain, fn) / q.force[2] - 1)
    if worst > fn.mpf(10) ** -AGREEMENT:
        raise ArithmeticError(f"{case.name}: two formulations differ by {fn.nstr(worst, 3)}")


def _shown(case: StateCase, value: Scalar, digits: int) -> str:
    return decimal(case.context.mpf(value), digits, case.context)


def _vector(case: StateCase, value: Vector, digits: int) -> list[str]:
    return [_shown(case, part, digits) for part in value]
