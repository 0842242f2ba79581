"""Outcomes are statements about the state at the end."""

import math

import numpy

import tt_precise as tt
from tt_precise.scene.scene import load_scene
from tt_precise.sweeps.columns import outcomes

BODY = load_scene("reference").body.dimensionless(math, float)


def test_does_not_invert_is_said_only_of_what_never_will() -> None:
    """A later horizon changes what is undecided, and nothing else."""
    starts, record = tt.grid({"omega_3": "20:260:25"}), ("max_theta",)
    early, late = (
        tt.sweep(load_scene("reference").varied(until=until), starts, record=record, recheck=0)
        for until in ("1", "60")
    )
    pairs = {*zip(early["outcome"], late["outcome"], strict=True)}
    assert {("does_not_invert", "does_not_invert"), ("undecided", "inverts")} <= pairs
    assert ("does_not_invert", "inverts") not in pairs
    excluded = late["outcome"] == "does_not_invert"
    assert (late["max_theta"][excluded] < numpy.pi / 2).all()


def test_the_energy_decides_only_where_it_falls() -> None:
    z, lambda_ = numpy.array([0.9, 0.9, -0.9, -0.9]), numpy.full(4, 0.1)
    energy, crossed = numpy.array([0.8, 2.0, 2.0, 2.0]), numpy.array([False, False, True, False])
    for falling in (True, False):  # with g_n < 0 the energy may rise
        expected = ["does_not_invert" if falling else "undecided", "undecided", "inverts"]
        assert outcomes(BODY, z, lambda_, energy, crossed, falling)[:3] == expected
