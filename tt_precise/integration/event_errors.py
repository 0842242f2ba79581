"""Errors of events: how far a reference run has its zeros from where a run has found them.

A reference run need not look for events: where its event function vanishes follows from its value
and slope at the run's time, by one step of Newton's method.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from tt_precise.integration.columns import Columns, digits_of_time, digits_over_rows
from tt_precise.integration.dense_output import Times, long_double
from tt_precise.integration.events import Event, Hit
from tt_precise.integration.reading import Reference, distance, floats
from tt_precise.integration.segments import Run, Segment
from tt_precise.runtime.arithmetic import Array, Scalar

GLIDING = ("vx", "vy", "nu_x", "nu_y")


class Part(NamedTuple):
    """A segment, the events that joined those before it, and the one that ends it, if any."""

    one: Segment
    before: tuple[str, ...]
    ended: str


def _parts(run: Run) -> list[Part]:
    found: list[Part] = []
    before: tuple[str, ...] = ()
    for one in run.segments:
        ended = "" if one is run.segments[-1] else one.ended
        found.append(Part(one, before, ended))
        before += (ended,) if ended else ()
    return found


def event_errors(run: Run, references: Sequence[Reference]) -> dict[str, Array]:
    """Of each event, in order of time: name, t, its error (s), and "digits".

    These are the significant ones of the worst entry of the state there, and of the time beside
    itself, or beside the unit of time where that is longer. An error is the largest of the
    distances from ``references``, infinite where one of them has ended before, or is in another
    part of its motion.
    """
    import numpy

    unit = float(run.start.units.time)
    others = [(reference, _parts(reference.reader.run)) for reference in references]
    names: list[str] = []
    columns: list[tuple[Array, Array, Array]] = []
    for part in _parts(run):
        hits = sorted(part.one.output.propagation.hits, key=lambda hit: hit.time)
        names += [hit.name for hit in hits]
        columns.append(_errors_within(part, hits, others))
        if part.ended:
            names.append(part.ended)
            columns.append(_errors_of_joint(part, [parts for _, parts in others]))
    times, errors, digits = (numpy.concatenate(column) for column in zip(*columns, strict=True))
    most = run.precision.bits * math.log10(2)
    digits = numpy.minimum(numpy.minimum(digits, digits_of_time(errors, times, unit)), most)
    found = numpy.array(names, dtype=object)
    return {"name": found, "t": times, "error": errors, "digits": digits}


def _errors_within(
    part: Part,
    hits: Sequence[Hit],
    others: Sequence[tuple[Reference, Sequence[Part]]],
) -> tuple[Array, Array, Array]:
    """Times and errors (s) of what happens inside a part, and digits of the states there."""
    import numpy

    of = part.one.columns
    unit = float(of.start.units.time)
    times = numpy.array([float(part.one.begin) + float(hit.time) for hit in hits]) * unit
    errors, digits = numpy.zeros(len(hits)), numpy.full(len(hits), math.inf)
    for reference, parts in others:
        alike: dict[tuple[str, int], list[int]] = {}
        begins = [float(one.one.begin) * unit for one in parts]
        for place, hit in enumerate(hits):
            at = max(bisect.bisect_left(begins, times[place]) - 1, 0)
            alike.setdefault((hit.name, at), []).append(place)
        for (name, at), places in alike.items():
            event = part.one.output.setup.watched[name]
            there = [hits[place] for place in places]
            late, right = _beside(part, there, event, parts[at], float(reference.end) / unit)
            errors[places] = numpy.maximum(errors[places], late)
            digits[places] = numpy.minimum(digits[places], right)
    return times, errors, digits


def _errors_of_joint(part: Part, others: Sequence[Sequence[Part]]) -> tuple[Array, Array, Array]:
    """Time and error (s) of the event that ends a part, and digits of the state there."""
    import numpy

    of = part.one.columns
    time, state = _end(part)
    error, digits = 0.0, math.inf
    for parts in others:
        same = [p for p in parts if (p.before, p.ended) == (part.before, part.ended)]
        if not same:
            error, digits = math.inf, 0.0
            continue
        other_time, other_state = _end(same[0])
        error = max(error, float(abs(time - other_time)))
        context = of.precision.context
        apart = {name: distance(state[name], other_state[name], context) for name in state}
        values = {name: floats(column) for name, column in state.items()}
        found = digits_over_rows(values, apart, of.start, of.precision.bits)
        digits = min(digits, float(found[0]))
    return numpy.array([float(time)]), numpy.array([error]), numpy.array([digits])


def _end(part: Part) -> tuple[Scalar, Mapping[str, Sequence[Scalar | None]]]:
    """The time (s) at which a part ends, and the columns of the state there."""
    of, output = part.one.columns, part.one.output
    time = (part.one.begin + output.end_time) * of.start.units.time
    state = of.of_rows(of.names, [output.end_row])
    if part.ended == "stick":  # at rest; what is left of v_A says how small a speed counts as none
        state |= {name: [time * 0] for name in GLIDING if name in state}
    return time, state


def _beside(
    part: Part, hits: Sequence[Hit], event: Event, other_part: Part, last: float
) -> tuple[Array, Array]:
    """Distances in time (s), and digits of the states, of one event from those of a reference.

    That ends at the time ``last`` (dimensionless).
    """
    import numpy

    of, other = part.one.columns, other_part.one.columns
    late, digits = numpy.full(len(hits), math.inf), numpy.zeros(len(hits))
    hits = [hit for hit in hits if float(part.one.begin) + float(hit.time) <= last]
    if not hits or part.before != other_part.before:
        return late, digits
    guarded, mpf = of.precision.guarded, other.precision.context.mpf
    shift = mpf(part.one.begin) - mpf(other_part.one.begin)
    delay, entries = _zeros(other_part.one, [mpf(guarded(hit.time)) + shift for hit in hits], event)
    names, inner, in_arrays = of.names, slice(0, len(hits)), _in_arrays(other_part.one)
    number = long_double if in_arrays else of.precision.context.mpf
    own = tuple(zip(*([number(guarded(x)) for x in hit.state] for hit in hits), strict=True))
    values, others = (
        _columns(run, names, rows, in_arrays) for run, rows in ((of, own), (other, entries))
    )
    apart = {name: distance(values[name], others[name], other.precision.context) for name in names}
    floating = {name: floats(values[name]) for name in names}
    late[inner] = numpy.abs(floats(delay)) * float(of.start.units.time)
    digits[inner] = digits_over_rows(floating, apart, of.start, of.precision.bits)
    return numpy.where(numpy.isfinite(late), late, math.inf), digits


def _zeros(one: Segment, times: Sequence[Scalar], event: Event) -> tuple[Array, tuple[Array, ...]]:
    """How much later than ``times`` a run's event function vanishes, and the states there.

    By the parabola through three points, so far apart that a slope has two thirds of its digits.
    """
    import numpy

    apart = 2.0 ** (-(one.columns.precision.bits // 3))
    end = one.output.end_time
    middle = [min(max(time, apart), end - apart) for time in times]
    (before, early), (at, now), (behind, later) = (
        _evaluated(one, event, [time + shift for time in middle]) for shift in (-apart, 0.0, apart)
    )
    kind = numpy.longdouble if _in_arrays(one) else object
    off = numpy.array([_number(one, t - m) for t, m in zip(times, middle, strict=True)], kind)

    def slope(first: Array, last: Array) -> Array:
        return (last - first) / (2 * apart)

    def curvature(first: Array, centre: Array, last: Array) -> Array:
        return (last - 2 * centre + first) / (apart * apart)

    value, rate = slope(early, later), curvature(early, now, later)
    if not event.of_rate:
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
    one: Segment, event: Event, times: Sequence[Scalar]
) -> tuple[tuple[Array, ...], Array]:
    import numpy

    of, dense_output = one.columns, one.output
    if _in_arrays(one):
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


def _in_arrays(one: Segment) -> bool:
    return one.output.precision.in_long_double


def _number(one: Segment, value: Scalar) -> Scalar:
    return long_double(value) if _in_arrays(one) else value
