"""The backend of motions in several segments, integrated one after another."""

from __future__ import annotations

from tt_precise.integration import multidouble_backend
from tt_precise.integration.equations import RIGID_CONTACT, Phase
from tt_precise.integration.setup import Setup
from tt_precise.integration.solution import Segment
from tt_precise.mechanics.formulations import Formulation
from tt_precise.nonsmooth.lifting import bouncing, flying, flying_on
from tt_precise.nonsmooth.phases import (
    DEEP_CONTACT,
    FAST_GLIDING,
    FLIGHT_PHASE,
    LINEAR_CONTACT,
    SegmentStart,
    elastic,
    raised,
    segment,
)
from tt_precise.nonsmooth.sticking import sticking_and_slipping
from tt_precise.runtime.terminal import Progress
from tt_precise.scene.scene import InitialState, Scene


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Refuse functions that sums of doubles lack."""
    return multidouble_backend.refuses(scene, setup) if setup.precision.doubles else None


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
    return flying_on([segment(setup, start, begin)], setup, start)
