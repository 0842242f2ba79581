"""Outcomes are statements about the state at the end."""

import math

import numpy
import pytest

import tt_precise as tt
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps import SweepSpec, spot_check
from tt_precise.sweeps.columns import outcomes

BODY = load_scene("reference").body.dimensionless(math, float)


def test_does_not_invert_is_said_only_of_what_never_will() -> None:
    """A later horizon changes what is undecided, and nothing else."""
    spins = {"omega_3": "20:260:25"}
    early, late = (
        tt.sweep("reference", vary=spins, until=until, record=("max_theta", "end_theta"), recheck=0)
        for until in ("1", "60")
    )
    pairs = set(zip(early["outcome"], late["outcome"], strict=True))
    assert {("does_not_invert", "does_not_invert"), ("undecided", "inverts")} <= pairs
    assert not {later for first, later in pairs if first == "does_not_invert"} - {"does_not_invert"}
    held = late["outcome"] == "does_not_invert"
    assert (late["max_theta"][held] < numpy.pi / 2).all()
    # a top that is inverted inverts, whatever the definitions say of its climb
    slow = late[late["omega_3"] == 80]
    assert slow["end_theta"].item() > 3.14
    assert slow["outcome"].item() == "inverts"


def test_the_energy_decides_only_where_it_falls() -> None:
    z, lambda_ = numpy.array([0.9, 0.9, -0.9, -0.9]), numpy.full(4, 0.1)
    energy = numpy.array([0.8, 2.0, 2.0, 2.0])
    crossed = numpy.array([False, False, True, False])
    found = outcomes(BODY, z, lambda_, energy, crossed)
    assert found == ["does_not_invert", "undecided", "inverts", "undecided"]
    # with g_n < 0 the energy may rise
    assert outcomes(BODY, z, lambda_, energy, crossed, falling=False)[0] == "undecided"


@pytest.mark.slow
def test_the_spot_check_ends_beside_the_pole_too() -> None:
    scene = SweepSpec.of("reference", until="120").scene.varied(omega_3="80")
    assert spot_check.recomputed(scene, ())["outcome"] == "inverts"


@pytest.mark.parametrize(
    ("changes", "ended"),
    [
        ({"nu_x": "1000", "mu": "100"}, "singular_contact"),
        ({"theta": "3", "theta_dot": "400"}, "contact_lost"),
    ],
)
def test_the_spot_check_tells_how_a_start_ends(changes: dict[str, str], ended: str) -> None:
    scene = load_scene("reference").varied(**changes)
    found = spot_check.recomputed(scene, ())
    assert found.pop("min_g_n") < 0
    assert found == {"outcome": ended, "t_stop": 0.0}


def test_what_overflows_fails_alone_and_warns_nobody(recwarn: pytest.WarningsRecorder) -> None:
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
