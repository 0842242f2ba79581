"""Sections 1 and 2.1: when the effective potential is a rational function of cos theta."""

from __future__ import annotations

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Check, Finding, misprint, statement
from tt_precise.mechanics.quantities import d
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import load_scene

PRINTED = "(1 - alpha)/(gamma + alpha**2 - 1)"
CORRECT = "(1 - gamma)/(gamma + alpha**2 - 1)"
NOTE = (
    "d(z) is a square exactly when its discriminant vanishes, which gives 1 - gamma where the "
    "paper prints 1 - alpha."
)


@claim(
    "EQ-26",
    quote="sigma=(1-alpha)/(gamma+alpha^2-1)",
    where="Sec. 1 and Sec. 2.1",
    definition="the condition under which d(z) is the square of a polynomial",
    control={"printed": CORRECT},
)
def rationality_condition(printed: str = PRINTED) -> Finding:
    """The printed relation of sigma, gamma and alpha makes d(z) a square."""
    return misprint(_square(printed), _square(CORRECT), f"sigma = {CORRECT}", NOTE, proved=True)


@claim(
    "EQ-27",
    quote="V(z,D(t),lambda) is a rational function of cos theta",
    where="Sec. 1",
    definition="for all lambda and D",
    control={"printed": CORRECT},
)
def rational_potential(printed: str = PRINTED) -> Finding:
    """V is a rational function of cos theta when the printed condition holds."""
    return misprint(
        _square(printed, f"V rational for sigma = {printed}"),
        _square(CORRECT, f"V rational for sigma = {CORRECT}"),
        f"V is rational for sigma = {CORRECT}",
        "V contains sqrt(d) once, in the product of lambda and D, and so is rational if and only "
        "if d is a square. " + NOTE,
        proved=True,
    )


@claim(
    "TH-19",
    quote="1-alpha^2<gamma<1 ... They satisfy the rationality condition",
    where="Sec. 2.1",
    control={"printed": CORRECT},
)
def toy_satisfies_the_condition(printed: str = PRINTED, scene: str = "reference") -> Finding:
    """The toy has 1 - alpha^2 < gamma < 1 and satisfies the printed rationality condition."""
    body = load_scene(scene).body
    gamma, sigma, alpha = body.gamma, body.sigma, body.alpha
    between = 1 - alpha**2 < gamma < 1

    def satisfied(text: str) -> Check:
        value = f.read(text, {"gamma": gamma, "alpha": alpha})
        both = f"m R^2/I3 = {decimal(sigma, 6)}, {text} = {decimal(value, 6)}"
        return statement(between and sigma == value, printed=f"m R^2/I3 = {text}", measured=both)

    return misprint(
        satisfied(printed),
        satisfied(CORRECT),
        f"m R^2/I3 = {CORRECT}",
        f"Exact: gamma = {gamma} lies between 1 - alpha^2 = {1 - alpha**2} and 1.",
        proved=True,
    )


def _square(text: str, shown: str = "") -> Check:
    """Whether d(z) is a square, that is, has a double root, when sigma is ``text``."""
    import sympy

    alpha, gamma, z = sympy.symbols("alpha gamma z", positive=True)
    sigma = f.read(text, {"gamma": gamma, "alpha": alpha})
    body: Any = SimpleNamespace(alpha=alpha, gamma=gamma, sigma=sigma)
    discriminant = sympy.discriminant(d(body, z), z)
    toy = load_scene("reference").body
    at_toy = discriminant.subs({alpha: _rational(toy.alpha), gamma: _rational(toy.gamma)})
    value = decimal(Fraction(str(at_toy)), 4)
    return statement(
        sympy.simplify(discriminant) == 0,
        printed=shown or f"sigma = {text}",
        measured=f"discriminant of d(z): {value} for the toy's alpha and gamma",
    )


def _rational(value: Fraction) -> Scalar:
    import sympy

    return sympy.Rational(value.numerator, value.denominator)
