"""The scoreboard of engines in the report."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tt_precise.engines.ladder import STEPS, RungResult, rungs
from tt_precise.engines.scoreboard import ENGINES, as_dict
from tt_precise.report import measured, render
from tt_precise.report.document import Figure, PageTable, Report


@pytest.fixture
def board() -> dict[str, Any]:
    momentum = {"values": [0.04, None, 0.03], "limit": 1e-4, "verdict": "fail", "note": "why"}
    rows = [
        RungResult("MuJoCo", "flight", "converges", digits=(7.0, 8.2, 9.5), order=4.0, floor=1e-12,
               drift={"angular_momentum": (1e-8, 1e-9, 1e-10)}),
        RungResult("MuJoCo", "ice", "floor", digits=(1.0, 1.5, 1.7), order=1.1, floor=0.02,
                   checks={"contact_momentum": momentum}),
        RungResult("MuJoCo", "inversion", "measured", equator=(2.9, None, 3.8)),
        RungResult("Bullet", "flight", "failed", "step 0.001 s: timeout: still running after 60 s"),
        RungResult("Bullet", "ice", "refused", "Bullet has no viscous friction"),
    ]  # fmt: skip
    return as_dict(
        [one for one in ENGINES if one.name in ("MuJoCo", "Bullet")], rungs(), STEPS, rows,
        ["DART: not installed"],
    )  # fmt: skip


def test_it_shows_what_was_measured(
    board: dict[str, Any], small_report: Report, tmp_path: Path
) -> None:
    (tmp_path / "engines.json").write_text(json.dumps(board))
    section = measured.engines(tmp_path)
    (figure,) = (block for block in section.blocks if isinstance(block, Figure))
    table, settings = (block for block in section.blocks if isinstance(block, PageTable))
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
    table = next(one for one in measured.engines(tmp_path).blocks if isinstance(one, PageTable))
    assert table.header[-1] == "largest drift of conserved quantities"
