"""The results of checks and the verdict: as tables, Markdown, HTML, XML and a plot."""

from __future__ import annotations

import itertools
import math
import operator
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple

import numpy
from msgspec import to_builtins

from tt_precise.runtime.plotting import BLACK, CYCLE, new_figure, save, styled, thinned
from tt_precise.runtime.records import UNSET, Record, Unset, means
from tt_precise.runtime.terminal import one_line
from tt_precise.runtime.values import Array, Check, Json, Sense, Verdict

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure


class Cause(Record, frozen=True):
    """An explanation of a failure."""

    kind: Annotated[
        Literal[
            "columns",
            "convention",
            "parameter",
            "precision",
            "start",
            "clock",
            "rows",
            "end",
            "force",
        ],
        means("the kind of the cause"),
    ]
    text: Annotated[str, means("the cause in one line")]


class CheckRecord(Record, frozen=True, kw_only=True):
    """The result of one check."""

    name: Annotated[str, means("name")]
    verdict: Annotated[
        Verdict,
        means(
            "open if the rows do not decide or a column is missing, skipped if it does not apply"
        ),
    ]
    value: Annotated[float | None, means("the worst value of all rows; null if there is none")]
    limit: Annotated[float | None, means("limit of the value; null if it was not judged")]
    sense: Annotated[Sense, means("how value and limit compare")]
    bound: Annotated[
        float | None, means("largest error that would go unnoticed; null: none, or not finite")
    ]
    at: Annotated[float | None, means("time of the worst value in s; null if there is none")]
    since: Annotated[float | None, means("first time in s beyond the limit; null if there is none")]
    reason: Annotated[str, means("reason for skipping, or a remark; may be empty")]
    meaning: Annotated[str, means("meaning, with the place in the paper")]
    digits: Annotated[dict[str, float] | Unset, means("correct digits of each column")] = UNSET
    digits_over_time: Annotated[str | Unset, means("correct digits over time, in words")] = UNSET

    @classmethod
    def of(cls, finding: Check) -> CheckRecord:
        """Return the record of a check; the note states an infinite value, which JSON has not."""
        return cls(
            name=finding.name,
            verdict=finding.verdict,
            value=_finite(finding.value),
            limit=finding.limit,
            sense=finding.sense,
            bound=_finite(finding.bound),
            at=finding.at,
            since=finding.since,
            reason=finding.note,
            meaning=finding.meaning,
            digits=finding.parts or UNSET,
            digits_over_time=finding.history if finding.parts else UNSET,
        )


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else value


class Checked(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.check/1"):
    """JSON document of `tt-precise check FILE --scene SCENE --json`."""

    trajectory: Annotated[str, means("the checked file or table")]
    scene: Annotated[str, means("name of the scene")]
    columns: Annotated[str, means("the columns")]
    summary: Annotated[
        list[str],
        means("the verdict in words, each failure, its cause, and the digits of the solution"),
    ]
    verdict: Annotated[
        Literal["pass", "fail", "incomplete"],
        means("fail if a check failed, incomplete if a deciding check was not made, else pass"),
    ]
    unseen: Annotated[list[str], means("the deciding checks that could not be made, in words")]
    written: Annotated[
        str, means("columns that are written with fewer digits than doubles; may be empty")
    ]
    causes: Annotated[list[Cause], means("what explains a failure")]
    rows: Annotated[int, means("number of rows")]
    t_first: Annotated[
        float, means("the file's own time of the first row in s, from which other times count")
    ]
    t_last: Annotated[float, means("time of the last row in s")]
    checks: Annotated[list[CheckRecord], means("the checks")]


SIGNS = {"at most": "<=", "above": ">", "at least": ">="}
HOLDS = {"at most": operator.le, "above": operator.gt, "at least": operator.ge}
LEAST = 1e-12  # A plot draws values below this part of the limit linearly, down to 0.
HIGHEST = 1e12  # A plot draws values above this multiple of the limit, and infinite ones, here.


class Residual(NamedTuple):
    """The values of a check at the rows, to be compared with the check's limit.

    The error bound of each value is already subtracted. ``bound`` is the largest error that would
    go unnoticed; ``open`` is the reason why the rows do not decide, "" if they decide, which they
    do if ``bound`` is at most the limit, or ``decided``. ``t`` are the times (s) of the values,
    None for one value per row.
    """

    values: Array
    bound: float = 0.0
    note: str = ""
    open: str = ""
    t: Array | None = None
    decided: bool = False


def check_of_rows(
    name: str, meaning: str, sense: Sense, limit: float, t: Array, seen: Residual
) -> Check:
    """Return the check of rows at the times ``t`` (s); a value that is NaN fails."""
    t = t if seen.t is None else seen.t
    values = numpy.broadcast_to(seen.values, t.shape)
    beyond = ~HOLDS[sense](values, limit)
    sign = 1.0 if sense == "at most" else -1.0
    badness = numpy.where(numpy.isnan(values), numpy.inf, sign * values)
    worst = int(numpy.argmax(badness))
    value = float(sign * badness[worst])
    verdict: Verdict = "pass"
    note, since = seen.note, None
    if beyond.any():
        verdict, since = "fail", float(t[int(numpy.argmax(beyond))])
        note = note if math.isfinite(value) else "not finite there"
    elif seen.open or (sense == "at most" and seen.bound > limit and not seen.decided):
        verdict, note = "open", seen.open or f"rows too far apart; {note}"
    shown = thinned(t, badness)
    return Check(
        name, verdict, value, limit, float(t[worst]), note, meaning, sense,
        bound=seen.bound, since=since, curve=(t[shown], sign * badness[shown]),
    )  # fmt: skip


WIDTH = 100
MARKS = {
    "pass": "✅ pass", "fail": "❌ **fail**", "open": "❓ **open**", "skipped": "➖ skipped",
}  # fmt: skip
HEADINGS = ("check", "verdict", "worst", "limit", "at t/s", "note")


def to_one_digit(value: float, rounded: Callable[[float], int]) -> float:
    """Return ``value`` with its first digit only, ``rounded`` up or down."""
    if not 0 < value < math.inf:
        return value
    exponent = math.floor(math.log10(value))
    return float(f"{rounded(value / 10.0**exponent)}e{exponent}")


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


FEW_DIGITS = 3  # fewer digits than these are shown over time


def shortened(note: str) -> str:
    """The first clause of a note, and the spacing of rows that would suffice."""
    first, *rest = one_line(note).split("; ")
    return "; ".join([first, *(clause for clause in rest if clause.endswith("would suffice"))])


def _pairs(pairs: Sequence[tuple[str, str]]) -> list[str]:
    lines, width = [], max([10, *(len(name) for name, _ in pairs)])
    for name, text in pairs:
        lines += textwrap.wrap(
            f"  {name:<{width}} {one_line(text)}", WIDTH, subsequent_indent=" " * (width + 3),
            break_long_words=False,
        )  # fmt: skip
    return lines


def _listed(heading: str, names: Sequence[str]) -> list[str]:
    return _wrapped(f"{heading}: {', '.join(names) or 'none'}")


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, WIDTH, subsequent_indent="  ")


def unusable(trajectory: str, scene: str, why: str) -> Result:
    """The failed check that every format shows for a trajectory that cannot be used."""
    refused = Check("input", "fail", note=why, meaning="the input can be used")
    return Result(trajectory, scene, "", 0, 0.0, 0.0, (refused,))


@dataclass(frozen=True)
class Result:
    """The results of all checks of one trajectory.

    ``verdict`` is "fail" if a check failed, "incomplete" if a deciding check could not be made
    (``unseen``, in words), else "pass". ``causes`` explain a failure. ``written`` names columns
    with fewer digits than doubles. Times count from the first row, which has the file's own time
    ``t_first``. ``frame`` is the table, shown in a notebook.
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
        return self._with("fail")

    def _with(self, verdict: Verdict) -> tuple[Check, ...]:
        return tuple(finding for finding in self.checks if finding.verdict == verdict)

    def __getitem__(self, name: str) -> Check:
        for finding in self.checks:
            if finding.name == name:
                return finding
        raise KeyError(name)

    @cached_property
    def frame(self) -> pandas.DataFrame:
        """A row for each check: name, verdict, value, limit, bound, at and since (s), reason."""
        import pandas

        rows = [to_builtins(CheckRecord.of(finding)) for finding in self.checks]
        return pandas.DataFrame(rows, columns=CheckRecord.__struct_fields__[:10])

    def as_dict(self) -> dict[str, Json]:
        """The JSON object of the command."""
        checked = Checked(
            trajectory=self.trajectory,
            scene=self.scene,
            columns=self.columns,
            summary=self.summary(),
            verdict=self.verdict,
            unseen=list(self.unseen),
            written=self.written,
            causes=list(self.causes),
            rows=self.rows,
            t_first=self.t_first,
            t_last=self.t_last,
            checks=[CheckRecord.of(finding) for finding in self.checks],
        )
        document: dict[str, Json] = to_builtins(checked)
        return document

    @property
    def heading(self) -> str:
        """The first line of every output: the verdict in words, the scene and the rows."""
        words = self.verdict.upper()
        if self.verdict == "incomplete":
            words += f": {self._unseen_in_words()}"
        return f"{self.trajectory}: {words} ({self.scene}, {self.rows} rows, {self._span()})"

    def _unseen_in_words(self) -> str:
        return f"could not check {', nor '.join(self.unseen)}"

    def _span(self) -> str:
        if not self.t_first:
            return f"0 to {self.t_last:.6g} s"
        length = self.t_last - self.t_first
        return f"{length:.6g} s; times count from the first row, t = {self.t_first:.12g} s"

    def summary(self) -> list[str]:
        """Return the heading, and a line for each failure, its cause, and the digits."""
        remarks = [f"{name}: {text}" for name, text in self._remarks()]
        failures = [finding.sentence() for finding in self.failures]
        return [one_line(text) for text in (self.heading, *failures, *remarks)]

    def __str__(self) -> str:
        """The verdict, each failure with its cause, the digits, and the names of other checks."""
        lines = [one_line(self.heading)]
        pairs = [(finding.name, finding.words()) for finding in self.failures]
        lines += _pairs([*pairs, *self._remarks()])
        passed, open_, skipped = self._with("pass"), self._with("open"), self._with("skipped")
        # digits that nobody asked for are reported, not passed
        names = [one.name for one in passed if one.name != "golden" or one.limit is not None]
        lines += _listed("passed", names)
        lines += _listed("open", [f"{one.name} ({shortened(one.note)})" for one in open_])
        lines += _listed("skipped", [finding.name for finding in skipped])
        return "\n".join([*lines, "--verbose shows the table"])

    def _remarks(self) -> list[tuple[str, str]]:
        """The causes, the digits of the solution, and the columns with few digits, by name."""
        causes = [cause.text for cause in self.causes]
        # a number that is not finite is named by its line
        if not causes and self.rows and any(one.name != "finite" for one in self.failures):
            causes = ["not explained"]
        remarks = [("cause", text) for text in causes]
        remarks += [("solution", text) for text in self._solution()]
        return remarks + [("written", text) for text in [self.written] if text]

    def _solution(self) -> list[str]:
        golden = next((finding for finding in self.checks if finding.name == "golden"), None)
        if golden is None or golden.value is None:
            return []
        over_time = f": {golden.history}" if golden.history and golden.value < FEW_DIGITS else ""
        return [f"{golden.value:.1f} digits{over_time}"]

    def table(self) -> str:
        """The results as a table for a terminal, with a note on checks that could not be made."""
        done = [finding for finding in self.checks if finding.value is not None]
        rows = [HEADINGS, *map(_cells, done)]
        widths = [max(len(row[i]) for row in rows) for i in range(5)]
        margin = sum(widths) + 2 * len(widths)
        lines = _wrapped(one_line(self.heading))
        for row in rows:
            padded = [cell.ljust(size) for cell, size in zip(row, widths, strict=False)]
            notes = textwrap.wrap(row[5], max(24, WIDTH - margin)) or [""]
            lines.append("  ".join([*padded, notes[0]]).rstrip())
            lines += [" " * margin + note for note in notes[1:]]
        for finding in done:
            if finding.parts:
                listed = "  ".join(f"{name} {digits:.1f}" for name, digits in finding.parts.items())
                lines += _wrapped(f"{finding.name}, correct digits of each column: {listed}")
        for cause in self.causes:
            lines += _wrapped(f"cause: {one_line(cause.text)}")
        reasons: dict[tuple[str, str], list[str]] = {}
        for finding in self.checks:
            if finding.value is None:
                reasons.setdefault((finding.verdict, finding.note), []).append(finding.name)
        for (verdict, reason), names in reasons.items():
            lines += _wrapped(f"{verdict} {', '.join(names)}: {one_line(reason)}")
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
        remarks = [f"- {name}: {_escaped(one_line(text))}" for name, text in self._remarks()]
        return "\n".join([*lines, "", *remarks]) + "\n"

    def junit(self) -> str:
        """The results as JUnit XML: a test case for each check, and the text for a terminal."""
        from xml.etree import ElementTree

        checks = [*self.checks]
        if self.verdict == "incomplete":
            meaning = "every deciding check was made"
            checks.append(Check("looked_at", "fail", note=self._unseen_in_words(), meaning=meaning))
        counts = {
            "tests": str(len(checks)),
            "failures": str(sum(finding.verdict == "fail" for finding in checks)),
            "errors": "0",
            "skipped": str(sum(finding.verdict in ("skipped", "open") for finding in self.checks)),
        }
        causes = [_printable(f"{name}: {text}") for name, text in self._remarks()]
        classname = _printable(f"{self.scene}.{self.trajectory}")
        suites = ElementTree.Element("testsuites", counts)
        suite = ElementTree.SubElement(suites, "testsuite", {"name": "tt-precise check", **counts})
        for finding in checks:
            named = {"name": finding.name, "classname": classname}
            case = ElementTree.SubElement(suite, "testcase", named)
            if finding.verdict in ("skipped", "open"):
                message = {"message": _printable(f"{finding.verdict}: {finding.note}")}
                ElementTree.SubElement(case, "skipped", message)
            elif finding.verdict == "fail":
                message = {"message": _printable(finding.sentence())}
                text = "\n".join([finding.meaning, *causes])
                ElementTree.SubElement(case, "failure", message).text = text
            else:
                ElementTree.SubElement(case, "system-out").text = _printable(finding.sentence())
        screen = "\n".join(map(_printable, str(self).splitlines()))
        ElementTree.SubElement(suite, "system-out").text = screen
        ElementTree.indent(suites)
        return ElementTree.tostring(suites, "unicode", xml_declaration=True) + "\n"

    @styled()
    def plot(self, path: str | Path | None = None) -> Figure:
        """A matplotlib ``Figure`` of each residual over its limit, written to ``path`` if given.

        Those that failed come first, with a dot at the first time above the limit.
        """
        drawn = new_figure(8, 4.5)
        axes = drawn.add_subplot()
        # black is the limit; further curves have the same colours in dashes and dots
        styles = itertools.product(("-", "-."), (colour for colour in CYCLE if colour != BLACK))
        order = (*self.failures, *self._with("pass"), *self._with("open"))
        shown = [
            (finding, finding.limit, *finding.curve)
            for finding in order
            if finding.curve and finding.sense == "at most" and finding.limit
        ]
        for (finding, limit, t, values), (line, colour) in zip(shown, styles, strict=False):
            with numpy.errstate(over="ignore"):
                parts = numpy.minimum(values / limit, HIGHEST)
            label = f"{finding.name} {finding.value:.1e}, allowed {limit:.1e}"
            axes.plot(t, parts, color=colour, linestyle=line, linewidth=1, label=label)
            if finding.bound and math.isfinite(finding.bound):
                axes.axhline(finding.bound / limit, color=colour, linestyle=":")
            if finding.since is not None:
                axes.plot(finding.since, parts[parts > 1][0], "o", color=colour, markersize=4)
        # a value of 0 has a place on the axis
        axes.set_yscale("symlog", linthresh=LEAST, linscale=0.5)
        axes.set_ylim(bottom=-LEAST / 4)
        axes.axhline(1.0, color=BLACK, linewidth=2, label="limit")
        since = [finding.since for finding in self.failures if finding.since is not None]
        if since:
            axes.axvline(min(since), color=BLACK, linestyle="--", linewidth=0.8)
        first = f"; dashed: t = {min(since):.6g} s, the first above a limit" if since else ""
        axes.set_xlabel(f"t (s){first}")
        axes.set_ylabel("value/limit; dotted: the error bound")
        axes.set_title(f"{Path(self.trajectory).name} against {self.scene}: {self.verdict}")
        axes.legend(fontsize="small", loc="center left", bbox_to_anchor=(1, 0.5))
        if path is not None:
            save(drawn, path)
        return drawn
