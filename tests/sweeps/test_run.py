"""Sweeps as a whole: on disk, interrupted, resumed, damaged, checked in finer arithmetic."""

import json
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
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps import SweepSpec, read_rows, run_sweep, spot_check
from tt_precise.sweeps import run as running
from tt_precise.sweeps.columns import FIXED
from tt_precise.sweeps.run import integrate_tables
from tt_precise.sweeps.specification import blocks
from tt_precise.sweeps.spot_check import differences, sampled_rows

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


def test_columns_and_summary(whole: pandas.DataFrame) -> None:
    assert list(whole.columns) == ["index", "phi_dot", *FIXED]
    assert list(whole["index"]) == list(range(41))
    found = run_sweep(SPEC, recheck=0, chunk=5).summary
    assert found["schema"] == "tt_precise.sweep/1"
    assert found["rows"] == found["expected"] == found["outcomes"]["undecided"] == 41
    assert found["columns"]["phi_dot"] == {"min": -20, "max": 20, "mean": 0, "missing": 0}
    assert found["columns"]["t_end_A"]["missing"] == 41
    assert found["how"]["rows_computed"] == 41
    json.dumps(found)


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


def test_one_row_of_each_thousand_is_drawn() -> None:
    rows = list(sampled_rows(10_500, seed=1))
    assert [row // 1000 for row in rows] == list(range(11))
    assert rows[-1] < 10_500
    assert rows == list(sampled_rows(10_500, seed=1)) != list(sampled_rows(10_500, seed=2))
    assert not list(sampled_rows(100, seed=1, one_in=0))
    with pytest.raises(InputError, match="recheck: got -1"):
        run_sweep(SPEC, recheck=-1)


def test_the_spot_check_finds_what_differs(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = SweepSpec.of("reference", until="0.2", vary={"phi_dot": "90,95,100"})
    found = run_sweep(spec, recheck=1).summary["recheck"]
    assert found["rows"] == 3
    assert not any(found[name] for name in ("other_outcome", "only_in_one", "errors"))
    # g_n of size 0.2 N over 40 steps: some eps of it, which the stiff force enlarges tenfold
    assert found["largest_difference"]["min_g_n"]["value"] < 1e3 * 0.2 * 2.0**-52
    right = spot_check.recomputed
    wrong = {"min_g_n": 0.1, "t_init_A": 0.5, "outcome": "inverts"}
    monkeypatch.setattr(spot_check, "recomputed", lambda *given: {**right(*given), **wrong})
    spoiled = run_sweep(spec, recheck=3).summary["recheck"]
    assert spoiled["largest_difference"]["min_g_n"]["value"] > 1e-3
    assert spoiled["other_outcome"]
    assert spoiled["only_in_one"]


@pytest.mark.slow
@pytest.mark.parametrize("row", [{}, {"mu": "3", "until": "1"}, {"phi_dot": "195"}])
def test_the_spot_check_finds_what_quad_finds(
    row: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, record = load_scene("reference").varied(**row), ("max_phi_dot", "start_E", "end_g_n")
    found = spot_check.recomputed(scene, record)
    monkeypatch.setattr(spot_check, "FINE", "quad")
    # the same doubles; only g_n where contact is lost, which is zero, is another rounding error
    assert max(differences(found, spot_check.recomputed(scene, record)).values()) < 1e-30


def test_what_several_doubles_lack_is_done_in_quad(monkeypatch: pytest.MonkeyPatch) -> None:
    used: list[str] = []
    right = spot_check.row_of

    def noting(scene: Scene, record: tuple[str, ...], **how: Any) -> Any:
        used.append(how["precision"])
        return right(scene, record, **how)

    monkeypatch.setattr(spot_check, "row_of", noting)
    for name, precision in (("reference", "double-double"), ("coulomb-stick-slip", "quad")):
        spot_check.recomputed(load_scene(name).varied(until="0.001"), ())
        assert used.pop() == precision
        assert not used
    thrown = load_scene("reference").varied(phi_dot="400")
    assert spot_check.recomputed(thrown, ())["outcome"] == "contact_lost"


def test_long_sweeps_have_more_lanes_and_the_same_rows(
    monkeypatch: pytest.MonkeyPatch, whole: pandas.DataFrame
) -> None:
    monkeypatch.setattr("heyoka.recommended_simd_size", lambda: 1)
    for size, many, lanes in ((1, 42, 2), (1, 41, 4), (1, 20, 4), (2, 20, 4), (2, 21, 2)):
        monkeypatch.setattr(running, "MANY_ROWS", many)
        found = run_sweep(SPEC, recheck=0, pool=Pool(Stopping(9), partial(int, size)))
        assert found.summary["how"]["batch"] == lanes
        assert found.rows.equals(whole)


def test_differences_tell_missing_values() -> None:
    row = {"outcome": "inverts", "t_init_A": 1.0, "t_end_A": numpy.nan, "t_end_B": 2.0}
    fine = {"outcome": "inverts", "t_init_A": 1.25, "t_end_A": None, "t_end_B": None}
    assert differences(row, fine) == {"t_init_A": 0.25, "t_end_A": 0.0, "t_end_B": numpy.inf}


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
