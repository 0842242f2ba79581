"""Marginal spins from the linearised equations alone, and the count of digits that agree."""

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from typing import Any

import mpmath
import numpy
import pytest
from gmpy2 import mpq

from tests.conftest import top
from tt_precise.exact import stability
from tt_precise.exact.stability import INVERTED, UPRIGHT, agreed_digits, own_context, rounding_to
from tt_precise.mechanics import newton, thresholds
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.scene.body import TippeTop

SIDES = pytest.mark.parametrize("side", [UPRIGHT, INVERTED])


def threshold_spin(body: TippeTop, side: int, context: Any) -> Any:
    """The spin of the paper's threshold."""
    numbers = body.numbers(rounding_to(context))
    if side == UPRIGHT:
        return thresholds.L0(numbers, thresholds.lambda_up(numbers, context))
    return thresholds.L1(numbers, thresholds.lambda_thres(numbers, context))


def matrix_with(*roots: complex) -> list[list[stability.Complex]]:
    """A full matrix of integers with these eigenvalues."""
    basis = numpy.array([[1, 0, 0], [2, 1, 0], [-1, 3, 1]])
    triangle = numpy.diag(roots) + numpy.triu(numpy.full((3, 3), 7 - 3j), 1)
    full = (basis @ triangle @ numpy.linalg.inv(basis)).round()
    return [[stability.Complex(int(z.real), int(z.imag)) for z in row] for row in full]


def test_hurwitz_of_known_eigenvalues() -> None:
    for roots in product((-90 + 1j, -1 - 5j, 2j, 1 - 7j, 2 + 40j), repeat=3):
        matrix, rates = matrix_with(*roots), [root.real for root in roots]
        assert stability.is_stable(matrix) is (max(rates) < 0)
        assert (stability.hurwitz(matrix)[2] == 0) is (0 in rates)


def test_derivatives_of_quotients_and_of_the_equations() -> None:
    x, body = stability.Tangent(2, Fraction(5)), top().numbers(mpq)
    assert ((stability.Tangent(3, 1) / x).derivative, (6 / x).derivative) == (-3.25, -7.5)
    turning = stability.linearised(body, UPRIGHT, mpq(7))[0][0]
    assert (turning.re, turning.im) == (0, 7 * body.I3 / body.I1)


@SIDES
@pytest.mark.parametrize("mu", [None, "0.3", "300", "1e-12", "1e-300"])
def test_the_threshold_does_not_depend_on_friction(side: int, mu: str | None) -> None:
    context = own_context(60)
    friction = None if mu is None else Fraction(mu)
    marginal = stability.marginal_momentum(top(), side, 45, context, friction)
    assert agreed_digits(marginal.momentum, threshold_spin(top(), side, context), 60, context) >= 45


@SIDES
@pytest.mark.parametrize(
    "changes",
    [
        {"alpha": "0.9", "I1": "0.3", "I3": "0.3"},
        {"I1": "0.2801", "I3": "0.4"},  # gamma just above 1 - alpha
        {"I1": "0.5199999999", "I3": "0.4"},  # gamma just below 1 + alpha
        {"alpha": "1e-100", "I1": "0.4", "I3": "0.4"},
        {"alpha": "0.999999", "I1": "0.4", "I3": "0.4"},
        {"I1": "3.7e-9", "I3": "4e-9"},
        {"I1": "3.7e9", "I3": "4e9"},
        {"m": "1e9", "R": "1e-9", "g": "1e6"},
    ],
)
def test_thresholds_of_extreme_tops(side: int, changes: dict[str, str]) -> None:
    body, context = top(**changes), own_context(150)
    spin = stability.marginal_momentum(body, side, 20, context).momentum
    assert agreed_digits(spin, threshold_spin(body, side, context), 50, context) >= 20


@pytest.mark.parametrize(
    ("I1", "side"),
    [  # gamma = 1 + alpha and 1 - alpha exactly, and beyond
        ("0.52", INVERTED),
        ("0.5200000001", INVERTED),
        ("5", INVERTED),
        ("0.28", UPRIGHT),
        ("0.2799999999", UPRIGHT),
    ],
)
@pytest.mark.parametrize("mu", [None, Fraction(1)])
def test_where_no_spin_is_marginal(I1: str, side: int, mu: Fraction | None) -> None:
    marginal = stability.marginal_momentum(top(I1=I1), side, 30, own_context(40), mu)
    assert marginal.momentum is None
    assert ("grow" if side == INVERTED else "decay") in marginal.reason


@SIDES
def test_upright_loses_and_inverted_gains_stability_with_spin(side: int) -> None:
    """The sign that names the two thresholds: lambda_up is the upright one, lambda_thres not."""
    context = own_context(30)
    body = top().numbers(rounding_to(context))
    marginal = stability.marginal_momentum(top(), side, 20, context).momentum / body.I3
    for factor, stable in (("0.99", side == UPRIGHT), ("1.01", side == INVERTED)):
        assert (
            stability.is_stable(stability.linearised(body, side, marginal * context.mpf(factor)))
            is stable
        )


@SIDES
def test_a_spoiled_equation_moves_the_threshold(side: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A torque that is off by 1e-30 of itself: the last digits no longer agree."""
    rates: Callable[..., NewtonState] = newton.rates

    def spoiled(body: Parameters, state: NewtonState, fn: Any = None) -> NewtonState:
        rate = rates(body, state, fn)
        return rate._replace(Lx=rate.Lx + rate.Lx / 10**30, Ly=rate.Ly + rate.Ly / 10**30)

    monkeypatch.setattr(newton, "rates", spoiled)
    context = own_context(60)
    spin = stability.marginal_momentum(top(), side, 45, context).momentum
    assert 25 <= agreed_digits(spin, threshold_spin(top(), side, context), 60, context) <= 31


def test_a_zero_without_a_change_of_stability_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    zero = stability._zero
    monkeypatch.setattr(stability, "_zero", lambda f, a, b, grid: zero(f, a, b, grid) * 101 / 100)
    with pytest.raises(ArithmeticError, match="no change of stability"):
        stability.marginal_momentum(top(), INVERTED, 20, own_context(30))


def test_a_context_leaves_the_global_one_alone() -> None:
    before = mpmath.mp.dps
    one, other = own_context(30), own_context(70)
    assert (one.dps, other.dps, mpmath.mp.dps) == (30, 70, before)
    assert stability.decimal(other.mpf(5) / 2, 10, other) == "2.500000000"


@pytest.mark.parametrize(
    ("a", "b", "digits"),
    [
        ("1", "1", 50),
        ("1", "1 - 1e-60", 50),
        ("1", "1 - 2e-40", 39),
        ("1", "1 - 9e-41", 40),
        ("1", "-0.5", 0),
        ("0", "0", 50),
        ("0", "1e-300", 0),
        ("nan", "1", 0),
        ("inf", "1", 0),
    ],
)
def test_agreed_digits(a: str, b: str, digits: int) -> None:
    context = own_context(80)
    one, other = (
        context.fsum(context.mpf(term) for term in text.replace("- ", "-").split())
        for text in (a, b)
    )
    assert agreed_digits(one, other, 50, context) == digits
    assert agreed_digits(other, one, 50, context) == digits
