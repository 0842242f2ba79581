"""Measured numbers with their correct digits, and the rules for verdicts.

A value is computed twice, in two arithmetics with independent errors, and has the digits on which
both agree. A *check* compares a statement of the paper with a computed result. A *finding* combines
the checks of a claim; no claim names its own verdict:

- ``all_of(checks)``: all checks must hold; rounded, reproduced or refuted;
- ``readings(checks)``: the same if all readings agree; "reading" if some hold and some fail;
- ``misprint(checks)``: misprint if the printed form fails and the corrected form holds.

A claim without anything to compute has the check ``untestable``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from decimal import ROUND_DOWN, Context, Decimal
from enum import StrEnum
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from tt_precise.runtime.values import Check, Scalar
from tt_precise.scene.numerals import as_fraction

# ---- measured numbers ---------------------------------------------------------------------------

MOST_DIGITS = 20  # printed; the fine runs have more
DEFAULT_DIGITS = 12  # printed for a number without a stated error


@dataclass(frozen=True)
class Settled:
    """A value, and the number of significant digits on which two computations agree."""

    value: Scalar
    digits: int

    @classmethod
    def of(cls, value: Measured, other: Measured, most: int = MOST_DIGITS) -> Settled:
        """``value`` with the digits (at most ``most``) in which independent ``other`` agrees."""
        exact, second = fraction_of(value), fraction_of(other)
        if exact == second:
            return cls(value, most)
        # a difference of half a unit in digit n still leaves n digits
        difference = 2 * abs(exact - second) / max(abs(exact), abs(second))
        return cls(value, max(0, min(most, -decade(difference) - 1)))

    def __float__(self) -> float:
        return float(self.value)

    def __str__(self) -> str:
        return decimal(self.value, self.digits)


Measured: TypeAlias = Any  # a Settled, an mpmath number, a float, an int or a Fraction


def fraction_of(number: Measured) -> Fraction:
    """The exact value of a number of any arithmetic, so that comparisons are exact."""
    return as_fraction(number.value if isinstance(number, Settled) else number)


def measured_text(number: Measured) -> str:
    """A number in decimals: settled and exact numbers with all digits, others with twelve."""
    if isinstance(number, Settled | int):
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


# ---- verdicts -----------------------------------------------------------------------------------


class Verdict(StrEnum):
    """The verdict on a claim."""

    REPRODUCED = "reproduced"
    ROUNDED = "rounded"
    READING = "reading"
    REFUTED = "refuted"
    MISPRINT = "misprint"
    UNTESTABLE = "untestable"

    @property
    def meaning(self) -> str:
        return _MEANINGS[self]


_MEANINGS = {
    Verdict.REPRODUCED: "holds within the stated accuracy",
    Verdict.ROUNDED: "equal after rounding to the printed digits",
    Verdict.READING: "holds under one reading and fails under another; the note states both",
    Verdict.REFUTED: "does not hold",
    Verdict.MISPRINT: "fails as printed, holds as corrected in the note",
    Verdict.UNTESTABLE: "cannot be computed; the note says why",
}


def verdict_of(check: Check) -> Verdict:
    """The verdict on a claim with only this check."""
    if check.verdict == "skipped":
        return Verdict.UNTESTABLE
    if not check.holds:
        return Verdict.REFUTED
    return Verdict.ROUNDED if check.sense == "rounds to" else Verdict.REPRODUCED


class Proof(NamedTuple):
    """Whether a verdict is proved, and the sentence about it in the note."""

    settled: bool
    sentence: str = ""


NO_PROOF = Proof(False)
EXACT = Proof(True)  # an identity for all symbols


class Form(StrEnum):
    """How the checks of a claim make its verdict."""

    ALL_OF = "all of"
    READINGS = "readings"
    MISPRINT = "misprint"


@dataclass(frozen=True)
class Finding:
    """The result for a claim, made only by the functions of this module.

    Attributes
    ----------
    form, checks
        The checks and how they make the verdict; for a misprint the printed and the corrected form.
    remark
        One or two sentences of explanation.
    proved
        Whether the verdict rests on a proof (SymPy, or rigorous enclosures), not on evaluation
        at points.
    proposed
        The correction, for a misprint.
    """

    form: Form
    checks: tuple[Check, ...]
    remark: str
    proved: bool = False
    proposed: str = ""

    @property
    def verdict(self) -> Verdict:
        holding = [check.holds for check in self.checks]
        verdicts = list(map(verdict_of, self.checks))
        if self.form is Form.MISPRINT:
            return Verdict.MISPRINT if holding == [False, True] else verdicts[0]
        if all(holding):
            return verdicts[0] if len(set(verdicts)) == 1 else Verdict.REPRODUCED
        some = self.form is Form.READINGS and any(holding)
        return Verdict.READING if some else Verdict.REFUTED

    @property
    def correction(self) -> str:
        """The correction; empty unless the claim is a misprint."""
        return self.proposed if self.verdict is Verdict.MISPRINT else ""

    @property
    def printed(self) -> str:
        """The paper's statement, with unit."""
        checks = self.checks if self.form is Form.ALL_OF else self.checks[:1]
        return _joined({check.name: check.expected for check in checks})

    @property
    def measured(self) -> str:
        """The computed result, with unit and its correct digits."""
        first = self.checks[0]
        if self.form is not Form.MISPRINT:
            return _joined({check.name: check.measured for check in self.checks})
        if first.holds:
            return first.measured
        other = "corrected" if self.correction else f"as {self.proposed}"
        return f"{first.measured}; {other}: {self.checks[1].measured}"

    @property
    def note(self) -> str:
        """The remark, with the correction or the readings and parts that hold and fail."""
        holding = [check.name for check in self.checks if check.holds]
        failing = [check.name for check in self.checks if not check.holds]
        if self.correction:
            return f"Should read {self.correction}. {self.remark}"
        if self.verdict is Verdict.READING:
            read_as = f"Holds if read as: {'; '.join(holding)}. Fails as: {'; '.join(failing)}."
            return f"{self.remark} {read_as}"
        if self.form is Form.ALL_OF and holding and failing:
            return f"{self.remark} Failing: {'; '.join(failing)}."
        return self.remark


# ---- checks: a printed statement compared with a computed result -------------------------------


def rounds_to(printed: str, measured: Measured, unit: str = "") -> Check:
    """Whether ``measured``, rounded to the digits of ``printed``, is ``printed``."""
    value, last = _printed(printed)
    distance = abs(fraction_of(measured) - value)
    return _numbers(2 * distance <= last, printed, measured, unit, rounded=True)


def about(printed: str, measured: Measured, unit: str = "") -> Check:
    """Whether "about ``printed``" fits: within one unit of its last significant digit.

    The zeros that end a whole number are not significant: about 80 means 70 to 90. A number that
    rounds to ``printed`` counts as rounded.
    """
    value, last = _printed(printed)
    significant = _printed(printed, zeros=False)[1]
    distance = abs(fraction_of(measured) - value)
    rounded = 2 * distance <= last
    return _numbers(distance <= significant, f"about {printed}", measured, unit, rounded=rounded)


def within(printed: str, measured: Measured, tolerance: str, unit: str = "") -> Check:
    """Whether ``measured`` is within an absolute ``tolerance`` that the paper states."""
    distance = abs(fraction_of(measured) - _printed(printed)[0])
    holds, shown = distance <= _printed(tolerance)[0], f"{printed} {unit}".strip()
    return statement(holds, f"{shown} within {tolerance}", _text(measured, unit))


def at_most_order(printed: str, measured: Measured, unit: str = "") -> Check:
    """Whether an error fits "of order ``printed``": less than half a decade above it."""
    holds = fraction_of(measured) ** 2 <= 10 * _printed(printed)[0] ** 2
    return _numbers(holds, f"order {printed}", measured, unit)


def approximate(printed: str, error: Measured, scale: Measured, what: str = "off by") -> Check:
    """Whether "approximately", without a number, fits: the error is at most a tenth of the scale.

    A tenth still leaves the leading digit; ``what`` introduces the ratio.
    """
    ratio = abs(fraction_of(error) / fraction_of(scale))
    return statement(10 * ratio <= 1, printed, f"{what} {decimal(ratio, 3)}")


def agrees(printed: str, value: Measured, independent: Measured, digits: int) -> Check:
    """Whether a printed formula's value agrees with an independent value to ``digits`` digits."""
    agreed = Settled.of(value, independent, most=digits).digits
    shown = decimal(independent, min(agreed, MOST_DIGITS))
    return statement(agreed >= digits, printed, f"{shown} ({agreed} digits agree)")


def statement(holds: bool, printed: str, measured: str) -> Check:
    """A statement that a computation confirms or refutes; both sides in words and numbers."""
    return Check("", "pass" if holds else "fail", expected=printed, measured=measured)


def untestable(printed: str) -> Check:
    """A statement that no computation can test."""
    return Check("", "skipped", expected=printed, measured="-")


def _numbers(
    holds: bool, printed: str, measured: Measured, unit: str, *, rounded: bool = False
) -> Check:
    check = statement(holds, f"{printed} {unit}".strip(), _text(measured, unit))
    return replace(check, sense="rounds to") if rounded else check


# ---- findings: the checks of a claim together --------------------------------------------------

Checks: TypeAlias = Check | Mapping[str, Check]  # a check, or the parts or readings by name


def statements(printed: str, parts: Mapping[str, tuple[bool, str]]) -> dict[str, Check]:
    """Several statements with the same printed words: whether each holds, and the result."""
    return {name: statement(holds, printed, measured) for name, (holds, measured) in parts.items()}


def all_of(checks: Checks, remark: str, proof: Proof = NO_PROOF) -> Finding:
    """A claim that holds if each of its parts does."""
    return _finding(Form.ALL_OF, checks, remark, proof)


def theorem(checks: Checks, remark: str) -> Finding:
    """A claim whose parts are identities, compared for all symbols."""
    return all_of(checks, remark, EXACT)


def readings(checks: Mapping[str, Check], remark: str, proof: Proof = NO_PROOF) -> Finding:
    """A claim whose words admit several readings, all of them computed."""
    return _finding(Form.READINGS, checks, remark, proof)


def misprint(
    checks: Iterable[Check], correction: str, remark: str, proof: Proof = NO_PROOF
) -> Finding:
    """A claim checked as printed and as corrected by ``correction``."""
    named = dict(zip(("as printed", "as corrected"), checks, strict=True))
    return _finding(Form.MISPRINT, named, remark, proof, correction)


def _finding(
    form: Form, checks: Checks, remark: str, proof: Proof, correction: str = ""
) -> Finding:
    parts = {"": checks} if isinstance(checks, Check) else checks
    named = tuple(replace(check, name=name) for name, check in parts.items())
    if not named:
        raise ValueError("claim: got no checks, expected one or more")
    return Finding(form, named, remark + proof.sentence, proof.settled, correction)


def _joined(texts: Mapping[str, str]) -> str:
    given = {name: text for name, text in texts.items() if text}
    if len(set(given.values())) <= 1:
        return next(iter(given.values()), "")
    return "; ".join(f"{name}: {text}" for name, text in given.items())


_NUMBER = re.compile(
    r"(?P<sign>[+-]?)(?P<whole>\d+)(\.(?P<part>\d*))?([eE](?P<power>[+-]?\d+))?", re.ASCII
)


def _printed(text: str, *, zeros: bool = True) -> tuple[Fraction, Fraction]:
    """A printed number, and one unit of its last digit (significant one without ``zeros``)."""
    number = _NUMBER.fullmatch(text)
    if not number:
        raise ValueError(f"printed number: got {text!r}, expected such as '9.381e-4'")
    places = len(number["part"] or "")
    last = Fraction(10) ** (int(number["power"] or 0) - places)
    if not zeros and not places:
        last *= 10 ** (len(number["whole"]) - len(number["whole"].rstrip("0") or "0"))
    return Fraction(text), last


def _text(measured: Measured, unit: str) -> str:
    return f"{measured_text(measured)} {unit}".strip()
