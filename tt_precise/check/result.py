"""What a check run returns: a finding for every check, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tt_precise.check import outputs
from tt_precise.check.finding import CheckFinding
from tt_precise.runtime.untyped import Json

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

SCHEMA = "tt_precise.check/1"
FEW_DIGITS = 4  # fewer of golden data, where none were asked for, are said loudly

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

    def as_dict(self) -> dict[str, Json]:
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

    @property
    def heading(self) -> str:
        """The first line of every output: the verdict, and how far golden data agree."""
        count = len(self.failures)
        failed = f": {count} check{'s' * (count > 1)} failed" if count else ""
        return (
            f"{self.trajectory} against scene {self.scene}: {self.verdict}{failed}"
            f"{self._golden()} ({self.rows} rows of {self.columns} columns, "
            f"t = {self.t_first:.6g} to {self.t_last:.6g} s)"
        )

    def _golden(self) -> str:
        golden = next((finding for finding in self.checks if finding.name == "golden"), None)
        if golden is None or golden.value is None:
            return ""
        over_time = f" ({golden.history})" if golden.history else ""
        if golden.limit is None and golden.value < FEW_DIGITS:
            return f", BUT ONLY {golden.value:.1f} CORRECT DIGITS of golden data{over_time}"
        return f", {golden.value:.1f} correct digits of golden data"

    def __str__(self) -> str:
        return outputs.table(self.heading, self.checks)

    def _repr_html_(self) -> str:
        return outputs.html(self.heading, self.checks)

    def markdown(self) -> str:
        """The table in Markdown, for the summary of a CI job."""
        return outputs.markdown(self.heading, self.checks)

    def junit(self) -> str:
        """The findings as JUnit XML: one test case for each check."""
        return outputs.junit(f"{self.scene}.{self.trajectory}", self.checks)

    def plot(self, path: str | Path | None = None) -> Figure:
        """A matplotlib ``Figure`` of all drifts over time, written to ``path`` if one is given."""
        from tt_precise.check.plot import figure

        name = Path(self.trajectory).name
        return figure(f"{name} against {self.scene}: {self.verdict}", self.checks, path)
