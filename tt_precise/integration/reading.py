"""``Reader``: all rows of one run at once, as columns, events and drifts.

Rows are read in arrays: 801 of a run in double cost less than the run. What has to be finer than
its numbers is computed in NumPy's long double there. Those of every other precision are arrays of
wide numbers (``mpfr``), with guard bits. A run of several segments is read segment by segment.
"""

from __future__ import annotations

import itertools
from collections.abc import Container, Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal

from tt_precise.integration.columns import Name
from tt_precise.integration.dense_output import ARRIVED, long_double
from tt_precise.integration.segments import Run, Segment
from tt_precise.mechanics.conserved import Integral, drift
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.numerals import as_fraction, shortest_texts

if TYPE_CHECKING:
    import pandas

Numbers = Literal["float", "exact", "text"]
ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's
FALLING = -1  # the speed where the top sticks, the margin to the cone where it slips


class Reader:
    """What is read from many rows of a ``run``, in SI."""

    def __init__(self, run: Run):
        self.run, self.precision = run, run.precision

    @property
    def in_arrays(self) -> bool:
        """Whether all rows are read at once in arrays of doubles."""
        return self.precision.is_float and self.precision.in_long_double

    def columns(
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
        if self.run.alone:
            return self._of_segment(self.run.alone, names, times, numbers, progress)
        import numpy

        parts, order = [], []
        for one, places in self._groups(times):
            local = [_local(one, times[i]) for i in places]
            parts.append(self._of_segment(one, names, local, numbers))
            order += places
        back = numpy.argsort(order).tolist()
        found: dict[Any, Any] = {}
        for name in ("t", *names):
            values = [x for part in parts for x in part[name]] if parts else []
            found[name] = [values[i] for i in back]
        found["t"] = self._seconds(times, numbers)
        if numbers == "text":
            return found
        double = numbers == "float" or self.precision.is_float
        return {n: numpy.array(c, dtype=float if double else object) for n, c in found.items()}

    def _of_segment(
        self,
        one: Segment,
        names: Sequence[Name],
        times: Sequence[Fraction],
        numbers: Numbers,
        progress: Progress | None = None,
    ) -> dict[Any, Array]:
        """The columns of one segment, over its own time."""
        if self.in_arrays:
            return _array_columns(one, names, times, numbers, progress)
        mpfr = self.precision.mpfr
        with mpfr.precision():
            seconds = mpfr.of_fractions(times)
            entries = one.output.mpfr_arrays(seconds, progress)
            found = one.columns.of_arrays(names, entries, mpfr.number, mpfr)
            table = {"t": seconds, **found}
            return {name: self._converted(values, numbers) for name, values in table.items()}

    def _groups(self, times: Sequence[Fraction]) -> Iterable[tuple[Segment, list[int]]]:
        groups: dict[int, list[int]] = {}
        for i, time in enumerate(times):
            groups.setdefault(self.run.place(self.run.dimensionless_time(time)), []).append(i)
        return [(self.run.segments[place], groups[place]) for place in sorted(groups)]

    def _seconds(self, times: Sequence[Fraction], numbers: Numbers) -> Array:
        if self.precision.is_float:
            plain = list(map(float, times))
            return shortest_texts(plain) if numbers == "text" else plain
        return self._converted(self.precision.mpfr.of_fractions(times), numbers)

    def _converted(self, values: Array, numbers: Numbers) -> Array:
        """Wide numbers as they are asked for."""
        import numpy

        precision = self.precision
        if numbers == "text":
            return precision.mpfr.texts(values, precision.decimals)
        if numbers == "float" or precision.is_float:
            found = values.astype(float)
            return (
                numpy.where(numpy.isfinite(found), found, numpy.nan) + 0.0
            )  # no minus before zero
        return numpy.array(list(map(precision.mpfr.back, values)), dtype=object)

    def events(self) -> pandas.DataFrame:
        """The recorded events in order of time: name, t, direction and the state there."""
        import pandas

        columns = self.event_columns(self.run.columns.names)
        return pandas.DataFrame(columns if columns["name"] else [], columns=list(columns))

    def event_columns(
        self, names: Sequence[str], at: Container[str] | None = None
    ) -> dict[str, Array]:
        """The same as columns, without pandas, with those quantities that are named.

        In wide arithmetics, where they take their time, only ``at`` the events of these names, if
        any are given; they are missing elsewhere.
        """
        if self.run.alone:
            return self._events_of_segment(self.run.alone, names, at)
        context, to_user = self.precision.context, self.run.columns.to_user
        columns: dict[str, Array] = {name: [] for name in ("name", "t", "direction", *names)}
        for one in self.run.segments:
            found = self._events_of_segment(one, names, at)
            found["t"] = [to_user(context.mpf(t) + one.begin_s) for t in found["t"]]
            for name, column in columns.items():
                column += list(found[name])
            if one.ended and one is not self.run.segments[-1]:
                output = one.output
                (state,) = one.columns.states([output.end_time], [output.end_row])
                row = {"name": one.ended, "t": to_user(one.end_s), "direction": FALLING}
                row |= state.values
                for name, column in columns.items():
                    column.append(row.get(name))
        return columns

    def _events_of_segment(
        self, one: Segment, names: Sequence[str], at: Container[str] | None
    ) -> dict[str, Array]:
        import numpy

        of, unit = one.columns, one.output.start.units.time
        hits = sorted(one.output.propagation.hits, key=lambda hit: hit.time)
        directions = numpy.array([hit.direction for hit in hits])
        columns: dict[str, Array] = {"name": [hit.name for hit in hits]}
        if self.in_arrays and hits:
            entries = tuple(numpy.array([hit.state for hit in hits], numpy.longdouble).T)
            times = numpy.array([hit.time for hit in hits], numpy.longdouble)
            times *= long_double(unit)
            columns |= {"t": times.astype(float), "direction": directions}
            values = of.of_arrays(names, entries, long_double)
            return columns | {name: column.astype(float) for name, column in values.items()}
        with_guard_bits, to_user = self.precision.with_guard_bits, of.to_user
        columns["t"] = [to_user(with_guard_bits(hit.time) * unit) for hit in hits]
        columns["direction"] = directions
        asked = [names and (at is None or hit.name in at) for hit in hits]
        rows = [tuple(map(with_guard_bits, hit.state)) for hit in itertools.compress(hits, asked)]
        for name, column in of.of_rows(names, rows).items():
            found = map(to_user, column)
            columns[name] = [next(found) if one else None for one in asked]
        return columns

    def drift(
        self, integrals: Iterable[Integral], times: Sequence[Fraction]
    ) -> dict[str, Sequence[Scalar]]:
        """Relative change of each integral since the start, at ``times``, the last being the end.

        In double a float64 array for each, otherwise a list of mpmath numbers.
        """
        run = self.run
        if not (self.in_arrays and run.alone):
            zero = run.start.until * 0
            inner = [zero, *map(run.dimensionless_time, times[:-1]), run.end_time]
            motions = run.motions(inner)
            return {integral.name: drift(integral, motions)[1:] for integral in integrals}
        import numpy

        of, output = run.alone.columns, run.alone.output
        entries = output.arrays(output.times(times), long_double)
        if run.status not in ARRIVED:
            for entry, value in zip(entries, output.end_row, strict=True):
                entry[-1] = long_double(value)
        start = tuple(map(long_double, output.start_row))
        motions = [of.array_motion(rows, long_double) for rows in (start, entries)]
        ones = numpy.ones(len(times))  # an integral may be one number for all rows
        return {
            integral.name: (drift(integral, motions)[1] * ones).astype(float)
            for integral in integrals
        }


def _local(one: Segment, time: Fraction) -> Fraction:
    """A time since the segment's begin; never behind its end by a rounding."""
    return min(max(time - as_fraction(one.begin_s), Fraction(0)), as_fraction(one.output.end))


def _array_columns(
    one: Segment,
    names: Sequence[Name],
    exact: Sequence[Fraction],
    numbers: Numbers,
    progress: Progress | None,
) -> dict[Any, Array]:
    """Columns of a run in double: text is the shortest that recovers the number."""
    import numpy

    number = long_double if numbers == "text" else float
    times = one.output.times(exact)
    entries = one.output.arrays(times, number, progress)
    table = {"t": times.seconds, **one.columns.of_arrays(names, entries, number)}
    found = numpy.array(list(table.values()), dtype=float)
    found[~numpy.isfinite(found)] = numpy.nan
    table = dict(zip(table, found, strict=True))
    if numbers != "text":
        return table
    return {name: shortest_texts(values) for name, values in table.items()}
