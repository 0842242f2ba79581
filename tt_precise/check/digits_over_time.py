"""How many digits are right until when, in a few words."""

from __future__ import annotations

import numpy

from tt_precise.check.worst import RunningWorst
from tt_precise.golden.distance import correct_digits
from tt_precise.golden.measuring import Measured

STEPS = (12, 10, 8, 6, 4, 2, 1)  # digits whose end is looked for
MOST = 3  # of them are named
EARLY = 0.02  # part of the span before which an end is not worth a word
FURTHER = 1.2  # times the end before, for another one to be named


class DigitsOverTime:
    """Takes blocks of measured rows; as text such as "9 digits until 1.2 s, none from 5 s"."""

    def __init__(self) -> None:
        self._errors = RunningWorst()

    def add(self, found: Measured) -> None:
        """The next rows."""
        rows = found.compared & ~found.start
        if rows.any():
            self._errors.add(found.t[rows], found.worst()[rows])

    @property
    def from_the_start(self) -> bool:
        """Whether no digit is right in the first row after the start already."""
        _, errors = self._errors.curve
        return len(errors) > 0 and correct_digits(errors[0]) < 1

    def __str__(self) -> str:
        t, errors = self._errors.curve
        if not len(t):
            return ""
        order = numpy.argsort(t)
        t, errors = t[order], errors[order]
        worst = numpy.maximum.accumulate(errors)
        spans: list[tuple[int, float]] = []
        for digits in STEPS:
            good = int(numpy.searchsorted(worst, 10.0**-digits, side="right"))
            if good == len(t):
                spans.append((digits, float(t[-1])))
                break
            until = float(t[good - 1]) if good else 0.0
            if until > EARLY * t[-1] and (not spans or until > FURTHER * spans[-1][1]):
                spans.append((digits, until))
        whole = bool(spans) and spans[-1][1] == t[-1]
        named = spans[:1] + spans[1:][-(MOST - 1) :]
        words = [
            f"{digits} {'digit' if digits == 1 else 'digits'} "
            + ("to the end" if until == t[-1] else f"until {until:.3g} s")
            for digits, until in named
        ]
        if not whole:
            beyond = numpy.flatnonzero(worst > 0.1)
            words.append(f"none from {t[beyond[0]]:.3g} s" if len(beyond) else "fewer then")
        return ", ".join(words)
