"""Events of golden scenes: the golden ones in every arithmetic, and those that heyoka detects."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from tests.conftest import more
from tt_precise import golden
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.equations import Equations
from tt_precise.integration.events import EVENTS, JOINING, TERMINAL
from tt_precise.runtime.process import import_heyoka
from tt_precise.scene.scene import load_scene, shipped

# s, of the time of an event: roundings, which decaying velocities magnify in below-threshold
REACH = {"double": 1e-12, "double-double": 0, "triple-double": 0, "quad": 0}
QUICK = ("contact-lost", "rocking", "stays-upright")
SCENES = [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in shipped()]
Times = dict[str, list[float]]


def times_of(events: Any) -> Times:
    """Times by name, but for the events that switch a motion."""
    events = events[~events["name"].isin([*JOINING, *TERMINAL])]
    return {str(kind): [*map(float, rows["t"])] for kind, rows in events.groupby("name")}


def golden_events(name: str) -> Times:
    return times_of(golden.load(name, "text").events)


def assert_golden(run: Trajectory, expected: Times) -> None:
    found = times_of(run.events)
    assert {*found} == {*expected}
    reach = 1e-9 if run.scene.name == "below-threshold" else REACH[run.precision.name]
    for kind, times in expected.items():
        # the golden times as doubles are half an ulp off
        assert found[kind] == pytest.approx(times, rel=4e-16, abs=reach), kind
    assert run.unresolved == ()


@pytest.mark.parametrize("precision", [more(one) if one == "quad" else one for one in REACH])
@pytest.mark.parametrize("name", SCENES)
def test_all_events_are_the_golden_ones(name: str, precision: str) -> None:
    expected = golden_events(name)
    assert_golden(integrate(name, precision, events=tuple(expected) or "theta_max"), expected)


def test_those_of_the_reference_scene_and_a_lost_one_is_noticed(double: Trajectory) -> None:
    expected = golden_events("reference")
    assert_golden(double, expected)
    lost = {kind: times[1:] for kind, times in expected.items()}
    with pytest.raises(AssertionError):
        assert_golden(double, expected | {"nu_y_zero": lost["nu_y_zero"]})


def detected(name: str, kinds: tuple[str, ...]) -> Counter[str]:
    """Return how often heyoka detects each event, after a first step that hides no other zero."""
    heyoka, run = import_heyoka(), integrate(name, events=())
    equations = Equations.of(run.setup.formulation)
    counts: Counter[str] = Counter()

    def noted(kind: str) -> Any:
        def callback(adaptive: Any, time: float, sign: int) -> None:
            counts[kind] += sign != 0

        direction = {0: "any", 1: "positive", -1: "negative"}[EVENTS[kind].direction]
        return heyoka.nt_event(
            EVENTS[kind].function(equations.motion), callback,
            direction=getattr(heyoka.event_direction, direction),
        )  # fmt: skip

    adaptive = heyoka.taylor_adaptive(
        equations.system, [0.0] * len(equations.variables),
        pars=[1.0] * len(run.setup.formulation.parameters),
        nt_events=[noted(kind) for kind in kinds], compact_mode=True,
    )  # fmt: skip
    adaptive.state[:] = [float(x) for x in run.start.first_row(run.setup.formulation, ())]
    adaptive.pars[:] = [float(x) for x in run.start.parameters(run.setup.formulation)]
    adaptive.propagate_until(2.0**-20)
    counts.clear()
    adaptive.propagate_until(float(run.run.end_time))
    return counts


@pytest.mark.parametrize("name", SCENES)
def test_heyoka_detects_as_many(name: str) -> None:
    """An independent finder, whose tangencies are those that the criterion names."""
    if load_scene(name).in_pieces or name in ("flight", "upright", "inverted"):
        pytest.skip("heyoka alone has one set of equations, and misses what is always zero")
    kinds = tuple(golden_events(name))
    run = integrate(name, events=kinds)
    witness = detected(name, kinds)
    for kind in kinds:
        if kind not in run.touches:
            assert witness[kind] == run.event_counts[kind], kind


def test_noise_of_a_component_that_cancels_is_no_event() -> None:
    """A free top that spins about its axis: theta's rate is 0, a sum of terms that cancel."""
    still = dict.fromkeys(("theta_dot", "phi_dot", "nu_x", "nu_y"), "0")
    body = {"alpha": "0.2736", "I1": "0.5762", "I3": "0.4953", "g": "9.8"}
    scene = load_scene("flight").varied(theta="1.0008", omega_3="191.2162", **still, **body)
    for precision in ("double", "double-double"):
        run = integrate(scene, precision, events=("theta_min", "theta_max"))
        assert run.event_counts["theta_min"] == run.event_counts["theta_max"] == 0
        assert set(run.touches) == {"theta_min", "theta_max"}
