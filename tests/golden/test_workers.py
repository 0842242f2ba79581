"""Tasks in, runs out: further rungs, cached runs, interruptions."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tt_precise.golden import building, workers
from tt_precise.golden.runs import LADDER, Run, Task, tasks
from tt_precise.golden.table import Table
from tt_precise.golden.workers import RunCache, perform_all
from tt_precise.runtime.workers import Pool

if TYPE_CHECKING:
    from tests.golden.conftest import Small


class Desk(Executor):
    """An executor that does each task at once, in this process."""

    def __init__(self, result: Callable[[Task], Run]):
        self.result, self.asked = result, list[Task]()

    def submit(self, fn: Any, /, *args: Any, **_: Any) -> Future[Any]:
        (task,) = args
        self.asked.append(task)
        future: Future[Any] = Future()
        try:
            future.set_result(self.result(task))
        except ArithmeticError as error:
            future.set_exception(error)
        return future

    @property
    def pool(self) -> Pool:
        return Pool(self, lambda: 1)


def outcome(task: Task) -> Run:
    empty = Table(("t",), ())
    return Run(task.label, task.formulation, 1, 1, "complete", empty, empty, ())


def task(name: str, bits: int) -> Task:
    return Task(name, "", "mp", bits, "newton")


def test_each_plan_is_finished_once_with_its_runs_in_order() -> None:
    finished: dict[str, list[str]] = {}

    def finish(name: str, runs: list[Run]) -> list[Task]:
        assert name not in finished
        finished[name] = [run.label for run in runs]
        return []

    plans = {"a": [task("a", 3), task("a", 1)], "b": [task("b", 2)]}
    heard: list[float] = []
    perform_all(Desk(outcome).pool, plans, finish, progress=heard.append)
    assert finished == {"a": ["newton 3", "newton 1"], "b": ["newton 2"]}
    assert heard[-1] == 1
    assert all(0 <= fraction <= 1 for fraction in heard)


def test_a_plan_may_ask_for_further_tasks() -> None:
    rounds: list[list[str]] = []

    def finish(name: str, runs: list[Run]) -> list[Task]:
        rounds.append([run.label for run in runs])
        return [task("a", 9)] if len(rounds) == 1 else []

    perform_all(Desk(outcome).pool, {"a": [task("a", 1)]}, finish)
    assert rounds == [["newton 1"], ["newton 9"]]


def test_after_an_interruption_only_the_rest_is_computed(tmp_path: Path) -> None:
    plans = {"a": [task("a", 1), task("a", 2)], "b": [task("b", 3)]}

    def breaks(one: Task) -> Run:
        if one.bits == 2:
            raise ArithmeticError("interrupted")
        return outcome(one)

    with pytest.raises(ArithmeticError):
        perform_all(Desk(breaks).pool, plans, lambda *_: [], cache=RunCache(tmp_path))
    desk = Desk(outcome)
    perform_all(desk.pool, plans, lambda *_: [], cache=RunCache(tmp_path))
    assert {one.bits for one in desk.asked} < {1, 2, 3}
    assert 2 in {one.bits for one in desk.asked}


def test_cached_runs_are_void_when_the_code_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    RunCache(tmp_path).keep(task("a", 1), outcome(task("a", 1)))
    assert RunCache(tmp_path).find(task("a", 1)) is not None
    monkeypatch.setattr(workers, "source_hash", lambda *_: "another")
    assert RunCache(tmp_path).find(task("a", 1)) is None


def test_missing_digits_are_computed_with_more_bits(small: Small, tmp_path: Path) -> None:
    scene, (high, low, euler) = small.scene, small.runs
    rows = [list(row) for row in low.trajectory.rows]
    rows[3][1] = rows[3][1][:20] + "e-2"
    coarse = replace(low, trajectory=Table(low.trajectory.columns, tuple(map(tuple, rows))))
    shelf = type(small.shelf)(tmp_path)
    for one, run in zip(tasks(scene, LADDER[0]), (high, coarse, euler), strict=True):
        shelf.keep(one, run)
    for one, run in zip(tasks(scene, LADDER[1]), (high, high, euler), strict=True):
        shelf.keep(one, replace(run, label=one.label))
    (built,) = building.build([scene], folder=tmp_path / "data", workers=1, cache=shelf)
    assert built.bits == LADDER[1]
    assert built.digits == 34
