"""Printed formulas as text, and their comparison with the mechanics.

A printed formula is a string in the paper's names, such as "R*I1*phi_dot*sin(theta)**2". The string
can be compared with the paper, falsified by a test, and evaluated in any arithmetic. ``equal``
compares the formula with the mechanics on the symbols of ``exact.chart``: a proof for every body
and state. If the two differ, ``equal`` shows the difference at one state in exact rational numbers.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from tt_precise.claims.part import Part, decimal, formula, statement
from tt_precise.exact.chart import EulerChart
from tt_precise.exact.identities import prove
from tt_precise.mechanics import euler, newton, rolling
from tt_precise.mechanics.euler import vectors_from_euler
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import NAMES, Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, d
from tt_precise.mechanics.rolling import RollingEulerState
from tt_precise.mechanics.vectors import cross, dot, scaled
from tt_precise.runtime.values import Functions, Scalar

# A state without symmetry at which everything, including the root in Routh's function, is rational;
# in consistent units with m, R, g all different from 1, so that a missing factor shows.
POINT = {
    "m": "4", "R": "1/2", "alpha": "3/10", "I1": "711/1900", "I3": "2/5", "g": "7/3",
    "mu": "27/100", "s": "3/5", "c": "4/5", "S": "0", "C": "1", "q": "31/50", "phi": "0",
    "theta": "0", "theta_dot": "11/5", "phi_dot": "17/3", "omega_3": "23/2", "nu_x": "-13/10",
    "nu_y": "19/10",
}  # fmt: skip
AT_POINT = "at a state with " + ", ".join(f"{name} = {POINT[name]}" for name in ("m", "R", "g"))


@cache
def chart() -> EulerChart:
    """The symbols of body and state."""
    return EulerChart()


@cache
def motion() -> Motion:
    """The motion with symbolic Euler state, in the plane of the tilt (x-hat = X, y-hat = Y)."""
    symbols = chart()
    vectors = vectors_from_euler(symbols.body, symbols.state, symbols)
    return Motion(symbols.body, vectors, symbols, euler=symbols.state)


@cache
def vector_rates() -> NewtonState:
    """Eq (1) at ``motion()``."""
    return newton.rates(chart().body, motion().state)


def quantity(name: str) -> Scalar:
    """A quantity of the mechanics in the symbols."""
    return QUANTITIES[name].evaluate(motion())


@cache
def rate_of(name: str) -> Scalar:
    """The time derivative of a quantity along the motion."""
    return rate(quantity(name))


def rate(value: Scalar) -> Scalar:
    """Time derivative of a scalar in the symbols, along the Euler form (proved to be eq (1))."""
    symbols = chart()
    return symbols.along(value, euler.rates(symbols.body, symbols.state, symbols))


@cache
def rolling_rate(name: str) -> Scalar:
    """The time derivative of a quantity of the rolling top, v_A = 0, along its own equations."""
    symbols = chart()
    here = RollingEulerState(*symbols.state[:4])
    still = symbols.state._replace(nu_x=symbols.field.zero, nu_y=symbols.field.zero)
    vectors = vectors_from_euler(symbols.body, still, symbols)
    value = QUANTITIES[name].evaluate(Motion(symbols.body, vectors, symbols, euler=still))
    return symbols.along(value, rolling.euler_rates(symbols.body, here, symbols))


@cache
def names() -> Mapping[str, Scalar]:
    """The symbols for the names in a printed formula."""
    symbols = chart()
    words = _words(symbols.body, symbols) | symbols.state._asdict()
    words["psi_dot"] = quantity("psi_dot")
    words["g_n"] = newton.normal_force(symbols.body, motion().state)
    return words


def parse(text: str, values: Mapping[str, Scalar] | None = None) -> Scalar:
    """The value of a printed formula, in the symbols or with the ``values`` of its names."""
    code = compile(text, "<printed formula>", "eval")
    return eval(code, {"__builtins__": {}}, dict(names() if values is None else values))


def evaluate(text: str, body: Parameters, fn: Functions, **values: Scalar) -> Scalar:
    """The value of a printed formula for a body in the arithmetic ``fn``."""
    return parse(text, _words(body, fn) | values)


def equal(printed: Scalar, truth: Scalar, equation: str = "") -> Part:
    """Compare a printed formula (text or symbols) with ``truth`` for every body and state.

    ``equation`` is the whole statement as a formula. A difference is given as a share of the larger
    side at ``POINT``. Both results are proofs: an identity, or a state that contradicts it.
    """
    element = parse(printed) if isinstance(printed, str) else printed
    equation = re.sub(r"\blambda_\b", "lambda", equation or str(printed))
    left, right = at_point(element), at_point(truth)
    if left != right:
        off = 100 * abs(left - right) / max(abs(left), abs(right))
        return formula(False, equation, f"off by {decimal(off, 3)} % {AT_POINT}", proved=True)
    if not chart().equal(element, truth):
        raise ArithmeticError(f"{equation}: unequal, but equal at POINT; choose another one")
    return formula(True, equation, "equal, for every body and state", proved=True)


def equal_vectors(printed: Sequence[Scalar], truth: Sequence[Scalar], equation: str) -> Part:
    """Compare vectors: the first component that differs, if any, decides."""
    parts = [
        equal(component, exact, equation) for component, exact in zip(printed, truth, strict=True)
    ]
    return next((part for part in parts if not part.holds), parts[0])


@cache
def identity(printed: str, derived: str, equation: str) -> Part:
    """Compare two formulas in the words of ``vocabulary``; scalars or vectors.

    The result is cached: a control changes one part of a claim and reuses the other parts.
    """
    left, right = (parse(side, vocabulary()) for side in (printed, derived))
    compare = equal_vectors if isinstance(right, tuple) else equal
    return compare(left, right, equation)


@cache
def vocabulary() -> Mapping[str, Any]:
    """The names of a formula with vectors, rates and functions of the state."""
    q, rates = motion(), vector_rates()
    F = q.force
    return {
        **names(), "dot": dot, "cross": cross, "scaled": scaled, "s_dot": q.s_dot,
        "v_A": q.state.v, "v_A_dot": (rates.vx, rates.vy, 0), "omega": q.omega, "a": q.a,
        "axis": q.k, "axis_dot": (rates.kx, rates.ky, rates.kz), "L": q.state.L,
        "L_dot": (rates.Lx, rates.Ly, rates.Lz), "F": F, "F_f": (F[0], F[1], 0),
        "tau": q.torque, "z_hat": (0, 0, 1), "z": chart().c, "D": quantity("D"),
        "lambda_": quantity("lambda"), "quantity": quantity, "rate": rate,
        "rate_of": rate_of, "rolling_rate": rolling_rate,
    }  # fmt: skip


@cache
def prove_identity(identity: str) -> Part:
    """A statement about the mechanics that ``exact.identities`` proves."""
    proof = prove(identity)
    outcome = "proved" if proof.holds else f"fails in {len(proof.failed)} of {proof.residuals}"
    return statement(proof.holds, "", f"{proof.identity.statement} ({outcome})", proved=True)


def at_point(element: Scalar) -> Fraction:
    """The exact value of an element at ``POINT``."""
    symbols = chart()
    element, rational = symbols.field(element), symbols.field.domain
    exact = [Fraction(POINT[str(symbol)]) for symbol in symbols.field.symbols]
    values = [rational(value.numerator, value.denominator) for value in exact]
    value = element.numer(*values) / element.denom(*values)
    return Fraction(int(rational.numer(value)), int(rational.denom(value)))


def _words(body: Parameters, fn: Functions) -> dict[str, Scalar]:
    return {
        **{name: getattr(body, name) for name in NAMES},
        "gamma": body.gamma,
        "sigma": body.sigma,
        "d": lambda z: d(body, z),
        **{name: getattr(fn, name) for name in ("sin", "cos", "sqrt")},
    }
