"""The results of checks and the verdict: as tables, Markdown, HTML, XML and a plot."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy

from tt_precise.runtime.terminal import one_line
from tt_precise.runtime.values import Check, Json

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

SIGNS = {"at most": "<=", "above": ">", "at least": ">="}
MOST_POINTS = 4096


class RunningWorst:
    """Takes values of consecutive rows; keeps the worst, and the worst of every bucket of rows.

    ``largest_is_worst`` is False for checks with a lower limit. NaN is the worst value.
    """

    def __init__(self, largest_is_worst: bool = True):
        self._sign = 1.0 if largest_is_worst else -1.0
        self.worst: float | None = None
        self.at: float | None = None
        self._bucket = 1
        self._t: list[numpy.ndarray] = []
        self._values: list[numpy.ndarray] = []
        self._count = 0

    def add(self, t: numpy.ndarray, values: numpy.ndarray) -> None:
        badness = numpy.where(numpy.isnan(values), numpy.inf, values * self._sign)
        row = int(numpy.argmax(badness))
        if self.worst is None or badness[row] > self.worst * self._sign:
            self.worst, self.at = float(badness[row] * self._sign), float(t[row])
        self._keep(t, badness, self._bucket)
        if self._count > 2 * MOST_POINTS:
            t, badness = numpy.concatenate(self._t), numpy.concatenate(self._values)
            factor = math.ceil(self._count / MOST_POINTS)
            self._t, self._values, self._count = [], [], 0
            self._bucket *= factor
            self._keep(t, badness, factor)

    def _keep(self, t: numpy.ndarray, badness: numpy.ndarray, bucket: int) -> None:
        starts = numpy.arange(0, len(t), bucket)
        self._t.append(t[starts])
        self._values.append(numpy.maximum.reduceat(badness, starts))
        self._count += len(starts)

    @property
    def curve(self) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Times (s), and the worst value of the bucket of rows that begins at each."""
        if not self._t:
            return numpy.empty(0), numpy.empty(0)
        return numpy.concatenate(self._t), self._sign * numpy.concatenate(self._values)


WIDTH = 100
MARKS = {"pass": "✅ pass", "fail": "❌ **fail**", "info": "ℹ️ info", "skipped": "➖ skipped"}
HEADINGS = ("check", "verdict", "worst", "limit", "at t/s", "note")


def _number(value: float | None, digits: int = 3) -> str:
    return "" if value is None else f"{value:.{digits}g}"


def _cells(finding: Check) -> tuple[str, ...]:
    limit = _number(finding.limit)
    return (
        finding.name,
        finding.verdict.upper() if finding.verdict == "fail" else finding.verdict,
        _number(finding.value),
        f"{SIGNS[finding.sense]} {limit}" if limit else "",
        _number(finding.at, 6),
        one_line(finding.note),
    )


def _escaped(text: str) -> str:
    for mark in "\\|`*_<>[]":
        text = text.replace(mark, "\\" + mark)
    return text


def _printable(text: str) -> str:
    # XML does not allow control characters, but file names do
    return "".join(c if c.isprintable() else "?" for c in text)


SMALLEST = 1e-18  # drawn for an exact zero
SCHEMA = "tt_precise.check/1"
FEW_DIGITS = 4  # fewer digits of golden data give a warning, even if no digits were requested


def unusable(trajectory: str, scene: str, why: str) -> Result:
    """The failed check that every format shows for a trajectory that cannot be used."""
    refused = Check("input", "fail", note=why, meaning="the input can be used")
    return Result(trajectory, scene, "", 0, 0.0, 0.0, (refused,))


@dataclass(frozen=True)
class Result:
    """All findings about one trajectory.

    ``verdict`` is "pass" if no check failed; ``frame`` is the table, shown in a notebook.
    """

    trajectory: str
    scene: str
    columns: str
    rows: int
    t_first: float
    t_last: float
    checks: tuple[Check, ...]

    @property
    def verdict(self) -> Literal["pass", "fail"]:
        """Whether a check failed."""
        return "fail" if self.failures else "pass"

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return not self.failures

    @property
    def failures(self) -> tuple[Check, ...]:
        """The findings that failed."""
        return tuple(finding for finding in self.checks if finding.verdict == "fail")

    def __getitem__(self, name: str) -> Check:
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
        """The first line of every output: the verdict and the agreement with golden data."""
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
        if golden.verdict == "info":
            return ", another start than that of golden data"
        over_time = f" ({golden.history})" if golden.history else ""
        if golden.limit is None and golden.value < FEW_DIGITS:
            return f", BUT ONLY {golden.value:.1f} CORRECT DIGITS of golden data{over_time}"
        return f", {golden.value:.1f} correct digits of golden data"

    def __str__(self) -> str:
        """The results for a terminal, with the skipped checks below."""
        done = [finding for finding in self.checks if finding.verdict != "skipped"]
        rows = [HEADINGS, *map(_cells, done)]
        widths = [max(len(row[i]) for row in rows) for i in range(5)]
        margin = sum(widths) + 2 * len(widths)
        lines = textwrap.wrap(one_line(self.heading), WIDTH)
        for row in rows:
            padded = [cell.ljust(size) for cell, size in zip(row, widths, strict=False)]
            notes = textwrap.wrap(row[5], max(24, WIDTH - margin)) or [""]
            lines.append("  ".join([*padded, notes[0]]).rstrip())
            lines += [" " * margin + note for note in notes[1:]]
        for finding in done:
            if finding.parts:
                listed = "  ".join(f"{name} {digits:.1f}" for name, digits in finding.parts.items())
                lines += textwrap.wrap(
                    f"{finding.name}, correct digits of each column: {listed}", WIDTH,
                    subsequent_indent="  ",
                )  # fmt: skip
        reasons: dict[str, list[str]] = {}
        for finding in self.checks:
            if finding.verdict == "skipped":
                reasons.setdefault(finding.note, []).append(finding.name)
        for reason, names in reasons.items():
            lines += textwrap.wrap(
                f"skipped {', '.join(names)}: {one_line(reason)}", WIDTH, subsequent_indent="  "
            )
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from html import escape

        import pandas

        rows = pandas.DataFrame(map(_cells, self.checks), columns=list(HEADINGS))
        return f"<p>{escape(one_line(self.heading))}</p>{rows.to_html(index=False)}"

    def markdown(self) -> str:
        """The table in Markdown, for the summary of a CI job."""
        lines = [
            f"### {_escaped(one_line(self.heading))}",
            "",
            "| " + " | ".join(HEADINGS) + " |",
            "| --- | --- | ---: | ---: | ---: | --- |",
        ]
        for finding in self.checks:
            name, _, *rest = _cells(finding)
            cells = (f"`{name}`", MARKS[finding.verdict], *map(_escaped, rest))
            lines.append("| " + " | ".join(cells) + " |")
        return "\n".join(lines) + "\n"

    def junit(self) -> str:
        """The findings as JUnit XML: one test case for each check."""
        from xml.etree import ElementTree

        counts = {
            "tests": str(len(self.checks)),
            "failures": str(sum(finding.verdict == "fail" for finding in self.checks)),
            "errors": "0",
            "skipped": str(sum(finding.verdict == "skipped" for finding in self.checks)),
        }
        classname = _printable(f"{self.scene}.{self.trajectory}")
        suites = ElementTree.Element("testsuites", counts)
        suite = ElementTree.SubElement(suites, "testsuite", {"name": "tt-precise check", **counts})
        for finding in self.checks:
            named = {"name": finding.name, "classname": classname}
            case = ElementTree.SubElement(suite, "testcase", named)
            if finding.verdict == "skipped":
                ElementTree.SubElement(case, "skipped", {"message": _printable(finding.note)})
            elif finding.verdict == "fail":
                message = {"message": _printable(finding.sentence())}
                ElementTree.SubElement(case, "failure", message).text = finding.meaning
            else:
                ElementTree.SubElement(case, "system-out").text = _printable(finding.sentence())
        ElementTree.indent(suites)
        return ElementTree.tostring(suites, "unicode", xml_declaration=True) + "\n"

    def plot(self, path: str | Path | None = None) -> Figure:
        """A matplotlib ``Figure`` of all drifts over time, written to ``path`` if one is given."""
        from tt_precise.runtime.plotting import require_format, save, styled

        if path is not None:
            require_format(path)
        with styled():
            drawn = self._drawn()
        if path is not None:
            save(drawn, path)
        return drawn

    def _drawn(self) -> Figure:
        from tt_precise.runtime.plotting import new_figure

        drawn = new_figure(8, 4.5)
        axes = drawn.add_subplot()
        limits: dict[float, Any] = {}
        for finding in self.checks:
            if finding.curve is None or finding.sense != "at most" or finding.verdict == "skipped":
                continue
            t, values = finding.curve
            label = f"{finding.name} {finding.value:.1e}"
            (line,) = axes.semilogy(t, numpy.maximum(values, SMALLEST), linewidth=1, label=label)
            if finding.limit is not None and finding.limit > 0:
                limits[finding.limit] = "black" if finding.limit in limits else line.get_color()
        for limit, colour in limits.items():
            label = f"limit {limit:.1e}"
            axes.axhline(limit, color=colour, linestyle="--", linewidth=1, label=label)
        axes.set_xlabel("t (s)")
        axes.set_ylabel("relative drift")
        axes.set_title(f"{Path(self.trajectory).name} against {self.scene}: {self.verdict}")
        if axes.lines:
            axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
        return drawn
