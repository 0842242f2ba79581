"""Initiation and ending time of the climb, in the definitions A, B and C."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mpmath
import pytest

from tests.conftest import more
from tt_precise.integration import Trajectory, integrate, inversion
from tt_precise.scene.scene import Scene, load_scene

NONE = inversion.Climb(None, None)

MINIMA = [(1, 0.1, -0.5), (3, 0.2, 0.5), (5, 0.1, -0.5), (7, 0.3, 0.5), (11, 1.5, 0.5)]
MAXIMA = [(2, 0.4, -0.5), (10.5, 1.6, -0.5)]
MAXIMA += [(13, math.pi - 0.3, 0.5), (15, math.pi - 0.1, -0.5), (17, math.pi - 0.2, 0.5)]
FORWARD = [turn for turn in MINIMA if turn[2] > 0]


def turns(rows: Sequence[tuple[float, float, float]]) -> inversion.TurningPoints:
    return inversion.TurningPoints(*zip(*rows, strict=True))


# A climb with everything on either side: theta reaches pi/2 at t = 10.
MARKS = inversion.InversionEvents(
    equator=[10, 12], minima=turns(MINIMA), maxima=turns(MAXIMA), aligned=[1, 6.5],
    opposed=[3, 14.5, 18], phi_dot_zero=[2, 4, 6, 14, 16],
)  # fmt: skip
LATER = [*MINIMA[:3], (7, 0.3, -0.5), (9, 0.1, 0.5), MINIMA[4]]


@pytest.mark.parametrize(
    ("changes", "when", "expected"),
    [
        # A: from b = -0.1 at 5 to b = 0.3 at 7; from b = 0.3 at 13 to b = -0.1 at 15
        ({}, "t_init", (5.5, 6.5, 6)),
        ({}, "t_end", (14.5, 14.5, 14)),
        ({}, "duration", (9, 8, 8)),
        # a later negative perigee; only those above the equator are counted
        ({"minima": turns(LATER)}, "t_init", (8.5, 6.5, 6)),
        ({"minima": turns([(-1, 2.0, -0.5), *FORWARD])}, "t_init", (0, 6.5, 6)),
        # backwards precession: no times by definition C
        ({"backwards": True}, "t_init", (5.5, 6.5, None)),
        # no climb, one under way from the start, and one that ends behind the horizon
        ({"equator": []}, "duration", (None, None, None)),
        ({"minima": turns(FORWARD), "aligned": [], "phi_dot_zero": [14, 16]}, "t_init", (0, 0, 0)),
        (
            {"maxima": turns(MAXIMA[:3]), "opposed": [3], "phi_dot_zero": [2, 4, 6]},
            "t_end",
            (None, None, None),
        ),
    ],
)
def test_the_definitions_on_climbs_made_by_hand(
    changes: dict[str, Any], when: str, expected: tuple[Any, ...]
) -> None:
    times = inversion.from_inversion_events(replace(MARKS, **changes), math.pi)
    climbs = [getattr(climb, when) for climb in (times.A, times.B, times.C)]
    assert climbs == [t and pytest.approx(t, rel=1e-15) for t in expected]
    assert times.equator == (None if "equator" in changes else 10)


def all_times(run: Trajectory) -> list[Any]:
    """Return the times at the equator, and of A, B and C."""
    return [run.inversion.equator, *run.inversion.times.values()]


def test_the_initiation_time_is_the_one_computed_with_200_bits(fine: Trajectory) -> None:
    """The scene that restarts there has it, from runs with 200 and 224 bits."""
    printed = load_scene("from-initiation").source.split("t = ")[1].split(" s;")[0]
    distance = abs(fine.inversion.A.t_init - fine.precision.context.mpf(printed))
    assert 0 < distance < 1e-30  # s


def test_the_definitions_differ_by_less_than_a_tenth_of_a_second(
    double: Trajectory, fine: Trajectory
) -> None:
    equator, *times = all_times(double)
    inits, ends = times[::2], times[1::2]
    assert len({*inits, *ends}) == 6
    assert max(inits) - min(inits) < 0.1 > max(ends) - min(ends)
    assert max(inits) < equator < min(ends)
    # C literally: phi_dot > 0 between, and not just outside
    first, last = times[-2:]
    inside = double.frame("phi_dot", times=[first + 1e-6, (first + last) / 2, last - 1e-6])
    outside = double.frame("phi_dot", times=[first - 1e-6, last + 1e-6])
    assert (inside["phi_dot"] > 0).all()
    assert (outside["phi_dot"] < 0).all()
    for time, exact in zip(all_times(double), all_times(fine), strict=True):
        assert abs(mpmath.mpf(time) - exact) < 1e-12  # s; the bar


def test_the_mirror_image_has_the_same_times(double: Trajectory, reference: Scene) -> None:
    mirrored = integrate(reference.varied(omega_3="-155"), events=double.setup.events)
    assert mirrored.state.theta == pytest.approx(double.state.theta, rel=1e-13)
    assert all_times(mirrored) == pytest.approx(all_times(double), rel=1e-12)


@pytest.mark.parametrize("way", [1, -1])
def test_a_climb_that_precesses_backwards_has_no_times_in_definition_c(
    reference: Scene, way: int
) -> None:
    start = {"theta": "1.5", "theta_dot": "8", "phi_dot": f"{-2 * way}", "omega_3": f"{-30 * way}"}
    times = integrate(reference.varied(**start, until="1/60")).inversion
    assert times.equator > 0
    assert (times.B.t_init, times.C) == (0, NONE)


def test_the_second_integration_is_of_the_same_setup(reference: Scene) -> None:
    """With g_n < 0 on the way; unilateral the top would leave the table first."""
    scene = reference.varied(phi_dot="-30", until="12")
    setup: Any = {"contact": "bilateral", "tolerance": 1e-13}
    at_once = integrate(scene, events=inversion.NEEDED, **setup)
    climb = at_once.inversion.A
    assert [climb.t_init, climb.t_end] == pytest.approx([1.486, 5.834], abs=1e-3)
    assert integrate(scene, **setup).inversion == at_once.inversion


@pytest.mark.parametrize("chosen", [{}, {"digits": 20}])
def test_a_passage_of_the_pole_has_no_direction(chosen: dict[str, Any]) -> None:
    """A top that rocks in a plane has no phi_dot where theta is 0, and does not climb."""
    assert set(all_times(integrate("rocking", **chosen))) == {None}


@pytest.mark.parametrize(
    ("options", "largest"),
    [({}, 1e-10), ({"digits": 6}, 1e-4), ({"digits": 12}, 1e-12), more({"digits": 20}, 1e-20)],
)
def test_the_times_of_the_climb_have_their_errors(
    options: dict[str, Any], largest: float, fine: Trajectory
) -> None:
    run = integrate("reference", **options)
    names, errors = ["equator", *run.inversion.times], run.inversion_errors
    assert list(errors) == names
    for name, time, exact in zip(names, all_times(run), all_times(fine), strict=True):
        # in double a time is stored with half a unit in its last place
        allowed = 1.5 * errors[name] + (1e-15 if run.precision.is_float else 0)
        assert abs(time - exact) <= allowed, name
        assert errors[name] < largest, name
