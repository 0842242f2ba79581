"""Bars: declared once, evaluated as ratios; the yardsticks do the work that they stand for."""

from __future__ import annotations

import random
from itertools import islice
from pathlib import Path

import pytest

from benchmarks import bars, calls, random_scenes
from benchmarks.bars import Bar
from benchmarks.estimates import right_throughout
from tt_precise.integration import integrate
from tt_precise.scene.scene import load_scene
from tt_precise.tradeoff.bare_loop import bare_loop
from tt_precise.tradeoff.findings import met
from tt_precise.tradeoff.timing import Turn


def test_every_bar_is_declared_once(tmp_path: Path) -> None:
    names = [one.name for one in bars.bars(tmp_path)] + [one.name for one in bars.engine()]
    assert len(names) == len(set(names))


def test_an_aim_at_most_is_met_on_its_edge() -> None:
    assert [met(("at most", 2.0), value) for value in (1.9, 2.0, 2.1)] == [True, True, False]
    assert [met(("below", 2.0), value) for value in (1.9, 2.0)] == [True, False]


def waiting(seconds: float, yardstick: float) -> Bar:
    """By a clock that only these two move."""
    clock = [0.0]

    def wait(duration: float) -> None:
        clock[0] += duration

    turn = Turn(lambda: lambda: wait(seconds), lambda: wait(yardstick), lambda: clock[0])
    return Bar(f"{seconds} s", "a wait", lambda: [turn], aim=2.0, rounds=3)


def test_a_bar_is_a_ratio_to_its_yardstick(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    every = [waiting(0.03, 0.01), waiting(0.005, 0.02)]
    monkeypatch.setattr(bars, "bars", lambda scratch, scenes: every)
    monkeypatch.setattr(bars, "engine", list)
    slow, fast = bars.measured(tmp_path)
    assert (slow["met"], fast["met"]) == (False, True)
    assert slow["aim"] == "at most 2"
    assert slow["turns"] == 3
    assert slow["milliseconds"] == pytest.approx(30)
    assert slow["value"] == pytest.approx(3)
    assert [row["name"] for row in bars.measured(tmp_path, only=["0.03"])] == ["0.03 s"]


def test_the_bare_loop_goes_the_whole_way_again_and_again() -> None:
    scene = load_scene("reference")
    loop = bare_loop(scene)
    steps = loop()
    assert steps == loop()
    # contact, which it does not watch, ends a step here and there
    assert steps == pytest.approx(integrate(scene, events=()).steps, rel=0.02)


def test_the_tolerance_needed_is_the_coarsest_that_has_the_digits() -> None:
    scene = next(random_scenes.gliding_scenes(1))
    needed = calls.tolerance_needed(scene, 6)
    assert needed > 0
    for tolerance, enough in ((needed, True), (needed * 10, False)):
        run = integrate(scene, "double", tolerance=tolerance, events=(), record=())
        assert (right_throughout(run) >= 6) == enough


def test_random_scenes_are_the_same_every_time() -> None:
    one, again = (
        [scene.name for scene in islice(random_scenes.gliding_scenes(1), 4)] for _ in range(2)
    )
    assert one == again
    first = random_scenes.random_scene(random.Random(1), "a")
    assert first != random_scenes.random_scene(random.Random(2), "a")
