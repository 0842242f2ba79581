"""The adapters of other people's engines, each run for real."""

from __future__ import annotations

from fractions import Fraction

import pytest

from tt_precise.engines.catalogue import ADAPTERS, ENGINES, NODE, Engine
from tt_precise.engines.ladder import climb
from tt_precise.engines.rungs import rungs
from tt_precise.engines.scoreboard import measure

STEPS = (Fraction(1, 1000), Fraction(1, 2000), Fraction(1, 4000))


def test_adapters_are_short_and_there_is_one_for_each_engine() -> None:
    files = {path.stem: path for path in ADAPTERS.glob("*_adapter.py")} | {
        path.name: path for path in NODE.glob("*.mjs") if path.name != "program.mjs"
    }
    assert {engine.program for engine in ENGINES} == set(files)
    for path in files.values():
        assert len(path.read_text("utf-8").splitlines()) <= 80, path


def test_an_engine_that_is_not_installed_is_skipped_with_a_line() -> None:
    lines: list[str] = []
    gone = Engine("Gone", "no-such-package", "no_adapter", "", "")
    board = measure([gone], STEPS, time_limit=1, workers=1, note=lines.append)
    assert lines == ['skipped: Gone: not installed; pip install "tt-precise[engines]"']
    assert board["rows"] == []
    assert board["skipped"]


@pytest.mark.clients
@pytest.mark.parametrize("engine", ENGINES, ids=lambda engine: engine.name)
def test_engines_fly(engine: Engine) -> None:
    if engine.version is None:
        pytest.skip(engine.missing)
    (flight,) = (rung for rung in rungs(engine.law) if rung.name == "flight")
    (found,) = climb(engine.name, engine.command, [flight], STEPS)
    # cannon-es leaves out the gyroscopic term, which is what this test is for
    expected = {"cannon-es": {"no order", "floor"}}.get(engine.name, {"converges", "floor"})
    if engine.precision == "single":
        expected = {"converges", "floor", "no order"}
    assert found.verdict in expected, found.message
    assert found.digits[-1] > (0 if engine.name == "cannon-es" else 1)


@pytest.mark.clients
def test_the_scoreboard_is_the_same_when_it_is_measured_again() -> None:
    engines = [one for one in ENGINES if one.name in ("Bullet", "MuJoCo") and one.version]
    if not engines:
        pytest.skip("neither Bullet nor MuJoCo is installed")
    boards = [
        measure(
            engines, STEPS, chosen=lambda rung: rung.name in ("gliding", "rolling"),
            time_limit=60, workers=2,
        )
        for _ in range(2)
    ]  # fmt: skip
    assert boards[0] == boards[1]
