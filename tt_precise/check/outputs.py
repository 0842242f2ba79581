"""A result as text: a table for a terminal, Markdown, HTML, JUnit XML."""

from __future__ import annotations

import textwrap
from html import escape
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from tt_precise.check.result import SIGNS

if TYPE_CHECKING:
    from tt_precise.check.result import CheckFinding, Result

WIDTH = 100
HEADINGS = ("check", "verdict", "worst", "limit", "at t/s", "note")


def _number(value: float | None, digits: int = 3) -> str:
    return "" if value is None else f"{value:.{digits}g}"


def _cells(finding: CheckFinding) -> tuple[str, ...]:
    limit = _number(finding.limit)
    return (
        finding.name,
        finding.verdict.upper() if finding.verdict == "fail" else finding.verdict,
        _number(finding.value),
        f"{SIGNS[finding.sense]} {limit}" if limit else "",
        _number(finding.at, 6),
        finding.reason,
    )


def _heading(result: Result) -> str:
    count = len(result.failures)
    failed = f": {count} check{'s' * (count > 1)} failed" if count else ""
    return (
        f"{result.trajectory} against scene {result.scene}: {result.verdict}{failed} "
        f"({result.rows} rows of {result.columns} columns, "
        f"t = {result.t_first:.6g} to {result.t_last:.6g} s)"
    )


def table(result: Result, width: int = WIDTH) -> str:
    """The result for a terminal of ``width`` characters; what was skipped stands below."""
    done = [finding for finding in result.checks if finding.verdict != "skipped"]
    rows = [HEADINGS, *map(_cells, done)]
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    margin = sum(widths) + 2 * len(widths)
    lines = textwrap.wrap(_heading(result), width)
    for row in rows:
        start = "  ".join(cell.ljust(size) for cell, size in zip(row, widths, strict=False)) + "  "
        notes = textwrap.wrap(row[5], max(24, width - margin)) or [""]
        lines.append((start + notes[0]).rstrip())
        lines += [" " * margin + note for note in notes[1:]]
    for finding in done:
        if finding.parts:
            told = "  ".join(f"{name} {digits:.1f}" for name, digits in finding.parts.items())
            lines += textwrap.wrap(
                f"{finding.name}, correct digits of each column: {told}", width,
                subsequent_indent="  ",
            )  # fmt: skip
    reasons: dict[str, list[str]] = {}
    for finding in result.checks:
        if finding.verdict == "skipped":
            reasons.setdefault(finding.reason, []).append(finding.name)
    for reason, names in reasons.items():
        lines += textwrap.wrap(
            f"skipped {', '.join(names)}: {reason}", width, subsequent_indent="  "
        )
    return "\n".join(lines)


def markdown(result: Result) -> str:
    """The result as Markdown."""
    marks = {"pass": "✅ pass", "fail": "❌ **fail**", "skipped": "➖ skipped"}
    lines = [
        f"### {_escaped(_heading(result))}",
        "",
        "| " + " | ".join(HEADINGS) + " |",
        "| --- | --- | ---: | ---: | ---: | --- |",
    ]
    for finding in result.checks:
        name, _, *rest = _cells(finding)
        cells = (f"`{name}`", marks[finding.verdict], *map(_escaped, rest))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _escaped(text: str) -> str:
    for mark in "\\|`*_<>[]":
        text = text.replace(mark, "\\" + mark)
    return text


def html(result: Result) -> str:
    """The result as an HTML table."""
    colours = {"pass": "#1a7f37", "fail": "#cf222e", "skipped": "#6e7781"}
    head = "".join(f"<th>{name}</th>" for name in HEADINGS)
    body = "".join(
        f'<tr title="{escape(finding.meaning)}">'
        + "".join(
            f'<td style="color:{colours[finding.verdict]}">{cell}</td>'
            if i == 1
            else f"<td>{escape(cell)}</td>"
            for i, cell in enumerate(_cells(finding))
        )
        + "</tr>"
        for finding in result.checks
    )
    return (
        f"<p>{escape(_heading(result))}</p>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    )


def junit(result: Result) -> str:
    """The result as JUnit XML, a test case for each check."""
    counts = {
        "tests": str(len(result.checks)),
        "failures": str(len(result.failures)),
        "errors": "0",
        "skipped": str(sum(finding.verdict == "skipped" for finding in result.checks)),
    }
    suites = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(suites, "testsuite", {"name": "tt-precise check", **counts})
    for finding in result.checks:
        place = f"{result.scene}.{_printable(result.trajectory)}"
        case = ElementTree.SubElement(suite, "testcase", {"name": finding.name, "classname": place})
        if finding.verdict == "skipped":
            ElementTree.SubElement(case, "skipped", {"message": _printable(finding.reason)})
        elif finding.verdict == "fail":
            message = {"message": _printable(finding.sentence())}
            ElementTree.SubElement(case, "failure", message).text = finding.meaning
        else:
            ElementTree.SubElement(case, "system-out").text = _printable(finding.sentence())
    ElementTree.indent(suites)
    return ElementTree.tostring(suites, "unicode", xml_declaration=True) + "\n"


def _printable(text: str) -> str:
    # XML has no place for control characters, and a file name may hold them
    return "".join(c if c.isprintable() else "?" for c in text)
