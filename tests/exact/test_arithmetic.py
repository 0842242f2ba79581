"""Own contexts, and the count of digits that agree."""

import mpmath
import pytest

from tt_precise.exact import arithmetic


def test_a_context_leaves_the_global_one_alone() -> None:
    before = mpmath.mp.dps
    one, other = arithmetic.own_context(30), arithmetic.own_context(70)
    assert (one.dps, other.dps, mpmath.mp.dps) == (30, 70, before)
    assert arithmetic.decimal(other.mpf(5) / 2, 10, other) == "2.500000000"


@pytest.mark.parametrize(
    ("a", "b", "digits"),
    [
        ("1", "1", 50),
        ("1", "1 - 1e-60", 50),
        ("1", "1 - 2e-40", 39),
        ("1", "1 - 9e-41", 40),
        ("1", "0.5", 0),
        ("1", "4", 0),
        ("0", "0", 50),
        ("0", "1e-300", 0),
        ("nan", "1", 0),
        ("inf", "1", 0),
    ],
)
def test_agreed_digits(a: str, b: str, digits: int) -> None:
    context = arithmetic.own_context(80)
    one, other = (
        context.fsum(context.mpf(term) for term in text.replace("- ", "-").split())
        for text in (a, b)
    )
    assert arithmetic.agreed_digits(one, other, 50, context) == digits
    assert arithmetic.agreed_digits(other, one, 50, context) == digits
