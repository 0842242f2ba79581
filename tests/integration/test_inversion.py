"""Initiation and ending time of the climb, in the definitions A, B and C."""

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.inversion import NEEDED, Climb, Marks, Turns, from_marks
from tt_precise.scene.scene import Scene, load_scene

NONE = Climb(None, None)

MINIMA = [(1, 0.1, -5), (3, 0.2, 5), (5, 0.1, -5), (7, 0.3, 5), (11, 1.5, 5)]
MAXIMA = [
    (2, 0.4, -5),
    (10.5, 1.6, -5),
    (13, math.pi - 0.3, 5),
    (15, math.pi - 0.1, -5),
    (17, math.pi - 0.2, 5),
]


def turns(rows: Sequence[tuple[float, float, float]]) -> Turns:
    return Turns(*zip(*rows, strict=True))


# A climb with everything on either side: theta reaches pi/2 at t = 10.
MARKS = Marks(
    equator=[10, 12],
    minima=turns(MINIMA),
    maxima=turns(MAXIMA),
    phi_dot_zero=[2, 4, 6, 14, 16],
    aligned=[1, 6.5],
    opposed=[3, 14.5, 18],
)


def test_the_definitions_on_a_climb_made_by_hand() -> None:
    found = from_marks(MARKS, math.pi)
    assert found.equator == 10
    # A: from b = -0.1 at 5 to b = 0.3 at 7; from b = 0.3 at 13 to b = -0.1 at 15
    assert found.A.t_init == pytest.approx(5.5, rel=1e-15)
    assert found.A.t_end == pytest.approx(14.5, rel=1e-15)
    assert (found.B.t_init, found.B.t_end) == (6.5, 14.5)
    assert (found.C.t_init, found.C.t_end) == (6, 14)
    assert found.C.duration == 8


def test_a_later_negative_perigee_moves_definition_a() -> None:
    turned = [*MINIMA[:3], (7, 0.3, -5), (9, 0.1, 5), MINIMA[4]]
    found = from_marks(replace(MARKS, minima=turns(turned)), math.pi)
    assert found.A.t_init == pytest.approx(8.5, rel=1e-15)


def test_a_climb_that_precesses_backwards_has_no_times_in_definition_c() -> None:
    found = from_marks(replace(MARKS, backwards=True), math.pi)
    assert found.C == NONE
    assert (found.B.t_init, found.B.t_end) == (6.5, 14.5)


def test_no_climb_has_no_times() -> None:
    found = from_marks(replace(MARKS, equator=[]), math.pi)
    assert (found.equator, found.A, found.B, found.C) == (None, NONE, NONE, NONE)
    assert found.A.duration is None


def test_a_climb_under_way_from_the_start_begins_at_zero() -> None:
    forward = turns([turn for turn in MINIMA if turn[2] > 0])
    found = from_marks(replace(MARKS, minima=forward, aligned=[], phi_dot_zero=[14, 16]), math.pi)
    assert (found.A.t_init, found.B.t_init, found.C.t_init) == (0, 0, 0)


def test_an_end_behind_the_horizon_is_none() -> None:
    found = from_marks(
        replace(MARKS, maxima=turns(MAXIMA[:3]), opposed=[3], phi_dot_zero=[2, 4, 6]), math.pi
    )
    assert (found.A.t_end, found.B.t_end, found.C.t_end) == (None, None, None)


def test_double_and_quad_agree(double: Trajectory, quad: Trajectory) -> None:
    rough, fine = double.inversion, quad.inversion
    for definition in "ABC":
        for when in ("t_init", "t_end"):
            seconds = getattr(getattr(rough, definition), when)
            apart = abs(mpmath.mpf(seconds) - getattr(getattr(fine, definition), when))
            assert apart < 1e-12, (definition, when)  # s; the bar
    assert abs(mpmath.mpf(rough.equator) - fine.equator) < 1e-12


def test_the_initiation_time_is_the_one_computed_with_200_bits(quad: Trajectory) -> None:
    """The scene that restarts there carries it, from runs with 200 and 224 bits."""
    source = load_scene("from-initiation").source
    printed = source.split("t = ")[1].split(" s;")[0]
    apart = abs(quad.inversion.A.t_init - quad.precision.context.mpf(printed))
    assert apart < 1e-30  # s; quad carries 1e-33 there, grown by the sensitivity to the start
    assert apart > 0


def test_definitions_differ_but_tell_of_one_climb(double: Trajectory) -> None:
    times = double.inversion
    inits = [climb.t_init for climb in (times.A, times.B, times.C)]
    ends = [climb.t_end for climb in (times.A, times.B, times.C)]
    assert len({*inits, *ends}) == 6
    assert max(inits) - min(inits) < 0.1
    assert max(ends) - min(ends) < 0.1
    assert max(inits) < times.equator < min(ends)
    # C literally: phi_dot > 0 between, and not just outside
    first, last = times.C.t_init, times.C.t_end
    inside = double.frame("phi_dot", times=[first + 1e-6, (first + last) / 2, last - 1e-6])
    outside = double.frame("phi_dot", times=[first - 1e-6, last + 1e-6])
    assert (inside["phi_dot"] > 0).all()
    assert (outside["phi_dot"] < 0).all()


def test_the_mirror_image_has_the_same_times(double: Trajectory, reference: Scene) -> None:
    start = replace(reference.start, omega_3=-reference.start.omega_3)
    mirrored = integrate(replace(reference, start=start), events=double.setup.events)
    assert mirrored.state.theta == pytest.approx(double.state.theta, rel=1e-13)
    for definition in "ABC":
        times, others = (getattr(t.inversion, definition) for t in (double, mirrored))
        assert others.t_init == pytest.approx(times.t_init, rel=1e-12)
        assert others.t_end == pytest.approx(times.t_end, rel=1e-12)


def test_missing_events_are_integrated_for(reference: Scene, double: Trajectory) -> None:
    plain = integrate(reference, "extended")
    assert plain.events.empty
    assert float(plain.inversion.equator) == pytest.approx(double.inversion.equator, rel=1e-14)


def test_a_horizon_before_the_climb(reference: Scene, double: Trajectory) -> None:
    short = integrate(replace(reference, until=Fraction(5)), events=double.setup.events)
    assert short.inversion.equator is None
    assert short.inversion.A == NONE


def test_the_second_integration_is_of_the_same_setup(reference: Scene) -> None:
    """With g_n < 0 on the way, as asked for; unilateral the top would leave the table first."""
    scene = reference.varied(phi_dot="-30", until="12")
    setup: Any = {"contact": "bilateral", "tolerance": 1e-13}
    at_once = integrate(scene, events=NEEDED, **setup)
    assert at_once.inversion.A.t_init == pytest.approx(1.486, abs=1e-3)
    assert at_once.inversion.A.t_end == pytest.approx(5.834, abs=1e-3)
    assert integrate(scene, **setup).inversion == at_once.inversion


def test_minima_above_the_equator_are_no_perigees() -> None:
    """A top that starts beyond pi/2 and first comes down to it."""
    before = [(-1, 2.0, -5), *(turn for turn in MINIMA if turn[2] > 0)]
    found = from_marks(replace(MARKS, minima=turns(before)), math.pi)
    assert found.A.t_init == 0
