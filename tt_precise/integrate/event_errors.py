"""Errors of events: how far a reference run has its zeros from where a run has found them.

A reference run need not look for events: where its event function vanishes follows from its value
and slope at the run's time, by one step of Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tt_precise.arithmetic import Array, Scalar
from tt_precise.integrate.accuracy import digits_over_rows
from tt_precise.integrate.columns import Columns
from tt_precise.integrate.error_over_time import Reference, distance, floats
from tt_precise.integrate.events import EXTREMUM, Event, event_named
from tt_precise.integrate.system import Hit
from tt_precise.integrate.tables import Tables
from tt_precise.integrate.times import Times, long_double


def event_errors(tables: Tables, references: Sequence[Reference]) -> dict[str, Array]:
    """Of each event, in order of time: name, t, its error (s), and "digits".

    These are the significant ones of the worst entry of the state there, and of the time beside
    itself, or beside the unit of time where that is longer. An error is the largest of the
    distances from ``references``, infinite where one of them has ended before. In a motion of
    several pieces they are the events that join the pieces.
    """
    import numpy

    if tables.joints is not None:
        return _errors_of_joints(tables.joints, tables, references)
    hits = sorted(tables.dense_output.propagation.hits, key=lambda hit: hit.time)
    unit = float(tables.of.start.units.time)
    times = numpy.array([float(hit.time) for hit in hits]) * unit
    errors, digits = numpy.zeros(len(hits)), numpy.full(len(hits), math.inf)
    for name in dict.fromkeys(hit.name for hit in hits):
        places = [place for place, hit in enumerate(hits) if hit.name == name]
        event = event_named(name, tables.of.form.model)
        for reference in references:
            late, right = _beside(tables, [hits[place] for place in places], event, reference)
            errors[places] = numpy.maximum(errors[places], late)
            digits[places] = numpy.minimum(digits[places], right)
    most = tables.of.precision.bits * math.log10(2)
    digits = numpy.minimum(numpy.minimum(digits, digits_of_time(errors, times, unit)), most)
    names = numpy.array([hit.name for hit in hits], dtype=object)
    return {"name": names, "t": times, "error": errors, "digits": digits}


def digits_of_time(error: Array, time: Array, unit: float) -> Array:
    """Significant digits of a time, beside itself or the unit of time where that is longer."""
    import numpy

    with numpy.errstate(divide="ignore"):
        return numpy.maximum(-numpy.log10(error / numpy.maximum(time, unit)), 0.0)


def _errors_of_joints(
    joints: Sequence[tuple[str, Scalar]], tables: Tables, references: Sequence[Reference]
) -> dict[str, Array]:
    import numpy

    names, times = [name for name, _ in joints], [time for _, time in joints]
    errors = numpy.zeros(len(names))
    for reference in references:
        others = reference.tables.joints or ()
        alike = [name for name, _ in others] == names
        apart = (
            [float(abs(t - u)) for t, (_, u) in zip(times, others, strict=True)]
            if alike
            else math.inf
        )
        errors = numpy.maximum(errors, apart)
    t = numpy.array([float(time) for time in times])
    digits = digits_of_time(errors, t, float(tables.of.start.units.time))
    most = tables.of.precision.bits * math.log10(2)
    return {"name": numpy.array(names, dtype=object), "t": t, "error": errors,
            "digits": numpy.minimum(digits, most)}  # fmt: skip


def _beside(
    tables: Tables, hits: Sequence[Hit], event: Event, reference: Reference
) -> tuple[Array, Array]:
    """Distances in time (s), and digits of the states, of one event from those of a reference."""
    import numpy

    of, other = tables.of, reference.tables.of
    late, digits = numpy.full(len(hits), math.inf), numpy.zeros(len(hits))
    last = float(reference.end) / float(of.start.units.time)
    hits = [hit for hit in hits if float(hit.time) <= last]
    if not hits:
        return late, digits
    guarded = of.precision.guarded
    times = [other.precision.context.mpf(guarded(hit.time)) for hit in hits]
    delay, entries = _zeros(reference.tables, times, event)
    names, inner, in_arrays = of.names, slice(0, len(hits)), _in_arrays(reference.tables)
    number = long_double if in_arrays else of.precision.context.mpf
    own = tuple(zip(*([number(guarded(x)) for x in hit.state] for hit in hits), strict=True))
    values, others = (
        _columns(run, names, rows, in_arrays) for run, rows in ((of, own), (other, entries))
    )
    apart = {name: distance(values[name], others[name], other.precision.context) for name in names}
    floating = {name: floats(values[name]) for name in names}
    late[inner] = numpy.abs(floats(delay)) * float(of.start.units.time)
    digits[inner] = digits_over_rows(floating, apart, of.start.units, of.precision.bits)
    return numpy.where(numpy.isfinite(late), late, math.inf), digits


def _zeros(
    tables: Tables, times: Sequence[Scalar], event: Event
) -> tuple[Array, tuple[Array, ...]]:
    """How much later than ``times`` a run's event function vanishes, and the states there.

    By the parabola through three points, so far apart that a slope has two thirds of its digits.
    """
    import numpy

    apart = 2.0 ** (-(tables.of.precision.bits // 3))
    end = tables.dense_output.end_time
    middle = [min(max(time, apart), end - apart) for time in times]
    (before, early), (at, now), (behind, later) = (
        _evaluated(tables, event, [time + shift for time in middle])
        for shift in (-apart, 0.0, apart)
    )
    kind = numpy.longdouble if _in_arrays(tables) else object
    off = numpy.array([_number(tables, t - m) for t, m in zip(times, middle, strict=True)], kind)

    def slope(first: Array, last: Array) -> Array:
        return (last - first) / (2 * apart)

    def curvature(first: Array, centre: Array, last: Array) -> Array:
        return (last - 2 * centre + first) / (apart * apart)

    value, rate = slope(early, later), curvature(early, now, later)
    if not event.name.startswith(EXTREMUM) or event.slope:
        value, rate = now + off * (value + off * rate / 2), value + off * rate
    with numpy.errstate(all="ignore"):
        delay = -value / rate
        shift = off + delay
        rows = [
            x + shift * (slope(w, z) + shift * curvature(w, x, z) / 2)
            for w, x, z in zip(before, at, behind, strict=True)
        ]
    return delay, tuple(rows)


def _evaluated(
    tables: Tables, event: Event, times: Sequence[Scalar]
) -> tuple[tuple[Array, ...], Array]:
    import numpy

    of, dense_output = tables.of, tables.dense_output
    if _in_arrays(tables):
        rounded = numpy.array([float(time) for time in times])
        delay = numpy.array([float(t - float(t)) for t in times])
        entries = dense_output.arrays(Times(rounded, rounded, delay), long_double)
        return entries, event.function(of.array_motion(entries, long_double))
    rows = dense_output.rows(times)
    values = [event.function(of.motion(row)) for row in rows]
    return tuple(numpy.array(rows, dtype=object).T), numpy.array(values, dtype=object)


def _columns(
    of: Columns, names: Sequence[str], entries: Sequence[Sequence[Scalar]], in_arrays: bool
) -> Mapping[str, Sequence[Scalar]]:
    import numpy

    if in_arrays:
        rows = tuple(numpy.array(entry, dtype=numpy.longdouble) for entry in entries)
        return of.of_arrays(names, rows, long_double)
    return of.of_rows(names, list(zip(*entries, strict=True)))


def _in_arrays(tables: Tables) -> bool:
    return tables.in_long_double


def _number(tables: Tables, value: Scalar) -> Scalar:
    return long_double(value) if _in_arrays(tables) else value
