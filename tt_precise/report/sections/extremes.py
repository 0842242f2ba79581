"""Numerical stability at the extremes, as ``tt-precise extremes`` found it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from tt_precise.extremes.case import TOPICS, shown
from tt_precise.report.document import Block, PageTable, Section, Text
from tt_precise.report.figures import measured as pictures
from tt_precise.runtime import records
from tt_precise.runtime.untyped import Json

FILE = "extremes.json"
COMMAND = "tt-precise extremes --out reports/measured/extremes.json"
TITLE = "At the extremes"


def section(folder: Path) -> Section:
    """A row for each family of cases, the failed cases one by one, and the pictures."""
    file = folder / FILE
    if not file.is_file():
        return Section("extremes", TITLE, [Text(f"Not measured yet: `{COMMAND}`.")])
    return records.read_as(
        file, f"what `{COMMAND}` writes", lambda content: _measured(content["cases"])
    )


def _measured(cases: Sequence[Mapping[str, Json]]) -> Section:
    counts = Counter(case["verdict"] for case in cases)
    by_topic = Counter(case["topic"] for case in cases)
    listed = ", ".join(f"{topic} {by_topic[topic]}" for topic in TOPICS if by_topic[topic])
    blocks: list[Block] = [
        Text(
            f"{len(cases)} cases drive everything to its edges ({listed}): {counts['pass']} came "
            f"out as expected, {counts['fail']} did not. What is expected comes from theory or "
            f"from a higher precision. Measured by `{COMMAND}`, not by the run that wrote this "
            "page."
        ),
        PageTable(
            ("topic", "case", "expected", "from", "found", "verdict"),
            [row for members in _families(cases) for row in _rows(members)],
            "Families of cases have one row, which shows the worst of them; a case that failed "
            "has its own. The file has every case.",
            filters=("topic", "verdict"),
            verdict="verdict",
            name="extremes-table",
            folded=True,
        ),
        *pictures.all_pictures(cases),
    ]
    results = {
        "cases": len(cases),
        "failed": [case["name"] for case in cases if case["verdict"] == "fail"],
        "by_topic": dict(by_topic),
    }
    return Section("extremes", TITLE, blocks, results)


def _families(cases: Sequence[Mapping[str, Json]]) -> list[list[Mapping[str, Json]]]:
    groups: dict[tuple[str, str], list[Mapping[str, Json]]] = {}
    for case in cases:
        groups.setdefault((case["topic"], case["family"]), []).append(case)
    return list(groups.values())


def _rows(members: list[Mapping[str, Json]]) -> list[tuple[str, ...]]:
    failed = [case for case in members if case["verdict"] == "fail"]
    if failed or len(members) == 1:
        return [_row(case, case["name"], case["found"]) for case in failed or members]
    worst = max(members, key=lambda case: case["value"] or 0.0)
    found = worst["found"]
    if worst["value"] is not None:
        found += f" [the worst: {worst['name']}]"
    return [_row(worst, shown(worst["family"], members), found)]


def _row(case: Mapping[str, Json], name: str, found: str) -> tuple[str, ...]:
    return case["topic"], name, case["expected"], case["source"], found, case["verdict"]
