"""Sweeps as a whole: tasks that fail, rows in a finer arithmetic, a cluster."""

import json
import os
import signal
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tt_precise.runtime.values import InputError
from tt_precise.runtime.workers import dask_pool
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import run as running
from tt_precise.sweeps.columns import FIXED

SCENE = load_scene("reference").varied(until="0.05")
STARTS = tt.grid({"phi_dot": "-20:20:12"})


def test_columns_and_summary() -> None:
    fractions: list[float] = []
    rows = tt.sweep(SCENE, STARTS, chunk=5, recheck=0, progress=fractions.append)
    assert list(rows.columns) == ["index", "phi_dot", *FIXED]
    assert rows["phi_dot"].equals(STARTS["phi_dot"])
    assert fractions == pytest.approx([5 / 12, 10 / 12, 1])
    summary = rows.attrs["summary"]
    assert summary["rows"] == summary["rows_computed"] == summary["outcomes"]["undecided"] == 12
    phi_dot = summary["columns"]["phi_dot"]
    assert phi_dot == {"min": -20, "max": 20, "mean": pytest.approx(0, abs=1e-14), "missing": 0}
    assert summary["columns"]["t_end_A"] == {"min": None, "max": None, "mean": None, "missing": 12}
    json.dumps(summary)
    assert tt.sweep(SCENE, STARTS, chunk=12, recheck=0).equals(rows)
    with pytest.raises(InputError, match="chunk: got -1, expected a whole number between 1 and"):
        tt.sweep(SCENE, STARTS, chunk=-1)


@pytest.mark.parametrize(
    ("error", "kind"),
    [(OSError(28, "No space left on device"), InputError), (ValueError("a bug"), RuntimeError)],
)
def test_a_task_that_fails_names_its_rows(
    monkeypatch: pytest.MonkeyPatch, error: Exception, kind: type[Exception]
) -> None:
    right = running.rows_task

    def task(plan: Any, values: Any, version: str) -> Any:
        if values[0, 0] > -10:
            raise error
        return right(plan, values, version)

    monkeypatch.setattr(running, "rows_task", task)
    with pytest.raises(kind, match=rf"^sweep: rows 4 to 7: {type(error).__name__}.*; repeat the"):
        tt.sweep(SCENE, STARTS, chunk=4, recheck=0)


def kill_the_worker(*arguments: Any) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.evidence
def test_a_worker_that_dies_ends_the_sweep(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setattr(running, "rows_task", kill_the_worker)
    out = tmp_path / "rows.csv"
    with pytest.raises(InputError, match=r"repeat the command \(finished rows are stored in"):
        tt.sweep(SCENE, STARTS, chunk=4, recheck=0, workers=2, out=out)


def test_recheck_is_a_number_of_rows() -> None:
    checks = [tt.sweep(SCENE, STARTS, recheck=n).attrs["summary"]["recheck"] for n in (0, 5)]
    assert [check["rows"] for check in checks] == [0, 3]
    # g_n of size 0.2 N over some steps: some eps of it, which the stiff force enlarges tenfold
    assert 0 <= checks[1]["differences"]["min_g_n"] < 1e3 * 0.2 * 2.0**-52
    assert checks[1]["contradictions"] == []


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"min_g_n": 0.1}, None),
        ({"outcome": "inverts"}, {"column": "outcome", "double": "undecided", "finer": "inverts"}),
        ({"t_init_A": 0.5}, {"column": "t_init_A", "double": None, "finer": 0.5}),
        ({"t_stop": None}, {"column": "t_stop", "double": 0.05, "finer": None}),
        (InputError("refused"), {"column": "failed", "finer": "InputError: refused"}),
    ],
)
def test_a_finer_arithmetic_contradicts(
    monkeypatch: pytest.MonkeyPatch, changes: Any, expected: dict[str, Any] | None
) -> None:
    right = running.fine_row_of

    def wrong(*given: Any) -> dict[str, Any]:
        if isinstance(changes, Exception):
            raise changes
        return {**right(*given), **changes}

    monkeypatch.setattr(running, "fine_row_of", wrong)
    check = tt.sweep(SCENE, STARTS[:1], recheck=1).attrs["summary"]["recheck"]
    assert check["contradictions"] == ([{"index": 0, **expected}] if expected else [])
    assert (check["differences"].get("min_g_n", 0) > 1e-3) == ("min_g_n" in str(changes))


def test_rows_that_continue_without_contact_are_compared_too() -> None:
    scene = load_scene("reference").varied(until="0.7")
    rows = tt.sweep(scene, tt.grid({"mu": "0.3,3"}), contact="bilateral", recheck=1)
    assert [force > 0 for force in rows["min_g_n"]] == [True, False]
    check = rows.attrs["summary"]["recheck"]
    assert (check["rows"], check["contradictions"]) == (2, [])
    assert check["differences"]["min_g_n"] < 1e-10


@pytest.mark.slow
def test_a_killed_cluster_worker_loses_and_doubles_nothing(tmp_path: Any) -> None:
    """A real scheduler and two worker processes over loopback TCP; one is killed in the middle."""
    distributed = pytest.importorskip("distributed", reason="needs the extra dask")
    scene = load_scene("reference")
    starts = tt.grid(None, {"phi_dot": "-1:1", "theta_dot": "-0.1:0.1"}, samples=2000, seed=1)
    killed: list[int] = []

    def progress(share: float) -> None:
        if not killed and share > 1 / 4:
            killed.append(cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster, dask_pool(cluster.scheduler_address) as pool:  # fmt: skip
        out = tmp_path / "rows"
        rows = tt.sweep(scene, starts, pool=pool, chunk=50, out=out, recheck=0, progress=progress)
    assert killed
    pandas.testing.assert_frame_equal(
        rows, tt.sweep(scene, starts, recheck=0, chunk=500), check_exact=True
    )
