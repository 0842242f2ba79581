"""``Solution``: a scene integrated once, by the first backend that accepts it.

A solution is a list of segments, usually one. Where the equations change, another segment begins.
Each time belongs to one segment, a common end to the earlier segment.
"""

from __future__ import annotations

import bisect
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache, partial
from typing import Any, Literal, NamedTuple, Protocol

from tt_precise.integration.columns import Columns
from tt_precise.integration.dense_output import ARRIVED, FoundEvents, SampleTimes, Segment, TimeSpan
from tt_precise.integration.events import LEAVES
from tt_precise.integration.precision import Precision
from tt_precise.integration.registry import asked_by
from tt_precise.integration.setup import Setup, full_tolerance, require_contact
from tt_precise.runtime.terminal import Progress, progress_bar
from tt_precise.runtime.values import InputError, Memory, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LiftedStart

Status = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole", "failed",
]  # fmt: skip


class PhaseInterval(NamedTuple):
    """A segment of a motion under one model: times in s, and the status at its end.

    ``status`` is one of ``events.JOINING`` if another segment follows, else the trajectory's.
    """

    model: str
    begin: Scalar
    end: Scalar
    status: str

    @property
    def leaves(self) -> bool:
        """True if the top leaves the table at the end."""
        return self.status in LEAVES


@dataclass(frozen=True, eq=False)
class Solution(TimeSpan, Memory):
    """A scene, its start in the arithmetic of a set-up, and the segments from there.

    With ``opposite_rounding`` every number of body and start lies on the other side of the exact
    number. ``reading`` has the columns and events of a solution, ``errors`` its errors.
    """

    scene: Scene
    setup: Setup
    start: InitialState
    segments: tuple[Segment, ...]
    opposite_rounding: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        # integrated again where it is unpickled: heyoka's own pickles are machine code
        return _unpickled, (self.scene, self.setup, self.opposite_rounding)

    def again(self, *, opposite_rounding: bool = False, **changes: Any) -> Solution:
        """Integrate the scene again, with some fields of the ``Setup`` replaced."""
        setup = self.setup.but(**changes)
        return solve(self.scene, setup, opposite_rounding=opposite_rounding)

    @property
    def tolerance(self) -> Scalar:
        """The relative tolerance of the integration, an mpmath number."""
        return self.precision.context.mpf(self.setup.tolerance) or full_tolerance(self.precision)

    @cached_property
    def columns(self) -> Columns:
        """The columns of the set-up's rows."""
        return Columns(self.setup, self.start)

    @property
    def alone(self) -> Segment | None:
        """The single segment of a run under one set of equations, else None."""
        first = self.segments[0]
        return first if len(self.segments) == 1 and first.output.setup == self.setup else None

    @property
    def status(self) -> Status:
        """Status at the end."""
        ended: Any = self.segments[-1].output.status
        return ended

    @property
    def steps(self) -> int:
        """Taylor steps taken."""
        return sum(segment.output.propagation.steps for segment in self.segments)

    @property
    def order(self) -> int:
        """The order of the last step."""
        return self.segments[-1].output.propagation.order

    @property
    def switched(self) -> list[Segment]:
        """The segments after which an event joins another segment."""
        return [segment for segment in self.segments if segment.ended]

    @property
    def event_counts(self) -> Counter[str]:
        """Numbers of recorded events by name, including events that join segments."""
        names = [name for found in self._findings for name in found.hits.name.tolist()]
        return Counter(names + [segment.ended for segment in self.switched])

    @property
    def touches(self) -> tuple[str, ...]:
        """Requested events whose functions touch zero, stay zero, or are ``unresolved``."""
        touched = {name for found in self._findings for name in found.touches}
        return tuple(name for name in self.setup.watched if name in touched)

    @property
    def unresolved(self) -> tuple[str, ...]:
        """Requested events whose functions are below their error over several extrema."""
        lost = {name for found in self._findings for name in found.unresolved}
        return tuple(name for name in self.setup.watched if name in lost)

    @property
    def _findings(self) -> list[FoundEvents]:
        return [segment.output.propagation.found for segment in self.segments]

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution: the exact horizon if it was reached."""
        last = self.segments[-1]
        if self.alone:
            return last.output.end_time
        return self.start.until if self.status == "complete" else last.begin + last.output.end_time

    @cached_property
    def t_end(self) -> Scalar:
        """The end in s: a float in double, else an mpmath number."""
        return self.columns.to_user(self.end)

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to the end; an early end is added."""
        if self.status in ARRIVED:
            return self.scene.sample_times
        end = as_fraction(self.end)
        return (*(t for t in self.scene.sample_times if t < end), end)

    def segment_at(self, time: Scalar) -> int:
        """The number of the segment that a dimensionless time belongs to."""
        begins = [segment.begin for segment in self.segments]
        return max(bisect.bisect_left(begins, time) - 1, 0)

    @property
    def stretches(self) -> tuple[PhaseInterval, ...]:
        """The segments between mode switches, as ``PhaseInterval``."""
        to_user, begin, stretches = self.columns.to_user, self.start.until * 0, []
        for segment in self.switched:
            end = segment.end_s
            stretches.append(
                PhaseInterval(segment.model, to_user(begin), to_user(end), segment.ended)
            )
            begin = end
        last = self.segments[-1].model
        return (*stretches, PhaseInterval(last, to_user(begin), to_user(self.end), self.status))

    @property
    def in_arrays(self) -> bool:
        """True if all rows are read at once in arrays of doubles."""
        return self.precision.is_float and self.precision.in_long_double


SLOW = ("quad", "mp")  # Precisions that take seconds to minutes, and show their progress.
MOST_SAMPLES = 20_000  # states that are kept of a run at its sample times


class Backend(Protocol):
    """An integrator: one file, and an entry in ``backends`` or in the registry."""

    def refuses(self, scene: Scene, setup: Setup) -> str | None:
        """The reason, in one line, to refuse ``scene`` with this set-up; None if accepted."""

    def run(
        self,
        scene: Scene,
        setup: Setup,
        start: InitialState,
        samples: SampleTimes | None,
        progress: Progress | None,
    ) -> list[Segment]:
        """The run from ``start``; ``samples`` are the times at which rows will be read, if any."""


def backends(scene: Scene) -> Iterator[Backend]:
    """All backends; each is imported when the earlier ones have refused."""
    from tt_precise.integration import heyoka_backend

    yield heyoka_backend
    yield from asked_by(scene)
    from tt_precise.integration import multidouble_backend

    yield multidouble_backend


def solve(
    scene: Scene,
    setup: Setup,
    progress: Progress | None = None,
    *,
    opposite_rounding: bool = False,
) -> Solution:
    """The solution of ``scene``, integrated once with ``setup``.

    With ``opposite_rounding`` every number of body and start is rounded to the other side of the
    exact value: the difference between both runs contains the effect of this rounding.

    Raises ``InputError``: the top is not on the table at t = 0, there are too many events, or no
    backend supports the set-up.
    """
    thread = threading.get_ident()
    start = beginning(scene, setup.precision, setup.contact, opposite_rounding, thread)
    reason = None
    for backend in backends(scene):
        reason = backend.refuses(scene, setup)
        if reason is None:
            few = 0 < scene.until <= MOST_SAMPLES * scene.sample_every
            made = partial(SampleTimes.of, scene, start)
            samples = start.once(SampleTimes, made) if few else None
            silent = progress is not None or setup.precision.name not in SLOW
            title = f"{scene.name} in {setup.precision.name}"
            with nullcontext(progress) if silent else progress_bar(title) as report:
                segments = tuple(backend.run(scene, setup, start, samples, report))
            return Solution(scene, setup, start, segments, opposite_rounding)
    raise InputError(reason or f"{scene.name}: got no backend")


def _unpickled(scene: Scene, setup: Setup, opposite_rounding: bool) -> Solution:
    return solve(scene, setup, opposite_rounding=opposite_rounding)


@lru_cache(maxsize=64)
def beginning(
    scene: Scene, precision: Precision, contact: str, opposite_rounding: bool, thread: int
) -> InitialState:
    """The start of a scene, cached per thread, because each thread has its own mpmath context."""
    if opposite_rounding:
        nearest = beginning(scene, precision, contact, False, thread)
        return nearest.map(precision.opposite_neighbour)
    start = InitialState.of(scene, precision.arithmetic)
    if not isinstance(scene.start, LiftedStart):
        require_contact(scene.name, start, precision.context, contact)
    return start
