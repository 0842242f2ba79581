"""Arrays of MPFR's numbers against the same computed number by number in mpmath."""

from __future__ import annotations

import operator
import random
from collections.abc import Callable
from fractions import Fraction

import mpmath
import numpy

from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.values import Scalar

CONTEXT = mpmath.MPContext()
CONTEXT.prec = 219
WIDE = mpfr_of(CONTEXT)


def _numbers(seed: int, count: int = 2000) -> list[Scalar]:
    """Some of every size and with every number of bits, small integers among them; none is 0."""
    rng = random.Random(seed)
    numbers = []
    for _ in range(count):
        mantissa = (rng.getrandbits(rng.choice((3, 53, 219))) or 1) * rng.choice((-1, 1))
        numbers.append(CONTEXT.ldexp(CONTEXT.mpf(mantissa), rng.randint(-300, 100)))
    return numbers


def test_a_number_comes_back_with_all_its_bits() -> None:
    values = _numbers(1)
    assert list(map(WIDE.back, WIDE.array(values))) == values
    # more bits are kept until something is computed
    wide = CONTEXT.make_mpf(mpmath.libmp.from_man_exp(2**300 + 1, -300))
    with WIDE.precision():
        assert WIDE.back(WIDE.number(wide)) == wide != 1
        assert WIDE.back(WIDE.number(wide) - 1) == wide - 1 == CONTEXT.ldexp(1, -300)


def test_what_is_no_number_comes_back_as_none() -> None:
    values = [None, CONTEXT.nan, CONTEXT.inf, CONTEXT.mpf(0), CONTEXT.mpf(-2)]
    array = WIDE.array(values)
    assert [WIDE.back(value) for value in array] == [None, None, None, 0, -2]
    assert WIDE.texts(array, 48) == [None, None, None, "0.0", "-2.0"]
    with WIDE.precision():
        assert WIDE.exp(-array)[2] == 0  # and an infinity is one until then


SUMS_AND_PRODUCTS: tuple[Callable[..., Scalar], ...] = (
    operator.add, operator.sub, operator.mul, operator.truediv, lambda x, y: x**2,
    # a whole number beside an array is exact
    lambda x, y: 3 * x, lambda x, y: 1 - x, lambda x, y: 7 / x, lambda x, y: x / 2,
)  # fmt: skip


def test_numbers_have_mpmaths_bits() -> None:
    first, second = _numbers(2), _numbers(3)
    squares = [value * value for value in first]
    thirds = [CONTEXT.mpf(k) / 3 for k in range(-9, 10)]
    with WIDE.precision():
        x, y = WIDE.array(first), WIDE.array(second)
        for function in SUMS_AND_PRODUCTS:
            assert list(map(WIDE.back, function(x, y))) == list(map(function, first, second))
        pairs = {"hypot": (first, second), "atan2": (first, second)}
        for name, arguments in {**pairs, "sqrt": (squares,), "nint": (thirds,)}.items():
            values = getattr(WIDE, name)(*map(WIDE.array, arguments))
            assert list(map(WIDE.back, values)) == list(map(getattr(CONTEXT, name), *arguments))


def test_other_functions_are_mpmaths_within_a_rounding() -> None:
    arguments = [CONTEXT.mpf(k) / 97 for k in range(-400, 400)]
    for name in ("sin", "cos", "exp"):
        with WIDE.precision():
            values = getattr(WIDE, name)(WIDE.array(arguments))
        for argument, value in zip(arguments, map(WIDE.back, values), strict=True):
            expected = getattr(CONTEXT, name)(argument)
            # both are right to a unit in the last place, beside one half
            assert abs(value - expected) <= CONTEXT.eps * max(abs(expected), CONTEXT.mpf("0.5"))


def test_exact_numbers_are_rounded_once() -> None:
    fractions = [Fraction(1, 3), Fraction(-131, 350), Fraction(2), Fraction(1, 10**30)]
    values = list(map(WIDE.back, WIDE.of_fractions(fractions)))
    assert values == [CONTEXT.mpf(x.numerator) / x.denominator for x in fractions]
    texts = ["1.25", "-3.141592653589793238462643383279503e-05", "0"]
    assert list(map(WIDE.back, WIDE.of_fractions(texts))) == list(map(CONTEXT.mpf, texts))


def test_limbs_are_doubles_each_nearest_to_the_rest() -> None:
    values = WIDE.of_fractions([Fraction(1, 3), Fraction(-2, 7), Fraction(0), Fraction(5)])
    limbs = WIDE.to_limbs(values, 3)
    assert limbs[:, 0].tolist() == [1 / 3, -2 / 7, 0, 5]
    with WIDE.precision():
        left = values - WIDE.from_limbs(limbs)
        assert numpy.abs(left.astype(float)).max() < 2.0**-160
    # one far behind the others is not lost
    limbs = numpy.array([[1.0, 2.0**-200, 2.0**-400], [1.0, 0.0, 0.0]])
    with WIDE.precision():
        far, one = WIDE.from_limbs(limbs) - 1
        assert WIDE.back(far - 2.0**-200) == CONTEXT.ldexp(1, -400)
        assert one == 0
