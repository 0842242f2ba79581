"""Test the scoreboard, and run the adapters of other people's engines."""

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from benchmarks import engines
from benchmarks.engines import ADAPTERS, ENGINES, NODE, Engine, main, scoreboard
from tests.engines.conftest import ladder_test, measured_on
from tt_precise.engines.ladder import LadderResult, LadderTest
from tt_precise.runtime.cache import changed

ROWS = [
    LadderResult("One", "flight", "converges", digits=(7.0, 8.2, 9.5), order=4.0, floor=1e-12),
    LadderResult("One", "ice", "floor", digits=(1.0, 1.5, 1.7), order=1.1, floor=0.02),
    LadderResult("Other", "flight", "failed", "step 0.001 s: stopped"),
    LadderResult("Other", "ice", "refused", "no such friction"),
]


def test_there_is_an_adapter_for_each_engine() -> None:
    files = {path.stem for path in ADAPTERS.glob("*_adapter.py")}
    files |= {path.name for path in NODE.glob("*.mjs") if path.name != "program.mjs"}
    assert {engine.program for engine in ENGINES} == files


def test_the_scoreboard_is_written_with_its_figure_and_its_code(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def run_ladder(name: str, _: object, tests: list[LadderTest], **options: object) -> Any:
        return (row for row in ROWS if row.engine == name)

    monkeypatch.setattr("benchmarks.engines.run_ladder", run_ladder)
    here = [Engine(name, "numpy", "no_adapter", "", "") for name in ("One", "Other")]
    monkeypatch.setattr(engines, "ENGINES", (*here, Engine("Gone", "no-such-package", "", "", "")))
    main(["--out", str(tmp_path / "engines.json")])
    assert "skipped: Gone" in capsys.readouterr().out
    board = json.loads((tmp_path / "engines.json").read_text())
    assert [row["verdict"] for row in board["rows"]] == [row.verdict for row in ROWS]
    assert [engine["name"] for engine in board["engines"]] == ["One", "Other"]
    assert changed(board["code"]) == ()
    assert changed(board["code"] | {"engines": "0"}) == ("engines",)
    (figure,) = board["figures"]
    svg = (tmp_path / f"{figure['name']}.svg").read_text()
    texts = ElementTree.fromstring(svg).itertext()
    assert {"(1.7)", "✗", "–", "One", "Other"} < {text.strip() for text in texts}
    assert scoreboard(board).svg == svg


@pytest.mark.clients
@pytest.mark.parametrize("engine", ENGINES, ids=lambda engine: engine.name)
def test_engines_fly(engine: Engine) -> None:
    if engine.version is None:
        pytest.skip(engine.missing)
    result = measured_on(engine.command, ladder_test("flight", engine.law))
    # cannon-es has no gyroscopic term, which this test isolates
    expected = {"cannon-es": {"no order", "floor"}}.get(engine.name, {"converges", "floor"})
    if engine.precision == "single":
        expected = {"converges", "floor", "no order"}
    assert result.verdict in expected, result.message
    assert result.digits[-1] > (0 if engine.name == "cannon-es" else 1)
