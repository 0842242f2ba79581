"""The result of a check, the same whatever was checked."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.untyped import Json

Verdict = Literal["pass", "fail", "info", "skipped"]
Sense = Literal["at most", "above", "at least"]


@dataclass(frozen=True)
class Check:
    """One check as it came out: of a trajectory, an engine, a case.

    ``value`` is the worst of all rows, ``at`` its time in s, ``note`` why it was skipped or
    what else must be known. ``curve`` holds times and values for a plot, ``parts`` what the value
    is made of (correct digits of every column), and ``history`` says how it came about over time.
    """

    name: str
    verdict: Verdict
    value: float | None = None
    limit: float | None = None
    at: float | None = None
    note: str = ""
    meaning: str = ""
    sense: Sense = "at most"
    parts: dict[str, float] = field(default_factory=dict)
    history: str = ""
    curve: tuple[Array, Array] | None = field(default=None, repr=False, compare=False)

    def as_dict(self) -> dict[str, Json]:
        """For JSON."""
        # JSON has no infinity: an infinite worst value is given by its note
        value = None if self.value is None or not math.isfinite(self.value) else self.value
        found: dict[str, Json] = {
            "name": self.name,
            "verdict": self.verdict,
            "value": value,
            "limit": self.limit,
            "sense": self.sense,
            "at": self.at,
            "reason": self.note,
            "meaning": self.meaning,
        }
        if self.parts:
            found |= {"digits": self.parts, "digits_over_time": self.history}
        return found

    def sentence(self) -> str:
        """One line: check, value, limit, time."""
        if self.value is None or self.limit is None:
            return f"{self.name}: {self.note}"
        where = f" at t = {self.at:.6g} s" if self.at is not None else ""
        why = f" ({self.note})" if self.note else ""
        return f"{self.name}: {self.value:.3g}{where}, expected {self.sense} {self.limit:.3g}{why}"
