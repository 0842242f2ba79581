"""heyoka's Taylor integrators in double, extended, quad and mp, for every scene."""

from __future__ import annotations

from tt_precise.integration.dense_output import DenseOutput, StoredPieces
from tt_precise.integration.propagate import propagate
from tt_precise.integration.run import Beginning
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


def run(begun: Beginning, setup: Setup, start: InitialState, progress: Progress | None) -> Run:
    """What becomes of ``start``, in one segment unless the scene may have several."""
    if begun.scene.in_pieces:
        from tt_precise.integration.hybrid import segments_of

        return Run(setup, start, segments_of(begun.scene, setup, start, progress))
    if setup.precision.name == "double":
        times = begun.samples
        samples = None if times is None else times.doubles.rounded[1:]
        propagation = propagate(setup, start, samples=samples, progress=progress)
        output = DenseOutput(setup, start, propagation, samples=times)
    else:
        # wider arithmetics take longer, so there the dense output is always stored at once
        stored = StoredPieces(setup)
        propagation = propagate(setup, start, dense=stored, progress=progress)
        output = DenseOutput(setup, start, propagation, stored.pieces)
    return Run(setup, start, [Segment(start.until * 0, output)])
