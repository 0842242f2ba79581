"""The backend of motions in several segments, which heyoka integrates one after another."""

from __future__ import annotations

from tt_precise.integration.dense_output import SampleTimes, Segment
from tt_precise.integration.equations import RIGID_CONTACT, Phase
from tt_precise.integration.setup import Setup, refused_in_doubles
from tt_precise.mechanics.formulations import Formulation
from tt_precise.nonsmooth.lifting import bouncing, flying, flying_on
from tt_precise.nonsmooth.phases import (
    DEEP_CONTACT,
    FAST_GLIDING,
    FLIGHT_PHASE,
    LINEAR_CONTACT,
    elastic,
    raised,
)
from tt_precise.nonsmooth.segments import SegmentStart, propagated
from tt_precise.nonsmooth.sticking import sticking_and_slipping
from tt_precise.runtime.terminal import Progress
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse numbers that heyoka, which integrates the segments, does not have."""
    if not setup.precision.doubles:
        return None
    why = refused_in_doubles(scene)
    return (
        f"{scene.name}: got {setup.precision.name}, expected double, extended, quad or mp for {why}"
    )


def first(scene: Scene, form: Formulation) -> tuple[Formulation, Phase]:
    """Return the equations at the start of a scene; ``form`` are those of its model."""
    spring = scene.body.spring
    if scene.model == "flight":
        return raised(), FLIGHT_PHASE
    if spring:
        on_table = elastic(spring, scene.body.friction)
        return on_table, LINEAR_CONTACT if spring == "linear" else DEEP_CONTACT
    return form, FAST_GLIDING if scene.may_stick else RIGID_CONTACT


def run(
    scene: Scene,
    setup: Setup,
    start: InitialState,
    samples: SampleTimes | None,
    progress: Progress | None,
) -> list[Segment]:
    """Return the run from ``start``, segment by segment."""
    if scene.body.spring:
        return bouncing(scene.name, setup, start, progress)
    if scene.may_stick:
        segments = sticking_and_slipping(scene.name, setup, start, progress)
        return flying_on(segments, setup, start) if scene.flies else segments
    begin = start.until * 0
    if scene.model == "flight":
        return [flying(setup, SegmentStart.of_run(setup, start), begin)]
    return flying_on([Segment(begin, propagated(setup, start))], setup, start)
