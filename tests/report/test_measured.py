"""The sections made of measurements: the trade-off, the extremes, the engines, the faults."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.report.conftest import figures, problems, tables
from tt_precise.report import measured
from tt_precise.report.document import Section, Text
from tt_precise.report.measured import MEASURED
from tt_precise.runtime.cache import changed, source_hash
from tt_precise.runtime.values import InputError


@pytest.mark.parametrize("make", [measured.tradeoff, measured.extremes, measured.engines])
def test_figures_are_placed_and_changed_code_is_named(
    make: Callable[[], Section], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = MEASURED / f"{make.__name__}.json"
    document = json.loads(file.read_text())
    for figure in document["figures"]:
        name = f"{figure['name']}.svg"
        (tmp_path / name).write_bytes((MEASURED / name).read_bytes())
    monkeypatch.setattr(measured, "MEASURED", tmp_path)
    for code, stale in ((source_hash("scene"), False), ("0" * 64, True)):
        (tmp_path / file.name).write_text(json.dumps(document | {"code": {"scene": code}}))
        section = make()
        assert [f.name for f in figures(section)] == [f["name"] for f in document["figures"]]
        assert [problem for figure in figures(section) for problem in problems(figure)] == []
        texts = [block.text for block in section.blocks if isinstance(block, Text)]
        assert texts[-1].endswith("Stale: measured before the last change of scene.") == stale
    (tmp_path / file.name).write_text("{")
    with pytest.raises(InputError, match=file.name):
        make()


def test_extremes_are_counted_by_topic_and_failed_cases_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = {"topic": "poles", "name": "a", "expected": "e", "found": "f", "verdict": "pass"}
    cases = [case, case | {"name": "b", "topic": "units"}, case | {"name": "c", "verdict": "fail"}]
    document = {"cases": cases, "figures": [], "code": {}}
    (tmp_path / "extremes.json").write_text(json.dumps(document))
    monkeypatch.setattr(measured, "MEASURED", tmp_path)
    section = measured.extremes()
    by_topic = {"poles": 2, "units": 1}
    assert section.results == {"cases": 3, "failed": ["c"], "by_topic": by_topic}
    assert "3 extreme cases (poles 2, units 1): 2 have" in str(section.blocks[0])


@pytest.mark.slow
def test_what_was_measured_is_of_this_code() -> None:
    documents = [json.loads(file.read_text()) for file in sorted(MEASURED.glob("*.json"))]
    assert [changed(document["code"]) for document in documents] == [()] * 6


def test_faults_are_counted_where_lambda_alone_shows_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measured, "changed", lambda code: ("check",))
    section = measured.faults()
    assert "before the last change of check." in str(section.blocks[-1])
    (table,) = tables(section)
    assert len(table.rows) > 10
    emphasis = section.blocks[0]
    assert isinstance(emphasis, Text)
    assert emphasis.emphasis
    assert "At 1e-06 lambda alone detects" in emphasis.text
