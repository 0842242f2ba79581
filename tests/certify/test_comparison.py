from decimal import Decimal
from fractions import Fraction

import flint
import pytest
from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.certify.comparison import is_whole, outward, tally
from tt_precise.certify.comparison import printed as compare


@pytest.mark.parametrize(
    ("text", "middle", "radius", "digits", "rounded", "wrong"),
    [
        ("1.2346e+00", "1.23456", "1e-9", 5, True, False),
        ("1.2345e+00", "1.23456", "1e-9", 4, False, True),
        ("1.2346e+00", "1.23455", "1e-9", 4, False, False),  # a tie within the ball: undecided
        ("1.2346e+00", "1.23456", "1e-3", 3, False, False),
        ("-1.2346e-7", "-1.23456e-7", "1e-16", 5, True, False),
        ("9.999e+00", "9.99", "1e-9", 2, False, True),
        ("1.2346e+00", "7", "1e-9", 0, False, True),
        # below a power of ten five digits are ten times finer
        ("1.0000e+00", "1.00004", "1e-9", 5, True, False),
        ("1.0000e+00", "0.99996", "1e-9", 5, False, True),
        ("-1.0000e+00", "-0.999996", "1e-9", 5, True, False),
        ("-1.0000e+00", "-0.99996", "1e-9", 5, False, True),
        # the ties themselves: either neighbour is right
        ("2e+00", "2.5", "0", 1, True, False),
        ("2e+00", "1.5", "0", 1, True, False),
    ],
)
def test_compare(
    text: str, middle: str, radius: str, digits: int, rounded: bool, wrong: bool
) -> None:
    with flint.ctx.workprec(100):
        compared = compare(text, arb(middle, radius))
    assert (compared.digits, compared.rounded, compared.wrong) == (digits, rounded, wrong)
    assert compared.within >= abs(Fraction(Decimal(text)) - Fraction(Decimal(middle)))


@pytest.mark.parametrize(
    ("middle", "radius", "rounded", "wrong"),
    [(0, 1e-40, True, False), (0, 1e-30, False, False), (1, 1e-30, False, True)],
)
def test_a_printed_zero_stands_for_little(
    middle: int, radius: float, rounded: bool, wrong: bool
) -> None:
    compared = compare("0", arb(middle, radius), Fraction(1, 10**34))
    assert (compared.rounded, compared.wrong) == (rounded, wrong)


def test_a_tally_counts_and_takes_the_worst() -> None:
    last = "0" * 31
    with flint.ctx.workprec(200):
        cells = [
            (f"1.25{last}e+0", arb("1.25", "1e-9")),
            (f"1.30{last}e+0", arb("1.31", "1e-9")),
            (f"1.50{last}e+0", arb("1.5", "1e-40")),
            ("", arb(1)),
            (f"1.40{last}e+0", None),
            ("1.4e+0", arb("1.4", "1e-40")),  # not with all digits
        ]
        one = tally(cells, Fraction(0))
    assert (one.digits, one.entries, one.enclosed, one.rounded, one.wrong) == (2, 5, 3, 1, 1)
    assert one.within == "1.1e-2"
    assert not one.settled
    assert "enclosed" not in one.as_dict()


def test_cells_in_their_form_and_in_others() -> None:
    for cell in ("0", f"-1.{'0' * 33}e-12", f"9.{'9' * 33}e+0"):
        assert is_whole(cell), cell
    last = "0" * 33
    for cell in (
        "0e9",
        "0.0",
        "-0",
        "1.5e+0",
        "1.50e0",
        " 0",
        "nan",
        f"0.{'1' * 33}e+1",
        f"1.{last}e+00",
        f"1.{last}E+0",
        f"1.{last}0e+0",
        f"+1.{last}e+0",
    ):
        assert not is_whole(cell), cell


@pytest.mark.parametrize(
    ("middle", "radius"),
    [("0.333333333333333333", "1e-50"), ("-2.857e-10", "3e-45"), ("0", "1e-31"), ("155e20", "0")],
)
def test_outward_decimals_enclose_the_ball(middle: str, radius: str) -> None:
    with flint.ctx.workprec(200):
        exact = arb(middle, radius) / 3
        low, high = bounds(exact)
        centre, spread = (Fraction(Decimal(text)) for text in outward(exact, 34))
    assert centre - spread <= low <= high <= centre + spread
    assert spread <= 3 * (high - low) + Fraction(Decimal(abs(float(centre)) * 1e-37))
