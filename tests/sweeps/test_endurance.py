"""Long sweeps: memory, and a cluster whose worker is killed. Figures are printed (-s)."""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tt_precise.runtime.workers import dask_pool
from tt_precise.sweeps import Specification, run_sweep, specification

pytestmark = pytest.mark.slow

REFERENCE_KIND = {"phi_dot": "-1:1", "theta_dot": "-0.1:0.1"}
GIB = 2**30


def reference_kind(rows: int) -> Specification:
    return specification("reference", box=REFERENCE_KIND, samples=rows, seed=1)


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
    spec = reference_kind(2000)
    with cluster() as (address, workers):
        killed: list[int] = []

        def progress(share: float) -> None:
            if not killed and share > 1 / 4:
                victim = workers()[0]
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)

        out = tmp_path / "sweep"
        swept = run_sweep(
            spec, pool=dask_pool(address), chunk=50, out=out, recheck=0, progress=progress
        )
    assert killed
    assert not swept.summary["quarantined"]
    assert list(swept.rows["index"]) == list(range(2000))
    assert swept.rows.equals(run_sweep(spec, recheck=0, chunk=500).rows)


@contextmanager
def cluster() -> Iterator[tuple[str, Callable[[], list[int]]]]:
    """A dask scheduler and its two workers as processes; its address, and the workers' ids."""
    pytest.importorskip("distributed", reason="needs the extra dask")
    psutil: Any = pytest.importorskip("psutil", reason="comes with the extra dask")
    from distributed import Client

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    address = f"tcp://127.0.0.1:{port}"
    single = ["--nthreads", "1", "--death-timeout", "60"]  # no orphans if the test is killed
    started = [
        subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{words[0]}", *words[1:],
             "--host", "127.0.0.1", "--no-dashboard"],
            stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        )
        for words in (["scheduler", "--port", port], *[["worker", address, *single, "--nanny"]] * 2)
    ]  # fmt: skip

    def workers() -> list[int]:
        """Each is the child of its nanny."""
        children = [
            child for nanny in started[1:]
            for child in psutil.Process(nanny.pid).children(recursive=True)
        ]  # fmt: skip
        return [child.pid for child in children if "spawn_main" in " ".join(child.cmdline())]

    try:
        with Client(address, timeout="60s", set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
        yield address, workers
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            process.wait(timeout=30)


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
