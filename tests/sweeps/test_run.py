"""Sweeps as a whole: on disk, interrupted, resumed, damaged, checked in finer arithmetic."""

from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError, local_pool
from tt_precise.sweeps import SweepSpec, read_rows, run_sweep
from tt_precise.sweeps import run as running
from tt_precise.sweeps.run import integrate_tables
from tt_precise.sweeps.specification import blocks

SPEC = SweepSpec.of("reference", until="0.5", vary={"phi_dot": "-20:20:41"})
CHUNK = 8  # six chunks


class Stopping(Executor):
    """Runs tasks at once, and is interrupted at the ``last``."""

    def __init__(self, last: int):
        self.left = last

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        if not self.left:
            raise KeyboardInterrupt
        self.left -= 1
        future: Future[Any] = Future()
        future.set_result(fn(*args))
        return future


@pytest.fixture(scope="module")
def whole() -> pandas.DataFrame:
    return run_sweep(SPEC, recheck=0).rows


def test_an_interrupted_sweep_is_resumed(tmp_path: Path, whole: pandas.DataFrame) -> None:
    out = tmp_path / "sweep"
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            run_sweep(SPEC, out=out, chunk=CHUNK, pool=Pool(Stopping(3), lambda: 1), recheck=0)
    written = len(list((out / "chunks").iterdir()))
    assert 2 <= written < 6
    done = run_sweep(SPEC, out=out, recheck=0)  # the size of the chunks is known
    assert done.summary["how"]["chunks_found"] == written
    assert done.summary["how"]["rows_computed"] == 41 - CHUNK * written
    pandas.testing.assert_frame_equal(read_rows(out), whole, check_exact=True)
    again = run_sweep(SPEC, out=out, recheck=0)
    assert (again.summary["how"]["rows_computed"], again.summary["how"]["damaged"]) == (0, [])
    pandas.testing.assert_frame_equal(again.rows, whole, check_exact=True)


def test_another_sweep_is_refused(tmp_path: Path) -> None:
    out, full = tmp_path / "sweep", tmp_path / "full"
    run_sweep(SPEC, out=out, chunk=CHUNK, recheck=0)
    full.mkdir()
    (full / "mine.txt").write_text("mine", "utf-8")
    other = replace(SPEC, scene=SPEC.scene.varied(until="0.6"))
    for spec, place, chunk, message in (
        (other, out, None, "another sweep"),
        (SPEC, out, CHUNK + 1, "chunk"),
        (SPEC, full, None, "not empty"),
    ):
        with pytest.raises(InputError, match=message):
            run_sweep(spec, out=place, chunk=chunk, recheck=0)


@pytest.mark.parametrize(
    ("error", "kind"), [(RuntimeError("cosmic ray"), RuntimeError), (MemoryError(), InputError)]
)
def test_a_chunk_that_fails_names_its_rows_and_ends_the_sweep(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    whole: pandas.DataFrame,
    error: Exception,
    kind: type[Exception],
) -> None:
    right = running.chunk_task

    def spoiled(*arguments: Any) -> Any:
        if -20 + 16 in arguments[2]:
            raise error
        return right(*arguments)

    monkeypatch.setattr(running, "chunk_task", spoiled)
    out = tmp_path / "sweep"
    with pytest.raises(kind, match=r"^sweep: rows 16 to 23: .*; run it again to resume$"):
        run_sweep(SPEC, out=out, chunk=CHUNK, recheck=0)
    monkeypatch.undo()
    done = run_sweep(SPEC, out=out, recheck=0)
    assert done.summary["how"]["chunks_found"] == 2  # those before the one that failed
    pandas.testing.assert_frame_equal(done.rows, whole, check_exact=True)


def test_a_worker_of_another_version_is_refused() -> None:
    (values,) = (v for _, v in blocks(SPEC, 100))
    with pytest.raises(InputError, match="worker"):
        running.chunk_task(SPEC, "0.0.0", values, 8)


def test_long_sweeps_have_more_lanes_and_the_same_rows(
    monkeypatch: pytest.MonkeyPatch, whole: pandas.DataFrame
) -> None:
    monkeypatch.setattr("heyoka.recommended_simd_size", lambda: 1)
    for size, many, lanes in ((1, 42, 2), (1, 41, 4), (1, 20, 4), (2, 20, 4), (2, 21, 2)):
        monkeypatch.setattr(running, "MANY_ROWS", many)
        found = run_sweep(SPEC, recheck=0, pool=Pool(Stopping(9), partial(int, size)))
        assert found.summary["how"]["batch"] == lanes
        assert found.rows.equals(whole)


TWO = SweepSpec.of("reference", until="0.001", vary={"phi_dot": "-20:20:2"})
TABLES = [("one", numpy.arange(2), numpy.array([[-20.0], [20.0]]))]


@pytest.mark.parametrize(
    ("error", "kind"),
    [
        (InputError("theta: got 4"), InputError),
        (WorkerDiedError("by signal 9"), InputError),
        (MemoryError(), InputError),
        (OSError(28, "No space left on device"), InputError),
        (ValueError("a bug"), RuntimeError),
    ],
)
def test_a_failure_is_bad_input_or_a_bug(
    monkeypatch: pytest.MonkeyPatch, error: Exception, kind: type[Exception]
) -> None:
    def perform(pool: Pool, work: Any, calls: Iterator[Call]) -> Iterator[tuple[Call, Failure]]:
        yield next(calls), Failure(error)

    monkeypatch.setattr(Pool, "perform", perform)
    with local_pool(1) as pool, pytest.raises(kind, match=f"^sweep of one: {type(error).__name__}"):
        integrate_tables(pool, TWO, TABLES)


def test_rows_of_tables_come_in_order() -> None:
    with local_pool(1) as pool:
        rows = integrate_tables(pool, TWO, TABLES)
    assert (rows["phi_dot"].to_list(), *rows["series"]) == ([-20.0, 20.0], "one", "one")
