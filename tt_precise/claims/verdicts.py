"""The rules that turn computations into verdicts; no claim ever names its own verdict.

A *check* compares what the paper says with what was computed. A *finding* is what checks come to:

- ``judged(check)``: reproduced or rounded if it holds, refuted if not;
- ``all_of(checks)``: the same for a claim of several parts, each of which has to hold;
- ``readings(checks)``: the same if all readings agree; "reading" if some hold and some do not;
- ``misprint(printed, corrected)``: misprint if the printed form fails and the corrected one holds;
- ``wording(note)``: untestable.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction

from tt_precise.claims.measured import (
    MOST_DIGITS,
    Measured,
    Settled,
    decimal,
    fraction_of,
    measured_text,
)


class Verdict(StrEnum):
    """What a claim comes to."""

    REPRODUCED = "reproduced"
    ROUNDED = "rounded"
    READING = "reading"
    REFUTED = "refuted"
    MISPRINT = "misprint"
    UNTESTABLE = "untestable"

    @property
    def meaning(self) -> str:
        """What the verdict says, for a legend."""
        return _MEANINGS[self]


_MEANINGS = {
    Verdict.REPRODUCED: "holds within the stated accuracy",
    Verdict.ROUNDED: "equal after rounding to the printed digits",
    Verdict.READING: "holds under one reading and not under another; the note states them",
    Verdict.REFUTED: "does not hold",
    Verdict.MISPRINT: "fails as printed, holds as corrected in the note",
    Verdict.UNTESTABLE: "nothing to compute; the note says why",
}


@dataclass(frozen=True)
class Check:
    """One comparison: whether it holds, and as what; what was printed, what was measured."""

    holds: bool
    printed: str
    measured: str
    exactly_rounded: bool = False

    @property
    def verdict(self) -> Verdict:
        """What a claim of this one check comes to."""
        if not self.holds:
            return Verdict.REFUTED
        return Verdict.ROUNDED if self.exactly_rounded else Verdict.REPRODUCED


@dataclass(frozen=True)
class Finding:
    """What came out for one claim. Made by the rules of this module only.

    Attributes
    ----------
    verdict
        See ``Verdict``.
    printed, measured
        As text, with unit, the measured one with the digits it has.
    note
        One or two sentences that a referee would accept.
    readings
        (reading, verdict under it, measured) where the paper's words admit several.
    proved
        Whether the verdict rests on a proof (SymPy, or rigorous enclosures), not on evaluation
        at points.
    parts
        (part, verdict on it, printed, measured) of a claim of several parts; of a misprint, as
        printed and as corrected.
    correction
        What should stand in the paper, if the claim is a misprint.
    """

    verdict: Verdict
    printed: str
    measured: str
    note: str
    readings: tuple[tuple[str, Verdict, str], ...] = ()
    proved: bool = False
    parts: tuple[tuple[str, Verdict, str, str], ...] = ()
    correction: str = ""


# ---- checks: the comparison of one printed thing with one computed thing -----------------------


def rounds_to(printed: str, measured: Measured, unit: str = "") -> Check:
    """Whether ``measured``, rounded to the digits of ``printed``, is ``printed``."""
    value, last = _printed(printed)
    distance = abs(fraction_of(measured) - value)
    return Check(2 * distance <= last, _united(printed, unit), _text(measured, unit), True)


def about(printed: str, measured: Measured, unit: str = "") -> Check:
    """Whether "about ``printed``" fits: within one unit of its last significant digit.

    The zeros that end a whole number are not significant: about 80 means 70 to 90. What even
    rounds to ``printed`` counts as rounded.
    """
    value, last = _printed(printed)
    significant = _printed(printed, zeros=False)[1]
    distance = abs(fraction_of(measured) - value)
    shown, found = _united(f"about {printed}", unit), _text(measured, unit)
    return Check(distance <= significant, shown, found, 2 * distance <= last)


def within(printed: str, measured: Measured, tolerance: str, unit: str = "") -> Check:
    """Whether ``measured`` is within an absolute ``tolerance`` that the paper itself states."""
    distance = abs(fraction_of(measured) - _printed(printed)[0])
    shown = f"{_united(printed, unit)} within {tolerance}"
    return Check(distance <= _printed(tolerance)[0], shown, _text(measured, unit))


def at_most_order(printed: str, measured: Measured, unit: str = "") -> Check:
    """Whether an error "of order ``printed``" is so: less than half a decade above it."""
    size = abs(fraction_of(measured))
    holds = size * size <= 10 * _printed(printed)[0] ** 2
    return Check(holds, _united(f"order {printed}", unit), _text(measured, unit))


def in_range(low: str, high: str, measured: Measured, unit: str = "") -> Check:
    """Whether ``measured`` lies between two printed numbers, ends included."""
    value = fraction_of(measured)
    holds = _printed(low)[0] <= value <= _printed(high)[0]
    return Check(holds, _united(f"{low} to {high}", unit), _text(measured, unit))


def approximate(printed: str, error: Measured, scale: Measured, what: str = "off by") -> Check:
    """Whether "approximately", without a number, fits: the error is at most a tenth of the scale.

    A tenth is what still leaves the leading digit; ``what`` introduces the ratio.
    """
    ratio = abs(fraction_of(error) / fraction_of(scale))
    return Check(10 * ratio <= 1, printed, f"{what} {decimal(ratio, 3)}")


def agrees(printed: str, value: Measured, independent: Measured, digits: int) -> Check:
    """Whether a printed formula's value has ``digits`` digits of an independent determination."""
    found = Settled.of(value, independent, most=digits)
    agreed = decimal(independent, min(found.digits, MOST_DIGITS))
    measured = f"{agreed} ({found.digits} digits agree)"
    return Check(found.digits >= digits, printed, measured)


def statement(holds: bool, *, printed: str, measured: str) -> Check:
    """A statement that a computation found true or false; both sides in words and numbers."""
    return Check(bool(holds), printed, measured)


# ---- findings: what the checks come to ---------------------------------------------------------


def judged(check: Check, note: str, *, proved: bool = False) -> Finding:
    """A claim of one check."""
    return Finding(check.verdict, check.printed, check.measured, note, proved=proved)


def all_of(checks: Mapping[str, Check], note: str, *, proved: bool = False) -> Finding:
    """A claim of several parts: refuted if one fails, and the note says which."""
    if not checks:
        raise ValueError("claim of several parts: got none, expected one or more")
    failed = [name for name, check in checks.items() if not check.holds]
    if failed and len(failed) < len(checks):
        note = f"{note} What fails: {'; '.join(failed)}."
    return Finding(
        Verdict.REFUTED if failed else _common(checks),
        _joined(checks, "printed"),
        _joined(checks, "measured"),
        note,
        proved=proved,
        parts=_parts(checks),
    )


def readings(checks: Mapping[str, Check], note: str, *, proved: bool = False) -> Finding:
    """A claim whose words admit several readings, all of them computed."""
    holding = [name for name, check in checks.items() if check.holds]
    if not holding:
        verdict = Verdict.REFUTED
    elif len(holding) == len(checks):
        verdict = _common(checks)
    else:
        verdict = Verdict.READING
        failing = [name for name in checks if name not in holding]
        note = f"{note} Holds read as: {'; '.join(holding)}. Not as: {'; '.join(failing)}."
    return Finding(
        verdict,
        next(iter(checks.values())).printed,
        _joined(checks, "measured"),
        note,
        tuple((name, check.verdict, check.measured) for name, check in checks.items()),
        proved,
    )


def misprint(
    printed: Check, corrected: Check, correction: str, note: str, *, proved: bool = False
) -> Finding:
    """A claim that may be misprinted: ``correction`` is what should stand there."""
    if printed.holds:
        return judged(printed, note, proved=proved)
    if not corrected.holds:
        measured = f"{printed.measured}; as {correction}: {corrected.measured}"
        return Finding(Verdict.REFUTED, printed.printed, measured, note, proved=proved)
    return Finding(
        Verdict.MISPRINT,
        printed.printed,
        f"{printed.measured}; corrected: {corrected.measured}",
        f"Should read {correction}. {note}",
        proved=proved,
        parts=_parts({"as printed": printed, "as corrected": corrected}),
        correction=correction,
    )


def wording(note: str, *, printed: str, measured: str = "-") -> Finding:
    """Words that no computation can test."""
    return Finding(Verdict.UNTESTABLE, printed, measured, note)


def _common(checks: Mapping[str, Check]) -> Verdict:
    verdicts = {check.verdict for check in checks.values()}
    return verdicts.pop() if len(verdicts) == 1 else Verdict.REPRODUCED


def _parts(checks: Mapping[str, Check]) -> tuple[tuple[str, Verdict, str, str], ...]:
    return tuple(
        (name, check.verdict, check.printed, check.measured) for name, check in checks.items()
    )


def _joined(checks: Mapping[str, Check], side: str) -> str:
    texts = {name: getattr(check, side) for name, check in checks.items()}
    given = {name: text for name, text in texts.items() if text}
    if len(set(given.values())) <= 1:
        return next(iter(given.values()), "")
    return "; ".join(f"{name}: {text}" for name, text in given.items())


_NUMBER = re.compile(
    r"(?P<sign>[+-]?)(?P<whole>\d+)(\.(?P<part>\d*))?([eE](?P<power>[+-]?\d+))?", re.ASCII
)


def _printed(text: str, *, zeros: bool = True) -> tuple[Fraction, Fraction]:
    """A printed number, and one unit of its last digit (significant one without ``zeros``)."""
    found = _NUMBER.fullmatch(text)
    if not found:
        raise ValueError(f"printed number: got {text!r}, expected such as '9.381e-4'")
    places = len(found["part"] or "")
    last = Fraction(10) ** (int(found["power"] or 0) - places)
    if not zeros and not places:
        last *= 10 ** (len(found["whole"]) - len(found["whole"].rstrip("0") or "0"))
    return Fraction(text), last


def _united(text: str, unit: str) -> str:
    return f"{text} {unit}".strip()


def _text(measured: Measured, unit: str) -> str:
    return _united(measured_text(measured), unit)
