"""Taylor models, derivatives and power series, against exact arithmetic."""

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

import flint
import pytest
from flint import arb, arb_poly, arb_series, fmpq

from tests.certify.harness import Mutant
from tests.certify.mutants import assert_noticed, mutants_of
from tt_precise.certify.balls import ball, bounds
from tt_precise.certify.models import Frame, PowerSeries, Rates, TaylorModel, solution

END = Fraction(1, 6)
BITS = 100


def contains(model: TaylorModel, s: Fraction, value: Fraction) -> bool:
    low, high = bounds(model.p(ball(s)))
    return low <= value <= high


def polynomial(coefficients: list[Fraction]) -> arb_poly:
    return arb_poly([arb(fmpq(c.numerator, c.denominator)) for c in coefficients])


def at(coefficients: list[Fraction], s: Fraction) -> Fraction:
    return sum((c * s**k for k, c in enumerate(coefficients)), start=Fraction(0))


@pytest.fixture
def frame() -> Iterator[Frame]:
    with flint.ctx.workprec(BITS):
        yield Frame(ball(END), 8)


@pytest.mark.parametrize("seed", range(20))
def test_model_arithmetic_contains_exact_values(frame: Frame, seed: int) -> None:
    dice = random.Random(seed)
    a, b = ([Fraction(dice.randint(-99, 99), 70) for _ in range(9)] for _ in range(2))
    b[0] = Fraction(3) + abs(b[0])
    f, g = TaylorModel(polynomial(a), frame), TaylorModel(polynomial(b), frame)
    for s in (Fraction(0), END / 3, END):
        x, y = at(a, s), at(b, s)
        for model, value in (
            (f * f * g - f, x * x * y - x), (2 - f * g / 3, 2 - x * y / 3),
            (1 / (g * g), 1 / (y * y)), ((g * g).sqrt(), y),
        ):  # fmt: skip
            assert contains(model, s, value)
            assert model.p.degree() <= 8
        assert f.exp().p(ball(s)).overlaps(ball(x).exp())


def test_a_model_without_what_was_cut_off_would_be_wrong(frame: Frame) -> None:
    """The control of the test above: the tail matters."""
    ones = [Fraction(1)] * 9
    product = polynomial(ones) * polynomial(ones)
    careless = TaylorModel(product.truncate(9), frame)
    assert not contains(careless, END, at(ones, END) ** 2)
    assert contains(Frame(arb(2), 8).cut(product), Fraction(2), at(ones, Fraction(2)) ** 2)


def test_derivatives_of_a_right_hand_side() -> None:
    x, y = (fmpq(n, d) for n, d in ((3, 7), (-5, 11)))

    def rates(state: Sequence[Any]) -> list[Any]:
        a, b = state
        f = (a * a * b - 2 * b + 1) / (3 - a * b) - 1 / (b - 4) + 0 * a + (a - a) + b * b / 3
        return [f, fmpq(7)]

    f, constant = Rates(rates, 2).derivatives([x, y], [0, 1])
    u, v = x * x * y - 2 * y + 1, 3 - x * y
    assert f.value == u / v - 1 / (y - 4) + y * y / 3
    assert f.slopes[0] == (2 * x * y * v + u * y) / v**2
    of_v = ((x * x - 2) * v + u * x) / v**2
    assert f.slopes[1] == of_v + 1 / (y - 4) ** 2 + 2 * y / 3
    assert constant == (7, {})


def test_derivatives_of_a_root_and_of_an_exponential() -> None:
    with flint.ctx.workprec(BITS):
        both = Rates(lambda y: [(5 * y[0]).sqrt(), (5 * y[0]).exp()], 1)
        root, power = both.derivatives([arb(9) / 20], [0])
        assert root.value.contains(arb(3) / 2)
        assert root.slopes[0].contains(arb(5) / 3)
        assert power.slopes[0].overlaps(5 * (arb(9) / 4).exp())


def test_power_series_are_those_of_closed_forms() -> None:
    with flint.ctx.workprec(BITS):
        x = PowerSeries(lambda c, n: arb(0), [*map(arb, (4, 1, -3, 2, 5))])
        known, t = arb_series(x.upto(6), 7), arb_series([0, 1], 7)
        sine, _, line = solution(lambda y: [y[1], -y[0], arb(3)], [arb(0), arb(1), arb(2)])
        for series, expected in (
            (1 / x, 1 / known), (x.sqrt(), known.sqrt()), (x.exp(), known.exp()),
            (sine, t.sin()), (line, 2 + 3 * t),
        ):  # fmt: skip
            assert all(arb(series[n]).overlaps(expected[n]) for n in range(7))


@mutants_of("models")
def test_a_dropped_hypothesis_is_noticed(mutant: Mutant) -> None:
    assert_noticed(mutant)
