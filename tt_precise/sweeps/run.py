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
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, import_heyoka, silent
from tt_precise.runtime.values import Array, InputError, Json, listed, whole_number
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError, local_pool
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.columns import OUTCOMES, fine_row_of
from tt_precise.sweeps.starts import Sweep
from tt_precise.sweeps.store import store_at

if TYPE_CHECKING:
    import pandas

MOST_CHUNKS = 2000  # Larger sweeps have larger chunks, which are files in a folder.
CHUNK, CHUNK_ALONE = 256, 4  # Rows of a task at least: each takes a second, in lanes and alone.
VECTORS = 2  # SIMD vectors of lanes. Four are 1.2 times as fast, and compile in 6 s instead of 3.
RECHECK = 1000  # One row in so many is integrated again in a finer arithmetic.
UNUSABLE = (InputError, OSError, MemoryError, WorkerDiedError)


class Summary(Record, frozen=True, kw_only=True, tag_field="schema", tag="tt_precise.sweep/2"):
    """Output of `tt-precise sweep SCENE --json`."""

    rows: Annotated[int, means("number of rows")]
    outcomes: Annotated[dict[str, int], means("number of rows with each outcome")]
    columns: Annotated[
        dict[str, dict[str, float | None]], means("min, max, mean of columns; missing values")
    ]
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
        A file ``.csv``, or a folder or URL for Parquet files. The same call computes missing rows.
    workers, pool, chunk
        Processes; with more than one a script needs ``if __name__ == "__main__"``. A ``pool``, such
        as a cluster, replaces the processes. ``chunk`` is the number of rows of a task.
    recheck
        Integrate one row in ``recheck`` again in double-double; 0: none.
    progress
        A function that is called with the finished fraction.

    Returns ``index``, the columns of ``starts``, and the columns of ``tt_precise.sweeps.columns``,
    in SI; ``attrs["summary"]`` has counts, ranges and settings.

    Raises ``InputError``: an argument cannot be used, or a worker process ended; ``RuntimeError``:
    a task failed. Finished rows are stored, and the same call resumes.
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
    least = max(CHUNK if plan.has_lanes else CHUNK_ALONE, -(-len(values) // MOST_CHUNKS))
    size = least if chunk is None else whole_number(chunk, "chunk", 1, 10**9)
    manifest = {
        "tt_precise": __version__,
        "rows": len(values),
        "chunk": size,
        "starts": hashlib.sha256(values.tobytes()).hexdigest(),
        **plan.description(),
    }
    store = store_at(str(out or ""), manifest)
    with nullcontext(pool) if pool else local_pool(workers) as at_work:
        parts = {
            first // size: values[first : first + size]
            for first in range(0, len(values), size)
            if first // size not in store.finished
        }
        computed = sum(map(len, parts.values()))
        calls = [Call(n, (plan, part, __version__)) for n, part in parts.items()]
        done = len(values) - computed
        for call, result in at_work.perform(rows_task, calls):
            first, part = call.key * size, parts[call.key]
            if isinstance(result, Failure):
                kind = InputError if isinstance(result.error, UNUSABLE) else RuntimeError
                stored = f" (finished rows are stored in {out})" if out else ""
                raise kind(
                    f"sweep: rows {first} to {first + len(part) - 1}: {result.reason}; repeat the "
                    f"command{stored}"
                ) from result.error
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
        out=str(out) if out else None,
    )
    rows.attrs = {"law": plan.scene.body.law, "summary": to_builtins(summary)}
    return rows


def rows_task(plan: Sweep, values: Array, version: str) -> Mapping[str, Array]:
    """Integrate some rows, in a worker; return the columns of the results."""
    from tt_precise.sweeps.rows import integrate_rows

    if __version__ != version:
        raise InputError(f"worker: has tt_precise {__version__}, expected {version} as here")
    return integrate_rows(plan, values, VECTORS * int(import_heyoka().recommended_simd_size()))


def _ranges(rows: pandas.DataFrame) -> dict[str, dict[str, float | None]]:
    numbers = rows.drop(columns=["index", "outcome"])
    ranges = numbers.agg(["min", "max", "mean"]).astype(object)
    table = ranges.where(ranges.notna(), None).to_dict()
    missing = numbers.isna().sum().to_dict()
    return {str(name): {**values, "missing": missing[name]} for name, values in table.items()}


# ---- rows again, in a finer arithmetic -----------------------------------------------------------


def recheck_task(plan: Sweep, values: list[float]) -> dict[str, Json]:
    """Integrate a row again by another integrator, in a worker."""
    return fine_row_of(plan.scene_of(values), plan.record, plan.contact)


def _check_again(
    plan: Sweep, values: Array, rows: pandas.DataFrame, one_in: int, pool: Pool
) -> dict[str, Json]:
    """Compare one row in ``one_in`` with the same row in a finer arithmetic."""
    count = -(-len(rows) // one_in) if one_in else 0
    drawn = numpy.random.default_rng(0).choice(len(rows), count, replace=False)
    calls = [Call(n, (plan, values[n].tolist())) for n in sorted(drawn.tolist())]
    differences: dict[str, float] = {}
    contradictions: list[dict[str, Json]] = []
    for call, again in pool.perform(recheck_task, calls):
        if isinstance(again, Failure):
            contradictions.append({"index": call.key, "column": "failed", "finer": again.reason})
            continue
        for name, finer in again.items():
            double = rows[name][call.key]
            double = None if double != double else double if name == "outcome" else float(double)
            if name == "outcome" or None in (double, finer):
                if double != finer:
                    pair = {"double": double, "finer": finer}
                    contradictions.append({"index": call.key, "column": name, **pair})
            elif name not in ("steps", "jellett_drift"):  # an arithmetic has its own
                differences[name] = max(differences.get(name, 0.0), abs(double - finer))
    return {"rows": count, "differences": differences, "contradictions": contradictions}
