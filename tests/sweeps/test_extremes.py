"""Extreme values along steps: no peak is missed."""

import numpy
import pytest

import tt_precise as tt
from tt_precise.sweeps.extremes import FINER, NODES, peak_bound


def test_a_ceiling_is_above_every_peak_between_the_nodes() -> None:
    fine = numpy.linspace(0, 1, 1001)
    for shift in numpy.linspace(-0.5, 1.5, 41):
        for nodes in (NODES, FINER):
            ceiling, largest = peak_bound(-((nodes - shift) ** 2)[:, None])
            assert largest[0] <= (-((fine - shift) ** 2)).max() <= ceiling[0] < numpy.inf
    # a peak far narrower than a step is not excluded, as phi_dot has them beside a pole
    for place in numpy.linspace(0.02, 0.98, 49):
        ceiling, _ = peak_bound(1 / (1e-4 + (FINER - place) ** 2)[:, None])
        assert ceiling[0] == numpy.inf


def test_the_spike_of_phi_dot_beside_the_pole_is_found() -> None:
    """Some 40 microseconds wide near 3.19 s on the reference scene, where steps take 5 ms."""
    rows = tt.sweep("reference", vary={"mu": "0.3"}, until="4", record="min_phi_dot", recheck=0)
    run = tt.integrate(tt.load_scene("reference").varied(until="4"), events=("extremum:phi_dot",))
    spike = run.event_table(("phi_dot",))["phi_dot"].min()
    assert spike < -1e3
    assert rows["min_phi_dot"][0] == pytest.approx(spike, rel=1e-9)
