"""The pose of golden data: as many digits, and refused where it contradicts what is published."""

import mpmath
import pytest

from tt_precise.check import conservation
from tt_precise.golden import load, store
from tt_precise.golden.pose import pose_columns
from tt_precise.golden.table import Table
from tt_precise.mechanics.pose import Pose
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Scene


def shortened(name: str, rows: int) -> tuple[Scene, Table]:
    """The first rows only: the horizon decides how long it takes."""
    whole = store.read(name, None)
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


def test_a_table_that_says_otherwise_is_refused() -> None:
    scene, table = shortened("track", 3)
    columns = {name: list(table.column(name)) for name in table.columns}
    columns["Lx"][-1] = str(float(columns["Lx"][-1]))  # 17 digits only
    spoiled = Table(table.columns, tuple(zip(*columns.values(), strict=True)))
    with pytest.raises(InputError, match="Lx of a run for the pose differs by"):
        pose_columns(scene, spoiled, in_full=True)


@pytest.mark.slow
def test_loaded_with_the_pose() -> None:
    frame = load("reference", pose=True)
    assert conservation(frame, "reference", digits=14, columns={}).passed
    columns = ["t", *Pose._fields]
    assert conservation(frame[columns], "reference", digits=12).passed
    with pytest.raises(InputError, match="phi or psi from a pole"):
        load("upright", pose=True)


@pytest.mark.parametrize("row", [0, 2])
@pytest.mark.parametrize("cell", ["nan", "inf"])
def test_what_is_no_number_is_refused(cell: str, row: int) -> None:
    scene, table = shortened("track", 3)
    columns = {name: list(table.column(name)) for name in table.columns}
    columns["Lx"][row] = cell
    spoiled = Table(table.columns, tuple(zip(*columns.values(), strict=True)))
    with pytest.raises(InputError, match="Lx of a run for the pose differs by"):
        pose_columns(scene, spoiled, in_full=False)
