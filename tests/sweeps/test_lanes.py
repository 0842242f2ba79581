"""Lanes: a trajectory does not depend on the others beside it."""

import pytest

import tt_precise as tt


def test_a_row_that_overflows_fails_alone_without_a_warning(
    recwarn: pytest.WarningsRecorder,
) -> None:
    """In the middle of nine rows, where its lane goes on with another row."""
    others = [1e12, *range(150, 157)]
    found, alone = (
        tt.sweep("reference", vary={"omega_3": spins}, until="0.1", recheck=0)
        for spins in ([*others[:4], 1e150, *others[4:]], others)
    )
    assert list(found["outcome"]) == [
        "contact_lost",
        *["undecided"] * 3,
        "failed",
        *["undecided"] * 4,
    ]
    rows = found.drop(index=4).drop(columns="index").reset_index(drop=True)
    assert rows.equals(alone.drop(columns="index"))
    assert found["t_stop"][4] == 0
    assert not recwarn.list


def test_a_top_that_rolls_with_any_force_can_be_swept() -> None:
    """It has no terminal event at all."""
    rows = tt.sweep("rolling", vary={"theta_dot": "0,1"}, until="2", contact="bilateral", recheck=0)
    alone = tt.sweep("rolling", vary={"theta_dot": "0,1"}, until="2", recheck=0)
    assert list(rows["t_stop"]) == [2, 2]
    assert rows["min_g_n"].to_numpy() == pytest.approx(alone["min_g_n"], rel=1e-12)
