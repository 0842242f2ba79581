"""Depth 1: seeded states under every law of friction and contact, and each term of the equations.

A drifting trajectory does not show which term is wrong; these numbers do. Inputs have 50 digits, so
that their rounding does not show in the 34 digits of the expected numbers.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from benchmarks.vectors.terms import disagreement, terms
from tt_precise.exact.stability import arithmetic_of, decimal, own_context
from tt_precise.mechanics import flight, newton
from tt_precise.mechanics.friction import cone_margin
from tt_precise.mechanics.laws import COULOMB, LAWS, REGULARISED, VISCOUS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import SPRINGS
from tt_precise.mechanics.quantities import Motion, Pose, pose
from tt_precise.mechanics.vectors import Quaternion, Vector, added, cross
from tt_precise.runtime.values import Functions, Json, Scalar
from tt_precise.scene.body import top_of
from tt_precise.scene.scene import InitialState, Scene

SEED = 2013
STATES = 5  # Number of states of each law.
STEPS = (Fraction(1, 10_000), Fraction(1, 1000), Fraction(1, 100))  # s
# seeds of states that stick or slip within a step: the first and fourth within the shortest, the
# second and fifth within the middle one, the third within the longest
JOINED = {"coulomb-sticks": (3, 9, 13, 14, 17), "sticking-slips": (2, 12, 25, 30, 36)}
GLIDING = {law.name: law for law in LAWS.values() if law.in_vectors}
KINDS = (*GLIDING, "rolling", "none", "sticking", *SPRINGS)
# the friction of each kind that has some
FRICTION = {**GLIDING, "sticking": COULOMB, **dict.fromkeys(SPRINGS, REGULARISED)}
STIFFNESS = {"linear": ("500", "5000"), "hunt-crossley": ("50000", "500000")}  # N/m, N/m^1.5
DAMPING = {"linear": ("0.05", "0.5"), "hunt-crossley": ("0.2", "2")}  # N s/m, s/m
INPUT_DIGITS, DIGITS, WORKING_DIGITS = 50, 34, 80
AGREEMENT = 40  # digits on which two formulations must agree
ROUNDING = 1e-60
PLUS = Fraction(101, 100)  # 1 % more
VALID, INVALID = "valid", "invalid"
MISTAKEN = (*GLIDING, "rolling")  # kinds whose first state has mistakes
STEP = 26  # -log10 of s; central differences over it are off by some 1e-45


@dataclass(frozen=True)
class StateCase:
    """One state: a top, its law, and a start turned about the vertical by a rational angle.

    ``law`` is that of friction, "rolling" (v_A = 0, by the constraint force), "sticking"
    (Coulomb's, v_A = 0 and that force within the cone), "none" (free flight), or the force of an
    elastic table, on which friction is regularised. ``half`` is (cos, sin) of half the azimuth.
    Those named as in ``JOINED`` stick or slip soon.
    """

    name: str
    law: str
    scene: Scene
    half: tuple[Fraction, Fraction]

    @cached_property
    def context(self) -> Functions:
        """The arithmetic of all computations."""
        return own_context(WORKING_DIGITS)

    @cached_property
    def motion(self) -> Motion:
        """The motion at the start, rotated to the case's azimuth."""
        start: Any = self.start.vectors
        parts = [*self.turned(start.k), *self.turned(start.L), *self.turned(start.v)[:2]]
        model = "flight" if self.law == "none" else self.scene.model
        if self.law in SPRINGS:
            model, parts = self.law, [*parts, start.height, start.rise]
        return Motion(self.start.body, type(start)(*parts), self.context, model)

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
        return arithmetic_of(self.context).exact(value)

    def pose_of(self, q: Motion, phi: Scalar = 0, psi: Scalar = 0) -> Pose:
        """Orientation and velocities of a motion that has rotated by ``phi`` since the start."""
        fn = self.context
        azimuth = 2 * fn.atan2(self.number(self.half[1]), self.number(self.half[0])) + phi
        return pose(q, fn.hypot(q.k[0], q.k[1]), azimuth, psi, 0, 0)


def cases() -> Iterator[StateCase]:
    """The seeded states: ``STATES`` for each law, with g_n > 0 where there is contact.

    Where the top sticks, its force lies within the cone.
    """
    draws = random.Random(SEED)
    for law in KINDS:
        count = 0
        while count < STATES:
            case = StateCase(f"{law}-{count + 1}", law, _scene(law, draws), _half_angle(draws))
            if law == "none" or _pressed(case):
                count += 1
                yield case
    for law, seeds in JOINED.items():
        for number, seed in enumerate(seeds, start=1):
            yield _joined(f"{law}-{number}", random.Random(seed))


def _joined(name: str, draws: random.Random) -> StateCase:
    """A slow start that may stick, or one at rest whose force is hardly within the cone."""
    law = name.partition("-")[0]
    scene, half = _scene(law, draws), _half_angle(draws)
    if law in GLIDING:
        slow = Fraction(1, draws.choice((100, 1000, 10_000)))
        gliding = {name: getattr(scene.start, name) * slow for name in ("nu_x", "nu_y")}
        scene = scene.varied(**{name: str(float(value)) for name, value in gliding.items()})
    else:
        x, y, z = StateCase(name, law, scene, half).motion.force
        ratio = float((x * x + y * y) ** 0.5 / abs(z))
        scene = scene.varied(mu=f"{ratio * (1 + 10 ** draws.uniform(-4, -1)):.6f}")
    return StateCase(name, law, scene, half)


def _decimal(draws: random.Random, low: str, high: str) -> str:
    a, b = Fraction(low), Fraction(high)
    return str(float(a + (b - a) * Fraction(draws.randint(0, 1000), 1000)))


def _scene(law: str, draws: random.Random) -> Scene:
    body = {
        "m": _decimal(draws, "0.005", "0.05"), "R": _decimal(draws, "0.01", "0.04"),
        "alpha": _decimal(draws, "0.1", "0.4"), "I1": _decimal(draws, "0.3", "0.6"),
        "I3": _decimal(draws, "0.3", "0.5"), "g": "9.81",
    }  # fmt: skip
    friction = {"law": VISCOUS.name, "mu": "0"}
    if law in FRICTION:
        drawn = {name: _decimal(draws, *usual) for name, _, _, usual in FRICTION[law].parameters}
        friction = {"law": FRICTION[law].name, **drawn}
    glides = {name: _decimal(draws, "-1", "1") for name in ("nu_x", "nu_y")}
    start = {
        "theta": _decimal(draws, "0.1", "3"),
        "theta_dot": _decimal(draws, "-5", "5"),
        "phi_dot": _decimal(draws, "-8", "8"),
        "omega_3": _decimal(draws, "-200", "200"),
        **({} if law in ("rolling", "sticking") else glides),
    }
    contact = None
    if law in SPRINGS:
        contact = {
            "law": "compliant", "force": law, "stiffness": _decimal(draws, *STIFFNESS[law]),
            "damping": _decimal(draws, *DAMPING[law]),
        }  # fmt: skip
        start |= {
            "height": _decimal(draws, "-0.0005", "-0.00005"),
            "rise": _decimal(draws, "-0.2", "0.2"),
        }
    model = "rolling" if law == "rolling" else "gliding"
    top, _ = top_of(body, friction, contact)
    given: Any = start
    return Scene(law, model, top, given, until=Fraction(1, 100), sample_every=Fraction(1, 100))


def _half_angle(draws: random.Random) -> tuple[Fraction, Fraction]:
    t = Fraction(draws.randint(-9, 9), 10)
    return (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)


def _pressed(case: StateCase) -> bool:
    q = case.motion
    sticks = case.law != "sticking" or cone_margin(q.body, q.state) > 0
    return bool(sticks and q.force[2] > q.body.m * q.body.g / 10)


# Common mistakes of engines: the terms of the same state with one mistake, by its flag.
MISTAKES: dict[str, Callable[[StateCase], Motion]] = {
    "I1 plus 1 %": lambda case: _with_body(case, I1=case.start.body.I1 * case.number(PLUS)),
    "I3 plus 1 %": lambda case: _with_body(case, I3=case.start.body.I3 * case.number(PLUS)),
    "friction reversed": lambda case: _with_body(case, mu=-case.start.body.mu),
    "centre of mass at the centre of the sphere": lambda case: _with_body(
        case, alpha=case.number(Fraction(0))
    ),
    "omega in the body frame": lambda case: _seen(
        case, omega=flight.rotate(_inverse_of(case), case.motion.omega)
    ),
    "quaternion inverse": lambda case: _seen(case, k=flight.rotate(_inverse_of(case), (0, 0, 1))),
}


def _with_body(case: StateCase, **changed: Scalar) -> Motion:
    return _seen(case, body=replace(case.motion.body, **changed))


def _inverse_of(case: StateCase) -> Quaternion:
    w, x, y, z = case.pose_of(case.motion)[:4]
    return (w, -x, -y, -z)


def _seen(
    case: StateCase, body: Any = None, k: Vector | None = None, omega: Vector | None = None
) -> Motion:
    """The case's motion with another body, axis or angular velocity."""
    q = case.motion
    body, k, w = body or q.body, k or q.k, omega or q.omega
    v = added(q.s_dot, cross(w, newton.contact_arm(body, k)))
    L = newton.angular_momentum(body, k, w)
    return Motion(body, NewtonState(*k, *L, *v[:2]), q.fn, q.model)


def state_file() -> list[dict[str, Json]]:
    """The entries of ``states.json``: each state, and after some the same with a mistake.

    Raises ``ArithmeticError``: two formulations do not agree.
    """
    return [entry for case in cases() for entry in _entries(case)]


def _entries(case: StateCase) -> Iterator[dict[str, Json]]:
    entry = _entry(case)
    flags = [case.law, *(["joins"] if case.name.rpartition("-")[0] in JOINED else [])]
    yield {**entry, "result": VALID, "flags": flags, "expected": texts(case, expected(case))}
    if case.law not in MISTAKEN or case.name != f"{case.law}-1":
        return
    for number, (flag, mistaken) in enumerate(MISTAKES.items(), start=1):
        if flag == "friction reversed" and case.law == "rolling":
            continue
        wrong = texts(case, terms(mistaken(case)))
        name = {"name": f"{case.name}-mistake-{number}"}
        yield {**entry, **name, "result": INVALID, "flags": [case.law, flag], "expected": wrong}


def texts(case: StateCase, values: Mapping[str, Scalar | Vector]) -> dict[str, Json]:
    """Numbers and vectors as decimals of ``DIGITS`` digits."""
    return {
        name: _vector(case, value, DIGITS)
        if isinstance(value, tuple)
        else _shown(case, value, DIGITS)
        for name, value in values.items()
    }


def orientation(case: StateCase, quaternion: Sequence[Scalar], digits: int) -> dict[str, Json]:
    """A quaternion, scalar first, in both orders."""
    four = [_shown(case, part, digits) for part in quaternion]
    return {"quaternion_wxyz": four, "quaternion_xyzw": [*four[1:], four[0]]}


def _entry(case: StateCase) -> dict[str, Json]:
    q = case.motion

    def numbers(*names: str) -> dict[str, Json]:
        return {name: _shown(case, q.body.numbers_by_name[name], INPUT_DIGITS) for name in names}

    friction: dict[str, Json] = {"law": q.body.law if case.law in SPRINGS else case.law}
    if case.law in FRICTION:
        friction |= numbers(*(parameter.name for parameter in FRICTION[case.law].parameters))
    contact: dict[str, Json] = {"law": "none" if case.law == "none" else "rigid"}
    state: dict[str, Json] = {
        name: _vector(case, getattr(q, name), INPUT_DIGITS) for name in ("k", "omega", "s_dot")
    }
    if case.law in SPRINGS:
        contact = {"law": "compliant", "force": case.law, **numbers("stiffness", "damping")}
        state["height"] = _shown(case, q.state.height, INPUT_DIGITS)
    return {
        "name": case.name,
        "body": numbers("m", "R", "alpha", "I1", "I3", "g"),
        "friction": friction,
        "contact": contact,
        "state": orientation(case, case.pose_of(q)[:4], INPUT_DIGITS) | state,
    }


def expected(case: StateCase) -> dict[str, Scalar | Vector]:
    """Every term at the case's state, at its azimuth; vectors as tuples, SI.

    Raises ``ArithmeticError``: Newton's and Euler's equations do not agree.
    """
    fn, known = case.context, terms(case.motion)
    worst = disagreement(case.motion, known, case.start.euler, fn.mpf(10) ** -STEP)
    if not worst <= fn.mpf(10) ** -AGREEMENT:
        raise ArithmeticError(f"{case.name}: two formulations differ by {fn.nstr(worst, 3)}")
    return known


def _shown(case: StateCase, value: Scalar, digits: int) -> str:
    number = case.context.mpf(value)
    # values that a constraint keeps zero are rounding: no other number in SI here is so small
    return decimal(number if abs(number) > ROUNDING else number * 0, digits, case.context)


def _vector(case: StateCase, value: Vector, digits: int) -> list[str]:
    return [_shown(case, part, digits) for part in value]
