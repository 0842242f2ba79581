"""``integrated``: a scene integrated once, as a set-up says, by the first backend that can."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol

from tt_precise.integration.dense_output import SampleTimes
from tt_precise.integration.precision import Precision
from tt_precise.integration.segments import Run
from tt_precise.integration.setup import Setup, require_contact
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LiftedStart

MOST_SAMPLES = 20_000  # states that are kept of a run at its sample times


class Backend(Protocol):
    """What integrates: a file of its own, and an entry in ``backends``."""

    def refuses(self, scene: Scene, setup: Setup) -> str | None:
        """Why it cannot integrate ``scene`` so, in a line of got and expected; None if it can."""

    def run(
        self,
        scene: Scene,
        setup: Setup,
        start: InitialState,
        samples: SampleTimes | None,
        progress: Progress | None,
    ) -> Run:
        """What becomes of ``start``; ``samples`` are times at which it will be read, if any."""


def backends(scene: Scene) -> Iterator[Backend]:
    """All of them; each is imported when those before it have refused."""
    from tt_precise.integration import heyoka_backend

    yield heyoka_backend
    if scene.in_pieces:
        from tt_precise.integration import hybrid

        yield hybrid
    from tt_precise.integration import multidouble_backend

    yield multidouble_backend


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
    def opposite_rounding(self) -> InitialState:
        """The start with every number on the other side of the exact one."""
        return self.start.map(self.precision.opposite_neighbour)


def integrated(
    scene: Scene,
    setup: Setup,
    progress: Progress | None = None,
    *,
    opposite_rounding: bool = False,
) -> Run:
    """What becomes of ``scene``, integrated once as ``setup`` says.

    With ``opposite_rounding`` every number of body and start lies on the other side of the exact
    one: what such a run differs by contains what their rounding does to a run.

    Raises
    ------
    InputError
        The top is not on the table at t = 0, more events happened than are taken, or no backend
        can do what the set-up asks for.
    """
    begun = beginning(scene, setup.precision, setup.contact, threading.get_ident())
    start = begun.opposite_rounding if opposite_rounding else begun.start
    reason = None
    for backend in backends(scene):
        reason = backend.refuses(scene, setup)
        if reason is None:
            return backend.run(scene, setup, start, begun.samples, progress)
    raise InputError(reason or f"{scene.name}: got no backend")


@lru_cache(maxsize=64)
def beginning(scene: Scene, precision: Precision, contact: str, thread: int) -> Beginning:
    """The start of a scene, once for each thread: each has its own context of mpmath."""
    start = InitialState.of(scene, precision.arithmetic)
    if not isinstance(scene.start, LiftedStart):
        require_contact(scene.name, start, precision.context, contact)
    return Beginning(start, precision, scene)
