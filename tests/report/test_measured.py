"""The sections made of measurements: the trade-off, the extremes, the scoreboard of engines."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas
import pytest

from tests.report.conftest import drawn, tables
from tt_precise.report import measured, render
from tt_precise.report.build import MEASURED
from tt_precise.report.document import Report, Section, Text
from tt_precise.report.measured import DROPPED, FAULTS, jellett_alone
from tt_precise.runtime.cache import source_hash
from tt_precise.runtime.values import InputError


@pytest.mark.parametrize(
    ("make", "command"),
    [
        (measured.tradeoff, "benchmarks.work_precision"),
        (measured.extremes, "benchmarks.extremes"),
        (measured.engines, "benchmarks.engines"),
        (measured.faults, "benchmarks.fault_amounts"),
    ],
)
def test_without_a_table_it_says_how_to_make_one(
    make: Callable[[Path], Section], command: str, tmp_path: Path
) -> None:
    (block,) = make(tmp_path).blocks
    assert isinstance(block, Text)
    assert command in block.text


@pytest.mark.parametrize("name", [DROPPED, FAULTS])
@pytest.mark.parametrize("content", ["", "a,b\n1,2\n"])
def test_a_table_of_something_else_is_refused_by_name(
    tmp_path: Path, name: str, content: str
) -> None:
    for other in {DROPPED, FAULTS} - {name}:
        (tmp_path / other).write_text((MEASURED / other).read_text())
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=rf"{name}\b.*: not of its form .*; expected what"):
        measured.faults(tmp_path)


@pytest.mark.parametrize(
    ("make", "file", "figures"),
    [
        (measured.tradeoff, "tradeoff.json", [
            "work-precision", "work-and-digits", "hidden-by-conservation", "growth-of-errors"]),
        (measured.engines, "engines.json", ["engines"]),
        (measured.extremes, "extremes.json", ["extremes"]),
    ],
)  # fmt: skip
def test_figures_are_placed_and_changed_code_is_shown(
    make: Callable[[Path], Section], file: str, figures: list[str], tmp_path: Path
) -> None:
    for name in (file, *(f"{figure}.svg" for figure in figures)):
        (tmp_path / name).write_bytes((MEASURED / name).read_bytes())
    document = json.loads((MEASURED / file).read_text())
    for code, stale in (({"scene": source_hash("scene")}, False), ({"scene": "0" * 64}, True)):
        (tmp_path / file).write_text(json.dumps(document | {"code": code}))
        section = make(tmp_path)
        assert drawn(section) == figures
        emphasised = [b.text for b in section.blocks if isinstance(b, Text) and b.emphasis]
        assert [text.endswith("of scene.") for text in emphasised] == [True] * stale


def test_the_findings_and_the_costs_of_the_committed_tables() -> None:
    section = measured.tradeoff(MEASURED)
    newton, _, findings = tables(section)
    assert newton.header == ("method", *(f"ms to 1e-{n:02}" for n in (3, 6, 9, 12)))
    assert newton.rows[0][0].startswith("heyoka")
    assert newton.rows[-1][-1] == "-"  # not reached by the method
    assert len(section.results) == len(findings.rows) > 50


def test_the_scoreboard_of_the_committed_engines(small_report: Report) -> None:
    section = measured.engines(MEASURED)
    table, settings = tables(section)
    cells = {row[:2]: row for row in table.rows}
    assert len(cells) == len(section.results) == 70
    assert cells["MuJoCo", "inversion"][2].startswith("measured (axis horizontal at ")
    assert len(settings.rows) == 10
    assert "MuJoCo" in render.markdown(replace(small_report, sections=[section]))


def test_failed_cases_are_counted(tmp_path: Path) -> None:
    (tmp_path / "extremes.svg").write_bytes((MEASURED / "extremes.svg").read_bytes())
    document = json.loads((MEASURED / measured.EXTREMES).read_text())
    case = document["cases"][0] | {"verdict": "fail"}
    document["cases"].append(case)
    (tmp_path / measured.EXTREMES).write_text(json.dumps(document))
    section = measured.extremes(tmp_path)
    (table,) = tables(section)
    assert section.results["failed"] == [case["name"]]
    assert sum(section.results["by_topic"].values()) == len(table.rows) == section.results["cases"]
    assert [row[-1] for row in table.rows].count("fail") == 1


def test_faults_that_conserve_lambda_are_counted() -> None:
    rows = [("1e-3", "jellett energy"), ("2e-7", "equations"), ("", "")]
    table = pandas.DataFrame(rows, columns=["jellett", "fails"])
    numbers = re.findall(r"(?<![\de-])\d+(?!e)", jellett_alone(table))
    assert [one for one in numbers if one in "123"] == ["3", "1", "2"]
