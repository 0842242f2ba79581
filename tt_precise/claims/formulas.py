"""Printed formulas as text, and what the mechanics say in the same symbols.

A printed formula is a string in the paper's names, such as "R*I1*phi_dot*sin(theta)**2", so that
it can be read beside the paper and spoiled by a test. What it is compared with is derived from
the vectors of eq (1): ``upright_motion`` is the motion with symbols for its Euler state, and
``rate`` differentiates along the equations of motion with g_n as a symbol of its own.

``vanishes`` is a proof: the numerator of the difference is reduced to zero as a polynomial.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import cache
from typing import Any

import mpmath
import sympy
from sympy.parsing.sympy_parser import parse_expr

from tt_precise.body import Parameters
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Check, statement
from tt_precise.mechanics import newton
from tt_precise.mechanics.conversion import euler_from_vectors, vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion, d
from tt_precise.mechanics.vectors import Vector, added, cross, scaled

BODY = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
STATE = EulerState(*sympy.symbols("theta theta_dot phi_dot omega_3 nu_x nu_y", real=True))
BODY_SYMBOLS = tuple(getattr(BODY, field.name) for field in fields(Parameters))
G_N, LAMBDA, D_VALUE, Z = sympy.symbols("g_n lambda D z", real=True)
SINE, COSINE = sympy.symbols("s c", real=True)
ROOT = sympy.Symbol("root_d", positive=True)  # sqrt(d(cos theta))

# Where a difference is told in numbers: a toy-like top in a state without symmetry, SI. The angle
# has sin = 3/5.
POINT = {
    BODY.m: "0.021", BODY.R: "0.019", BODY.alpha: "0.31", BODY.I1: "2.9e-6", BODY.I3: "3.1e-6",
    BODY.g: "9.82", BODY.mu: "0.27", STATE.theta_dot: "7.3", STATE.phi_dot: "61", LAMBDA: "6.7e-6",
    STATE.omega_3: "113", STATE.nu_x: "-0.11", STATE.nu_y: "0.23", G_N: "0.17", D_VALUE: "5.1e-4",
    Z: "0.37",
}  # fmt: skip
DIGITS = 40

NAMES: dict[str, Any] = {
    **{name: getattr(BODY, name) for name in map(str, BODY_SYMBOLS)},
    **STATE._asdict(),
    "gamma": BODY.gamma,
    "sigma": BODY.sigma,
    "g_n": G_N,
    "lambda_": LAMBDA,
    "D": D_VALUE,
    "z": Z,
    "psi_dot": STATE.omega_3 - STATE.phi_dot * sympy.cos(STATE.theta),
    "d": lambda z: d(BODY, z),
}


def parse(text: str, **more: Any) -> Any:
    """The SymPy expression of a printed formula; ``more`` names further symbols."""
    return parse_expr(text, local_dict={**NAMES, **more})


def evaluate(text: str, body: Parameters, fn: Any, **values: Any) -> Any:
    """The value of a printed formula for a body in the mpmath context ``fn``."""
    expression = parse(text)
    numbers = {symbol: getattr(body, str(symbol)) for symbol in BODY_SYMBOLS}
    numbers |= {NAMES[name]: value for name, value in values.items()}
    used = sorted(expression.free_symbols, key=str)
    return sympy.lambdify(used, expression, modules=[{"sqrt": fn.sqrt}, fn])(
        *(numbers[symbol] for symbol in used)
    )


@cache
def upright_motion() -> Motion:
    """The motion with symbolic Euler state, in the plane of the lean (x-hat = X, y-hat = Y)."""
    vectors = vectors_from_euler(BODY, STATE, sympy)
    return Motion(BODY, vectors, sympy, euler=STATE)


@cache
def force() -> Vector:
    """F with the symbol g_n for the normal force."""
    return scaled(G_N, newton.force_per_normal(BODY, upright_motion().state))


@cache
def vector_rates() -> NewtonState:
    """Eq (1) at ``upright_motion``, with the symbol g_n for the normal force."""
    q = upright_motion()
    free, forced = newton.contact_acceleration_terms(BODY, q.state)
    v_dot = added(free, scaled(G_N, forced))
    torque = cross(q.a, force())
    return NewtonState(*newton.axis_rate(BODY, q.state), *torque, v_dot[0], v_dot[1])


@cache
def derived_normal_force() -> Any:
    """g_n from the constraint v_A.z = 0 differentiated once."""
    numerator, denominator = newton.contact_terms(BODY, upright_motion().state)
    return numerator / denominator


@cache
def euler_rates() -> EulerState:
    """The rates of the Euler state, derived from eq (1) by the chain rule; g_n is a symbol."""
    symbols = NewtonState(*sympy.symbols("kx ky kz Lx Ly Lz vx vy", real=True))
    here = dict(zip(symbols, upright_motion().state, strict=True))
    rates = []
    for entry in euler_from_vectors(BODY, symbols, sympy):
        slope = sum(
            sympy.diff(entry, symbol).subs(here) * rate
            for symbol, rate in zip(symbols, vector_rates(), strict=True)
        )
        rates.append(in_sine_and_cosine(slope))
    return EulerState(*rates)


def rate(expression: Any) -> Any:
    """The time derivative of an expression in the Euler state, along eq (1)."""
    return sum(
        sympy.diff(expression, symbol) * change
        for symbol, change in zip(STATE, euler_rates(), strict=True)
    )


def in_sine_and_cosine(expression: Any) -> Any:
    """sin theta > 0 and cos theta as the symbols s and c, with sqrt(s^2) = s."""
    theta = STATE.theta
    replaced = sympy.sympify(expression).subs(
        {sympy.sin(theta): SINE, sympy.cos(theta): COSINE, sympy.Abs(sympy.sin(theta)): SINE}
    )
    positive = sympy.Symbol("s", positive=True)
    back = {positive: sympy.sin(theta), COSINE: sympy.cos(theta)}
    return sympy.powdenest(replaced.subs(SINE, positive)).subs(back)


def equal(printed: str, truth: Any, *, shown: str = "", normal_force: bool = False) -> Check:
    """Whether a printed formula says what the mechanics say, for every body and state.

    ``normal_force`` puts the constraint's g_n in place of its symbol on both sides. A difference
    is told as a fraction of the larger side at one state without symmetry.
    """
    formula = parse(printed) if isinstance(printed, str) else printed
    if normal_force:
        formula, truth = (
            sympy.sympify(side).subs(G_N, derived_normal_force()) for side in (formula, truth)
        )
    return _compared(formula, truth, shown or printed)


def equal_vectors(printed: Sequence[Any], truth: Sequence[Any], *, shown: str) -> Check:
    """The same for vectors, entry by entry."""
    pairs = zip(map(sympy.sympify, printed), map(sympy.sympify, truth), strict=True)
    checks = [_compared(one, other, shown) for one, other in pairs]
    return next((check for check in checks if not check.holds), checks[0])


def _compared(formula: Any, truth: Any, shown: str) -> Check:
    holds = vanishes(formula - truth)
    left, right = value_at_point(formula), value_at_point(truth)
    size = max(abs(left), abs(right))
    off = abs(left - right) / size if size else size
    if holds != (off < mpmath.mpf(10) ** (10 - DIGITS)):
        raise ArithmeticError(f"{shown}: the proof says {holds}, numbers differ by {off}")
    told = "equal, for every body and state" if holds else f"off by {decimal(off, 3)} of its size"
    return statement(holds, printed=shown, measured=told)


def value_at_point(expression: Any) -> Any:
    """An expression at ``POINT``, as an mpmath number of ``DIGITS`` digits."""
    exact = {symbol: sympy.Rational(text) for symbol, text in POINT.items()}
    theta = {STATE.theta: sympy.asin(sympy.Rational(3, 5))}
    with mpmath.workdps(DIGITS + 10):
        return mpmath.mpf(str(sympy.sympify(expression).subs(theta).subs(exact).evalf(DIGITS)))


def vanishes(expression: Any) -> bool:
    """Whether an expression is zero at every state of every body: a proof, not a sample.

    sin theta, cos theta and sqrt(d(cos theta)) become symbols, and the numerator is reduced as a
    polynomial with sin^2 = 1 - cos^2 and the square of the root.
    """
    theta = STATE.theta
    rooted = sympy.sympify(expression).replace(
        lambda part: part.is_Pow and abs(part.exp) == sympy.Rational(1, 2),
        lambda part: _root(part),
    )
    plain = rooted.subs(
        {sympy.sin(theta): SINE, sympy.cos(theta): COSINE, sympy.tan(theta): SINE / COSINE}
    )
    if plain.has(theta):
        raise ValueError(f"cannot reduce {plain}: theta is left over")
    numerator = sympy.fraction(sympy.together(plain))[0]
    square = d(BODY, COSINE) * BODY.I3**2
    relations = [SINE**2 + COSINE**2 - 1, ROOT**2 - sympy.expand(square)]
    generators = (ROOT, SINE, COSINE)
    remainder = sympy.reduced(
        sympy.expand(numerator), [sympy.expand(one) for one in relations], *generators
    )[1]
    return bool(sympy.expand(remainder) == 0)


def _root(part: Any) -> Any:
    square = BODY.I3**2 * d(BODY, sympy.cos(STATE.theta))
    ratio = sympy.simplify(part.base / square)
    if ratio.has(STATE.theta):
        return part
    return (ROOT * sympy.sqrt(ratio)) ** sympy.sign(part.exp)
