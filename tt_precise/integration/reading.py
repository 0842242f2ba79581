"""The rows, columns, events and drifts of a ``Solution``.

All rows of a segment are read at once. Where doubles are not precise enough, a run in double uses
NumPy's long double; the other precisions use arrays of numbers with guard bits (``mpfr``).
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from fractions import Fraction
from typing import Any, Literal

import numpy

from tt_precise.integration.columns import POSE_NAMES, Name, Row, State
from tt_precise.integration.dense_output import ARRIVED, Segment, is_doubles, long_double
from tt_precise.integration.solution import Solution
from tt_precise.mechanics.conserved import OF_QUANTITY, Integral, conserved, drift
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, InputError, Scalar, wrong_name
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.scene.scene import RECORDABLE

Numbers = Literal["float", "exact", "text"]
DRIFT = "drift:"  # The name of a column of drifts begins so.
FALLING = -1  # the speed where the top sticks, the margin to the cone where it slips


def rows(run: Solution, times: Sequence[Scalar]) -> list[tuple[Segment, Row]]:
    """Rows at dimensionless ``times`` (with guard bits), and their segments."""
    if run.alone:
        return [(run.alone, row) for row in run.alone.output.rows(times)]
    found = []
    for time in times:
        segment = run.segments[run.segment_at(time)]
        output = segment.output
        if segment is run.segments[-1] and time == run.end_time:
            found.append((segment, output.end_row))
        else:
            found.append((segment, output.rows([min(time - segment.begin, output.end_time)])[0]))
    return found


def states(run: Solution, times: Sequence[Scalar]) -> list[State]:
    """The states (SI) at dimensionless ``times`` (with guard bits)."""
    here = rows(run, times)
    if run.alone:
        return run.columns.states(times, [row for _, row in here])
    return [
        segment.columns.states([time], [row])[0]
        for time, (segment, row) in zip(times, here, strict=True)
    ]


def end_state(run: Solution) -> State:
    """The state (SI) at the end."""
    return run.once(end_state, lambda: states(run, [run.end_time])[0])


def values_at_end(run: Solution) -> dict[str, Scalar]:
    """``t_end`` (s) and the components of the state at ``t_end`` (SI), by name."""
    return {"t_end": run.t_end, **end_state(run).values}


def motions(run: Solution, times: Sequence[Scalar]) -> list[Motion]:
    """The motions at dimensionless ``times`` (with guard bits)."""
    return [segment.columns.motion(row) for segment, row in rows(run, times)]


def table(
    run: Solution,
    wanted: Sequence[Name],
    times: Sequence[Fraction] | Array | None = None,
    numbers: Numbers = "float",
    progress: Progress | None = None,
) -> dict[Any, Array]:
    """Columns by default at the samples; integrate again for a pose that was not recorded."""
    exact: Sequence[Fraction] | Array
    exact = run.sample_times if times is None else times
    missing = [name for name in wanted if name in POSE_NAMES and name not in run.setup.record]
    if not missing:
        return own_table(run, wanted, exact, numbers, progress)
    posed = with_quadratures(run)
    plain = [name for name in wanted if name not in missing]
    exact = _fractions(exact)
    columns = own_table(run, plain, exact, numbers)
    columns = own_table(posed, missing, _alike(exact, run, posed), numbers) | columns
    return {name: columns[name] for name in ("t", *wanted)}


def _fractions(times: Sequence[Fraction] | Array) -> Sequence[Fraction]:
    return tuple(map(as_fraction, times.tolist())) if is_doubles(times) else times


def _alike(times: Sequence[Fraction], run: Solution, other: Solution) -> tuple[Fraction, ...]:
    """``times`` in another run of the scene; the end of this run becomes that run's end."""
    if run.status in ARRIVED:
        return tuple(times)
    end, later = as_fraction(run.end), as_fraction(other.end)
    return tuple(later if t >= end else t for t in times)


def with_quadratures(run: Solution) -> Solution:
    """The run with phi, psi, x and y recorded; integrated again if necessary.

    Raises ``InputError``: the axis is exactly vertical at some time.
    """
    return run.once(with_quadratures, lambda: _recording(run))


def _recording(run: Solution) -> Solution:
    if set(RECORDABLE) <= set(run.setup.record):
        return run
    if not run.scene.start.theta.at_pole:
        again = run.again(record=RECORDABLE, events=())
        if again.status == run.status:
            return again
    raise InputError(
        "pose: got an axis that is exactly vertical at some time, where phi and psi are "
        "undefined; expected another scene"
    )


def own_table(
    run: Solution,
    names: Sequence[Name],
    times: Sequence[Fraction] | Array,
    numbers: Numbers,
    progress: Progress | None = None,
) -> dict[Any, Array]:
    """``t`` and the named columns at exact ``times`` in s.

    Numbers of double are a float64 array with NaN where a value is undefined; wider ones, and
    text, are a list or an array of objects with None there.
    """
    if run.alone and run.in_arrays:
        return _array_columns(run.alone, names, times, numbers, progress)
    times = _fractions(times)
    if run.alone:
        return _of_segment(run, run.alone, names, times, numbers, progress)

    parts, order = [], []
    for segment, places in _groups(run, times):
        local = [_local(segment, times[i]) for i in places]
        parts.append(_of_segment(run, segment, names, local, numbers))
        order += places
    back = numpy.argsort(order).tolist()
    columns: dict[Any, Any] = {}
    for name in ("t", *names):
        values = [x for part in parts for x in part[name]] if parts else []
        columns[name] = [values[i] for i in back]
    columns["t"] = _seconds(run, times, numbers)
    if numbers == "text":
        return columns
    double = numbers == "float" or run.precision.is_float
    return {n: numpy.array(c, dtype=float if double else object) for n, c in columns.items()}


def _of_segment(
    run: Solution,
    segment: Segment,
    names: Sequence[Name],
    times: Sequence[Fraction],
    numbers: Numbers,
    progress: Progress | None = None,
) -> dict[Any, Array]:
    """The columns of one segment, over its own time."""
    if run.in_arrays:
        return _array_columns(segment, names, times, numbers, progress)
    mpfr = run.precision.mpfr
    with mpfr.precision():
        seconds = mpfr.of_fractions(times)
        entries = segment.output.mpfr_arrays(seconds, progress)
        columns = segment.columns.of_arrays(names, entries, mpfr.number, mpfr)
        table = {"t": seconds, **columns}
        return {name: _converted(run, values, numbers) for name, values in table.items()}


def _groups(run: Solution, times: Sequence[Fraction]) -> Iterable[tuple[Segment, list[int]]]:
    groups: dict[int, list[int]] = {}
    for i, time in enumerate(times):
        groups.setdefault(run.segment_at(run.dimensionless_time(time)), []).append(i)
    return [(run.segments[place], groups[place]) for place in sorted(groups)]


def _seconds(run: Solution, times: Sequence[Fraction], numbers: Numbers) -> Array:
    if run.precision.is_float:
        plain = list(map(float, times))
        return shortest_texts(plain) if numbers == "text" else plain
    return _converted(run, run.precision.mpfr.of_fractions(times), numbers)


def _converted(run: Solution, values: Array, numbers: Numbers) -> Array:
    precision = run.precision
    if numbers == "text":
        return precision.mpfr.texts(values, precision.decimals)
    if numbers == "float" or precision.is_float:
        floats = values.astype(float)
        return numpy.where(numpy.isfinite(floats), floats, numpy.nan) + 0.0  # no minus before zero
    return numpy.array(list(map(precision.mpfr.back, values)), dtype=object)


def event_columns(
    run: Solution, names: Sequence[Name], at: Container[str] | None = None
) -> dict[Any, Array]:
    """Columns of the events in order of time: name, t, direction, and the columns ``names``.

    An event that ends a segment has the values just before it. In wide arithmetics, where
    quantities are slow, only ``at`` the events of these names, if given; elsewhere they are
    missing.
    """
    for name in names:
        if is_drift(name):
            also = ", pose, digits or error:NAME; frame(...) has drifts"
            raise wrong_name("column", name, run.columns.dimensions, also)
        run.columns.dimension(name)  # refuses an unknown name where there are no events too
    if run.alone:
        return _events_of_segment(run, run.alone, names, at)
    context, to_user = run.precision.context, run.columns.to_user
    columns: dict[Any, Array] = {name: [] for name in ("name", "t", "direction", *names)}
    for segment in run.segments:
        happened = _events_of_segment(run, segment, names, at)
        happened["t"] = [to_user(context.mpf(t) + segment.begin_s) for t in happened["t"]]
        for name, column in columns.items():
            column += list(happened[name])
        if segment.ended:
            values = segment.columns.of_rows(names, [segment.output.end_row])
            columns["name"].append(segment.ended)
            columns["t"].append(to_user(segment.end_s))
            columns["direction"].append(FALLING)
            for name, (value,) in values.items():
                columns[name].append(to_user(value))
    return columns


def _events_of_segment(
    run: Solution, segment: Segment, names: Sequence[Name], at: Container[str] | None
) -> dict[Any, Array]:
    of, unit = segment.columns, segment.output.start.units.time
    hits = segment.output.propagation.found.hits
    columns: dict[Any, Array] = {"name": hits.name.tolist()}
    if run.in_arrays and len(hits):
        entries = tuple(hits.state.T.astype(numpy.longdouble))
        times = hits.time.astype(numpy.longdouble) * long_double(unit)
        columns |= {"t": times.astype(float), "direction": hits.direction}
        values = of.of_arrays(names, entries, long_double)
        return columns | {name: column.astype(float) for name, column in values.items()}
    mpf, to_user = run.precision.context.mpf, of.to_user
    columns["t"] = [to_user(mpf(time) * unit) for time in hits.time.tolist()]
    columns["direction"] = hits.direction.astype(int)
    asked = [bool(names) and (at is None or name in at) for name in columns["name"]]
    states = [tuple(map(mpf, state)) for state in hits.state[asked].tolist()]
    for name, column in of.of_rows(names, states).items():
        shown = map(to_user, column)
        columns[name] = [next(shown) if wanted else None for wanted in asked]
    return columns


def integrals(run: Solution) -> list[Integral]:
    """The integrals of the motion that the run's state determines."""
    return [
        integral
        for integral in conserved(run.scene.model, run.scene.body)
        if run.columns.has_azimuth or not integral.azimuth
        if run.setup.formulation.coordinates == "newton" or integral.name != "axis_norm"
    ]


def changes(run: Solution, names: Iterable[Name]) -> str:
    """Return a sentence on the drifts in ``names`` of what the motion does not conserve, or ""."""
    known = {name for one in integrals(run) for name in (one.name, *one.quantities)}
    drifts = (str(name) for name in names if is_drift(name))
    others = [name for name in drifts if name.removeprefix(DRIFT) not in known]
    if not others:
        return ""
    kept = ", ".join(integral.name for integral in integrals(run))
    return f"{', '.join(others)}: changes since the start, no errors; this motion conserves {kept}"


class Drifts(dict[str, Any]):
    """Values by the names of integrals, also found by their quantities: lambda, E, D."""

    def __missing__(self, name: str) -> Any:
        integral = OF_QUANTITY.get(name, "")
        if integral in self:
            return self[integral]
        raise KeyError(str(wrong_name("drift", name, self, f'; frame("{DRIFT}E") has any change')))


def drift_over_time(run: Solution) -> Drifts:
    """Relative change since the start of each conserved quantity, at ``sample_times``.

    In double a float64 array for each, otherwise a list of mpmath numbers.
    """
    times, output = run.sample_times, run.segments[0].output
    if not (run.in_arrays and run.alone):
        zero = run.start.until * 0
        inner = [zero, *map(run.dimensionless_time, times[:-1]), run.end_time]
        along = motions(run, inner)
        return Drifts((each.name, drift(each, along)[1:]) for each in integrals(run))

    entries = output.arrays(output.times(times), long_double)
    if run.status not in ARRIVED:
        for entry, value in zip(entries, output.end_row, strict=True):
            entry[-1] = long_double(value)
    start = tuple(map(long_double, output.start_row))
    both = [run.columns.array_motion(there, long_double) for there in (start, entries)]
    ones = numpy.ones(len(times))  # an integral may be one number for all rows
    return Drifts(
        (each.name, (drift(each, both)[1] * ones).astype(float)) for each in integrals(run)
    )


def is_drift(name: Name) -> bool:
    """Return whether a column is the drift of a quantity, such as "drift:jellett"."""
    return isinstance(name, str) and name.startswith(DRIFT)


def drift_columns(
    run: Solution, names: Iterable[str], numbers: Numbers = "float"
) -> dict[str, Array]:
    """The relative drifts of the columns "drift:NAME" at the samples.

    NAME is an integral of the motion or a quantity with its value, whose drift is computed in finer
    arithmetic, or any quantity: the change since the start over its value there, or over its
    largest value if it starts at 0 (``changes``).

    Raises ``InputError``: there is no such quantity.
    """
    known = dict(drift_over_time(run))
    for integral in integrals(run):
        known |= dict.fromkeys(integral.quantities, known[integral.name])
    columns: dict[str, Any] = {}
    for name in names:
        wanted = name.removeprefix(DRIFT)
        if wanted not in known and wanted not in QUANTITIES:
            also, expected = ", or a quantity such as E or D", f"{DRIFT} and one of: "
            further = (f"{DRIFT}{one}" for one in (*known, *QUANTITIES))
            raise wrong_name("column", name, known, also, expected=expected, further=further)
        values = known[wanted] if wanted in known else _changes(run, wanted)
        if numbers == "text" and not run.precision.is_float:
            columns[name] = list(map(run.precision.text, values))
        elif numbers == "exact":
            columns[name] = values
        else:
            doubles = numpy.array(values, dtype=float)
            columns[name] = shortest_texts(doubles) if numbers == "text" else doubles
    return columns


def _changes(run: Solution, name: str) -> Array:
    values = own_table(run, [name], run.sample_times, "exact")[name]
    known = [abs(value) for value in values if value is not None and value == value]
    scale = (values[0] and abs(values[0])) or max(known, default=0) or 1
    return numpy.array([v if v is None else abs(v - values[0]) / scale for v in values])


def _local(segment: Segment, time: Fraction) -> Fraction:
    """A time since the start of a segment, never rounded beyond the segment's end."""
    since = max(time - as_fraction(segment.begin_s), Fraction(0))
    return min(since, as_fraction(segment.output.end))


def _array_columns(
    segment: Segment,
    names: Sequence[Name],
    exact: Sequence[Fraction] | Array,
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
