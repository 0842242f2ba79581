"""Tables are what they parse to, loaded numbers the printed ones; damage is not handed out."""

from typing import Any

import mpmath
import pandas
import pytest

import tt_precise as tt
from tests.golden.closed_form import closed_form
from tests.golden.conftest import Small
from tt_precise.check import conservation
from tt_precise.golden import load, store
from tt_precise.golden.loading import pose_columns
from tt_precise.golden.table import Table
from tt_precise.mechanics.pose import Pose
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene


def test_brings_events_and_manifest(small: Small) -> None:
    frame = tt.golden.load("reference", folder=small.folder)
    assert frame.manifest["digits"] == 34
    assert list(frame.events.columns[:3]) == ["name", "t", "direction"]
    assert frame.events["direction"].isin([-1, 1]).all()
    assert frame.events["t"].is_monotonic_increasing
    assert type(frame[["t", "theta"]]) is pandas.DataFrame


@pytest.mark.parametrize("numbers", ["float", "exact"])
def test_undefined_entries_are_missing(numbers: Any) -> None:
    frame = tt.golden.load("upright", numbers)
    assert frame["phi_dot"].isna().all()
    assert not frame["omega_3"].isna().any()


def test_unknown_scenes_and_kinds_are_refused(small: Small) -> None:
    with pytest.raises(InputError, match="expected one of: reference"):
        tt.golden.load("nowhere", folder=small.folder)
    with pytest.raises(InputError, match="expected one of: exact, float, text"):
        tt.golden.load("reference", "decimal", folder=small.folder)  # type: ignore[arg-type]


def shortened(name: str, rows: int) -> tuple[Scene, Table]:
    """The first rows only: the horizon decides how long it takes."""
    whole = store.read_files(name, None)
    table = Table(whole.trajectory.columns, whole.trajectory.rows[:rows])
    return whole.scene.varied(until=whole.scene.sample_every * (rows - 1)), table


@pytest.mark.slow  # compiling the quadratures in wide arithmetic takes most of it
def test_digits_of_the_pose() -> None:
    """34 digits at 0.04 s, against the published phi, psi, x and y of the scene that has them."""
    scene, table = shortened("track", 5)
    found = pose_columns(scene, table, in_full=True)
    assert set(found) == set(Pose._fields)
    mp = mpmath.MPContext()
    mp.dps = 50
    last = {name: mp.mpf(table.column(name)[-1]) for name in table.columns}
    half = mp.cos(last["theta"] / 2) * mp.cos((last["phi"] + last["psi"]) / 2)
    assert abs(mp.mpf(found["qw"][-1]) - half) < mp.mpf(10) ** -32
    for name in ("x", "y"):
        assert abs(mp.mpf(found[name][-1]) / last[name] - 1) < mp.mpf(10) ** -32
    assert abs(mp.mpf(found["wbz"][-1]) / last["omega_3"] - 1) < mp.mpf(10) ** -32
    assert len(found["qy"][-1].replace("-", "").split("e")[0]) >= 33


def test_the_pose_of_a_top_that_keeps_its_axis() -> None:
    """Zeros of the table are rounding in the run."""
    toss = load_scene("flight").varied(theta_dot="0", phi_dot="0", nu_y="0", until="0.02")
    known = closed_form(toss)
    assert known is not None
    rows = (("0" if "e-1" in cell[-5:] else cell for cell in row) for row in known.trajectory.rows)
    table = Table(known.trajectory.columns, tuple(map(tuple, rows)))
    assert {*map(float, table.column("ky"))} == {0.0}
    found = pose_columns(toss, table, in_full=False)
    assert abs(float(found["wbz"][-1]) / 150 - 1) < 1e-15


@pytest.mark.parametrize(("row", "cell"), [(2, "17 digits"), (0, "nan"), (2, "nan"), (0, "inf")])
def test_a_table_that_says_otherwise_is_refused(row: int, cell: str) -> None:
    scene, table = shortened("track", 3)
    columns = {name: list(table.column(name)) for name in table.columns}
    in_full = cell == "17 digits"
    columns["Lx"][row] = str(float(columns["Lx"][row])) if in_full else cell
    with pytest.raises(InputError, match="Lx of a run for the pose differs by"):
        pose_columns(scene, Table.of_columns(columns), in_full=in_full)


@pytest.mark.slow
def test_loaded_with_the_pose() -> None:
    frame = load("reference", pose=True)
    assert conservation(frame, "reference", digits=14, columns={}).passed
    columns = ["t", *Pose._fields]
    assert conservation(frame[columns], "reference", digits=12).passed
    with pytest.raises(InputError, match="phi or psi for a start at a pole"):
        load("upright", pose=True)
