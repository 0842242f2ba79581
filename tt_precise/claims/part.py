"""The parts of a claim: a number, a formula or words of the paper, compared with a result.

A ``Value`` is a result with the digits on which two independent computations agree, and with a
rigorous enclosure where there is one. A part is proved if its comparison has the same outcome at
both ends of the enclosure. Parts carry no verdict: ``verdicts`` derives it by the claim's rule.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from decimal import ROUND_DOWN, Context, Decimal
from fractions import Fraction
from typing import Annotated, Any, TypeAlias

from tt_precise.runtime.records import Record, means
from tt_precise.runtime.values import Scalar
from tt_precise.scene.numerals import as_fraction

MOST_DIGITS = 20  # Most digits that are printed; the fine runs have more.
DEFAULT_DIGITS = 12  # Digits of a number without a stated error.
Measured: TypeAlias = Any  # a Value, an mpmath number, a float, an int or a Fraction
Enclosure = tuple[Fraction, Fraction]
Outcome = tuple[bool, bool]  # The comparison holds; it holds after rounding.
Printed = Annotated[str, means("the paper's text")]
MeasuredText = Annotated[str, means("the computed result with its correct digits")]
_NUMBER = re.compile(r"[+-]?(?P<whole>\d+)(\.(?P<places>\d*))?([eE](?P<power>[+-]?\d+))?", re.ASCII)


# ---- measured values -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Value:
    """A value, the number of its correct digits, and the enclosure of the exact value if any."""

    value: Scalar
    digits: int
    enclosure: Enclosure | None = None

    @classmethod
    def of(cls, value: Measured, other: Measured, most: int = MOST_DIGITS) -> Value:
        """``value`` with the digits (at most ``most``) on which an independent ``other`` agrees."""
        exact, second = fraction_of(value), fraction_of(other)
        if exact == second:
            return cls(value, most)
        # n digits agree if the relative difference is less than half of 10^-n
        difference = 2 * abs(exact - second) / max(abs(exact), abs(second))
        return cls(value, max(0, min(most, -decade(difference) - 1)))

    def within(self, enclosure: Iterable[Fraction] | None) -> Value:
        """The value with the ends of its enclosure, or without an enclosure."""
        if enclosure is None:
            return replace(self, enclosure=None)
        low, high = enclosure
        return replace(self, enclosure=(low, high))

    def __float__(self) -> float:
        return float(self.value)

    def __str__(self) -> str:
        return decimal(self.value, self.digits)


def fraction_of(number: Measured) -> Fraction:
    """The exact value of a number of any arithmetic, so that comparisons are exact."""
    return as_fraction(number.value if isinstance(number, Value) else number)


def decimal(number: Measured, digits: int) -> str:
    """``number`` rounded to ``digits`` significant digits, plain or with an exponent."""
    value = fraction_of(number)
    if not value:
        return "0"
    digits = max(1, digits)
    rounded = Context(prec=digits).divide(Decimal(value.numerator), Decimal(value.denominator))
    power = rounded.adjusted()
    if -4 <= power < min(digits, 16):
        return f"{rounded:.{digits - 1 - power}f}"
    mantissa, _, exponent = f"{rounded:.{digits - 1}e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


def decade(value: Fraction) -> int:
    """The exponent of the largest power of ten that is at most ``value``."""
    cut = Context(prec=2, rounding=ROUND_DOWN)
    return cut.divide(Decimal(value.numerator), Decimal(value.denominator)).adjusted()


class Part(Record, frozen=True, kw_only=True):
    """One part or interpretation of a claim, compared with a computed result."""

    name: Annotated[
        str, means("name of the part or interpretation; empty if it is the only one")
    ] = ""
    holds: Annotated[
        bool | None, means("whether it holds; null if it is open or nothing can be computed")
    ]
    rounded: Annotated[bool, means("whether it holds after rounding to the printed digits")] = False
    printed: Printed
    measured: MeasuredText
    proved: Annotated[bool, means("whether a proof or a rigorous enclosure decides it")] = False
    formula: Annotated[bool, means("whether `printed` is a formula in Python's notation")] = False

    @property
    def outcome(self) -> str:
        """The outcome in one word, for a list of parts."""
        if self.holds is None:
            return "open"
        return "refuted" if not self.holds else "rounded" if self.rounded else "reproduced"


# ---- numbers -------------------------------------------------------------------------------------


def rounds_to(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare ``printed`` with ``measured`` rounded to as many digits."""
    value, last, _ = _parse(printed)
    return _number(printed, measured, unit, lambda x: (2 * abs(x - value) <= last,) * 2)


def about(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare "about ``printed``" with ``measured``, by one rule for all such numbers.

    The claim holds within one unit of the last significant digit. The zeros that end a whole number
    are not significant: about 80 means 70 to 90, about 3.2 means 3.1 to 3.3. A number that rounds
    to ``printed`` counts as rounded.
    """
    value, last, significant = _parse(printed)

    def compare(number: Fraction) -> Outcome:
        distance = abs(number - value)
        return distance <= significant, 2 * distance <= last

    return _number(f"about {printed}", measured, unit, compare)


def at_most(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare a printed bound with ``measured``, a size rounded to as many digits as the bound."""
    value, last, _ = _parse(printed)

    def compare(number: Fraction) -> Outcome:
        holds = 2 * (number - value) <= last
        return holds, holds and number > value

    return _number(f"at most {printed}", measured, unit, compare)


def at_most_order(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare an error with "of order ``printed``": less than half a decade above it."""
    value = _parse(printed)[0]
    return _number(f"order {printed}", measured, unit, lambda x: (x**2 <= 10 * value**2, False))


def _number(
    printed: str, measured: Measured, unit: str, compare: Callable[[Fraction], Outcome]
) -> Part:
    outcome, ends = compare(fraction_of(measured)), None
    shown = decimal(measured, DEFAULT_DIGITS)
    if isinstance(measured, Value):
        shown, ends = str(measured), measured.enclosure
    elif isinstance(measured, Fraction | int):  # exact: its own enclosure
        shown = str(measured) if isinstance(measured, int) else decimal(measured, MOST_DIGITS)
        ends = (Fraction(measured),) * 2
    return Part(
        holds=outcome[0],
        rounded=outcome[1],
        printed=f"{printed} {unit}".strip(),
        measured=f"{shown} {unit}".strip(),
        proved=ends is not None and all(compare(end) == outcome for end in ends),
    )


def _parse(text: str) -> tuple[Fraction, Fraction, Fraction]:
    """A printed number, the unit of its last digit, and the unit of its last significant digit."""
    number = _NUMBER.fullmatch(text)
    if not number:
        raise ValueError(f"printed number: got {text!r}, expected such as '9.381e-4'")
    whole, places = number["whole"], number["places"] or ""
    last = Fraction(10) ** (int(number["power"] or 0) - len(places))
    zeros = 0 if places else len(whole) - len(whole.rstrip("0") or "0")
    return Fraction(text), last, last * 10**zeros


# ---- words and formulas --------------------------------------------------------------------------


def statement(
    holds: Any, printed: str, measured: str, *, proved: bool = False, formula: bool = False
) -> Part:
    """Part of a statement that a computation confirms or refutes; None leaves the part open."""
    truth = None if holds is None else bool(holds)
    return Part(holds=truth, printed=printed, measured=measured, proved=proved, formula=formula)


def formula(holds: bool, printed: str, measured: str, *, proved: bool = False) -> Part:
    """Part of a statement that is printed as a formula, in Python's notation."""
    return statement(holds, printed, measured, proved=proved, formula=True)


def statements(printed: str, results: Mapping[str, tuple[Any, str]]) -> dict[str, Part]:
    """Several parts with the same printed words; each has a truth value and the result in words."""
    return {
        name: statement(holds, printed, measured) for name, (holds, measured) in results.items()
    }


def misprint(compare: Callable[[Any], Part], printed: Any, corrected: Any) -> dict[str, Part]:
    """The two parts of a misprint: the formula or number as printed, and as it should be."""
    return {"as printed": compare(printed), "as corrected": compare(corrected)}


def untestable(printed: str, measured: str = "-") -> Part:
    """Part of a statement that no computation can test."""
    return statement(None, printed, measured)


def approximate(printed: str, error: Measured, scale: Measured, what: str = "off by") -> Part:
    """Compare "approximately", without a number: the error is at most a tenth of the scale.

    A tenth still leaves the leading digit; ``what`` introduces the ratio.
    """
    ratio = abs(fraction_of(error) / fraction_of(scale))
    return statement(10 * ratio <= 1, printed, f"{what} {decimal(ratio, 3)}")


def agrees(printed: str, value: Measured, independent: Measured, digits: int) -> Part:
    """Compare a printed formula's value with an independent value to ``digits`` digits."""
    agreed = Value.of(value, independent, most=digits).digits
    shown = decimal(independent, min(agreed, MOST_DIGITS))
    return formula(agreed >= digits, printed, f"{shown} ({agreed} digits agree)")
