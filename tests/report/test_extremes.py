"""The section on the extremes: complete with and without measurements, failures first of all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from tt_precise.report import measured
from tt_precise.report.document import Figure, PageTable

LARGEST = 300_000  # characters of SVG


def case(name: str, **more: Any) -> dict[str, Any]:
    entry = {
        "topic": "contact", "family": "mu = {mu}", "name": name, "expected": "all well",
        "source": "theory", "found": "1 eps", "verdict": "pass", "value": 1.0,
    }  # fmt: skip
    return entry | more


def test_a_row_for_each_family_and_for_each_failure_and_pictures(tmp_path: Path) -> None:
    cases = [
        *(
            case(f"mu = {mu}", value=float(mu), data={"mu": mu, "steps": 10 * mu, "seconds": 0.1})
            for mu in (1, 10, 100)
        ),
        *(
            case(f"limit {mu}", family="limit {mu}", data={"mu": mu, "distance": 1 / mu})
            for mu in (1, 10, 100)
        ),
        *(
            case(f"off {off}", family="off {off}",
                 data={"off": off, "rate": -off, "eigenvalue": -off})
            for off in (-0.1, -0.01, 0.1, 0.01)
        ),
        case("a start", family="a start", verdict="fail", found="accepted", value=None),
    ]  # fmt: skip
    document = {"schema": "tt_precise.extremes/1", "verdict": "fail", "cases": cases}
    (tmp_path / measured.EXTREMES).write_text(json.dumps(document))
    section = measured.extremes(tmp_path)
    (table,) = (block for block in section.blocks if isinstance(block, PageTable))
    assert [row[1] for row in table.rows] == [
        "mu = … (3 cases)", "limit … (3 cases)", "off … (4 cases)", "a start",
    ]  # fmt: skip
    assert table.rows[0][4] == "1 eps [the worst: mu = 100]"
    assert table.rows[-1][4:] == ("accepted", "fail")
    assert section.results["failed"] == ["a start"]
    figures = [block for block in section.blocks if isinstance(block, Figure)]
    assert [figure.name for figure in figures] == [
        "extremes-poles", "extremes-friction", "extremes-threshold",
    ]  # fmt: skip
    for figure in figures:
        assert ElementTree.fromstring(figure.svg).tag.endswith("svg")
        assert len(figure.svg) < LARGEST
        assert figure.alt
