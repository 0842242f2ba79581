"""``sweep`` and ``run_sweep``: from a specification to rows on any pool of workers, resumable.

``sweep`` is ``tt.sweep``; the command uses ``run_sweep``; ``integrate_tables`` takes tables of
starts that are neither a grid nor a box.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Hashable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tt_precise._version import __version__
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.quantities import Motion, jellett
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError, Json, keyword_advice, listed, whole_number
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError, local_pool
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Inclination, Scene
from tt_precise.sweeps import spot_check
from tt_precise.sweeps.specification import (
    Ends,
    SweepSpec,
    Values,
    blocks,
)
from tt_precise.sweeps.store import Store, frame_of
from tt_precise.sweeps.summary import summary_of

if TYPE_CHECKING:
    import pandas

RECYCLED_AFTER = 500  # tasks of a process; then a new process replaces it, to free leaked memory
MANY_ROWS = 10_000  # Rows of a worker from which more lanes save what compiling them costs.
TABLE_ROWS = 128  # Rows in a task of ``integrated``.
NO_BUGS = (InputError, WorkerDiedError, MemoryError, OSError)


@keyword_advice('values by name: sweep(scene, vary={"mu": [0.2, 0.3]})')
def sweep(
    scene: str | Scene,
    vary: Mapping[str, Values] | None = None,
    *,
    box: Mapping[str, Ends] | None = None,
    samples: int = 0,
    seed: int = 0,
    record: Iterable[str] = (),
    until: str | float | Fraction | None = None,
    contact: Literal["unilateral", "bilateral"] = "unilateral",
    out: str | Path | None = None,
    workers: int = 1,
    recheck: int = spot_check.ONE_IN,
) -> pandas.DataFrame:
    """Integrate ``scene`` from many starts; each start gives one row.

    Parameters
    ----------
    scene
        A shipped name, a path to a TOML file, or a scene. Rows of gliding with the viscous law and
        of rolling, on a rigid table, take milliseconds; other rows take as long as ``integrate``.
    vary
        A grid: the values of each start value (rad, rad/s, m/s) or parameter (SI; I1 and I3 in
        units of m R^2), by name, as numbers or as text: "0.1,0.2", or "-200:200:801" for 801
        values, ends included.
    box, samples
        Ranges by name, as two numbers or as "low:high", and the number of samples.
    seed
        The seed of the Sobol sequence of the samples, and of the rows to recheck.
    record
        Extra columns; see ``tt_precise.sweeps.columns``.
    until
        Horizon in s, instead of the scene's.
    contact
        "unilateral": a row ends where g_n reaches 0; "bilateral": a row continues with g_n < 0.
    out
        A folder or URL for the rows; existing rows are not computed again.
    workers
        Processes; with more than one a script needs ``if __name__ == "__main__"``.
    recheck
        Integrate one row in ``recheck`` again in double-double; 0: none.

    Returns
    -------
    pandas.DataFrame
        ``index``, the varied values, ``outcome``, and the columns of ``tt_precise.sweeps.columns``,
        in SI; ``attrs["summary"]`` has results and settings. Outcomes are ``inverts`` (the axis
        has crossed the equator, and is below the equator at the end), ``does_not_invert`` (energy
        and lambda at the end exclude that the axis reaches the equator), ``undecided`` (at the
        horizon neither is certain), ``contact_lost``, ``singular_contact``, ``landed`` and
        ``failed``.

    Raises
    ------
    InputError
        An argument cannot be used.
    """
    spec = SweepSpec.of(
        scene,
        vary=vary,
        box=box,
        until=until,
        samples=samples,
        seed=seed,
        record=listed(record),
        contact=contact,
    )
    swept = run_sweep(spec, out=out, workers=workers, recheck=recheck)
    rows = swept.rows
    rows.attrs["summary"] = dict(swept.summary)
    return rows


@dataclass(frozen=True)
class Swept:
    """A finished sweep: its summary (see ``summary.summary_of``), and its rows on request."""

    summary: Mapping[str, Json]
    store: Store

    @property
    def rows(self) -> pandas.DataFrame:
        """All rows in one table, in the order of their index."""
        import pandas

        return pandas.concat(list(self.store.frames()), ignore_index=True)


def run_sweep(
    spec: SweepSpec,
    *,
    out: str | Path | None = None,
    workers: int = 1,
    pool: Pool | None = None,
    batch: int | None = None,
    chunk: int | None = None,
    recheck: int = spot_check.ONE_IN,
    progress: Progress = silent,
) -> Swept:
    """Integrate every row of ``spec``; ``out``, ``workers`` and ``recheck`` as of ``sweep``.

    If ``out`` (a folder, or a URL of fsspec, such as ``file:///...`` for a folder that all machines
    share) already contains this sweep, its rows are verified, and only missing rows are computed.
    ``pool``, such as a cluster, replaces the workers. ``batch`` is the number of SIMD lanes of a
    worker, by default two vectors of the processor, four in long sweeps; ``chunk`` is the number of
    rows of one task and of one file. ``progress`` is called with the completed fraction.

    Raises
    ------
    InputError
        An argument cannot be used, or a chunk fails repeatedly for want of resources. The rows of
        other chunks are stored.
    RuntimeError
        A chunk fails for another reason. Both errors name the rows of the chunk.
    """
    recheck = whole_number(recheck, "recheck", 0, sys.maxsize)
    store = Store(spec, out, chunk)
    with store.opened():
        before, missing = len(store.known), spec.rows - store.rows
        started = time.perf_counter()
        with pool or sweep_pool(workers) as at_work:
            lanes = batch or _simd_lanes(missing // at_work.size())
            _compute(store, at_work, lanes, progress)
            seconds = time.perf_counter() - started
            rechecked = _recheck(store, at_work, recheck)
            checked = time.perf_counter() - started - seconds
            serving = at_work.size()
        computed = missing - (spec.rows - store.rows)
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
        summary = summary_of(store, rechecked, how)
        store.finish(summary)
    return Swept(summary, store)


def sweep_pool(workers: int | None = None) -> Pool:
    """Processes of this machine that start up while the first starts are sampled."""
    return local_pool(workers, recycle_after=RECYCLED_AFTER)


def chunk_task(spec: SweepSpec, version: str, values: Array, batch: int) -> dict[str, Array]:
    """The results of some rows, in a worker: their columns."""
    from tt_precise.sweeps.chunk import compute

    if __version__ != version:
        raise InputError(f"worker: has tt_precise {__version__}, expected {version} as here")
    return compute(spec, values, batch)


def recheck_task(spec: SweepSpec, values: dict[str, float]) -> dict[str, Json]:
    """Integrate a row again in a finer arithmetic, in a worker."""
    return spot_check.recomputed(spec.scene_of(values), spec.record)


def _compute(store: Store, pool: Pool, batch: int, progress: Progress) -> None:
    spec = store.spec

    def calls() -> Iterator[Call]:
        for number, values in blocks(spec, store.size, frozenset(store.known)):
            yield Call(number, (spec.of_a_row, __version__, values, batch))

    for call, result in pool.perform(chunk_task, calls()):
        first, values = call.key * store.size, call.arguments[2]
        if isinstance(result, Failure):
            last = first + len(values) - 1
            again = "run it again to resume" if store.out else "expected other starts"
            raise _ended(f"sweep: rows {first} to {last}: {result.reason}; {again}", result)
        store.keep(call.key, frame_of(spec.names, first, values, result))
        progress(store.rows / spec.rows)


def _ended(reason: str, failure: Failure) -> Exception:
    """The error that ends a sweep after a failed task: bad input or resources, or a bug."""
    ended = (InputError if isinstance(failure.error, NO_BUGS) else RuntimeError)(reason)
    ended.__cause__ = failure.error
    return ended


def _recheck(store: Store, pool: Pool, one_in: int) -> dict[int, dict[str, Json]]:
    """Integrate the rows of the spot check again; returns the differences by index."""
    spec = store.spec
    wanted = set(spot_check.sampled_rows(spec.rows, spec.seed, one_in))
    asked: dict[int, dict[Hashable, Any]] = {}
    rechecked: dict[int, dict[str, Json]] = {}

    def calls() -> Iterator[Call]:
        for row in _rows(store, wanted):
            # these runs end where contact is lost; beyond, there is nothing to compare with
            if spec.contact == "bilateral" and not row["min_g_n"] > 0:
                continue
            asked[int(row["index"])] = row
            values = {name: float(row[name]) for name in spec.names}
            yield Call(int(row["index"]), (spec.of_a_row, values))

    for call, result in pool.perform(recheck_task, calls()):
        row = asked.pop(call.key)
        if isinstance(result, Failure):
            rechecked[call.key] = {"error": result.reason}
        else:
            rechecked[call.key] = {
                "outcomes": [row["outcome"], result["outcome"]],
                "differences": spot_check.differences(row, result),
            }
    return rechecked


def _rows(store: Store, wanted: set[int]) -> Iterator[dict[Hashable, Any]]:
    for frame in store.frames() if wanted else ():
        yield from frame[frame["index"].isin(wanted)].to_dict("records")


def _simd_lanes(rows: int) -> int:
    # the Python around each step of a batch costs the same for more lanes, and heyoka takes steps
    # of four vectors in as much time a lane as of two (24 lanes 1.25 times); but to compile them
    # takes 6 s instead of 3
    return (4 if rows >= MANY_ROWS else 2) * int(import_heyoka().recommended_simd_size())


# ---- tables of starts other than grids and boxes ----------------------------------------------


def integrate_tables(
    pool: Pool, spec: SweepSpec, tables: list[tuple[str, Array, Array]]
) -> pandas.DataFrame:
    """Integrate the rows of some tables, in their order.

    ``tables`` has (series, index, values of shape (rows, ``spec.names``)). The columns of the
    result are ``series``, ``contact``, ``index``, starts, results.

    Raises
    ------
    InputError
        A task fails repeatedly: a start cannot be used, or the system refuses resources.
    RuntimeError
        A task fails for another reason.
    """
    import pandas

    pieces = [
        (name, index[first : first + TABLE_ROWS], values[first : first + TABLE_ROWS])
        for name, index, values in tables
        for first in range(0, len(index), TABLE_ROWS)
    ]
    lanes = int(import_heyoka().recommended_simd_size())
    calls = (
        Call(number, (spec, __version__, values, lanes))
        for number, (_, _, values) in enumerate(pieces)
    )
    frames = {}
    for call, result in pool.perform(chunk_task, calls):
        name, index, values = pieces[call.key]
        if isinstance(result, Failure):
            raise _ended(f"sweep of {name}: {result.reason}", result)
        columns = {"series": name, "contact": spec.contact, "index": index}
        columns |= {start: values[:, position] for position, start in enumerate(spec.names)}
        frames[call.key] = pandas.DataFrame({**columns, **result})
    return pandas.concat([frames[number] for number in sorted(frames)], ignore_index=True)


def lambda_of_start(scene: Scene, theta: float) -> float:
    """Dimensionless lambda of a start with this inclination, omega_3 = 1 rad/s and no other rate.

    lambda is linear in omega_3.
    """
    start = replace(
        scene.start, theta=Inclination(Fraction(theta)), omega_3=Fraction(1), phi_dot=Fraction(0)
    )
    double = precision_named("double")
    initial = InitialState.of(replace(scene, start=start), double.arithmetic)
    return float(jellett(Motion(initial.body, initial.vectors, double.context)))
