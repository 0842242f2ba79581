"""Outcomes are statements about the state at the end."""

import math

import numpy

import tt_precise as tt
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps.columns import neighbours, outcomes

BODY = load_scene("reference").body.dimensionless(math, float)


def test_does_not_invert_is_said_only_of_what_never_will() -> None:
    """A later horizon changes what is undecided, and nothing else."""
    starts, record = tt.grid({"omega_3": "20:260:25"}), ("max_theta", "end_theta")
    early, late = (
        tt.sweep(load_scene("reference").varied(until=until), starts, record=record, recheck=0)
        for until in ("1", "60")
    )
    pairs = {*zip(early["outcome"], late["outcome"], strict=True)}
    assert {("does_not_invert", "does_not_invert"), ("undecided", "inverts")} <= pairs
    assert not {later for first, later in pairs if first == "does_not_invert"} - {"does_not_invert"}
    excluded = late["outcome"] == "does_not_invert"
    assert (late["max_theta"][excluded] < numpy.pi / 2).all()
    # a top that is inverted inverts, whatever the definitions say of its climb
    slow = late[late["omega_3"] == 80]
    assert slow["end_theta"].item() > 3.14
    assert slow["outcome"].item() == "inverts"


def test_the_energy_decides_only_where_it_falls() -> None:
    z, lambda_ = numpy.array([0.9, 0.9, -0.9, -0.9]), numpy.full(4, 0.1)
    energy = numpy.array([0.8, 2.0, 2.0, 2.0])
    crossed = numpy.array([False, False, True, False])
    expected = ["does_not_invert", "undecided", "inverts", "undecided"]
    assert outcomes(BODY, z, lambda_, energy, crossed) == expected
    # with g_n < 0 the energy may rise
    assert outcomes(BODY, z, lambda_, energy, crossed, falling=False)[0] == "undecided"


def test_crossings_next_to_the_climb() -> None:
    crossings = [(1.0, True), (2.0, False), (3.0, True), (5.0, True), (6.0, False), (7.0, False)]
    assert neighbours(crossings, 4.0) == (3.0, 6.0)
    assert neighbours(crossings, 0.5) == (None, 2.0)
    assert neighbours(crossings, None) == (None, None)
