"""Long sweeps: memory, and a cluster whose worker is killed. Figures are printed (-s)."""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tt_precise.runtime.workers import dask_pool
from tt_precise.sweeps import SweepSpec, run_sweep

pytestmark = pytest.mark.slow

REFERENCE_KIND = {"phi_dot": "-1:1", "theta_dot": "-0.1:0.1"}
GIB = 2**30


def reference_kind(rows: int) -> SweepSpec:
    return SweepSpec.of("reference", box=REFERENCE_KIND, samples=rows, seed=1)


def test_a_hundred_thousand_starts(tmp_path: Path) -> None:
    """0 to 8 s each, under 1 GiB in all processes together, with all that is around the lanes."""
    with watched_memory() as peak:
        swept = run_sweep(reference_kind(100_000), out=tmp_path / "sweep", workers=2, recheck=0)
    how = swept.summary["how"]
    print(f"  {how['seconds']} s, {how['rows_per_second']} rows/s, {peak[0] / GIB:.2f} GiB")
    assert swept.summary["rows"] == 100_000
    assert peak[0] < GIB


def test_a_killed_cluster_worker_loses_and_doubles_nothing(tmp_path: Path) -> None:
    """A real scheduler and two worker processes over loopback TCP; one is killed in the middle."""
    distributed = pytest.importorskip("distributed", reason="needs the extra dask")
    spec = reference_kind(2000)
    killed: list[int] = []

    def progress(share: float) -> None:
        if not killed and share > 1 / 4:
            killed.append(cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        pool, out = dask_pool(cluster.scheduler_address), tmp_path / "sweep"
        swept = run_sweep(spec, pool=pool, chunk=50, out=out, recheck=0, progress=progress)
    assert killed
    assert list(swept.rows["index"]) == list(range(2000))
    assert swept.rows.equals(run_sweep(spec, recheck=0, chunk=500).rows)


@contextmanager
def watched_memory() -> Iterator[list[int]]:
    """The largest memory of this process and its children together, shared pages counted once."""
    psutil: Any = pytest.importorskip("psutil", reason="comes with the extra dask")

    me, peak, over = psutil.Process(), [0], threading.Event()

    def watch() -> None:
        while not over.wait(0.5):
            total = 0
            for process in (me, *me.children(recursive=True)):
                try:
                    total += process.memory_full_info().pss
                except psutil.Error:
                    continue
            peak[0] = max(peak[0], total)

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        yield peak
    finally:
        over.set()
        thread.join()
