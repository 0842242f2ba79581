"""Findings as text under a heading: a table for a terminal, Markdown, HTML, JUnit XML."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from tt_precise.check.finding import SIGNS, CheckFinding
from tt_precise.runtime.terminal import one_line

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
        one_line(finding.reason),
    )


def table(heading: str, findings: Sequence[CheckFinding], width: int = WIDTH) -> str:
    """The findings for a terminal of ``width`` characters; what was skipped stands below."""
    done = [finding for finding in findings if finding.verdict != "skipped"]
    rows = [HEADINGS, *map(_cells, done)]
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    margin = sum(widths) + 2 * len(widths)
    lines = textwrap.wrap(one_line(heading), width)
    for row in rows:
        start = "  ".join(cell.ljust(size) for cell, size in zip(row, widths, strict=False)) + "  "
        notes = textwrap.wrap(row[5], max(24, width - margin)) or [""]
        lines.append((start + notes[0]).rstrip())
        lines += [" " * margin + note for note in notes[1:]]
    for finding in done:
        if finding.parts:
            listed = "  ".join(f"{name} {digits:.1f}" for name, digits in finding.parts.items())
            lines += textwrap.wrap(
                f"{finding.name}, correct digits of each column: {listed}", width,
                subsequent_indent="  ",
            )  # fmt: skip
    reasons: dict[str, list[str]] = {}
    for finding in findings:
        if finding.verdict == "skipped":
            reasons.setdefault(finding.reason, []).append(finding.name)
    for reason, names in reasons.items():
        lines += textwrap.wrap(
            f"skipped {', '.join(names)}: {one_line(reason)}", width, subsequent_indent="  "
        )
    return "\n".join(lines)


def markdown(heading: str, findings: Sequence[CheckFinding]) -> str:
    """The findings as Markdown."""
    marks = {"pass": "✅ pass", "fail": "❌ **fail**", "skipped": "➖ skipped"}
    lines = [
        f"### {_escaped(one_line(heading))}",
        "",
        "| " + " | ".join(HEADINGS) + " |",
        "| --- | --- | ---: | ---: | ---: | --- |",
    ]
    for finding in findings:
        name, _, *rest = _cells(finding)
        cells = (f"`{name}`", marks[finding.verdict], *map(_escaped, rest))
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _escaped(text: str) -> str:
    for mark in "\\|`*_<>[]":
        text = text.replace(mark, "\\" + mark)
    return text


def html(heading: str, findings: Sequence[CheckFinding]) -> str:
    """The findings as an HTML table."""
    from html import escape  # here, because few want it

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
        for finding in findings
    )
    return (
        f"<p>{escape(one_line(heading))}</p>"
        f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
    )


def junit(place: str, findings: Sequence[CheckFinding]) -> str:
    """The findings as JUnit XML, a test case for each of them, in the class ``place``."""
    from xml.etree import ElementTree

    counts = {
        "tests": str(len(findings)),
        "failures": str(sum(finding.verdict == "fail" for finding in findings)),
        "errors": "0",
        "skipped": str(sum(finding.verdict == "skipped" for finding in findings)),
    }
    suites = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(suites, "testsuite", {"name": "tt-precise check", **counts})
    for finding in findings:
        named = {"name": finding.name, "classname": _printable(place)}
        case = ElementTree.SubElement(suite, "testcase", named)
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
