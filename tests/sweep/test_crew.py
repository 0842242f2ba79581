"""Crews: retries, quarantine, bounded flight, dying workers."""

import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from tt_precise.errors import InputError
from tt_precise.sweep import crew as crews
from tt_precise.sweep.crew import IN_FLIGHT_EACH, TRIES, Crew, Failure, Inline, crew_of, performed


def square(number: int) -> int:
    return number * number


def fail_on_three(number: int) -> int:
    if number == 3:
        raise ValueError("three is not\nto be had")
    return number


def die_once(number: int, folder: str) -> int:
    mark = Path(folder) / str(number)
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def die_always(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def tasks(count: int, *more: Any) -> Iterator[tuple[int, tuple[Any, ...]]]:
    return ((number, (number, *more)) for number in range(count))


def results(crew: Crew, work: Callable[..., Any], some: Any) -> dict[int, Any]:
    found = list(performed(crew, work, some))
    assert len({number for number, _, _ in found}) == len(found)  # nothing doubled
    return {number: result for number, _, result in found}


@pytest.mark.parametrize("executor", [Inline(), ThreadPoolExecutor(2)], ids=["inline", "threads"])
def test_every_task_is_performed_once(executor: Executor) -> None:
    found = results(Crew(executor, lambda: 2), square, tasks(50))
    assert found == {number: number**2 for number in range(50)}


def test_a_failing_task_is_tried_again_and_then_told() -> None:
    tried: list[int] = []

    def work(number: int) -> int:
        tried.append(number)
        return fail_on_three(number)

    found = results(Crew(Inline(), lambda: 1), work, tasks(6))
    assert tried.count(3) == TRIES
    assert found[3] == Failure("ValueError: three is not to be had")
    assert {number: found[number] for number in (0, 1, 2, 4, 5)} == {n: n for n in (0, 1, 2, 4, 5)}


def test_a_task_that_recovers_is_a_result() -> None:
    left = [2]

    def work(number: int) -> int:
        if number == 1 and left[0]:
            left[0] -= 1
            raise OSError("not yet")
        return number

    assert results(Crew(Inline(), lambda: 1), work, tasks(3)) == {0: 0, 1: 1, 2: 2}


def test_flight_is_bounded() -> None:
    class Counting(Executor):
        def __init__(self) -> None:
            self.waiting: list[tuple[Future[Any], Any]] = []
            self.most = 0

        def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
            future: Future[Any] = Future()
            self.waiting.append((future, fn(*args)))
            self.most = max(self.most, len(self.waiting))
            if len(self.waiting) == 2 * IN_FLIGHT_EACH:
                for one, value in self.waiting:
                    one.set_result(value)
                self.waiting.clear()
            return future

    taken = []

    def some() -> Iterator[tuple[int, tuple[int]]]:
        for number in range(40):
            taken.append(number)
            yield number, (number,)

    executor = Counting()
    stream = performed(Crew(executor, lambda: 2), square, some())
    next(stream)
    assert len(taken) == 2 * IN_FLIGHT_EACH  # the rest is not even made yet
    assert len(list(stream)) == 39
    assert executor.most == 2 * IN_FLIGHT_EACH


def test_workers_are_renewed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(crews, "RECYCLED_AFTER", 5)
    hired = []

    def hire() -> Executor:
        hired.append(Inline())
        return hired[-1]

    assert len(results(Crew(hire(), lambda: 2, hire), square, tasks(35))) == 35
    assert len(hired) == 4


def test_refuses_no_workers() -> None:
    with pytest.raises(InputError, match="workers"):
        crew_of(0)


def test_a_killed_worker_loses_and_doubles_nothing(tmp_path: Path) -> None:
    crew = crew_of(2)
    try:
        found = results(crew, die_once, tasks(12, str(tmp_path)))
    finally:
        crew.leave()
    assert found == {number: number for number in range(12)}
    assert (tmp_path / "3").exists()


@pytest.mark.slow
def test_a_killing_task_is_told_from_its_neighbours() -> None:
    crew = crew_of(2)
    try:
        found = results(crew, die_always, tasks(12))
    finally:
        crew.leave()
    assert isinstance(found[3], Failure)
    assert "BrokenProcessPool" in found[3].error
    assert {n: found[n] for n in found if n != 3} == {n: n for n in range(12) if n != 3}
