"""How many digits of a printed number an enclosure proves."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from decimal import ROUND_UP, Decimal, localcontext
from fractions import Fraction

from flint import arb

from tt_precise.certify.balls import bounds
from tt_precise.runtime.untyped import Json


@dataclass(frozen=True)
class PrintedDigits:
    """What an enclosure says of one printed number.

    digits
        Proved significant digits: the exact number differs from the printed one by at most half
        a unit in that place. None where the number is printed as 0.
    rounded
        Proved to be the correctly rounded one, to all digits that are printed.
    wrong
        Proved not to be.
    within
        The exact number is no farther from the printed one than this.
    """

    digits: int | None
    rounded: bool
    wrong: bool
    within: Fraction


def compare(text: str, exact: arb, zero: Fraction = Fraction(0)) -> PrintedDigits:
    """Compare a printed decimal with a ball around the exact number.

    ``zero`` is what "0" stands for: anything no larger than that.
    """
    low, high = bounds(exact)
    printed = Decimal(text)
    value = Fraction(printed)
    nearest = max(low - value, value - high, Fraction(0))
    farthest = max(high - value, value - low)
    if not value:
        return PrintedDigits(None, farthest <= zero, nearest > zero, farthest)
    _, figures, exponent = printed.as_tuple()
    assert isinstance(exponent, int)  # a number, neither NaN nor infinite
    last = Fraction(10) ** exponent / 2
    half, digits = last, len(figures)
    while digits and farthest > half:
        digits -= 1
        half *= 10
    # towards zero the numbers with as many digits lie ten times closer below a power of ten
    inner = last / 10 if figures[0] == 1 and not any(figures[1:]) else last
    sign = 1 if value > 0 else -1
    ends = sorted((sign * (low - value), sign * (high - value)))
    correct = -inner <= ends[0] and ends[1] <= last
    wrong = ends[1] < -inner or ends[0] > last
    return PrintedDigits(digits, correct, wrong, farthest)


@dataclass(frozen=True)
class Tally:
    """What is proved about one printed column.

    digits
        Fewest proved digits of its enclosed entries, those printed as 0 and those that the
        column's scale excuses (``near_zero``) apart; None if there are no others.
    entries, rounded, wrong
        How many entries are printed, proved to be correctly rounded, proved wrong.
    within
        No enclosed entry is farther from the exact number than this (decimal, rounded up).
    enclosed
        Of how many entries an enclosure exists; of others nothing is proved.
    """

    digits: int | None
    entries: int
    rounded: int
    wrong: int
    within: str
    enclosed: int

    @property
    def settled(self) -> bool:
        """Whether more bits would show no more.

        No ball around zero proves that a column is zero throughout, however small it is.
        """
        return self.rounded + self.wrong == self.enclosed or self.digits is None

    def as_dict(self) -> dict[str, Json]:
        """For proof.json."""
        return {name: value for name, value in asdict(self).items() if name != "enclosed"}


def tally(cells: Iterable[tuple[str, arb | None, bool]], zero: Fraction) -> Tally:
    """The tally of a column: printed text, ball, and whether the entry is near zero."""
    fewest: int | None = None
    entries = enclosed = correct = wrong = 0
    farthest = Fraction(0)
    for text, exact, near_zero in cells:
        entries += bool(text)
        if not text or exact is None:
            continue
        compared = compare(text, exact, zero)
        farthest = max(farthest, compared.within)
        enclosed += 1
        correct += compared.rounded
        wrong += compared.wrong
        if compared.digits is not None and not near_zero:
            fewest = compared.digits if fewest is None else min(fewest, compared.digits)
    return Tally(fewest, entries, correct, wrong, rounded(farthest, ROUND_UP, 2), enclosed)


def outward(exact: arb, digits: int) -> tuple[str, str]:
    """Midpoint and radius of a ball as decimals that enclose it."""
    middle, radius, power = exact.mid_rad_10exp(digits)
    return _decimal(int(middle), int(power)), _upward(int(radius), int(power))


def rounded(number: Fraction, rounding: str, figures: int) -> str:
    """An exact number as a decimal with so many figures, rounded in the given direction."""
    if not number:
        return "0"
    with localcontext(prec=figures, rounding=rounding):
        return f"{Decimal(number.numerator) / Decimal(number.denominator):.{figures - 1}e}"


def _decimal(mantissa: int, power: int) -> str:
    # digit by digit, as arithmetic on Decimals rounds to the context's precision
    figures = str(abs(mantissa))
    sign = "-" if mantissa < 0 else ""
    text = f"{sign}{figures[0]}.{figures[1:]}".rstrip(".")
    return f"{text}e{power + len(figures) - 1:+03d}" if mantissa else "0"


def _upward(radius: int, power: int) -> str:
    """The radius with two figures, rounded up."""
    surplus = max(len(str(radius)) - 2, 0)
    lead = -(-radius // 10**surplus)
    return f"{lead}e{power + surplus}" if lead else "0"
