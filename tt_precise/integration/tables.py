"""``Tables``: all rows of one run at once, as columns, events and drifts.

Rows are read in arrays: 801 of a run in double cost less than the run. What has to be finer than
its numbers is computed in NumPy's long double there. Those of every other precision are arrays of
wide numbers (``mpfr``), with guard bits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Container, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Literal, NamedTuple

from tt_precise.integration.columns import Columns
from tt_precise.integration.dense_output import DenseOutput
from tt_precise.integration.propagate import ARRIVED
from tt_precise.integration.times import has_long_double, long_double
from tt_precise.mechanics.conserved import Integral, drift
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Array, Functions, Scalar
from tt_precise.runtime.progress import Progress
from tt_precise.scene.numerals import shortest_texts

if TYPE_CHECKING:
    import pandas

Numbers = Literal["native", "float", "text"]
ERROR, DIGITS = "error:", "digits"  # names of columns of errors, the first before another's


@dataclass(frozen=True)
class Tables:
    """What is read from many rows of a run, in SI."""

    dense_output: DenseOutput
    of: Columns

    @property
    def in_arrays(self) -> bool:
        """Whether all rows are read at once, and not one by one in mpmath."""
        return self.of.precision.name == "double" and has_long_double()

    @property
    def in_long_double(self) -> bool:
        """Whether rows can be had as arrays of long doubles."""
        return self.of.precision.name in ("double", "extended") and has_long_double()

    def columns(
        self,
        names: Sequence[str],
        times: Sequence[Fraction],
        numbers: Numbers,
        progress: Progress | None = None,
    ) -> dict[str, Array]:
        """``t`` and the named columns at exact ``times`` in s.

        Numbers of double are a float64 array with NaN where a value is undefined; wider ones, and
        text, are a list or an array of objects with None there.
        """
        if self.in_arrays:
            return self._array_columns(names, times, numbers, progress)
        wide = self.of.precision.wide
        with wide.precision():
            seconds = wide.of_fractions(times)
            entries = self.dense_output.wide_arrays(seconds, progress)
            found = self.of.of_arrays(names, entries, wide.number, wide)
            table = {"t": seconds, **found}
            return {name: self._converted(values, numbers) for name, values in table.items()}

    def _array_columns(
        self,
        names: Sequence[str],
        exact: Sequence[Fraction],
        numbers: Numbers,
        progress: Progress | None,
    ) -> dict[str, Array]:
        import numpy

        number = long_double if numbers == "text" else float
        times = self.dense_output.times(exact)
        entries = self.dense_output.arrays(times, number, progress)
        table = {"t": times.seconds, **self.of.of_arrays(names, entries, number)}
        found = numpy.array(list(table.values()), dtype=float)
        found[~numpy.isfinite(found)] = numpy.nan
        table = dict(zip(table, found, strict=True))
        if numbers != "text":
            return table
        return {name: shortest_texts(values) for name, values in table.items()}

    def _converted(self, values: Array, numbers: Numbers) -> Array:
        """Wide numbers as they are asked for."""
        import numpy

        precision = self.of.precision
        if numbers == "text":
            return precision.wide.texts(values, precision.decimals)
        if numbers == "float" or precision.name == "double":
            found = values.astype(float)
            return (
                numpy.where(numpy.isfinite(found), found, numpy.nan) + 0.0
            )  # no minus before zero
        return numpy.array(list(map(precision.wide.back, values)), dtype=object)

    def evaluated(
        self, function: Callable[[Motion], Scalar], times: Sequence[Scalar]
    ) -> list[Scalar]:
        """A function of the motion at guarded times in s, dimensionless, in guarded numbers."""
        wide = self.of.precision.wide
        with wide.precision():
            entries = self.dense_output.wide_arrays(wide.array(times))
            return list(map(wide.back, function(self.of.array_motion(entries, wide.number, wide))))

    def events(self) -> pandas.DataFrame:
        """The recorded events in order of time: name, t, direction and the state there."""
        import pandas

        columns = self.event_columns(self.of.names)
        return pandas.DataFrame(columns if columns["name"] else [], columns=list(columns))

    def event_columns(
        self, names: Sequence[str], at: Container[str] | None = None
    ) -> dict[str, Array]:
        """The same as columns, without pandas, with those quantities that are named.

        In wide arithmetics, where they take their time, only ``at`` the events of these names, if
        any are given; they are missing elsewhere.
        """
        import numpy

        hits = sorted(self.dense_output.propagation.hits, key=lambda hit: hit.time)
        directions = numpy.array([hit.direction for hit in hits])
        columns: dict[str, Array] = {"name": [hit.name for hit in hits]}
        if self.in_arrays and hits:
            entries = tuple(numpy.array([hit.state for hit in hits], numpy.longdouble).T)
            times = numpy.array([hit.time for hit in hits], numpy.longdouble)
            times *= long_double(self.of.start.units.time)
            columns |= {"t": times.astype(float), "direction": directions}
            values = self.of.of_arrays(names, entries, long_double)
            return columns | {name: column.astype(float) for name, column in values.items()}
        guarded, leaving = self.of.precision.guarded, self.of.leaving
        unit = self.of.start.units.time
        columns["t"] = [leaving(guarded(hit.time) * unit) for hit in hits]
        columns["direction"] = directions
        asked = [names and (at is None or hit.name in at) for hit in hits]
        rows = [tuple(map(guarded, hit.state)) for hit in itertools.compress(hits, asked)]
        for name, column in self.of.of_rows(names, rows).items():
            found = map(leaving, column)
            columns[name] = [next(found) if one else None for one in asked]
        return columns

    def drift(
        self, integrals: Iterable[Integral], times: Sequence[Fraction]
    ) -> dict[str, Sequence[Scalar]]:
        """Relative change of each integral since the start, at ``times``, the last being the end.

        In double a float64 array for each, otherwise a list of mpmath numbers.
        """
        dense_output = self.dense_output
        start = dense_output.start_row
        if not self.in_arrays:
            end = dense_output.end_row
            inner = [dense_output.dimensionless_time(t) for t in times[:-1]]
            rows = [start, *dense_output.rows(inner), end]
            motions = list(map(self.of.motion, rows))
            return {integral.name: drift(integral, motions)[1:] for integral in integrals}
        import numpy

        entries = dense_output.arrays(dense_output.times(times), long_double)
        if dense_output.propagation.status not in ARRIVED:
            for entry, value in zip(entries, dense_output.end_row, strict=True):
                entry[-1] = long_double(value)
        motions = [
            self.of.array_motion(rows, long_double)
            for rows in (tuple(map(long_double, start)), entries)
        ]
        ones = numpy.ones(len(times))  # an integral may be one number for all rows
        return {
            integral.name: (drift(integral, motions)[1] * ones).astype(float)
            for integral in integrals
        }


class Reference(NamedTuple):
    """A run beside another: its tables, where it ends (s), and whether it ends in the same way."""

    tables: Tables
    end: Fraction
    ends_alike: bool


def floats(values: Array | Sequence[Scalar]) -> Array:
    """Numbers of any kind as a float64 array, with NaN where one is undefined."""
    import numpy

    if isinstance(values, numpy.ndarray) and values.dtype != object:
        return values.astype(float)
    return numpy.array([math.nan if _missing(v) else float(v) for v in values])


def distance(values: Array, others: Array, fn: Functions) -> Array:
    """Absolute distances of two columns, as a float64 array with NaN where one is undefined."""
    import numpy

    if all(getattr(one, "dtype", None) in (float, numpy.longdouble) for one in (values, others)):
        with numpy.errstate(invalid="ignore"):
            apart: Array = numpy.abs(values - others).astype(float)
        return numpy.where(numpy.isfinite(apart), apart, math.nan)
    pairs = zip(values, others, strict=True)
    return numpy.array(
        [
            math.nan if _missing(a) or _missing(b) else float(abs(fn.mpf(a) - fn.mpf(b)))
            for a, b in pairs
        ],
        dtype=float,
    )


def _missing(value: Scalar) -> bool:
    return value is None or value != value
