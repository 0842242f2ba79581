"""Run a sweep: chunks of starts in worker processes or on a cluster, stored and resumed."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy
from msgspec import to_builtins

from tt_precise._version import __version__
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError, Json, listed, whole_number
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError, local_pool
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.columns import OUTCOMES
from tt_precise.sweeps.starts import Sweep
from tt_precise.sweeps.store import store_at

if TYPE_CHECKING:
    import pandas

MOST_CHUNKS = 2000  # Larger sweeps have larger chunks, which are files in a folder.
CHUNK, CHUNK_ALONE = 256, 4  # Rows of a task at least: each takes a second, in lanes and alone.
# Rows of a worker from which four SIMD vectors of lanes, which are 1.2 times as fast as two, save
# more than compiling them costs (6 s instead of 3).
MANY_ROWS = 10_000
RECHECK = 1000  # One row in so many is integrated again in a finer arithmetic.
UNUSABLE = (InputError, OSError, MemoryError, WorkerDiedError)
Ranges = dict[str, dict[str, float | None]]


class Summary(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.sweep/2"):
    """Output of `tt-precise sweep SCENE --json`."""

    rows: Annotated[int, means("number of rows")]
    outcomes: Annotated[dict[str, int], means("number of rows with each outcome")]
    columns: Annotated[Ranges, means("min, max and mean of each column, and missing values")]
    recheck: Annotated[
        dict[str, Json], means("rows again in a finer arithmetic: differences, contradictions")
    ]
    rows_computed: Annotated[int, means("rows computed now, not earlier")]
    seconds: Annotated[float, means("duration in s, without the rows integrated again")]
    rows_per_second: Annotated[float, means("rows per second")]
    specification: Annotated[dict[str, Json], means("everything on which the rows depend")]
    out: Annotated[str | None, means("file, folder or URL of the rows")]


def sweep(
    scene: str | Scene,
    starts: pandas.DataFrame,
    *,
    record: str | Iterable[str] = (),
    contact: str = "unilateral",
    out: str | Path | None = None,
    workers: int = 1,
    pool: Pool | None = None,
    chunk: int | None = None,
    recheck: int = RECHECK,
    progress: Progress = silent,
) -> pandas.DataFrame:
    """Integrate ``scene`` from each row of ``starts``.

    Parameters
    ----------
    scene
        A shipped name, a path to a TOML file, or a scene. Rows of gliding with the viscous law and
        of rolling, on a rigid table, take milliseconds; others take as long as ``integrate``.
    starts
        A column for each start value (rad, rad/s, m/s) or parameter (SI; I1 and I3 in units of
        m R^2) that varies, such as ``grid`` makes; all other values are the scene's.
    record
        Extra columns; see ``tt_precise.sweeps.columns``.
    contact
        "unilateral": a row ends where g_n reaches 0; "bilateral": a row continues with g_n < 0.
    out
        A file ``.csv``, or a folder or URL for Parquet files. The same call after an interruption
        computes the missing rows.
    workers, pool, chunk
        Processes; with more than one a script needs ``if __name__ == "__main__"``. A ``pool``, such
        as a cluster, replaces the processes. ``chunk`` is the number of rows of a task.
    recheck
        Integrate one row in ``recheck`` again in double-double; 0: none.
    progress
        A function that is called with the finished fraction.

    Returns
    -------
    pandas.DataFrame
        ``index``, the columns of ``starts``, and the columns of ``tt_precise.sweeps.columns``, in
        SI; ``attrs["summary"]`` has counts, ranges and settings.

    Raises
    ------
    InputError
        An argument cannot be used, or a worker process ended.
    RuntimeError
        A task failed. Finished rows are stored, and the same call resumes.
    """
    import pandas

    whole_number(recheck, "recheck", 0, 10**9)
    if not isinstance(starts, pandas.DataFrame):
        raise InputError(
            f"starts: got {type(starts).__name__}, expected a pandas table with a column for each "
            'name that varies, such as tt.grid({"mu": [0.2, 0.3]})'
        )
    plan = Sweep(load_scene(scene), tuple(map(str, starts.columns)), listed(record), contact)
    values, began = plan.values(starts), time.perf_counter()
    least = CHUNK if plan.has_lanes else CHUNK_ALONE
    size = chunk or max(least, -(-len(values) // MOST_CHUNKS))
    manifest = {
        "tt_precise": __version__,
        "rows": len(values),
        "starts": hashlib.sha256(values.tobytes()).hexdigest(),
        **plan.description(),
    }
    store = store_at(None if out is None else str(out), manifest, size)
    with nullcontext(pool) if pool else local_pool(workers) as at_work:
        missing = [n for n in range(-(-len(values) // store.chunk)) if n not in store.finished]
        parts = {n: values[n * store.chunk : (n + 1) * store.chunk] for n in missing}
        computed = sum(map(len, parts.values()))
        lanes = _lanes(computed // at_work.size())
        calls = [Call(n, (plan, part, __version__, lanes)) for n, part in parts.items()]
        done = len(values) - computed
        for call, result in at_work.perform(rows_task, calls):
            first, part = call.key * store.chunk, parts[call.key]
            if isinstance(result, Failure):
                raise _ended(first, first + len(part) - 1, result, out)
            index = numpy.arange(first, first + len(part))
            varied = dict(zip(plan.names, part.T, strict=True))
            store.keep(call.key, pandas.DataFrame({"index": index, **varied, **result}))
            done += len(part)
            progress(done / len(values))
        seconds = time.perf_counter() - began
        rows = store.rows()
        checked = _check_again(plan, values, rows, recheck, at_work)
    counts = rows["outcome"].value_counts()
    summary = Summary(
        rows=len(rows),
        outcomes={name: int(counts.get(name, 0)) for name in OUTCOMES},
        columns=_ranges(rows),
        recheck=checked,
        rows_computed=computed,
        seconds=round(seconds, 3),
        rows_per_second=round(computed / seconds, 1),
        specification=manifest,
        out=None if out is None else str(out),
    )
    rows.attrs = {"law": plan.scene.body.law, "summary": to_builtins(summary)}
    return rows


def rows_task(plan: Sweep, values: Array, version: str, lanes: int) -> Mapping[str, Array]:
    """Integrate some rows, in a worker; return the columns of the results."""
    from tt_precise.sweeps.rows import integrate_rows

    if __version__ != version:
        raise InputError(f"worker: has tt_precise {__version__}, expected {version} as here")
    return integrate_rows(plan, values, lanes)


def _lanes(rows: int) -> int:
    """Return the number of lanes of a worker with so many rows."""
    return (4 if rows >= MANY_ROWS else 2) * int(import_heyoka().recommended_simd_size())


def _ended(first: int, last: int, failure: Failure, out: str | Path | None) -> Exception:
    """Return the error that ends a sweep: unusable input or resources, or a bug."""
    stored = f" (finished rows are stored in {out})" if out else ""
    reason = f"sweep: rows {first} to {last}: {failure.reason}; repeat the command{stored}"
    error = (InputError if isinstance(failure.error, UNUSABLE) else RuntimeError)(reason)
    error.__cause__ = failure.error
    return error


def _ranges(rows: pandas.DataFrame) -> Ranges:
    ranges: Ranges = {}
    for name, column in rows.drop(columns=["index", "outcome"]).items():
        values = {"min": column.min(), "max": column.max(), "mean": column.mean()}
        numbers = {key: None if value != value else float(value) for key, value in values.items()}
        ranges[str(name)] = {**numbers, "missing": int(column.isna().sum())}
    return ranges


# ---- rows again, in a finer arithmetic -----------------------------------------------------------


def recheck_task(plan: Sweep, values: list[float]) -> dict[str, Json]:
    """Integrate a row again by another integrator, in a worker."""
    from tt_precise.sweeps.single import fine_row_of

    return fine_row_of(plan.scene_of(values), plan.record)


def _check_again(
    plan: Sweep, values: Array, rows: pandas.DataFrame, one_in: int, pool: Pool
) -> dict[str, Json]:
    """Compare one row in ``one_in`` with the same row in a finer arithmetic."""
    count = -(-len(rows) // one_in) if one_in else 0
    drawn = numpy.random.default_rng(0).choice(len(rows), count, replace=False)
    # beyond a loss of contact a finer integration does not continue
    compared = (rows["min_g_n"] > 0) | (plan.contact == "unilateral")
    chosen = [n for n in sorted(drawn.tolist()) if compared[n]]
    differences: dict[str, float] = {}
    contradictions: list[dict[str, Json]] = []
    for call, again in pool.perform(
        recheck_task, [Call(n, (plan, values[n].tolist())) for n in chosen]
    ):
        if isinstance(again, Failure):
            contradictions.append({"index": call.key, "column": "failed", "finer": again.reason})
            continue
        for name, finer in again.items():
            double = rows[name][call.key]
            double = None if double != double else double if name == "outcome" else float(double)
            if name == "outcome" or None in (double, finer):
                if double != finer:
                    values_there = {"double": double, "finer": finer}
                    contradictions.append({"index": call.key, "column": name, **values_there})
            elif name not in ("steps", "jellett_drift"):  # an arithmetic has its own
                differences[name] = max(differences.get(name, 0.0), abs(double - finer))
    return {"rows": len(chosen), "differences": differences, "contradictions": contradictions}
