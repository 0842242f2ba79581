"""Marginal spins: from the linearised equations alone, for ordinary and for extreme tops."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from tests.conftest import top
from tt_precise.exact.arithmetic import agreed_digits, own_context, rounding_to
from tt_precise.exact.stability import (
    INVERTED,
    UPRIGHT,
    Eigenvalue,
    UnresolvedError,
    eigenvalues,
    fineness,
    linearised,
    marginal_spin,
    narrow_crossing,
)
from tt_precise.mechanics import newton, thresholds
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.quantities import ANGULAR_MOMENTUM
from tt_precise.scene.body import TippeTop

SIDES = pytest.mark.parametrize("side", [UPRIGHT, INVERTED])


def expected(body: TippeTop, side: int, context: Any) -> Any:
    """The spin of the paper's threshold."""
    numbers = body.numbers(rounding_to(context))
    if side == UPRIGHT:
        return thresholds.L0(numbers, thresholds.lambda_up(numbers, context))
    return thresholds.L1(numbers, thresholds.lambda_thres(numbers, context))


def test_eigenvalues_of_a_known_matrix() -> None:
    context = own_context(40)
    exact = [context.mpc(-3, 1), context.mpc(2, -5), context.mpc(0, 4)]
    matrix = [[exact[0], 7, context.mpc(0, 3)], [0, exact[1], 2 + 2j], [0, 0, exact[2]]]
    found = eigenvalues(matrix, context.mpf(10) ** -30, context)
    for one, truth in zip(found, [exact[1], exact[2], exact[0]], strict=True):
        assert abs(one.value - truth) < context.mpf(10) ** -37
        assert 0 < one.error < context.mpf(10) ** -25
    assert [found[0].sign(), found[2].sign()] == [1, -1]
    with pytest.raises(ArithmeticError):
        found[1].sign()


def test_the_error_of_each_eigenvalue_is_that_of_its_own_place() -> None:
    """To first order, by the slope of the polynomial: the product of the distances to the others.

    Roots at very different distances, so that no other pair of them would do.
    """
    context = own_context(40)
    roots = [context.mpc(0), context.mpc(1), context.mpc(100)]
    error = context.mpf(10) ** -30
    matrix = [[root if root == column else 0 for column in roots] for root in roots]
    found = {round(float(one.value.real)): one.error for one in eigenvalues(matrix, error, context)}
    for root in roots:
        slope = context.fprod(abs(root - other) for other in roots if other != root)
        expected = 100 * context.mpf(100) ** 3 * error / slope
        assert abs(found[round(float(root.real))] / expected - 1) < 1e-20


@pytest.mark.parametrize(
    ("real", "error", "sign"),
    [
        ("1", "0.999999", 1),
        ("-1", "0.999999", -1),
        ("1", "1", None),
        ("-1", "1", None),
        ("nan", "0", None),
        ("1", "nan", None),
    ],
)
def test_a_sign_within_its_error_is_not_resolved(real: str, error: str, sign: int | None) -> None:
    context = own_context(20)
    one = Eigenvalue(context.mpc(real, 5), context.mpf(error))
    if sign:
        assert one.sign() == sign
    else:
        with pytest.raises(ArithmeticError):
            one.sign()


def test_the_signs_beside_a_crossing_are_looked_at() -> None:
    """At the crossing and a width on either side of it, of the eigenvalue that leads."""
    context = own_context(30)
    width, seen = context.mpf(10) ** -20, []

    def spectrum(gravity: Any) -> list[Eigenvalue]:
        seen.append(gravity)
        return [Eigenvalue(context.mpc(context.log(gravity / 2)), context.mpf(10) ** -28)]

    found = narrow_crossing(spectrum, context.mpf("0.3"), context.mpf(7), width, context)
    assert abs(found / 2 - 1) < width
    assert sorted(seen[-2:]) == [found * (1 - width), found * (1 + width)]

    def leading(gravity: Any) -> list[Eigenvalue]:
        # from 1.9 on another one leads, and decides
        other = 1 if gravity > 1.9 else -1
        values = (context.mpc(other), context.log(gravity / 2) + 0j)
        return [Eigenvalue(value, context.mpf(10) ** -28) for value in values]

    with pytest.raises(UnresolvedError):
        narrow_crossing(leading, context.mpf("1.85"), context.mpf("2.1"), width, context)


@SIDES
@pytest.mark.parametrize("mu", [None, "0.3", "300", "1e-12"])
def test_threshold_does_not_depend_on_friction(side: int, mu: str | None) -> None:
    context = own_context(60)
    friction = None if mu is None else Fraction(mu)
    found = marginal_spin(top(), side, 45, context, friction)
    assert found.exists
    assert agreed_digits(found.spin, expected(top(), side, context), 60, context) >= 45


@SIDES
@pytest.mark.parametrize(
    "changes",
    [
        {"alpha": "0.9", "I1": "0.3", "I3": "0.3"},
        {"I1": "0.2801", "I3": "0.4"},  # gamma just above 1 - alpha
        {"I1": "0.5199999999", "I3": "0.4"},  # gamma just below 1 + alpha
        {"alpha": "0.000001", "I1": "0.4", "I3": "0.4"},
        {"alpha": "0.999999", "I1": "0.4", "I3": "0.4"},
        {"I1": "3.7e-9", "I3": "4e-9"},
        {"I1": "3.7e9", "I3": "4e9"},
        {"m": "1e9", "R": "1e-9", "g": "1e6"},
    ],
)
def test_thresholds_of_extreme_tops(side: int, changes: dict[str, str]) -> None:
    body, context = top(**changes), own_context(50)
    found = marginal_spin(body, side, 20, context)
    assert agreed_digits(found.spin, expected(body, side, context), 50, context) >= 20


@pytest.mark.parametrize(
    ("I1", "side"),
    [  # gamma = 1 + alpha and 1 - alpha exactly, and beyond
        ("0.52", INVERTED),
        ("0.5200000001", INVERTED),
        ("5", INVERTED),
        ("0.28", UPRIGHT),
        ("0.2799999999", UPRIGHT),
        ("0.2", UPRIGHT),
    ],
)
@pytest.mark.parametrize("mu", [None, Fraction(1)])
def test_where_no_spin_is_marginal(I1: str, side: int, mu: Fraction | None) -> None:
    found = marginal_spin(top(I1=I1), side, 30, own_context(40), mu)
    assert (found.exists, found.spin) == (False, None)
    verb = "grow" if side == INVERTED else "decay"
    assert f"perturbations {verb} at every omega_3^2 R/g" in found.reason


def test_what_is_too_fine_is_left_undecided() -> None:
    found = marginal_spin(top(alpha="1e-100"), INVERTED, 20, own_context(30))
    assert (found.exists, found.spin) == (None, None)
    assert "not searched" in found.reason


@SIDES
def test_upright_loses_and_inverted_gains_stability_with_spin(side: int) -> None:
    """The sign that names the two thresholds: lambda_up is the upright one, lambda_thres not."""
    context = own_context(50)
    body = top().dimensionless(context, rounding_to(context))
    unit = Units.of(top(), context, rounding_to(context)).of_dimension(ANGULAR_MOMENTUM)
    spin = marginal_spin(top(), side, 20, context).spin
    for factor, grows in (("0.99", side == INVERTED), ("1.01", side == UPRIGHT)):
        omega_3 = spin * context.mpf(factor) / unit / body.I3
        # omega_3 = 1 with gravity 1/omega_3^2, and the friction coefficient scaled alike.
        gravity = 1 / omega_3**2
        numbers = Parameters(1, 1, body.alpha, body.I1, body.I3, gravity, body.mu * omega_3)
        matrix = linearised(numbers, side, context.mpf(10) ** -15, context)
        fastest = eigenvalues(matrix, context.mpf(10) ** -28, context)[0]
        assert (fastest.sign() > 0) is grows


@SIDES
def test_a_spoiled_equation_moves_the_threshold(side: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The torque on the axis off by 1e-30 of itself: the last digits no longer agree."""
    rates: Callable[..., NewtonState] = newton.rates

    def spoiled(body: Parameters, state: NewtonState, fn: Any = None) -> NewtonState:
        rate = rates(body, state, fn)
        return rate._replace(Lx=rate.Lx + rate.Lx / 10**30, Ly=rate.Ly + rate.Ly / 10**30)

    monkeypatch.setattr(newton, "rates", spoiled)
    context = own_context(60)
    found = marginal_spin(top(), side, 45, context)
    assert 25 <= agreed_digits(found.spin, expected(top(), side, context), 60, context) <= 31


def test_fineness_grows_with_the_digits_of_the_parameters() -> None:
    assert fineness(top()) < fineness(top(alpha="0.3000000000000001"))
    assert fineness(top()) < fineness(top(), Fraction(1, 10**20))
