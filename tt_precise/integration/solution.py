"""``solve``: a scene integrated once, as a set-up says."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

from tt_precise.integration.contact import require_contact
from tt_precise.integration.continuing import propagated
from tt_precise.integration.dense_output import DenseOutput, StoredPieces
from tt_precise.integration.in_doubles import propagate_in_doubles
from tt_precise.integration.lifting import bouncing, flying, flying_on
from tt_precise.integration.pieces import MotionPiece, joined
from tt_precise.integration.precision import Precision, refused_in_doubles
from tt_precise.integration.propagate import Pieces, Propagation, propagate
from tt_precise.integration.setup import Setup
from tt_precise.integration.stick_slip import pieces_of
from tt_precise.integration.times import SampleTimes
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LiftedStart

MOST_SAMPLES = 20_000  # states that are kept of a run at its sample times


class Solution(NamedTuple):
    """An initial state and what became of it."""

    start: InitialState
    output: DenseOutput


@dataclass(frozen=True)
class Beginning:
    """The start of a scene in one precision; what follows from it is computed once."""

    start: InitialState
    precision: Precision
    scene: Scene

    @cached_property
    def samples(self) -> SampleTimes | None:
        """The scene's sample times, where the states there are worth keeping."""
        scene = self.scene
        if not 0 < scene.until <= MOST_SAMPLES * scene.sample_every:
            return None
        return SampleTimes.of(scene, self.start)

    @cached_property
    def rounded_otherwise(self) -> InitialState:
        """The start with every number on the other side of the exact one."""
        return self.start.map(self.precision.other_side)


def solve(
    scene: Scene,
    setup: Setup,
    progress: Progress | None = None,
    *,
    rounded_otherwise: bool = False,
) -> Solution:
    """Integrate ``scene`` from its start; arguments as of ``Trajectory``.

    Raises
    ------
    InputError
        The top is not on the table at t = 0, or more events happened than are taken.
    """
    precision = setup.precision
    begun = beginning(scene, precision, setup.contact, threading.get_ident())
    start = begun.rounded_otherwise if rounded_otherwise else begun.start
    if precision.doubles:
        refused = refused_in_doubles(scene)
        if refused:
            raise InputError(
                f"{scene.name}: got {precision.name}, expected double, extended, quad or mp for "
                f"{refused}"
            )
        return Solution(start, _in_doubles(setup, start, begun.samples, progress))
    pieces = _pieces(scene, setup, start, progress)
    if pieces:
        return Solution(start, joined(pieces, setup, start))
    if precision.name == "double":
        times = begun.samples
        samples = None if times is None else times.doubles.rounded[1:]
        propagation = propagate(setup, start, samples=samples, progress=progress)
        return Solution(start, DenseOutput(setup, start, propagation, samples=times))
    # wider arithmetics take longer, so there the dense output is always stored at once
    stored = StoredPieces(setup)
    propagation = propagate(setup, start, dense=stored, progress=progress)
    return Solution(start, DenseOutput(setup, start, propagation, stored.pieces))


def _in_doubles(
    setup: Setup, start: InitialState, samples: SampleTimes | None, progress: Progress | None
) -> DenseOutput:
    stored = StoredPieces(setup)
    propagation = propagate_in_doubles(setup, start, dense=stored, progress=progress)

    def again(pieces: Pieces, progress: Progress | None) -> Propagation:
        return propagate_in_doubles(setup, start, dense=pieces, progress=progress)

    return DenseOutput(setup, start, propagation, stored.pieces, again, samples)


@lru_cache(maxsize=64)
def beginning(scene: Scene, precision: Precision, contact: str, thread: int) -> Beginning:
    """The start of a scene, once for each thread: each has its own context of mpmath."""
    start = InitialState.of(scene, precision.arithmetic)
    if not isinstance(scene.start, LiftedStart):
        require_contact(scene.name, start, precision.context, contact)
    return Beginning(start, precision, scene)


def _pieces(
    scene: Scene, setup: Setup, start: InitialState, progress: Progress | None
) -> list[MotionPiece]:
    """The pieces of a motion that has some; none where one set of equations holds throughout."""
    if scene.model == "flight":
        return flying(setup, start)
    if scene.body.spring:
        return bouncing(scene.name, setup, start, progress)
    found: list[MotionPiece] = []
    if scene.may_stick:
        found = pieces_of(scene.name, setup, start, progress)
    elif scene.flies:
        found = [MotionPiece(start.until * 0, propagated(setup, start), "")]
    return flying_on(found, setup, start) if scene.flies else found
