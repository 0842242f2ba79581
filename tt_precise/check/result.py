"""The result of all checks of one trajectory: the verdict, and its text, JSON, XML and plot."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy
from msgspec import to_builtins

from tt_precise.runtime.files import as_html
from tt_precise.runtime.plotting import BLACK, CYCLE, new_figure, save, styled
from tt_precise.runtime.records import UNSET, Record, Unset, means
from tt_precise.runtime.terminal import one_line
from tt_precise.runtime.values import Check, Json, Sense, Verdict

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

WIDTH = 100
HEADINGS = ("check", "verdict", "worst", "limit", "at t/s", "note")
SIGNS = {"at most": "<=", "above": ">", "at least": ">="}
MARKS = {"pass": "✅ pass", "fail": "❌ **fail**", "open": "❓ **open**", "skipped": "➖ skipped"}
LEAST, HIGHEST = 1e-12, 1e12  # A plot is linear below the first part of a limit; the largest ratio.
NOT_EXPLAINED = "not explained"
OTHER_FORCE = "; --friction other checks what holds for every contact force"
FEW_DIGITS = 3.0  # Fewer digits of the solution are printed over time.


class Cause(Record, frozen=True):
    """An explanation of a failure."""

    kind: Annotated[
        Literal["convention", "parameter", "precision", "start", "clock"],
        means("the kind of the cause"),
    ]
    text: Annotated[str, means("the cause in one line")]


class CheckRecord(Record, frozen=True, kw_only=True):
    """The result of one check."""

    name: Annotated[str, means("name")]
    verdict: Annotated[Verdict, means("open if the rows do not decide, skipped if not applicable")]
    value: Annotated[float | None, means("the worst value of all rows; null if there is none")]
    limit: Annotated[float | None, means("limit of the value; null if it was not judged")]
    sense: Annotated[Sense, means("how value and limit compare")]
    bound: Annotated[float | None, means("largest error that would go unnoticed; null: none")]
    at: Annotated[float | None, means("time of the worst value in s; null if there is none")]
    since: Annotated[float | None, means("first time in s beyond the limit; null if there is none")]
    reason: Annotated[str, means("reason for skipping, or a remark; may be empty")]
    meaning: Annotated[str, means("meaning, with the place in the paper")]
    digits: Annotated[dict[str, float] | Unset, means("correct digits of each column")] = UNSET
    digits_over_time: Annotated[str | Unset, means("correct digits over time, in words")] = UNSET

    @classmethod
    def of(cls, check: Check) -> CheckRecord:
        """Return the record of a check; JSON has no infinite numbers."""
        return cls(
            name=check.name, verdict=check.verdict, value=_finite(check.value), limit=check.limit,
            sense=check.sense, bound=_finite(check.bound), at=check.at, since=check.since,
            reason=check.note, meaning=check.meaning, digits=check.parts or UNSET,
            digits_over_time=check.history if check.parts else UNSET,
        )  # fmt: skip


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else value


class Checked(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.check/1"):
    """JSON document of `tt-precise check FILE --scene SCENE --json`."""

    trajectory: Annotated[str, means("the checked file or table")]
    scene: Annotated[str, means("name of the scene")]
    columns: Annotated[str, means("the columns")]
    summary: Annotated[list[str], means("the verdict, each failure, its cause, and the digits")]
    verdict: Annotated[
        Literal["pass", "fail", "incomplete"],
        means("fail if a check failed, incomplete if a deciding check was not made, else pass"),
    ]
    unseen: Annotated[list[str], means("the deciding checks that could not be made, in words")]
    written: Annotated[str, means("the digits of a file, if fewer than those of doubles")]
    causes: Annotated[list[Cause], means("explanations of the failures")]
    would_have_seen: Annotated[
        dict[str, float],
        means("the smallest relative change of each number that would have failed"),
    ]
    rows: Annotated[int, means("number of rows")]
    t_first: Annotated[float, means("time of the first row in s, from which others count")]
    t_last: Annotated[float, means("time of the last row in the file, in s")]
    checks: Annotated[list[CheckRecord], means("the checks")]


def unusable(trajectory: str, scene: str, why: str) -> Result:
    """Return the failed check that every format has for a trajectory that cannot be used."""
    refused = Check("input", "fail", note=why, meaning="the input can be used")
    return Result(trajectory, scene, "", 0, 0.0, 0.0, (refused,))


@dataclass(frozen=True, repr=False)
class Result:
    """The results of all checks of one trajectory.

    ``verdict`` is "fail" if a check failed, "incomplete" if a deciding check could not be made
    (``unseen``, in words), else "pass". ``causes`` explain a failure; ``would_have_seen`` has the
    smallest relative change of each number of the body, and of the clock, that would have failed.
    ``written`` states the digits of a file that has fewer of them than doubles. Times count from
    the first row, which has the file's own time ``t_first``.
    """

    trajectory: str
    scene: str
    columns: str
    rows: int
    t_first: float
    t_last: float
    checks: tuple[Check, ...]
    unseen: tuple[str, ...] = ()
    causes: tuple[Cause, ...] = ()
    written: str = ""
    would_have_seen: Mapping[str, float] = field(default_factory=dict)

    @property
    def verdict(self) -> Literal["pass", "fail", "incomplete"]:
        """The verdict on the whole file."""
        if self.failures:
            return "fail"
        return "incomplete" if self.unseen else "pass"

    @property
    def passed(self) -> bool:
        """True if no check failed and every deciding check was made."""
        return self.verdict == "pass"

    @property
    def failures(self) -> tuple[Check, ...]:
        """The failed checks."""
        return tuple(check for check in self.checks if check.verdict == "fail")

    def __getitem__(self, name: str) -> Check:
        return {check.name: check for check in self.checks}[name]

    @cached_property
    def frame(self) -> pandas.DataFrame:
        """A row for each check: name, verdict, value, limit, bound, at and since (s), reason."""
        import pandas

        rows = [to_builtins(CheckRecord.of(check)) for check in self.checks]
        return pandas.DataFrame(rows, columns=CheckRecord.__struct_fields__[:10])

    def as_dict(self) -> dict[str, Json]:
        """The JSON object of the command."""
        values = {name: getattr(self, name) for name in Checked.__struct_fields__}
        values |= {"summary": self.summary(), "checks": [*map(CheckRecord.of, self.checks)]}
        document: dict[str, Json] = to_builtins(Checked(**values))
        return document

    @property
    def heading(self) -> str:
        """The first line of every output: the verdict in words, the scene and the rows."""
        words = self.verdict.upper()
        if self.verdict == "incomplete":
            words += f": could not check {', nor '.join(self.unseen)}"
        span = f"0 to {self.t_last:.6g} s"
        if self.t_first:
            length = self.t_last - self.t_first
            span = f"{length:.6g} s; times count from the first row, t = {self.t_first:.12g} s"
        return one_line(f"{self.trajectory}: {words} ({self.scene}, {self.rows} rows, {span})")

    def remarks(self) -> list[str]:
        """The causes, the digits of the solution, the power and the precision, a line each."""
        causes = [cause.text for cause in self.causes]
        # a number that is not finite is named by its check
        failed = {check.name for check in self.failures} - {"finite"}
        if not causes and self.rows and failed:
            causes = [NOT_EXPLAINED + (OTHER_FORCE if "equations" in failed else "")]
        remarks = [f"cause: {text}" for text in causes]
        for check in self.checks:
            if check.name == "golden" and check.value is not None:
                few = check.value < FEW_DIGITS and check.history
                over_time = f": {check.history}" if few else ""
                remarks.append(f"solution: {check.value:.1f} digits{over_time}")
        if self.passed and self.would_have_seen:
            sizes = (f"{name} {100 * size:.1g} %" for name, size in self.would_have_seen.items())
            remarks.append(f"would have seen: {', '.join(sizes)}")
        remarks += [f"written: {self.written}"] if self.written else []
        return [one_line(remark) for remark in remarks]

    def summary(self) -> list[str]:
        """Return the heading, and a line for each failure, its cause, and the digits."""
        failures = [one_line(check.sentence()) for check in self.failures]
        return [self.heading, *failures, *self.remarks()]

    def __str__(self) -> str:
        """The summary in columns, and the names of the other checks."""
        heading, *lines = self.summary()
        pairs = [line.partition(": ")[::2] for line in lines]
        width = max([10, *(len(name) for name, _ in pairs)])
        screen = [heading]
        for name, text in pairs:
            screen += _wrap(f"  {name:<{width}} {text}", width + 3)
        for verdict, heading in (("pass", "passed"), ("open", "open"), ("skipped", "skipped")):
            names = [
                f"{check.name} ({one_line(check.note)})" if verdict == "open" else check.name
                for check in self.checks
                if check.verdict == verdict
                # digits that nobody required are reported, not passed
                and (check.name != "golden" or check.limit is not None or verdict != "pass")
            ]
            screen += _wrap(f"{heading}: {', '.join(names) or 'none'}", 2)
        return "\n".join([*screen, "--verbose shows the table"])

    __repr__ = __str__  # a session prints a result as the command does

    def table(self) -> str:
        """The table of all checks for a terminal, with the remarks."""
        rows = [HEADINGS, *map(_cells, self.checks)]
        widths = [max(len(row[i]) for row in rows) for i in range(5)]
        lines = _wrap(self.heading, 2)
        for row in rows:
            cells = [cell.ljust(width) for cell, width in zip(row, (*widths, 0), strict=True)]
            lines += _wrap("  ".join(cells).rstrip(), sum(widths) + 10)
        for check in self.checks:
            if check.parts:
                digits = "  ".join(f"{name} {value:.1f}" for name, value in check.parts.items())
                lines += _wrap(f"{check.name}, correct digits of each column: {digits}", 2)
        return "\n".join([*lines, *(line for each in self.remarks() for line in _wrap(each, 2))])

    def markdown(self) -> str:
        """The table in Markdown, for the summary of a CI job."""
        lines = [f"### {_escape(self.heading)}", "", f"| {' | '.join(HEADINGS)} |",
                 "| --- | --- | ---: | ---: | ---: | --- |"]  # fmt: skip
        for check in self.checks:
            name, _, *rest = _cells(check)
            cells = (f"`{name}`", MARKS[check.verdict], *map(_escape, rest))
            lines.append(f"| {' | '.join(cells)} |")
        return "\n".join([*lines, "", *(f"- {_escape(each)}" for each in self.remarks()), ""])

    def _repr_html_(self) -> str:
        return as_html(self.heading, map(_cells, self.checks), HEADINGS)

    def junit(self) -> str:
        """The results as JUnit XML: a test case for each check, and the text for a terminal."""
        from xml.etree.ElementTree import Element, SubElement, indent, tostring

        checks: Sequence[Check] = self.checks
        if self.verdict == "incomplete":
            note, meaning = ", nor ".join(self.unseen), "every deciding check was made"
            note = f"could not check {note}"
            checks = [*checks, Check("looked_at", "fail", note=note, meaning=meaning)]
        verdicts = [check.verdict for check in checks]
        skipped = verdicts.count("open") + verdicts.count("skipped")
        counts = {"tests": str(len(checks)), "failures": str(verdicts.count("fail")),
                  "errors": "0", "skipped": str(skipped)}  # fmt: skip
        suites = Element("testsuites", counts)
        suite = SubElement(suites, "testsuite", {"name": "tt-precise check", **counts})
        classname = one_line(f"{self.scene}.{self.trajectory}")
        for check in checks:
            case = SubElement(suite, "testcase", {"name": check.name, "classname": classname})
            sentence = one_line(check.sentence())
            if check.verdict == "pass":
                SubElement(case, "system-out").text = sentence
            elif check.verdict == "fail":
                failure = SubElement(case, "failure", {"message": sentence})
                failure.text = "\n".join([check.meaning, *self.remarks()])
            else:
                message = one_line(f"{check.verdict}: {check.note}")
                SubElement(case, "skipped", {"message": message})
        SubElement(suite, "system-out").text = str(self)
        indent(suites)
        return tostring(suites, "unicode", xml_declaration=True) + "\n"

    @styled()
    def plot(self, path: str | Path | None = None) -> Figure:
        """Return a matplotlib ``Figure`` of each value over its limit, written to ``path``.

        Failures come first, with a dot at the first time beyond the limit.
        """
        figure = new_figure(8, 4.5)
        axes = figure.add_subplot()
        # black is the limit; further curves have the same colours in dashes and dots
        styles = itertools.product(("-", "-."), (colour for colour in CYCLE if colour != BLACK))
        checks = sorted(self.checks, key=lambda check: check.verdict != "fail")
        drawn = [(check, check.limit, *check.curve) for check in checks if check.curve
                 and check.sense == "at most" and (check.limit or 0) > 0]  # fmt: skip
        for (check, limit, t, values), (line, colour) in zip(drawn, styles, strict=False):
            with numpy.errstate(over="ignore"):
                ratios = numpy.minimum(numpy.nan_to_num(values / limit, nan=HIGHEST), HIGHEST)
            label = f"{check.name} {check.value:.1e}, allowed {limit:.1e}"
            axes.plot(t, ratios, color=colour, linestyle=line, linewidth=1, label=label)
            if check.since is not None:
                axes.plot(check.since, ratios[ratios > 1][0], "o", color=colour, markersize=4)
        # a value of 0 has a position on the axis
        axes.set_yscale("symlog", linthresh=LEAST, linscale=0.5)
        axes.set_ylim(bottom=-LEAST / 4)
        axes.axhline(1.0, color=BLACK, linewidth=2, label="limit")
        axes.set(xlabel="t (s)", ylabel="value/limit")
        axes.set_title(f"{Path(self.trajectory).name} against {self.scene}: {self.verdict}")
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
        if path is not None:
            save(figure, path)
        return figure


def _wrap(text: str, indent: int) -> list[str]:
    return textwrap.wrap(text, WIDTH, subsequent_indent=" " * indent, break_long_words=False)


def _cells(check: Check) -> tuple[str, ...]:
    def number(value: float | None, digits: int = 3) -> str:
        return "" if value is None else f"{value:.{digits}g}"

    limit = number(check.limit)
    verdict = check.verdict.upper() if check.verdict == "fail" else check.verdict
    return (check.name, verdict, number(check.value),
            f"{SIGNS[check.sense]} {limit}" if limit else "", number(check.at, 6),
            one_line(check.note))  # fmt: skip


def _escape(text: str) -> str:
    for mark in "\\|`*_<>[]":
        text = text.replace(mark, "\\" + mark)
    return text
