"""Taylor coefficients against closed forms, exactly."""

from fractions import Fraction
from math import factorial

from tt_precise.certify.taylor_model import PowerSeries, taylor


def test_the_exponential_series() -> None:
    (y,) = taylor(lambda y: [y[0]], [Fraction(1)], 6)
    assert y.coefficients == tuple(Fraction(1, factorial(n)) for n in range(7))


def test_a_pole_in_the_rate() -> None:
    # y' = 1/y, y(0) = 1: sqrt(1 + 2 t)
    (y,) = taylor(lambda y: [1 / y[0]], [Fraction(1)], 4)
    square = y * y
    assert square.coefficients == (1, 2, 0, 0, 0)


def test_an_oscillator_and_a_clock() -> None:
    # the third rate contains no component
    x, v, t = taylor(lambda y: [y[1], -y[0], 1], [Fraction(1), Fraction(0), Fraction(0)], 4)
    assert x.coefficients == (1, 0, Fraction(-1, 2), 0, Fraction(1, 24))
    assert v.coefficients == (0, -1, 0, Fraction(1, 6), 0)
    assert t.coefficients == (0, 1, 0, 0, 0)


def test_arithmetic_with_numbers() -> None:
    t = PowerSeries([Fraction(0), Fraction(1), Fraction(0)])
    assert (2 * t - 1).coefficients == (-1, 2, 0)
    assert (1 - t / 2).coefficients == (1, Fraction(-1, 2), 0)
    assert (t - t).coefficients == (0, 0, 0)
    assert ((3 + t) / (1 + t)).coefficients == (3, -2, 2)


def test_the_square_root() -> None:
    class Square(Fraction):
        def sqrt(self) -> Fraction:
            return Fraction(3)

    root = PowerSeries([Square(9), Fraction(6), Fraction(2), Fraction(5)]).sqrt()
    assert (root * root).coefficients == (9, 6, 2, 5)
