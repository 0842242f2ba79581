"""Errors all along a run: how far it is from its reference runs at every sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from tt_precise.integration.accuracy import digits_over_rows
from tt_precise.integration.tables import Tables
from tt_precise.integration.times import long_double
from tt_precise.runtime.arithmetic import Array, Functions, Scalar


class Reference(NamedTuple):
    """A reference run: its tables, where it ends (s), and whether it ends in the same way."""

    tables: Tables
    end: Fraction
    ends_alike: bool


def error_columns(
    tables: Tables,
    names: Sequence[str],
    times: Sequence[Fraction],
    references: Sequence[Reference],
    end_errors: Mapping[str, Scalar] | None,
) -> dict[str, Array]:
    """Float64 columns: t, the errors of ``names`` (SI), "digits" of the state's worst entry."""
    import numpy

    state, precision = tables.of.names, tables.of.precision
    every = tuple(dict.fromkeys([*state, *names]))
    values, errors = _values_and_errors(tables, every, times, references, end_errors)
    own = {name: errors[name] for name in state}
    digits = digits_over_rows(values, own, tables.of.start, precision.bits)
    seconds = numpy.array([float(t) for t in times])
    return {"t": seconds, **{name: errors[name] for name in names}, "digits": digits}


def _values_and_errors(
    tables: Tables,
    names: Sequence[str],
    times: Sequence[Fraction],
    references: Sequence[Reference],
    end_errors: Mapping[str, Scalar] | None = None,
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Float64 columns at ``times``, and how far each is at most from those of ``references`` (SI).

    NaN where a value is undefined; infinite where a reference has ended in another way.
    ``end_errors`` are given where the model ends before its horizon, at the last of the times:
    each run has an end of its own there.
    """
    import numpy

    references = list(references)
    fast = all(one.in_long_double for one in (tables, *(r.tables for r in references)))
    read = _in_long_double if fast else _native
    own = read(tables, names, times)
    found = {name: numpy.zeros(len(times)) for name in names}
    for reference in references:
        inner = list(times if end_errors is None else times[:-1])
        end = reference.end  # two runs to one horizon differ by roundings
        while inner and inner[-1] > end and not math.isclose(inner[-1], end, rel_tol=1e-15):
            inner.pop()
        others = read(reference.tables, names, inner)
        for name in names:
            apart = numpy.full(len(times), math.inf)
            own_values = own[name][: len(inner)]
            apart[: len(inner)] = distance(
                own_values, others[name], reference.tables.of.precision.context
            )
            if reference.ends_alike:
                rest = math.nan if end_errors is None else end_errors.get(name, math.nan)
                apart[len(inner) :] = float(rest)
            found[name] = numpy.fmax(found[name], apart)
    return {name: floats(own[name]) for name in names}, found


def floats(values: Array | Sequence[Scalar]) -> Array:
    """Numbers of any kind as a float64 array, with NaN where one is undefined."""
    import numpy

    if isinstance(values, numpy.ndarray) and values.dtype != object:
        return values.astype(float)
    return numpy.array([math.nan if _missing(v) else float(v) for v in values])


def _native(tables: Tables, names: Sequence[str], times: Sequence[Fraction]) -> dict[str, Array]:
    return tables.columns(names, times, "native")


def _in_long_double(
    tables: Tables, names: Sequence[str], times: Sequence[Fraction]
) -> dict[str, Array]:
    dense_output = tables.dense_output
    entries = dense_output.arrays(dense_output.times(times), long_double)
    return tables.of.of_arrays(names, entries, long_double)


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
