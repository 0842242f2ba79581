"""What a check run returns: a finding for every check, and the verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import numpy
    import pandas

    from tt_precise.check.checks import Sense

Verdict = Literal["pass", "fail", "skipped"]
SCHEMA = "tt_precise.check/1"
SIGNS = {"at most": "<=", "above": ">", "at least": ">="}


@dataclass(frozen=True)
class CheckFinding:
    """One check as it came out.

    ``value`` is the worst of all rows, ``at`` its time in s, ``reason`` why it was skipped or
    what else must be known. ``curve`` holds times and values for a plot, ``parts`` what the value
    is made of (correct digits of every column).
    """

    name: str
    verdict: Verdict
    value: float | None = None
    limit: float | None = None
    at: float | None = None
    reason: str = ""
    meaning: str = ""
    sense: Sense = "at most"
    parts: dict[str, float] = field(default_factory=dict)
    curve: tuple[numpy.ndarray, numpy.ndarray] | None = field(
        default=None, repr=False, compare=False
    )

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        # JSON has no infinity: an infinite worst value is told by its reason
        value = None if self.value is None or not math.isfinite(self.value) else self.value
        found: dict[str, Any] = {
            "name": self.name,
            "verdict": self.verdict,
            "value": value,
            "limit": self.limit,
            "sense": self.sense,
            "at": self.at,
            "reason": self.reason,
            "meaning": self.meaning,
        }
        return found | ({"digits": self.parts} if self.parts else {})

    def sentence(self) -> str:
        """One line: check, value, limit, time."""
        if self.value is None or self.limit is None:
            return f"{self.name}: {self.reason}"
        where = f" at t = {self.at:.6g} s" if self.at is not None else ""
        why = f" ({self.reason})" if self.reason else ""
        return f"{self.name}: {self.value:.3g}{where}, expected {self.sense} {self.limit:.3g}{why}"


Finding = CheckFinding  # its public name in tt_precise.check


@dataclass(frozen=True)
class Result:
    """All findings about one trajectory.

    ``verdict`` is "pass" if no check failed; ``frame`` is the table; in a notebook it shows
    itself.
    """

    trajectory: str
    scene: str
    columns: str
    rows: int
    t_first: float
    t_last: float
    checks: tuple[CheckFinding, ...]

    @property
    def verdict(self) -> Literal["pass", "fail"]:
        """Whether a check failed."""
        return "fail" if self.failures else "pass"

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return not self.failures

    @property
    def failures(self) -> tuple[CheckFinding, ...]:
        """The findings that failed."""
        return tuple(finding for finding in self.checks if finding.verdict == "fail")

    def __getitem__(self, name: str) -> CheckFinding:
        for finding in self.checks:
            if finding.name == name:
                return finding
        raise KeyError(name)

    @cached_property
    def frame(self) -> pandas.DataFrame:
        """A row for each check: name, verdict, value, limit, sense, at (s), reason, meaning."""
        import pandas

        rows = [finding.as_dict() for finding in self.checks]
        names = ["name", "verdict", "value", "limit", "sense", "at", "reason", "meaning"]
        return pandas.DataFrame(rows, columns=names)

    def as_dict(self) -> dict[str, Any]:
        """The JSON object of the command."""
        return {
            "schema": SCHEMA,
            "trajectory": self.trajectory,
            "scene": self.scene,
            "columns": self.columns,
            "verdict": self.verdict,
            "rows": self.rows,
            "t_first": self.t_first,
            "t_last": self.t_last,
            "checks": [finding.as_dict() for finding in self.checks],
        }

    def __str__(self) -> str:
        from tt_precise.check.outputs import table

        return table(self)

    def _repr_html_(self) -> str:
        from tt_precise.check.outputs import html

        return html(self)

    def markdown(self) -> str:
        """The table in Markdown, for the summary of a CI job."""
        from tt_precise.check.outputs import markdown

        return markdown(self)

    def junit(self) -> str:
        """The findings as JUnit XML: one test case for each check."""
        from tt_precise.check.outputs import junit

        return junit(self)

    def plot(self, path: str | Path | None = None) -> Any:
        """A matplotlib ``Figure`` of all drifts over time, written to ``path`` if one is given."""
        from tt_precise.check.plot import figure

        return figure(self, path)
