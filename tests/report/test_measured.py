"""The sections made of measurements: the trade-off, the extremes, the scoreboard of engines."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from benchmarks.engines import DESCRIBED, ENGINES
from tests.conftest import more
from tests.report.conftest import drawn, tables
from tt_precise.engines.ladder import STEP_SIZES, ladder_tests
from tt_precise.engines.results import LadderResult, document
from tt_precise.report import measured, render
from tt_precise.report.build import MEASURED
from tt_precise.report.document import Figure, Report, Section, Text
from tt_precise.report.measured import DROPPED, FAULTS, jellett_alone
from tt_precise.runtime.values import InputError
from tt_precise.tradeoff.findings import GROWTH, TABLE


def measure(folder: Path, settings: int = 7) -> None:
    rows = [
        {
            "scene": "reference",
            "horizon_s": 8.0,
            "method": method,
            "setting": "s",
            "precision": "double",
            "bits": 53,
            "formulation": form,
            "tolerance": 1e-3,
            "peer": method != "heyoka",
            "error": 100.0**-n,
            "error_on_way": 99 * 100.0**-n,
            "seconds": slow * 2.0**n,
            "ratio": slow * 2.0**n,
            "setup_s": 1.0,
            "work": 1000 * n,
            "jellett_drift": 1e-3 * 100.0**-n,
        }
        for method, slow in (("heyoka", 1e-3), ("diffrax Dopri8", 2.5e-2))
        for form in ("newton", "euler")
        for n in range(1, settings + 1)
    ]
    pandas.DataFrame(rows).to_csv(folder / TABLE, index=False)
    draw = numpy.random.default_rng(1)
    long_runs = [
        {
            "scene": scene,
            "seed": seed,
            "t_s": t,
            "jellett": 1e-16 * draw.normal() * t**0.5,
            "energy": 1e-16 * draw.normal() * t**0.5,
        }
        for scene in ("frictionless", "rolling")
        for seed in range(4)
        for t in (1.0, 10.0, 100.0)
    ]
    pandas.DataFrame(long_runs).to_csv(folder / GROWTH, index=False)


@pytest.mark.parametrize(
    ("make", "command"),
    [
        (measured.tradeoff, "benchmarks.work_precision"),
        (measured.extremes, "tt-precise extremes"),
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


@pytest.mark.parametrize("name", [TABLE, GROWTH, DROPPED, FAULTS])
@pytest.mark.parametrize("content", ["", "a,b\n1,2\n"])
def test_a_table_of_something_else_is_refused_by_name(
    tmp_path: Path, name: str, content: str
) -> None:
    sections = [measured.tradeoff, measured.faults]
    assert all(make(tmp_path).blocks for make in sections)
    if name == GROWTH:  # which is read beside the other one
        measure(tmp_path)
    for other in {DROPPED, FAULTS} - {name} if name in (DROPPED, FAULTS) else ():
        (tmp_path / other).write_text((MEASURED / other).read_text())
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=rf"{name}\b.*: not of its form .*; expected what"):
        [make(tmp_path) for make in sections]


TRADEOFF = ["work-precision", "work-and-digits", "hidden-by-conservation", "growth-of-errors"]


@pytest.mark.parametrize("drawing", [False, more(True)], ids=["named", "drawn"])
def test_findings_and_figures_are_computed_from_the_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawing: bool
) -> None:
    for name in () if drawing else TRADEOFF:
        figure = Figure(name, "caption", "<svg><path/></svg>", "alt")
        function = name.replace("-", "_")
        monkeypatch.setattr(measured, function, lambda *_, figure=figure: figure)
    measure(tmp_path)
    section = measured.tradeoff(tmp_path)
    assert section.results["any peer at 1e-09, newton"] == {"value": "25"}
    assert "SIMD" not in section.results
    costs, _, found = tables(section)
    assert costs.rows[0] == ("heyoka", "2.8", "8", "23", "64")
    assert ("any peer at 1e-09, newton", "25 times") in {row[:2] for row in found.rows}
    assert drawn(section) == TRADEOFF


def test_an_accuracy_that_no_method_reaches_keeps_its_column(tmp_path: Path) -> None:
    measure(tmp_path, settings=4)
    table = measured._costs_table(pandas.read_csv(tmp_path / TABLE), "newton", "Newton form")
    assert table.header == ("method", *(f"ms to 1e-{n:02}" for n in (3, 6, 9, 12)))
    assert table.rows[0] == ("heyoka", "2.8", "8", "-", "-")


CASE: dict[str, Any] = {
    "topic": "contact", "family": "a start", "name": "a start", "expected": "all well",
    "source": "theory", "found": "1 eps", "verdict": "pass", "value": None,
}  # fmt: skip


def family(words: str, key: str, numbers: Any, data: Callable[[float], Any]) -> list[Any]:
    return [
        CASE
        | {
            "family": f"{words} {{{key}}}",
            "name": f"{words} {number}",
            "value": abs(number),
            "data": {key: number} | data(number),
        }
        for number in numbers
    ]


def test_a_row_for_each_family_and_for_each_failure_and_pictures(tmp_path: Path) -> None:
    cases = [
        *family("mu =", "mu", (1, 10, 100), lambda mu: {"steps": 10 * mu, "seconds": 0.1}),
        *family("limit", "mu", (1, 10, 100), lambda mu: {"distance": 1 / mu}),
        *family(
            "off", "off", (-0.1, -0.01, 0.1, 0.01), lambda off: {"rate": -off, "eigenvalue": -off}
        ),
        CASE | {"verdict": "fail", "found": "accepted"},
    ]
    document = {"schema": "tt_precise.extremes/1", "verdict": "fail", "cases": cases}
    (tmp_path / measured.EXTREMES).write_text(json.dumps(document | {"not_run": 7}))
    assert "1 do not, and 7 were not run (--quick)." in str(measured.extremes(tmp_path).blocks[0])
    (tmp_path / measured.EXTREMES).write_text(json.dumps(document))
    section = measured.extremes(tmp_path)
    assert "1 do not. The" in str(section.blocks[0])
    (table,) = tables(section)
    assert [row[1] for row in table.rows] == [
        "mu = … (3 cases)",
        "limit … (3 cases)",
        "off … (4 cases)",
        "a start",
    ]
    assert table.rows[0][4] == "1 eps [the worst: mu = 100]"
    assert table.rows[-1][4:] == ("accepted", "fail")
    assert section.results["failed"] == ["a start"]
    assert drawn(section) == ["extremes-poles", "extremes-friction", "extremes-threshold"]


@pytest.fixture
def board() -> dict[str, Any]:
    momentum = {"values": [0.04, None, 0.03], "limit": 1e-4, "verdict": "fail", "note": "why"}
    rows = [
        LadderResult(
            "MuJoCo",
            "flight",
            "converges",
            digits=(7.0, 8.2, 9.5),
            order=4.0,
            floor=1e-12,
            drift={"angular_momentum": (1e-8, 1e-9, 1e-10)},
        ),
        LadderResult(
            "MuJoCo",
            "ice",
            "floor",
            digits=(1.0, 1.5, 1.7),
            order=1.1,
            floor=0.02,
            checks={"contact_momentum": momentum},
        ),
        LadderResult("MuJoCo", "inversion", "measured", equator=(2.9, None, 3.8)),
        LadderResult("Bullet", "flight", "failed", "step 0.001 s: still running after 60 s"),
        LadderResult("Bullet", "ice", "refused", "Bullet has no viscous friction"),
    ]
    described = [
        {name: getattr(engine, name) for name in DESCRIBED}
        for engine in ENGINES
        if engine.name in ("MuJoCo", "Bullet")
    ]
    tests = [(test.name, test.meaning) for test in ladder_tests()]
    return document(tests, STEP_SIZES, rows, described, ["DART: not installed"])


def test_the_section_of_engines_shows_the_scoreboard(
    board: dict[str, Any], small_report: Report, tmp_path: Path
) -> None:
    (tmp_path / "engines.json").write_text(json.dumps(board))
    section = measured.engines(tmp_path)
    (figure,) = (block for block in section.blocks if isinstance(block, Figure))
    table, settings = tables(section)
    assert len(table.rows) == len(board["rows"])
    shown = "MuJoCo | flight | converges | 7.0, 8.2, 9.5 | 4.00 | 1.0e-12"
    assert " | ".join(table.rows[0][:6]) == shown
    assert table.header[-1] == "contact_momentum"
    assert [row[-1] for row in table.rows[:2]] == ["", "fail 4.0e-02, -, 3.0e-02 (why)"]
    assert table.rows[2][2] == "measured: axis horizontal at 2.90 s, never, 3.80 s"
    assert {row[0] for row in settings.rows} == {"MuJoCo", "Bullet"}
    assert "(1.7)" in figure.svg
    assert section.results["MuJoCo, ice"] == "floor"
    assert "DART" in render.markdown(replace(small_report, sections=[section]))
    # a file that was measured before these checks has no columns for them
    for row in board["rows"]:
        del row["checks"]
    (tmp_path / "engines.json").write_text(json.dumps(board))
    assert (
        tables(measured.engines(tmp_path))[0].header[-1] == "largest drift of conserved quantities"
    )


def test_faults_that_conserve_lambda_are_counted() -> None:
    rows = [("1e-3", "jellett energy"), ("2e-7", "equations"), ("", "")]
    table = pandas.DataFrame(rows, columns=["jellett", "fails"])
    numbers = re.findall(r"(?<![\de-])\d+(?!e)", jellett_alone(table))
    assert [one for one in numbers if one in "123"] == ["3", "1", "2"]
