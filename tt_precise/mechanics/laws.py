"""Friction laws as values: F_f = -c g_n v_A with a coefficient c (s/m) that each law defines.

A law is one entry of ``LAWS``: its parameters, its coefficient as a function that is generic in the
arithmetic, the elementary functions in it, and the properties of its form. Eqs (1) to (7) are
algebraic in mu, so with c for mu they are the equations of motion under every law.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from tt_precise.runtime.values import Functions, InputError, Scalar, require_name


class Parameter(NamedTuple):
    """A parameter of a law: its key, its unit as a power of a speed, and its range."""

    name: str
    speeds: int  # -1 for s/m, 0 for a pure number, 1 for m/s
    positive: bool = False  # otherwise at least 0
    usual: tuple[str, str] | tuple[()] = ()  # the range in which test vectors draw

    @property
    def unit(self) -> str:
        """The SI unit."""
        return {-1: "s/m", 0: "1", 1: "m/s"}[self.speeds]


@dataclass(frozen=True)
class Law:
    """A friction law.

    ``coefficient(square, fn, mu, ...)`` is c at v_A^2 = ``square``, and ``largest(speed, mu, ...)``
    a bound on c at all speeds of at least ``speed``; both take the values of ``parameters`` in
    order. ``functions`` are the elementary functions in the coefficient. The coefficient of a
    ``constant`` law does not depend on the state. A law that is not ``smooth_at_rest`` lets a top
    stick: the motion has several segments. ``force`` is the formula of the force, ``scene`` a
    shipped scene with this law, ``at_rest`` c(0) in words. Test vectors contain the laws that are
    ``in_vectors``, with parameters in their usual ranges.
    """

    name: str
    parameters: tuple[Parameter, ...]
    coefficient: Callable[..., Scalar]
    largest: Callable[..., Scalar]
    force: str
    scene: str
    functions: tuple[str, ...] = ()
    constant: bool = False
    smooth_at_rest: bool = True
    in_vectors: bool = False
    at_rest: str = ""
    check: Callable[..., None] = lambda *values: None

    def __reduce__(self) -> tuple[Callable[[str], Law], tuple[str]]:
        return law_named, (self.name,)  # each law is there once

    @property
    def further(self) -> tuple[str, ...]:
        """Names of the parameters after mu."""
        return tuple(parameter.name for parameter in self.parameters[1:])

    def missing(self, fn: Functions) -> list[str]:
        """The functions of the coefficient that an arithmetic lacks."""
        return [name for name in self.functions if not hasattr(fn, name)]


def _stribeck(
    square: Scalar, fn: Functions, mu: Scalar, mu_s: Scalar, v_s: Scalar, epsilon: Scalar
) -> Scalar:
    """(mu + (mu_s - mu) exp(-(v/v_s)^2))/sqrt(v^2 + epsilon^2).

    Stribeck's curve with a Gaussian fall from static to kinetic friction (Armstrong-Helouvry,
    Dupont and Canudas de Wit, Automatica 30, 1994, section 2.2.2, delta = 2), regularised at rest
    as Coulomb's law is.
    """
    fall = fn.exp(-(square / (v_s * v_s)))
    return (mu + (mu_s - mu) * fall) / fn.sqrt(square + epsilon * epsilon)


def _check_stribeck(mu: Fraction, mu_s: Fraction, v_s: Fraction, epsilon: Fraction) -> None:
    if mu_s < mu:
        raise InputError(
            f"mu_s: got {float(mu_s):g}, expected at least mu = {float(mu):g}: friction falls from "
            "mu_s at rest to mu at speed"
        )


USUAL_MU = "0.1", "0.6"
DIMENSIONLESS_MU = Parameter("mu", 0, usual=USUAL_MU)
EPSILON = Parameter("epsilon", 1, positive=True, usual=("0.001", "0.1"))
_ALL = (
    Law(
        "viscous", (Parameter("mu", -1, usual=USUAL_MU),),
        coefficient=lambda square, fn, mu: mu,
        largest=lambda speed, mu: mu,
        force="F_t = -mu g_n v_A", scene="reference",
        constant=True, at_rest="mu", in_vectors=True,
    ),
    Law(
        "regularised", (DIMENSIONLESS_MU, EPSILON),
        coefficient=lambda square, fn, mu, epsilon: mu / fn.sqrt(square + epsilon * epsilon),
        largest=lambda speed, mu, epsilon: mu / epsilon,
        force="F_t = -mu g_n v_A / sqrt(v_A^2 + epsilon^2)", scene="regularised-1e-2",
        functions=("sqrt",), at_rest="mu/epsilon", in_vectors=True,
    ),
    Law(
        "coulomb", (DIMENSIONLESS_MU,),
        coefficient=lambda square, fn, mu: mu / fn.sqrt(square),
        largest=lambda speed, mu: mu / speed,
        force="F_t = -mu g_n v_A / |v_A| while the contact glides", scene="coulomb-gliding",
        functions=("sqrt",), smooth_at_rest=False, in_vectors=True,
    ),
    Law(
        "stribeck",
        (DIMENSIONLESS_MU, Parameter("mu_s", 0), Parameter("v_s", 1, positive=True), EPSILON),
        coefficient=_stribeck,
        largest=lambda speed, mu, mu_s, v_s, epsilon: mu_s / epsilon,
        force="F_t = -(mu + (mu_s - mu) exp(-(v_A/v_s)^2)) g_n v_A / sqrt(v_A^2 + epsilon^2)",
        scene="stribeck",
        functions=("sqrt", "exp"), at_rest="mu_s/epsilon", check=_check_stribeck,
    ),
)  # fmt: skip
LAWS = {law.name: law for law in _ALL}
VISCOUS, REGULARISED, COULOMB = (LAWS[name] for name in ("viscous", "regularised", "coulomb"))


def law_named(name: str) -> Law:
    """Return the law of this name.

    Raises ``InputError``: there is no such law.
    """
    require_name("friction.law", name, LAWS)
    return LAWS[name]
