"""Measured values, the parts of a judged claim, and the rules that make a verdict.

A *value* has the digits on which two computations with independent errors agree, and its rigorous
enclosure where there is one. A *part* compares words or a number of the paper with a value; a part
is proved if the comparison has the same result at both ends of the enclosure. A claim's function
returns its *grounds*, one part or several and a note. The claim's rule makes the verdict of them
(``conclude``), and no claim names its own verdict:

- "all of": the parts are the assertions of the statement; "partly" if some hold and some fail;
- "interpretations": the meanings that its words admit; "ambiguous" if some hold and some fail;
- "misprint": two parts, the formula or number as printed and as it should be.

A statement that cannot be computed has the part ``untestable``. A part is open, neither true nor
false, while the outcome of some motions is undecided (``of_all``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import ROUND_DOWN, Context, Decimal
from enum import StrEnum
from fractions import Fraction
from typing import Annotated, Any, Literal, TypeAlias

from msgspec.structs import replace

from tt_precise.runtime.records import Record, means
from tt_precise.runtime.values import Scalar
from tt_precise.scene.numerals import as_fraction

# ---- measured values -----------------------------------------------------------------------------

MOST_DIGITS = 20  # Most digits that are printed; the fine runs have more.
DEFAULT_DIGITS = 12  # Digits of a number without a stated error.
ABOUT_UNITS = 1  # Units of the last significant digit that "about N" tolerates, for every N.
Enclosure = tuple[Fraction, Fraction]


@dataclass(frozen=True)
class Value:
    """A value, the number of its settled digits, and the enclosure of the exact value if any."""

    value: Scalar
    digits: int
    enclosure: Enclosure | None = None

    @classmethod
    def of(cls, value: Measured, other: Measured, most: int = MOST_DIGITS) -> Value:
        """``value`` with the digits (at most ``most``) on which an independent ``other`` agrees."""
        exact, second = fraction_of(value), fraction_of(other)
        if exact == second:
            return cls(value, most)
        # a difference of half a unit in digit n still leaves n digits
        difference = 2 * abs(exact - second) / max(abs(exact), abs(second))
        return cls(value, max(0, min(most, -decade(difference) - 1)))

    def within(self, enclosure: Iterable[Fraction] | None) -> Value:
        """The value with the ends of its enclosure, or without an enclosure."""
        if enclosure is None:
            return Value(self.value, self.digits)
        low, high = enclosure
        return Value(self.value, self.digits, (low, high))

    def __float__(self) -> float:
        return float(self.value)

    def __str__(self) -> str:
        return decimal(self.value, self.digits)


Measured: TypeAlias = Any  # a Value, an mpmath number, a float, an int or a Fraction


def fraction_of(number: Measured) -> Fraction:
    """The exact value of a number of any arithmetic, so that comparisons are exact."""
    return as_fraction(number.value if isinstance(number, Value) else number)


def enclosure_of(number: Measured) -> Enclosure | None:
    """The ends of the interval that provably contains a number; both ends equal an exact number."""
    if isinstance(number, Value):
        return number.enclosure
    return (Fraction(number),) * 2 if isinstance(number, Fraction | int) else None


def measured_text(number: Measured) -> str:
    """A number in decimals: values and exact numbers with all digits, others with twelve."""
    if isinstance(number, Value | int):
        return str(number)
    if isinstance(number, Fraction):
        return decimal(number, MOST_DIGITS)
    return decimal(number, DEFAULT_DIGITS)


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
    """The largest power of ten, as its exponent, that is at most ``value``."""
    cut = Context(prec=2, rounding=ROUND_DOWN)
    return cut.divide(Decimal(value.numerator), Decimal(value.denominator)).adjusted()


# ---- verdicts ------------------------------------------------------------------------------------


class Verdict(StrEnum):
    """The verdict on a claim."""

    REPRODUCED = "reproduced"
    ROUNDED = "rounded"
    PARTLY = "partly"
    AMBIGUOUS = "ambiguous"
    REFUTED = "refuted"
    MISPRINT = "misprint"
    UNTESTABLE = "untestable"

    @property
    def meaning(self) -> str:
        """The meaning of the verdict, in one line for a legend."""
        return _MEANINGS[self]


_MEANINGS = {
    Verdict.REPRODUCED: "holds within the stated accuracy",
    Verdict.ROUNDED: "equal after rounding to the printed digits",
    Verdict.PARTLY: "a part holds, and a part fails or is open; the note names both",
    Verdict.AMBIGUOUS: "the words admit several meanings, of which some hold; the note names them",
    Verdict.REFUTED: "does not hold",
    Verdict.MISPRINT: "fails as printed, holds as corrected in the note",
    Verdict.UNTESTABLE: "cannot be decided; the note says why",
}
# The rules of fairness, for every claim.
RULES = (
    "A claim is one statement of the paper; a statement about several quantities, or at several "
    "times, has a part for each. The quote is verbatim, and a definition adds only what the "
    "words leave open. A statement is ambiguous only where the paper's own words admit several "
    "meanings; a statement that is true only under a restriction of ours is partly right. "
    '"About N" holds within one unit of the last significant digit of N, whatever N is; other '
    "numbers hold if they round to the printed digits. An outcome counts only when it is decided: "
    "undecided starts are integrated further and named; while some are undecided, a statement "
    "about all starts is open. Claims about one mistake are one finding."
)
Verdicts = Annotated[
    Literal["reproduced", "rounded", "partly", "ambiguous", "refuted", "misprint", "untestable"],
    means("the verdict"),
]
Rule = Literal["all of", "interpretations", "misprint"]
Printed = Annotated[str, means("the paper's text")]
MeasuredText = Annotated[str, means("the computed result with its correct digits")]


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
    def verdict(self) -> Verdict:
        """The verdict on a claim with only this part."""
        if self.holds is None:
            return Verdict.UNTESTABLE
        if not self.holds:
            return Verdict.REFUTED
        return Verdict.ROUNDED if self.rounded else Verdict.REPRODUCED

    @property
    def outcome(self) -> str:
        """The word for this part in a list of parts: its verdict, or "open"."""
        return "open" if self.holds is None else self.verdict


# One part, named parts, or the two parts of a misprint; and the note.
Grounds: TypeAlias = tuple[Part | Mapping[str, Part] | Iterable[Part], str]


class JudgedClaim(Record, frozen=True, kw_only=True):
    """A claim and its verdict, with the parts from which the verdict follows."""

    id: Annotated[str, means("id of the claim")] = ""
    verdict: Verdicts
    printed: Printed
    measured: MeasuredText
    note: Annotated[str, means("explanation of the verdict")]
    kind: Annotated[str, means("equation, number, sweep, ...")] = ""
    paper: Annotated[str, means("the paper's name")] = ""
    section: Annotated[str, means("number of the section")] = ""
    statement: Annotated[str, means("the claim in words")] = ""
    quote: Annotated[str, means("the paper's words")] = ""
    where: Annotated[str, means("place in the paper")] = ""
    definition: Annotated[str, means("the quantity computed, where the paper leaves it open")] = ""
    finding: Annotated[str, means("id of the claim that stands for the finding in a count")] = ""
    rule: Annotated[Rule, means("how the parts make the verdict")]
    parts: Annotated[tuple[Part, ...], means("the parts behind the verdict")]
    remark: Annotated[str, means("the note without the parts and the correction")]
    proved: Annotated[bool, means("whether a proof or rigorous enclosures decide every part")]
    correction: Annotated[str, means("the correct formula or words of a misprint; else empty")]

    @property
    def lines(self) -> tuple[Part, ...]:
        """The named parts, to be listed; none if there is only one."""
        several = self.rule != "misprint" or self.correction
        return tuple(part for part in self.parts if part.name and several)

    @property
    def essential(self) -> Part:
        """The deciding part: the correction, or the first part that failed, is open, or exists."""
        if self.correction:
            return self.parts[1]
        # a stable sort: False before None before True
        failing = sorted(self.parts, key=lambda part: (False, None, True).index(part.holds))
        return self.parts[0] if self.rule == "misprint" else failing[0]


def _verdict(rule: Rule, named: tuple[Part, ...]) -> Verdict:
    holding = [part.holds for part in named]
    if rule == "misprint":
        return Verdict.MISPRINT if holding == [False, True] else named[0].verdict
    if not any(holding):
        return Verdict.REFUTED if False in holding else Verdict.UNTESTABLE
    if all(holding):
        return Verdict.ROUNDED if all(part.rounded for part in named) else Verdict.REPRODUCED
    return Verdict.AMBIGUOUS if rule == "interpretations" else Verdict.PARTLY


def conclude(rule: Rule, grounds: Grounds, **identity: str) -> JudgedClaim:
    """Judge a claim by its rule, from the parts and the note that its function returns."""
    listed, remark = grounds
    if isinstance(listed, Part):
        listed = {"": listed}
    elif not isinstance(listed, Mapping):
        listed = dict(zip(("as printed", "as corrected"), listed, strict=True))
    named = tuple(replace(part, name=name) for name, part in listed.items())
    if not named:
        raise ValueError("claim: got no parts, expected one or more")
    verdict = _verdict(rule, named)
    correction = named[1].printed if verdict is Verdict.MISPRINT else ""
    names = {
        holds: "; ".join(part.name for part in named if part.holds is holds)
        for holds in (True, False, None)
    }
    words = {
        Verdict.AMBIGUOUS: ("Holds if read as", "Fails as", "Open as"),
        Verdict.PARTLY: ("Holds", "Fails", "Open"),
    }.get(verdict, ())
    note = remark + "".join(
        f" {word}: {listing}."
        for word, listing in zip(words, names.values(), strict=False)
        if listing
    )
    if correction:
        note = f"Should read {correction}. {remark}"
    return JudgedClaim(
        verdict=verdict.value,
        printed=_join(named if rule == "all of" else named[:1], "printed"),
        measured=_join(named, "measured"),
        note=note,
        rule=rule,
        parts=named,
        remark=remark,
        proved=all(part.proved for part in named),
        correction=correction,
        **identity,
    )


def _join(named: tuple[Part, ...], field: str) -> str:
    texts = {part.name: getattr(part, field) for part in named if getattr(part, field)}
    if len(set(texts.values())) <= 1:
        return next(iter(texts.values()), "")
    return "; ".join(f"{name}: {text}" for name, text in texts.items())


# ---- parts: a printed statement compared with a computed result ----------------------------------


def rounds_to(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare ``printed`` with ``measured`` rounded to as many digits."""
    value, last = _parse(printed)

    def compare(number: Fraction) -> tuple[bool, bool]:
        holds = 2 * abs(number - value) <= last
        return holds, holds

    return _number(compare, printed, measured, unit)


def about(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare "about ``printed``" with ``measured``, by one rule for all such numbers.

    The claim holds within ``ABOUT_UNITS`` of the last significant digit. The zeros that end a whole
    number are not significant: about 80 means 70 to 90, about 3.2 means 3.1 to 3.3. A number that
    rounds to ``printed`` counts as rounded.
    """
    value, last = _parse(printed)
    tolerance = ABOUT_UNITS * _parse(printed, zeros=False)[1]

    def compare(number: Fraction) -> tuple[bool, bool]:
        distance = abs(number - value)
        return distance <= tolerance, 2 * distance <= last

    return _number(compare, f"about {printed}", measured, unit)


def at_most(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare a printed bound with ``measured``, a size rounded to as many digits as the bound."""
    value, last = _parse(printed)

    def compare(number: Fraction) -> tuple[bool, bool]:
        return 2 * (number - value) <= last, value < number and 2 * (number - value) <= last

    return _number(compare, f"at most {printed}", measured, unit)


def at_most_order(printed: str, measured: Measured, unit: str = "") -> Part:
    """Compare an error with "of order ``printed``": less than half a decade above it."""
    value = _parse(printed)[0]
    return _number(lambda x: (x**2 <= 10 * value**2, False), f"order {printed}", measured, unit)


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


def statement(holds: bool, printed: str, measured: str, *, proved: bool = False) -> Part:
    """A statement that a computation confirms or refutes; both sides in words and numbers."""
    return Part(holds=bool(holds), printed=printed, measured=measured, proved=proved)


def formula(holds: bool, printed: str, measured: str, *, proved: bool = False) -> Part:
    """A statement printed as a formula, in Python's notation."""
    return Part(holds=bool(holds), printed=printed, measured=measured, proved=proved, formula=True)


def statements(printed: str, found: Mapping[str, tuple[bool, str]]) -> dict[str, Part]:
    """Several statements with the same printed words, each with a truth value and the result."""
    return {name: statement(holds, printed, measured) for name, (holds, measured) in found.items()}


def untestable(printed: str, measured: str = "-") -> Part:
    """A statement that no computation can test."""
    return Part(holds=None, printed=printed, measured=measured)


def of_all(printed: str, measured: str, *, holding: int, failing: int, undecided: int) -> Part:
    """A statement about all motions of a set, by their outcomes; open while some are undecided.

    The statement fails if it holds for no motion, for example for an empty set.
    """
    holds = False if failing or not holding else None if undecided else True
    return Part(holds=holds, printed=printed, measured=measured)


def _number(
    compare: Callable[[Fraction], tuple[bool, bool]], printed: str, measured: Measured, unit: str
) -> Part:
    outcome, ends = compare(fraction_of(measured)), enclosure_of(measured)
    return Part(
        holds=outcome[0],
        rounded=outcome[1],
        printed=f"{printed} {unit}".strip(),
        measured=f"{measured_text(measured)} {unit}".strip(),
        proved=ends is not None and all(compare(end) == outcome for end in ends),
    )


_NUMBER = re.compile(
    r"(?P<sign>[+-]?)(?P<whole>\d+)(\.(?P<part>\d*))?([eE](?P<power>[+-]?\d+))?", re.ASCII
)


def _parse(text: str, *, zeros: bool = True) -> tuple[Fraction, Fraction]:
    """A printed number, and one unit of its last (without ``zeros``, last significant) digit."""
    number = _NUMBER.fullmatch(text)
    if not number:
        raise ValueError(f"printed number: got {text!r}, expected such as '9.381e-4'")
    places = len(number["part"] or "")
    last = Fraction(10) ** (int(number["power"] or 0) - places)
    if not zeros and not places:
        last *= 10 ** (len(number["whole"]) - len(number["whole"].rstrip("0") or "0"))
    return Fraction(text), last
