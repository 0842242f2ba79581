"""Digits asked for, on shipped scenes: delivered at every golden row, and by which setting."""

import pytest

from benchmarks.settings_table import right_digits
from tt_precise.integration import integrate
from tt_precise.integration.precision import DOUBLES
from tt_precise.scene.scene import load_scene, shipped


def test_a_flight_that_ends_on_the_table_has_digits() -> None:
    """The height there is zero: its error counts beside R."""
    run = integrate("coulomb-flight", digits=9)
    assert (run.status, run.precision.name) == ("landed", "double")
    assert run.digits_throughout >= 9
    assert right_digits(run) >= 9
    # negative control
    run.error_estimate["height"] = 1e-8 * run.start.units.length
    assert run.digits < 9


@pytest.mark.slow
@pytest.mark.parametrize("wanted", [3, 6, 9, 12, 14, 15])
@pytest.mark.parametrize("name", shipped())
def test_every_scene_delivers(name: str, wanted: int) -> None:
    run = integrate(name, digits=wanted)
    assert run.digits_throughout >= wanted
    assert right_digits(run) >= wanted
    assert run.digits_throughout - right_digits(run) < 1
    # what several doubles cannot do is done by the next of heyoka's arithmetics, not by mp
    heyokas = {"double", "extended", "quad"}
    assert run.precision.name in (heyokas if load_scene(name).in_pieces else heyokas | {*DOUBLES})
