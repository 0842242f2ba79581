"""``sweep``: from a specification to rows, on any executor, interrupted and resumed at will."""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise._version import __version__
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError, Json
from tt_precise.runtime.workers import Call, Failure, Pool, dask_pool, local_pool
from tt_precise.sweeps import spot_check
from tt_precise.sweeps.specification import Plan, Specification, blocks
from tt_precise.sweeps.store import Store, frame_of, summarized, write_chunk
from tt_precise.sweeps.summary import summary_of

if TYPE_CHECKING:
    import pandas

TRIES = 3  # of a chunk, before it is quarantined
RECYCLED_AFTER = 500  # tasks of a process; then a new one, without what it may have leaked
MANY_ROWS = 10_000  # of one worker: then steps of more lanes save what compiling them costs


@dataclass(frozen=True)
class Swept:
    """A finished sweep: its summary (see ``summary.summary_of``), and its rows when asked."""

    summary: Mapping[str, Json]
    store: Store

    @property
    def rows(self) -> pandas.DataFrame:
        """All rows in one table, in the order of their index."""
        import pandas

        frames = list(self.store.frames())
        if not frames:
            reason = next(iter(self.store.quarantined.values()))
            raise InputError(
                f"sweep: got no row ({reason}), expected some; reduce the varied values"
            )
        return pandas.concat(frames, ignore_index=True)


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
    progress: Progress = silent,
) -> Swept:
    """Integrate every row of ``spec``.

    Parameters
    ----------
    out
        A folder, or a URL that fsspec knows. If it holds this sweep already, what is there is
        verified, and only what is missing is computed. Without it the rows stay in memory. Workers
        write their chunks themselves, but for those of ``dask`` and ``executor``, which may be on
        other machines and do so at a URL only (``file:///...`` for a folder that all share).
    workers, dask, executor
        Processes on this machine; or the address of a dask scheduler; or any executor, of
        ``size`` workers, which is not shut down.
    batch
        SIMD lanes of a worker; by default two vectors of the processor, four in long sweeps.
    chunk
        Rows of one task and of one file.
    one_in
        One row in so many is integrated again in a finer arithmetic; 0: none.
    progress
        Called with the share of rows that are done.

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
    store = Store(spec, out, chunk)
    with store.opened():
        before, started = len(store.parts), time.perf_counter()
        with _pool(workers, dask, executor, size) as pool:
            missing = spec.rows - sum(part["rows"] for part in store.parts.values())
            lanes = batch or _simd_lanes(missing // pool.size())
            # other machines do not see a folder of this one; a URL is for all
            there = (dask is None and executor is None) or "://" in str(out)
            computed = _compute(spec, store, pool, lanes, there, progress)
            seconds = time.perf_counter() - started
            if not store.quarantined:
                _check(spec, store, pool, one_in)
            checked = time.perf_counter() - started - seconds
            serving = pool.size()
        how = {
            "batch": lanes,
            "workers": serving,
            "chunk": store.size,
            "chunks_found": before,
            "damaged": store.damaged,
            "rows_computed": computed,
            "seconds": round(seconds, 3),
            "rows_per_second": round(computed / seconds, 1) if computed else 0.0,
            "seconds_checking": round(checked, 3),
        }
        summary = summary_of(spec, store, how)
        store.finish(summary)
    return Swept(summary, store)


def sweep_pool(workers: int | None = None) -> Pool:
    """Processes of this machine that get ready while the first starts are drawn."""
    return local_pool(workers, tries=TRIES, recycle_after=RECYCLED_AFTER, prepare=_get_ready)


def _pool(workers: int, dask: str | None, executor: Executor | None, size: int) -> Pool:
    if executor is not None:
        return Pool(executor, lambda: size, tries=TRIES)
    return sweep_pool(workers) if dask is None else dask_pool(dask, tries=TRIES)


def _get_ready() -> None:
    import tt_precise.sweeps.chunk  # noqa: F401


def chunk_task(plan: Plan, version: str, values: Array, batch: int) -> dict[str, Any]:
    """The results of some rows, in a worker: "columns", and the "seconds" that they took."""
    from tt_precise.sweeps.chunk import compute

    if __version__ != version:
        raise InputError(f"worker: has tt_precise {__version__}, expected {version} as here")
    started = time.perf_counter()
    columns = compute(plan, values, batch)
    return {"columns": columns, "seconds": round(time.perf_counter() - started, 3)}


def written_chunk_task(
    plan: Plan,
    version: str,
    values: Array,
    batch: int,
    number: int,
    first: int,
    out: str,
    fingerprint: str,
) -> dict[str, Json]:
    """A chunk whose rows the worker writes itself; what a summary needs of it."""
    found = chunk_task(plan, version, values, batch)
    frame = frame_of(plan.names, first, values, found["columns"])
    write_chunk(out, fingerprint, number, frame)
    return summarized(frame)


def recheck_task(plan: Plan, values: dict[str, float]) -> dict[str, Json]:
    """A row again in a finer arithmetic, in a worker."""
    return spot_check.recomputed(plan.scene_of(values), plan.record)


def _compute(
    spec: Specification,
    store: Store,
    pool: Pool,
    batch: int,
    there: bool,
    progress: Progress,
) -> int:
    """Compute the chunks that are missing; ``there``: the workers can write where they belong."""
    found = done = sum(part["rows"] for part in store.parts.values())
    out = store.out if there else None

    def calls() -> Iterator[Call]:
        for number, values in blocks(spec, store.size, set(store.parts)):
            arguments: tuple[Any, ...] = (spec.plan, __version__, values, batch)
            if out is not None:
                arguments += (number, number * store.size, out, spec.fingerprint)
            yield Call(number, arguments)

    work = chunk_task if out is None else written_chunk_task
    for call, result in pool.perform(work, calls()):
        number, values = call.key, call.arguments[2]
        if isinstance(result, Failure):
            if isinstance(result.error, InputError):  # a full disk, for example
                raise result.error
            store.quarantined[number] = result.reason
            continue
        if out is None:
            frame = frame_of(spec.names, number * store.size, values, result["columns"])
            store.keep(number, frame, summarized(frame))
        else:
            store.keep(number, None, result)
        done += len(values)
        progress(done / spec.rows)
    return done - found


def _check(spec: Specification, store: Store, pool: Pool, one_in: int) -> None:
    """Integrate the rows of the spot check again, and note how they differ."""
    wanted = set(spot_check.drawn(spec.rows, spec.seed, one_in)) - store.checked.keys()
    asked: dict[int, dict[Hashable, Any]] = {}

    def calls() -> Iterator[Call]:
        for row in _rows(store, wanted):
            # these runs end where contact is lost; beyond, there is nothing to compare with
            if spec.contact == "bilateral" and not row["min_g_n"] > 0:
                continue
            asked[int(row["index"])] = row
            values = {name: float(row[name]) for name in spec.names}
            yield Call(int(row["index"]), (spec.plan, values))

    for call, result in pool.perform(recheck_task, calls()):
        row = asked.pop(call.key)
        if isinstance(result, Failure):
            store.checked[call.key] = {"error": result.reason}
        else:
            store.checked[call.key] = {
                "outcomes": [row["outcome"], result["outcome"]],
                "differences": spot_check.differences(row, result),
            }


def _rows(store: Store, wanted: set[int]) -> Iterator[dict[Hashable, Any]]:
    for frame in store.frames() if wanted else ():
        yield from frame[frame["index"].isin(wanted)].to_dict("records")


def _simd_lanes(rows: int) -> int:
    """How many lanes are best for a worker that has so many rows before it."""
    heyoka = import_heyoka()

    # the Python around each step of a batch costs the same for more lanes, and heyoka takes steps
    # of four vectors in as much time a lane as of two (24 lanes 1.25 times); but to compile them
    # takes 6 s instead of 3
    return (4 if rows >= MANY_ROWS else 2) * int(heyoka.recommended_simd_size())
