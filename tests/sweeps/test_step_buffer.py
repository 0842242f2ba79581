"""What is read off the steps of a row: as the scalar integration finds it, and only once."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.integration.idle import Idle
from tt_precise.scene.scene import Inclination, load_scene
from tt_precise.sweeps import lanes, specification, step_buffer
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.columns import detectors
from tt_precise.sweeps.lanes import Build, LaneResults
from tt_precise.sweeps.samples import blocks
from tt_precise.sweeps.steps_again import LaneStart

CLOSE = 1e-12  # dimensionless, of up to 180


def integrated(scene: Any, record: tuple[str, ...] = (), bodies: int = 1) -> LaneResults:
    from tt_precise.integration.precision import precision_named
    from tt_precise.mechanics.formulations import integrated
    from tt_precise.mechanics.initial_state import InitialState

    form = integrated(scene.model, "newton")
    begun = InitialState.of(scene, precision_named("double").arithmetic)
    state = tuple(float(one) for one in form.start(begun.body, begun.vectors, begun.euler))
    parameters = tuple(float(getattr(begun.body, name)) for name in form.parameters)
    start = LaneStart(state, parameters, float(begun.until))
    build = Build(scene.model, "unilateral", detectors(record, scene.model), 8)
    with lanes.lanes(build) as lent:
        return lent.integrate([start] * bodies)


def turns(found: LaneResults, row: int, rising: bool) -> Any:
    events = found.events
    mine = (events.row == row) & (events.detector == 0)
    return events.time[mine & ((events.direction > 0) == rising)]


@pytest.mark.parametrize("name", ["reference", "rolling", "frictionless"])
def test_turning_points_are_those_of_the_scalar_integration(name: str) -> None:
    scene = replace(load_scene(name), until=load_scene("reference").until / 4)
    found = integrated(scene, record=("max_theta",), bodies=3)
    run = tt.integrate(scene, events=("theta_min", "theta_max"))
    unit = run.start.units.time
    for rising, event in ((False, "theta_min"), (True, "theta_max")):
        expected = run.events["t"][run.events["name"] == event].to_numpy(float) / unit
        for row in range(3):
            mine = turns(found, row, rising)
            assert mine[mine > 1e-6] == pytest.approx(expected[expected > 1e-6], rel=0, abs=CLOSE)
        assert len(expected) > 10


def test_only_those_that_the_climb_depends_on_unless_all_are_asked_for() -> None:
    scene = load_scene("reference")
    every, some = integrated(scene, record=("max_theta",)), integrated(scene)
    names = [one.event.name for one in detectors((), scene.model)]
    equator = every.events.detector == names.index("equator")
    climb = every.events.time[equator][0]
    for rising in (False, True):
        all_of_them = turns(every, 0, rising)
        wanted = all_of_them[all_of_them > climb] if rising else all_of_them[all_of_them < climb]
        assert numpy.array_equal(turns(some, 0, rising), wanted)
        assert len(wanted) < len(all_of_them)


def test_rows_do_not_depend_on_when_the_steps_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    """A buffer that is full every few steps: turning points on its edges are found once."""
    spec = specification("reference", until="1", vary={"phi_dot": "-20:20:11"})
    ((_, values),) = blocks(spec, 4096, set())
    expected = compute(spec.plan, values, 8)
    monkeypatch.setattr(lanes, "STEPS_BETWEEN", 1)
    for room in (1, 2, 7):
        monkeypatch.setattr(step_buffer, "ROOM", room)
        monkeypatch.setattr(lanes, "ROOM", room)
        monkeypatch.setattr(lanes, "_idle", Idle(lanes.Lanes))
        found = compute(spec.plan, values, 8)
        for name, column in expected.items():
            if name == "outcome":
                assert found[name] == column
            else:
                assert numpy.array_equal(found[name], column, equal_nan=True), (room, name)


def test_a_log_does_not_remember_the_flights_before() -> None:
    """theta_dot of the start decides the sign in the first step; lanes are used again."""
    scene = load_scene("reference")
    for theta_dot in ("-3", "3", "-3"):
        start = replace(scene.start, theta_dot=Fraction(theta_dot))
        one = replace(scene, start=start, until=scene.until / 32)
        found = integrated(one, record=("max_theta",))
        run = tt.integrate(one, events=("theta_min", "theta_max"))
        assert len(turns(found, 0, True)) + len(turns(found, 0, False)) == len(run.events)


def test_a_start_on_the_equator_keeps_all_turning_points() -> None:
    """Whether its crossing of pi/2 counts is decided later, when all turning points are there."""
    scene = load_scene("reference")
    at_equator = Inclination.parse("1.5707963267948966")  # pi/2 in double
    start = replace(scene.start, theta=at_equator, theta_dot=Fraction(1))
    one = replace(scene, start=start, until=scene.until / 4)
    every, some = integrated(one, record=("max_theta",)), integrated(one)
    for rising in (False, True):
        assert numpy.array_equal(turns(every, 0, rising), turns(some, 0, rising))


def test_each_bound_between_steps_has_one_sign(monkeypatch: pytest.MonkeyPatch) -> None:
    """Even if it were a wrong one, minima and maxima would take turns."""
    draws = numpy.random.default_rng(1)
    true_rates = step_buffer.height_rates

    def wrong(*given: Any) -> Any:
        found = true_rates(*given)
        return found * draws.choice([-1, 1], size=len(found))

    monkeypatch.setattr(lanes, "_idle", Idle(lanes.Lanes))
    monkeypatch.setattr(lanes, "STEPS_BETWEEN", 1)
    monkeypatch.setattr(step_buffer, "ROOM", 1)
    monkeypatch.setattr(lanes, "ROOM", 1)
    monkeypatch.setattr(step_buffer, "height_rates", wrong)
    scene = replace(load_scene("reference"), until=load_scene("reference").until / 16)
    found = integrated(scene, record=("max_theta",)).events
    directions = found.direction[found.detector == 0]
    assert len(directions) > 20
    assert (directions[1:] == -directions[:-1]).all()
