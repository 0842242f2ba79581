"""``integrated``: a scene integrated once, by the first backend that can, into a ``Solution``.

A ``Solution`` is the solution from a start as a list of segments, usually one. Where friction sticks and
slips, the top flies and lands, or gliding begins from rest, another segment begins under its own
equations. Each time belongs to one segment, at a bound to the earlier one. All rows of a segment
are read at once. Where doubles are not precise enough, a run in double uses NumPy's long double;
the other precisions use arrays of numbers with guard bits (``mpfr``).
"""

from __future__ import annotations

import bisect
import itertools
import threading
from collections import Counter
from collections.abc import Container, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property, lru_cache, partial
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol

import numpy

from tt_precise.integration.columns import Columns, Name, Row, State
from tt_precise.integration.dense_output import (
    ARRIVED,
    SampleTimes,
    Segment,
    Span,
    Status,
    long_double,
)
from tt_precise.integration.events import Found
from tt_precise.integration.precision import Precision
from tt_precise.integration.registry import asked_by
from tt_precise.integration.setup import Setup, require_contact
from tt_precise.mechanics.conserved import Integral, drift
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LiftedStart

if TYPE_CHECKING:
    import pandas

Numbers = Literal["float", "exact", "text"]
ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's
FALLING = -1  # the speed where the top sticks, the margin to the cone where it slips


class Stretch(NamedTuple):
    """A stretch of one model: times in s, and how it ended.

    ``status`` is one of ``events.JOINING`` if another stretch follows, else the trajectory's.
    """

    model: str
    begin: Scalar
    end: Scalar
    status: str


class Solution(Span):
    """The solution from a start, as segments."""

    def __init__(self, setup: Setup, start: InitialState, segments: Sequence[Segment]):
        self.setup, self.start, self.segments = setup, start, tuple(segments)
        self.precision, self.columns = setup.precision, Columns(setup, start)

    @property
    def alone(self) -> Segment | None:
        """The only segment of a run under one set of equations, else None."""
        first = self.segments[0]
        return first if len(self.segments) == 1 and first.output.setup == self.setup else None

    @property
    def status(self) -> Status:
        """How it ended."""
        return self.segments[-1].output.status

    @property
    def steps(self) -> int:
        """Taylor steps taken."""
        return sum(segment.output.propagation.steps for segment in self.segments)

    @property
    def order(self) -> int:
        """The order of the last step."""
        return self.segments[-1].output.propagation.order

    @property
    def joints(self) -> list[Segment]:
        """The segments after which an event joins another segment."""
        return [segment for segment in self.segments if segment.ended]

    @property
    def event_counts(self) -> Counter[str]:
        """How often each event was recorded, including events that join segments."""
        hits = (hit for found in self._found for hit in found.hits)
        return Counter([hit.name for hit in hits] + [segment.ended for segment in self.joints])

    @property
    def touches(self) -> tuple[str, ...]:
        """Requested events whose functions touch zero, stay there, or are ``unresolved``."""
        touched = {name for found in self._found for name in found.touches}
        return tuple(name for name in self.setup.watched if name in touched)

    @property
    def unresolved(self) -> tuple[str, ...]:
        """Requested events whose functions are below their error over several extrema."""
        lost = {name for found in self._found for name in found.unresolved}
        return tuple(name for name in self.setup.watched if name in lost)

    @property
    def _found(self) -> list[Found]:
        return [segment.output.propagation.found for segment in self.segments]

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution: the exact horizon if it was reached."""
        last = self.segments[-1]
        if self.alone:
            return last.output.end_time
        return self.start.until if self.status == "complete" else last.begin + last.output.end_time

    def place(self, time: Scalar) -> int:
        """The number of the segment that a dimensionless time belongs to."""
        begins = [segment.begin for segment in self.segments]
        return max(bisect.bisect_left(begins, time) - 1, 0)

    def rows(self, times: Sequence[Scalar]) -> list[tuple[Segment, Row]]:
        """Rows at dimensionless ``times`` (with guard bits), and their segments."""
        if self.alone:
            return [(self.alone, row) for row in self.alone.output.rows(times)]
        rows = []
        for time in times:
            segment = self.segments[self.place(time)]
            output = segment.output
            if segment is self.segments[-1] and time == self.end_time:
                rows.append((segment, output.end_row))
            else:
                rows.append((segment, output.rows([min(time - segment.begin, output.end_time)])[0]))
        return rows

    def states(self, times: Sequence[Scalar]) -> list[State]:
        """The states (SI) at dimensionless ``times`` (with guard bits)."""
        rows = self.rows(times)
        if self.alone:
            return self.columns.states(times, [row for _, row in rows])
        return [
            segment.columns.states([time], [row])[0]
            for time, (segment, row) in zip(times, rows, strict=True)
        ]

    def motions(self, times: Sequence[Scalar]) -> list[Motion]:
        """The motions at dimensionless ``times`` (with guard bits)."""
        return [segment.columns.motion(row) for segment, row in self.rows(times)]

    @property
    def stretches(self) -> tuple[Stretch, ...]:
        """The stretches between events that join segments."""
        to_user, begin, stretches = self.columns.to_user, self.start.until * 0, []
        for segment in self.joints:
            end = segment.end_s
            stretches.append(Stretch(segment.model, to_user(begin), to_user(end), segment.ended))
            begin = end
        last = self.segments[-1].model
        return (*stretches, Stretch(last, to_user(begin), to_user(self.end), self.status))

    @property
    def in_arrays(self) -> bool:
        """Whether all rows are read at once in arrays of doubles."""
        return self.precision.is_float and self.precision.in_long_double

    def table(
        self,
        names: Sequence[Name],
        times: Sequence[Fraction],
        numbers: Numbers,
        progress: Progress | None = None,
    ) -> dict[Any, Array]:
        """``t`` and the named columns at exact ``times`` in s.

        Numbers of double are a float64 array with NaN where a value is undefined; wider ones, and
        text, are a list or an array of objects with None there.
        """
        if self.alone:
            return self._of_segment(self.alone, names, times, numbers, progress)

        parts, order = [], []
        for segment, places in self._groups(times):
            local = [_local(segment, times[i]) for i in places]
            parts.append(self._of_segment(segment, names, local, numbers))
            order += places
        back = numpy.argsort(order).tolist()
        columns: dict[Any, Any] = {}
        for name in ("t", *names):
            values = [x for part in parts for x in part[name]] if parts else []
            columns[name] = [values[i] for i in back]
        columns["t"] = self._seconds(times, numbers)
        if numbers == "text":
            return columns
        double = numbers == "float" or self.precision.is_float
        return {n: numpy.array(c, dtype=float if double else object) for n, c in columns.items()}

    def _of_segment(
        self,
        segment: Segment,
        names: Sequence[Name],
        times: Sequence[Fraction],
        numbers: Numbers,
        progress: Progress | None = None,
    ) -> dict[Any, Array]:
        """The columns of one segment, over its own time."""
        if self.in_arrays:
            return _array_columns(segment, names, times, numbers, progress)
        mpfr = self.precision.mpfr
        with mpfr.precision():
            seconds = mpfr.of_fractions(times)
            entries = segment.output.mpfr_arrays(seconds, progress)
            columns = segment.columns.of_arrays(names, entries, mpfr.number, mpfr)
            table = {"t": seconds, **columns}
            return {name: self._converted(values, numbers) for name, values in table.items()}

    def _groups(self, times: Sequence[Fraction]) -> Iterable[tuple[Segment, list[int]]]:
        groups: dict[int, list[int]] = {}
        for i, time in enumerate(times):
            groups.setdefault(self.place(self.dimensionless_time(time)), []).append(i)
        return [(self.segments[place], groups[place]) for place in sorted(groups)]

    def _seconds(self, times: Sequence[Fraction], numbers: Numbers) -> Array:
        if self.precision.is_float:
            plain = list(map(float, times))
            return shortest_texts(plain) if numbers == "text" else plain
        return self._converted(self.precision.mpfr.of_fractions(times), numbers)

    def _converted(self, values: Array, numbers: Numbers) -> Array:
        precision = self.precision
        if numbers == "text":
            return precision.mpfr.texts(values, precision.decimals)
        if numbers == "float" or precision.is_float:
            floats = values.astype(float)
            return (
                numpy.where(numpy.isfinite(floats), floats, numpy.nan) + 0.0
            )  # no minus before zero
        return numpy.array(list(map(precision.mpfr.back, values)), dtype=object)

    def events(self) -> pandas.DataFrame:
        """The recorded events in order of time: name, t, direction and the state there."""
        import pandas

        columns = self.event_columns(self.columns.names)
        return pandas.DataFrame(columns if columns["name"] else [], columns=list(columns))

    def event_columns(
        self, names: Sequence[str], at: Container[str] | None = None
    ) -> dict[str, Array]:
        """The same as columns, without pandas, with the named quantities.

        In wide arithmetics, where quantities are slow, only ``at`` the events of these names, if
        given; elsewhere they are missing.
        """
        if self.alone:
            return self._events_of_segment(self.alone, names, at)
        context, to_user = self.precision.context, self.columns.to_user
        columns: dict[str, Array] = {name: [] for name in ("name", "t", "direction", *names)}
        for segment in self.segments:
            happened = self._events_of_segment(segment, names, at)
            happened["t"] = [to_user(context.mpf(t) + segment.begin_s) for t in happened["t"]]
            for name, column in columns.items():
                column += list(happened[name])
            if segment.ended:
                output = segment.output
                (state,) = segment.columns.states([output.end_time], [output.end_row])
                row = {"name": segment.ended, "t": to_user(segment.end_s), "direction": FALLING}
                row |= state.values
                for name, column in columns.items():
                    column.append(row.get(name))
        return columns

    def _events_of_segment(
        self, segment: Segment, names: Sequence[str], at: Container[str] | None
    ) -> dict[str, Array]:
        of, unit = segment.columns, segment.output.start.units.time
        hits = sorted(segment.output.propagation.found.hits, key=lambda hit: hit.time)
        directions = numpy.array([hit.direction for hit in hits])
        columns: dict[str, Array] = {"name": [hit.name for hit in hits]}
        if self.in_arrays and hits:
            entries = tuple(numpy.array([hit.state for hit in hits], numpy.longdouble).T)
            times = numpy.array([hit.time for hit in hits], numpy.longdouble)
            times *= long_double(unit)
            columns |= {"t": times.astype(float), "direction": directions}
            values = of.of_arrays(names, entries, long_double)
            return columns | {name: column.astype(float) for name, column in values.items()}
        mpf, to_user = self.precision.context.mpf, of.to_user
        columns["t"] = [to_user(mpf(hit.time) * unit) for hit in hits]
        columns["direction"] = directions
        asked = [names and (at is None or hit.name in at) for hit in hits]
        rows = [tuple(map(mpf, hit.state)) for hit in itertools.compress(hits, asked)]
        for name, column in of.of_rows(names, rows).items():
            shown = map(to_user, column)
            columns[name] = [next(shown) if wanted else None for wanted in asked]
        return columns

    def drift(
        self, integrals: Iterable[Integral], times: Sequence[Fraction]
    ) -> dict[str, Sequence[Scalar]]:
        """Relative change of each integral since the start, at ``times``, the last being the end.

        In double a float64 array for each, otherwise a list of mpmath numbers.
        """
        if not (self.in_arrays and self.alone):
            zero = self.start.until * 0
            inner = [zero, *map(self.dimensionless_time, times[:-1]), self.end_time]
            motions = self.motions(inner)
            return {integral.name: drift(integral, motions)[1:] for integral in integrals}

        of, output = self.alone.columns, self.alone.output
        entries = output.arrays(output.times(times), long_double)
        if self.status not in ARRIVED:
            for entry, value in zip(entries, output.end_row, strict=True):
                entry[-1] = long_double(value)
        start = tuple(map(long_double, output.start_row))
        motions = [of.array_motion(rows, long_double) for rows in (start, entries)]
        ones = numpy.ones(len(times))  # an integral may be one number for all rows
        return {
            integral.name: (drift(integral, motions)[1] * ones).astype(float)
            for integral in integrals
        }


def _local(segment: Segment, time: Fraction) -> Fraction:
    """A time since the segment's begin; rounding never puts it after the segment's end."""
    since = max(time - as_fraction(segment.begin_s), Fraction(0))
    return min(since, as_fraction(segment.output.end))


def _array_columns(
    segment: Segment,
    names: Sequence[Name],
    exact: Sequence[Fraction],
    numbers: Numbers,
    progress: Progress | None,
) -> dict[Any, Array]:
    """Columns of a run in double: text is the shortest that recovers the number."""
    number = long_double if numbers == "text" else float
    times = segment.output.times(exact)
    entries = segment.output.arrays(times, number, progress)
    table = {"t": times.seconds, **segment.columns.of_arrays(names, entries, number)}
    stacked = numpy.array(list(table.values()), dtype=float)
    stacked[~numpy.isfinite(stacked)] = numpy.nan
    table = dict(zip(table, stacked, strict=True))
    if numbers != "text":
        return table
    return {name: shortest_texts(values) for name, values in table.items()}


MOST_SAMPLES = 20_000  # states that are kept of a run at its sample times


class Backend(Protocol):
    """An integrator: one file, and an entry in ``backends`` or in the registry."""

    def refuses(self, scene: Scene, setup: Setup) -> str | None:
        """Why it cannot integrate ``scene`` with this set-up, in one line; None if it can."""

    def run(
        self,
        scene: Scene,
        setup: Setup,
        start: InitialState,
        samples: SampleTimes | None,
        progress: Progress | None,
    ) -> list[Segment]:
        """The run from ``start``; ``samples`` are times at which it will be read, if any."""


def backends(scene: Scene) -> Iterator[Backend]:
    """All backends; each is imported when the earlier ones have refused."""
    from tt_precise.integration import heyoka_backend

    yield heyoka_backend
    yield from asked_by(scene)
    from tt_precise.integration import multidouble_backend

    yield multidouble_backend


def integrated(
    scene: Scene,
    setup: Setup,
    progress: Progress | None = None,
    *,
    opposite_rounding: bool = False,
) -> Solution:
    """The run of ``scene``, integrated once with ``setup``.

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
            return Solution(setup, start, backend.run(scene, setup, start, samples, progress))
    raise InputError(reason or f"{scene.name}: got no backend")


@lru_cache(maxsize=64)
def beginning(
    scene: Scene, precision: Precision, contact: str, opposite_rounding: bool, thread: int
) -> InitialState:
    """The start of a scene, once for each thread: each has its own context of mpmath."""
    if opposite_rounding:
        nearest = beginning(scene, precision, contact, False, thread)
        return nearest.map(precision.opposite_neighbour)
    start = InitialState.of(scene, precision.arithmetic)
    if not isinstance(scene.start, LiftedStart):
        require_contact(scene.name, start, precision.context, contact)
    return start
