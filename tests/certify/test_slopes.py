from fractions import Fraction

from tt_precise.certify.taylor_model import DualNumber, variables


def test_slopes_are_the_partial_derivatives() -> None:
    x, y = Fraction(3, 7), Fraction(-5, 11)
    a, b = variables([x, y])
    f = (a * a * b - 2 * b + 1) / (3 - a * b) - 1 / (b - 4) + 0 * a
    u, v = x * x * y - 2 * y + 1, 3 - x * y
    assert f.value == u / v - 1 / (y - 4)
    assert f.partials[0] == (2 * x * y * v + u * y) / v**2
    assert f.partials[1] == ((x * x - 2) * v + u * x) / v**2 + 1 / (y - 4) ** 2


def test_the_slope_of_a_root() -> None:
    class Square(Fraction):
        def sqrt(self) -> Fraction:
            return Fraction(3, 2)

    root = DualNumber(Square(9, 4), {0: Fraction(5)}).sqrt()
    assert (root.value, root.partials[0]) == (Fraction(3, 2), Fraction(5, 3))


def test_a_value_without_slopes_stays_constant() -> None:
    (a,) = variables([Fraction(2)])
    assert (a - a).partials[0] == 0
    assert DualNumber(Fraction(1), {}).partials == {}


def test_division_by_an_integer_rounds_nothing() -> None:
    third = DualNumber(Fraction(1), {0: Fraction(2)}) / 3
    assert (third.value, third.partials[0]) == (Fraction(1, 3), Fraction(2, 3))
