"""``sweep``: from a specification to rows, on any executor, interrupted and resumed at will."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise._version import __version__
from tt_precise.errors import InputError
from tt_precise.sweep import spot_check
from tt_precise.sweep.specification import Plan, Specification, blocks
from tt_precise.sweep.store import Folder, Memory, default_chunk
from tt_precise.sweep.summary import summary_of
from tt_precise.workers import Call, Failure, Pool, dask_pool, local_pool

if TYPE_CHECKING:
    import pandas

TRIES = 3  # of a chunk, before it is quarantined
RECYCLED_AFTER = 500  # tasks of a process; then a new one, without what it may have leaked
Told = Callable[[int, int], None]


@dataclass(frozen=True)
class Swept:
    """A finished sweep: its summary (see ``summary.summary_of``), and its rows when asked."""

    summary: Mapping[str, Any]
    store: Memory | Folder

    @property
    def rows(self) -> pandas.DataFrame:
        """All rows in one table, in the order of their index."""
        import pandas

        return pandas.concat(list(self.store.frames()), ignore_index=True)


def sweep(
    spec: Specification,
    *,
    out: str | Path | None = None,
    workers: int = 1,
    dask: str | None = None,
    executor: Executor | None = None,
    size: int = 1,
    batch: int | None = None,
    chunk: int | None = None,
    one_in: int = spot_check.ONE_IN,
    progress: Told | None = None,
    checking: Told | None = None,
) -> Swept:
    """Integrate every row of ``spec``.

    Parameters
    ----------
    out
        A folder. If it holds this sweep already, only what is missing is computed. Without it
        the rows stay in memory.
    workers, dask, executor
        Processes on this machine; or the address of a dask scheduler; or any executor, of
        ``size`` workers, which is not shut down.
    batch
        SIMD lanes of a worker; by default two vectors of the processor.
    chunk
        Rows of one task and of one file.
    one_in
        One row in so many is integrated again in quad; 0: none.
    progress, checking
        Called with rows done and all rows; and with rows recomputed and all of those.

    Raises
    ------
    InputError
        Something of this cannot be used.
    """
    if batch is not None and not 1 <= batch <= 64:
        raise InputError(f"batch: got {batch}, expected 1 to 64")
    if chunk is not None and not 1 <= chunk <= 1_000_000:
        raise InputError(f"chunk: got {chunk}, expected 1 to 1000000 rows")
    if one_in < 0:
        raise InputError(f"one_in: got {one_in}, expected 0 (none) or a number of rows")
    store: Memory | Folder
    if out is None:
        store = Memory(spec, chunk or default_chunk(spec.rows))
    else:
        store = Folder(out, spec, chunk)
    lanes = batch or _simd_lanes()
    before, begun = len(store.done), time.perf_counter()
    with _pool(workers, dask, executor, size) as pool:
        computed = _compute(spec, store, pool, lanes, progress)
        seconds = time.perf_counter() - begun
        if not store.quarantined:
            _check(spec, store, pool, one_in, checking)
        checked = time.perf_counter() - begun - seconds
        serving = pool.size()
    how = {
        "batch": lanes,
        "workers": serving,
        "chunk": store.size,
        "chunks_found": before,
        "rows_computed": computed,
        "seconds": round(seconds, 3),
        "rows_per_second": round(computed / seconds, 1) if computed else 0.0,
        "seconds_checking": round(checked, 3),
    }
    store.gather()
    summary = summary_of(spec, store, how)
    store.tell(summary)
    return Swept(summary, store)


def sweep_pool(workers: int | None = None) -> Pool:
    """Processes of this machine that get ready while the first starts are drawn."""
    return local_pool(workers, tries=TRIES, recycle_after=RECYCLED_AFTER, prepare=_get_ready)


def _pool(workers: int, dask: str | None, executor: Executor | None, size: int) -> Pool:
    if executor is not None:
        return Pool(executor, lambda: size, tries=TRIES)
    return sweep_pool(workers) if dask is None else dask_pool(dask, tries=TRIES)


def _get_ready() -> None:
    import tt_precise.sweep.chunk  # noqa: F401


def chunk_task(plan: Plan, version: str, number: int, values: Any, batch: int) -> dict[str, Any]:
    """The results of a chunk, in a worker; its ``seconds`` there are told beside the columns."""
    from tt_precise.sweep.chunk import compute

    if __version__ != version:
        raise InputError(f"worker: has tt_precise {__version__}, expected {version} as here")
    begun = time.perf_counter()
    columns = compute(plan, values, batch)
    return {"columns": columns, "seconds": time.perf_counter() - begun}


def recheck_task(plan: Plan, values: dict[str, float]) -> dict[str, Any]:
    """A row again in quad, in a worker."""
    return spot_check.recomputed(plan.scene_of(values), plan.record)


def _compute(
    spec: Specification, store: Memory | Folder, pool: Pool, batch: int, progress: Told | None
) -> int:
    tell = progress or (lambda done, all_rows: None)
    size = store.size
    last = -(-spec.rows // size) - 1

    def rows_of(number: int) -> int:
        return spec.rows - last * size if number == last else size

    done = sum(map(rows_of, store.done))
    found = done
    tell(done, spec.rows)
    calls = (
        Call(number, (spec.plan, __version__, number, values, batch))
        for number, values in blocks(spec, size, set(store.done))
    )
    for call, result in pool.perform(chunk_task, calls):
        if isinstance(result, Failure):
            store.quarantine(call.key, result.reason)
            continue
        about = {"seconds": round(result["seconds"], 3), "batch": batch}
        store.keep(call.key, call.arguments[3], result["columns"], about)
        done += rows_of(call.key)
        tell(done, spec.rows)
    return done - found


def _check(
    spec: Specification,
    store: Memory | Folder,
    pool: Pool,
    one_in: int,
    checking: Told | None,
) -> None:
    tell = checking or (lambda done, all_rows: None)
    wanted = set(spot_check.drawn(spec.rows, spec.seed, one_in)) - store.checked.keys()
    rows = {int(row["index"]): row for row in _rows(store, wanted)}
    if spec.contact == "bilateral":
        # quad runs end where contact is lost; beyond, there is nothing to compare with
        rows = {index: row for index, row in rows.items() if row["min_g_n"] > 0}
    calls = (
        Call(index, (spec.plan, {name: float(row[name]) for name in spec.names}))
        for index, row in rows.items()
    )
    for done, (call, result) in enumerate(pool.perform(recheck_task, calls), start=1):
        index = call.key
        if isinstance(result, Failure):
            store.check(index, {"error": result.reason})
        else:
            row = rows[index]
            store.check(
                index,
                {
                    "outcomes": [row["outcome"], result["outcome"]],
                    "differences": spot_check.differences(row, result),
                },
            )
        tell(done, len(rows))


def _rows(store: Memory | Folder, wanted: set[int]) -> Iterator[dict[Any, Any]]:
    for frame in store.frames():
        yield from frame[frame["index"].isin(wanted)].to_dict("records")


def _simd_lanes() -> int:
    import heyoka

    # two vectors of the processor: the Python around each step of a batch costs the same for
    # more lanes, until registers run out (measured where a vector has 4: with 8 lanes 1.2 to 1.6
    # times the rows of 4, with 16 fewer)
    return 2 * int(heyoka.recommended_simd_size())
