"""lambda, its thresholds and the asymptotic values, each determined twice, to any digits.

The formulas are those of ``mechanics.thresholds``. Each formula is compared with an independent
determination: the thresholds with the stability of the linearised equations of motion
(``exact.stability``), the asymptotic D and E~ with these quantities in the limit state, lambda with
the Euler form, gamma and sigma with accelerations. ``inversion`` decides whether a motion tends to
the inverted spin, by Theorem 1.1 and stability.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from tt_precise.exact.stability import (
    INVERTED,
    UPRIGHT,
    agreed_digits,
    arithmetic_of,
    decimal,
    fineness,
    marginal_momentum,
    own_context,
    rounding_to,
)
from tt_precise.mechanics import euler, friction, newton
from tt_precise.mechanics import thresholds as formulas
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.formulations import contact_terms
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import Functions, Json, Scalar, whole_number
from tt_precise.scene.scene import InitialState, Scene, load_scene

MOST_DIGITS = 2000  # Largest number of digits: more are mostly typing errors.
# Digits against some ten roundings in each formula; the fineness of the body comes on top of them,
# up to MOST_GUARD.
GUARD_DIGITS = 15
MOST_GUARD = 5000
# The verdict of Theorem 1.1 for a machine, and in words.
VERDICTS = {True: "inverts", False: "does_not_invert", None: "says_nothing"}
IN_WORDS = {
    "inverts": "inverts, if contact is never lost",
    "does_not_invert": "does not invert",
    "says_nothing": "says nothing",
}


@dataclass(frozen=True, repr=False)
class Determination:
    """A number and its independent determination (mpmath numbers, SI).

    ``value`` is None if the quantity does not exist, ``independent`` if the quantity does not exist
    or could not be determined; ``reason`` then has the reason. ``digits_agreed`` compares the two
    numbers, at most to the requested digits: 0 if only one number exists, None if neither exists.
    """

    value: Scalar
    independent: Scalar
    digits_agreed: int | None
    how: str
    unit: str
    reason: str = ""

    def agreed(self, digits: int) -> int:
        """The digits that agree; all ``digits`` if the quantity is absent in both ways."""
        return digits if self.digits_agreed is None else self.digits_agreed

    def __repr__(self) -> str:
        if self.value is None:
            return "<Determination: does not exist>"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"<Determination: {float(self.value):.12g}{unit}, {self.digits_agreed} digits agree>"


@dataclass(frozen=True, repr=False)
class Thresholds:
    """The results of ``thresholds`` for a scene; ``theorem`` is the verdict of Theorem 1.1."""

    digits: int
    context: Functions
    quantities: Mapping[str, Determination]
    theorem: Theorem

    @property
    def inverts(self) -> bool | None:
        """True if the theorem's verdict is "inverts", False if "does not invert", else None."""
        return self.theorem.inverts

    def __repr__(self) -> str:
        values = {name: each.value for name, each in self.quantities.items()}
        texts = (
            f"{name} {float(value):.8g}" for name, value in values.items() if value is not None
        )
        return f"<Thresholds, {self.digits} digits: {', '.join(texts)}; {self.theorem.verdict}>"

    def _repr_html_(self) -> str:
        from tt_precise.runtime.files import as_html

        texts = self.as_dict()["quantities"]
        rows: list[tuple[object, ...]] = [
            (name, texts[name]["value"] or "does not exist", each.unit, each.digits_agreed)
            for name, each in self.quantities.items()
        ]
        rows.append(("theorem", str(self.theorem), "", ""))
        return as_html("Thresholds (SI)", rows, ("", "value", "unit", "digits that agree"))

    def as_dict(self) -> dict[str, Json]:
        """Return the results as strings of ``digits`` digits, for JSON."""

        def text(number: Scalar) -> str | None:
            return None if number is None else decimal(number, self.digits, self.context)

        return {
            "digits": self.digits,
            "quantities": {
                name: vars(x) | {"value": text(x.value), "independent": text(x.independent)}
                for name, x in self.quantities.items()
            },
            "theorem": self.theorem.as_dict(),
            "inverts": self.inverts,
            "inverts_reason": self.theorem.reason,
        }


def thresholds(scene: str | Scene, digits: int = 50) -> Thresholds:
    """Determine lambda, lambda_thres, lambda_up, D0, D1, E0, E1, gamma, sigma, each in two ways.

    E0 and E1 are the paper's E~_0 and E~_1, in J; lambda is in kg m^3/s, D in kg m^2/s. D0 to E1
    are the values at the scene's lambda.

    Raises ``InputError``: the scene does not exist, or ``digits`` is not from 1 to 2000.
    """
    scene = load_scene(scene)
    determinations = _Determinations(scene, whole_number(digits, "digits", 1, MOST_DIGITS))
    top, fn, lambda_ = determinations.top, determinations.fn, determinations.lambda_start
    quantities = {
        "lambda": determinations.lambda_(),
        "lambda_thres": determinations.threshold(INVERTED),
        "lambda_up": determinations.threshold(UPRIGHT),
        "D0": determinations.asymptotic("D", UPRIGHT, formulas.D0(top, lambda_, fn)),
        "D1": determinations.asymptotic("D", INVERTED, formulas.D1(top, lambda_, fn)),
        "E0": determinations.asymptotic("E_tilde", UPRIGHT, formulas.E0(top, lambda_)),
        "E1": determinations.asymptotic("E_tilde", INVERTED, formulas.E1(top, lambda_)),
        "gamma": determinations.gamma(),
        "sigma": determinations.sigma(),
    }
    return Thresholds(digits, fn, quantities, determinations.theorem())


def theorem(scene: Scene) -> Theorem:
    """Return only the verdict of Theorem 1.1, from 50 digits of the formulas, in milliseconds."""
    return _Determinations(scene, 50).theorem()


def lambda_at_start(scene: Scene) -> Scalar:
    """Return only lambda, in kg m^3/s, to 50 digits; the thresholds would take a second."""
    return _Determinations(scene, 50).lambda_start


class _Determinations:
    """The quantities of one scene in one arithmetic, each determined in two ways."""

    def __init__(self, scene: Scene, digits: int):
        self.scene, self.digits = scene, digits
        # A tilt of 1e-30 leaves sin^2 theta = 1e-60 of phi_dot in lambda.
        guard = fineness(scene.body) + scene.start.theta.offset.denominator.bit_length()
        self.fn = own_context(digits + GUARD_DIGITS + min(guard, MOST_GUARD))
        start = InitialState.in_si(scene, arithmetic_of(self.fn))
        self.top, self.euler, self.motion = start.body, start.euler, start.motion(self.fn)
        self.lambda_start = QUANTITIES["lambda"].evaluate(self.motion)

    def lambda_(self) -> Determination:
        return self.compare(
            self.lambda_start,
            euler.jellett(self.top, self.euler, self.fn),
            "value: -L.a of the vectors at the start; independent: the paper's eq (14) "
            "in the Euler angles of the start",
            "kg m^3/s",
        )

    def theorem(self) -> Theorem:
        terms = contact_terms(self.scene.model, self.top, self.motion.state, self.fn)
        thresholds = self.formula(INVERTED), self.formula(UPRIGHT)
        margin = self.fn.mpf(10) ** -self.digits
        return inversion(self.scene, self.lambda_start, thresholds, bool(min(terms) > 0), margin)

    def formula(self, side: int) -> Scalar:
        """The threshold of a spin by its formula; None where the formula has none."""
        body = self.scene.body
        if side == INVERTED:
            return formulas.lambda_thres(self.top, self.fn) if body.gamma < 1 + body.alpha else None
        return formulas.lambda_up(self.top, self.fn) if body.gamma > 1 - body.alpha else None

    def threshold(self, side: int) -> Determination:
        spin, sign, needs = "upright", "-", "gamma > 1 - alpha"
        if side == INVERTED:
            spin, sign, needs = "inverted", "+", "gamma < 1 + alpha"
        own_name, own = self.friction_at_rest()
        frictions = {own_name: own, "a drag comparable with the top's inertia": None}
        how = (
            f"value: Theorem 1.1; independent: R (1 {sign} alpha) times the spin L at which the "
            f"linearised equations of motion change the stability of the {spin} spin, with "
            + " and again with ".join(frictions)
        )
        value, unit = self.formula(side), self.lambda_of_unit_momentum(side)
        reasons = [] if value is not None else [f"the formula needs {needs}"]
        determinations = []
        for name, mu in frictions.items():
            marginal = marginal_momentum(self.scene.body, side, self.digits, self.fn, mu)
            independent = None if marginal.momentum is None else marginal.momentum * unit
            determinations.append(self.compare(value, independent, how, "kg m^3/s"))
            reasons += [f"with {name} {marginal.reason}"] if marginal.reason else []
        worst = min(determinations, key=lambda each: each.agreed(self.digits))
        return replace(worst, reason="; ".join(reasons))

    def friction_at_rest(self) -> tuple[str, Fraction]:
        """The friction near a steady spin, v_A = 0, and its coefficient in s/m."""
        body = self.scene.body
        if self.scene.model != "gliding" or body.mu == 0:
            return "an auxiliary mu = 1 s/m, as the scene has none", Fraction(1)
        if not body.friction.smooth_at_rest:
            return "an auxiliary mu = 1 s/m, as Coulomb's law has none at v_A = 0", Fraction(1)
        return f"the scene's own {body.friction.at_rest}", friction.largest_coefficient(body, 0)

    def lambda_of_unit_momentum(self, side: int) -> Scalar:
        return QUANTITIES["lambda"].evaluate(self.steady_spin(side, 1))

    def steady_spin(self, side: int, momentum: Scalar) -> Motion:
        """The steady spin k = side z, L = momentum z."""
        state = NewtonState(0, 0, self.fn.mpf(side), 0, 0, self.fn.mpf(momentum), 0, 0)
        return Motion(self.top, state, self.fn)

    def asymptotic(self, name: str, side: int, value: Scalar) -> Determination:
        quantity = QUANTITIES[name]
        limit = self.steady_spin(side, self.lambda_start / self.lambda_of_unit_momentum(side))
        spin = "upright" if side == UPRIGHT else "inverted"
        return self.compare(
            value,
            quantity.evaluate(limit),
            f"value: the limits of section 1; independent: {name} of the vectors "
            f"of the {spin} spin that has the scene's lambda = -L.a",
            quantity.unit,
        )

    def gamma(self) -> Determination:
        state = EulerState(self.fn.mpf(1), self.fn.mpf(1), 0, self.fn.mpf(1), 0, 0)
        rate = euler.rates(self.top, state, self.fn)
        return self.compare(
            rounding_to(self.fn)(self.scene.body.gamma),
            state.theta_dot * state.omega_3 / (rate.phi_dot * self.fn.sin(state.theta)),
            "value: I1/I3; independent: the gyroscopic response "
            "theta_dot omega_3/(phi_ddot sin theta) of the equations of motion at phi_dot = nu = 0",
            "1",
        )

    def sigma(self) -> Determination:
        state = EulerState(self.fn.mpf(1), 0, 0, 0, 0, self.fn.mpf(1))
        sliding = replace(self.top, mu=self.fn.mpf(1))
        spin_up = euler.rates(sliding, state, self.fn).omega_3
        force = newton.contact_force(sliding, vectors_from_euler(sliding, state, self.fn))
        return self.compare(
            rounding_to(self.fn)(self.scene.body.sigma),
            sliding.m * sliding.R * spin_up / (force[1] * self.fn.sin(state.theta)),
            "value: m R^2/I3; independent: R omega_3_dot/(s_ddot_y sin theta), the response of "
            "spin (Euler form) and centre of mass (vectors) to friction, with mu = 1 s/m",
            "1",
        )

    def compare(self, value: Scalar, independent: Scalar, how: str, unit: str) -> Determination:
        if value is None or independent is None:
            agreed = None if value is independent else 0
        else:
            agreed = agreed_digits(value, independent, self.digits, self.fn)
        return Determination(value, independent, agreed, how, unit)


class Theorem(NamedTuple):
    """The verdict of Theorem 1.1 and stability on a scene, without integration.

    ``inverts`` is True if the condition of the theorem holds: the motion approaches the inverted
    spin while g_n > 0. ``inverts`` is False if the inverted spin is unstable or the start is a
    steady upright spin; the axis may pass the equator nevertheless. ``inverts`` is None if the
    theorem does not apply.
    """

    inverts: bool | None
    reason: str

    @property
    def verdict(self) -> str:
        """The verdict: "inverts", "does_not_invert" or "says_nothing"."""
        return VERDICTS[self.inverts]

    def __str__(self) -> str:
        return f"{IN_WORDS[self.verdict]}: {self.reason}"

    def as_dict(self) -> dict[str, Json]:
        """Return the fields of the JSON object."""
        return {"verdict": self.verdict, "reason": self.reason}


def inversion(
    scene: Scene, lambda_: Scalar, thresholds: tuple[Scalar, Scalar], on_table: bool, margin: Scalar
) -> Theorem:
    """Return whether the scene's motion tends to the inverted spin.

    Of ``thresholds`` lambda_thres is None where the inverted spin is unstable at every lambda,
    lambda_up where the upright spin is stable at every lambda; ``on_table`` says whether g_n > 0 at
    the start; lambdas closer than the relative ``margin`` to a threshold are undecided. The mirror
    image of a motion has -lambda and inverts when it does, so that only |lambda| counts.
    """
    lambda_thres, lambda_up = thresholds
    undecided, never = (partial(Theorem, answer) for answer in (None, False))
    if scene.model == "rolling" or scene.body.mu == 0:
        return undecided("Theorem 1.1 is about gliding with friction, which this scene lacks")
    if scene.body.spring:
        return undecided("Theorem 1.1 is about a rigid table")
    start = scene.start
    if start.theta.at_pole and not any((start.theta_dot, start.nu_x, start.nu_y)):
        if start.theta.from_pi:
            return undecided("starts as the inverted spin, a steady motion: nothing to invert")
        return never("starts as the upright spin, a steady motion that only a push ends")
    if not scene.body.friction.smooth_at_rest:
        return undecided("Theorem 1.1 is about friction that lets no top stick, as Coulomb's may")
    if not on_table:
        return undecided("Theorem 1.1 needs g_n > 0, which fails at the start")
    size = abs(lambda_)
    if lambda_thres is None:
        return never("gamma >= 1 + alpha: the inverted spin is unstable at every lambda")
    if abs(size - lambda_thres) <= margin * lambda_thres:
        return undecided("|lambda| = lambda_thres in all digits: the inverted spin is marginal")
    if size < lambda_thres:
        return never("|lambda| < lambda_thres: the inverted spin is unstable")
    both_stable = "upright and inverted spin are both stable, so the end depends on the start"
    if lambda_up is None:
        return undecided(f"gamma <= 1 - alpha: {both_stable}")
    if abs(size - lambda_up) <= margin * lambda_up:
        return undecided("|lambda| = lambda_up in all digits: the upright spin is marginal")
    if size < lambda_up:
        return undecided(f"lambda_thres < |lambda| < lambda_up: {both_stable}")
    condition = "1 - alpha < gamma < 1 + alpha and |lambda| > max(lambda_thres, lambda_up)"
    return Theorem(True, f"Theorem 1.1: {condition}")
