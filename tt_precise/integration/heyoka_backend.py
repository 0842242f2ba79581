"""heyoka's Taylor integrators in double, extended, quad and mp, for every scene."""

from __future__ import annotations

from tt_precise.integration.dense_output import DenseOutput, SampleTimes, StoredPieces
from tt_precise.integration.propagate import propagate
from tt_precise.integration.segments import Run, Segment
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.progress import Progress
from tt_precise.scene.scene import Scene


def refuses(scene: Scene, setup: Setup) -> str | None:
    """Numbers that heyoka does not have."""
    if setup.precision.doubles:
        return f"{scene.name}: got {setup.precision.name}, expected one of heyoka's precisions"
    return None


def run(
    scene: Scene,
    setup: Setup,
    start: InitialState,
    samples: SampleTimes | None,
    progress: Progress | None,
) -> Run:
    """What becomes of ``start``, in one segment unless the scene may have several."""
    if scene.in_pieces:
        from tt_precise.integration.hybrid import segments_of

        return Run(setup, start, segments_of(scene, setup, start, progress))
    if setup.precision.name == "double":
        taken = None if samples is None else samples.doubles.rounded[1:]
        propagation = propagate(setup, start, samples=taken, progress=progress)
        output = DenseOutput(setup, start, propagation, samples=samples)
    else:
        # wider arithmetics take longer, so there the dense output is always stored at once
        stored = StoredPieces(setup)
        propagation = propagate(setup, start, dense=stored, progress=progress)
        output = DenseOutput(setup, start, propagation, stored.pieces)
    return Run(setup, start, [Segment(start.until * 0, output)])
