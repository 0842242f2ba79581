"""The states, columns, events and drifts of a ``Solution``.

A run in double is read in arrays of doubles, or of NumPy's long doubles where doubles are not
precise enough; other runs are read in arrays of numbers with guard bits (``mpfr``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from fractions import Fraction
from typing import Any, Literal, NamedTuple

import numpy

from tt_precise.integration.columns import POSE_NAMES, Name, State
from tt_precise.integration.events import ARRIVED
from tt_precise.integration.heyoka_backend import sample_times
from tt_precise.integration.precision import (
    DOUBLES,
    Hardware,
    functions_of,
    times_in,
)
from tt_precise.integration.solution import Segment, Solution
from tt_precise.mechanics.conserved import OF_QUANTITY, Integral, conserved, drift
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import Array, InputError, Scalar, wrong_name
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.scene.scene import RECORDABLE

Numbers = Literal["float", "exact", "text"]
DRIFT = "drift:"  # The name of a column of drifts begins so.
FALLING = -1  # the speed where the top sticks, the margin to the cone where it slips


class States(NamedTuple):
    """The states of a run within one segment: an array for each component.

    ``index`` are their positions among the times.
    """

    segment: Segment
    index: Array
    row: list[Array]


def columns_in(
    segment: Segment, names: Sequence[Name], row: Sequence[Array], numbers: Any
) -> dict[Any, Array]:
    """Compute named columns (SI) of states in an arithmetic of arrays."""
    number = float if numbers is DOUBLES else numbers.number
    return segment.columns.of_arrays(names, tuple(row), number, functions_of(numbers))


def rounding_of(numbers: Any) -> AbstractContextManager[Any]:
    """Return the context in which arrays of an arithmetic are read."""
    hardware = isinstance(numbers, Hardware)
    return numpy.errstate(all="ignore") if hardware else numbers.precision()


def at_times(run: Solution, times: Array, numbers: Any, *, samples: bool = False) -> list[States]:
    """Evaluate the states at dimensionless times, in an arithmetic of arrays."""
    which = numpy.zeros(len(times), dtype=int)
    for segment in run.segments[1:]:  # a common end belongs to the earlier segment
        which += (times > times_in(numbers, [segment.begin])[0]).astype(bool)
    parts = []
    for i in numpy.unique(which).tolist():
        segment, index = run.segments[i], numpy.flatnonzero(which == i)
        local = times[index] - times_in(numbers, [segment.begin])[0]
        parts.append(States(segment, index, segment.at(local, numbers, samples=samples)))
    return parts


def states_at(run: Solution, times: Sequence[Fraction] | Array, numbers: Any) -> list[States]:
    """Evaluate the states at exact times in s, in an arithmetic of arrays.

    Raises ``InputError``: a time lies outside the trajectory.
    """

    def compute() -> list[States]:
        hardware, whole = isinstance(numbers, Hardware), times is run.scene.sample_times
        with rounding_of(numbers):
            if hardware and whole:
                return at_times(run, sample_times(run.start, run.scene), numbers, samples=True)
            seconds = numbers.of_fractions(times)
            ends: Any = (numpy.min, numpy.max) if isinstance(times, numpy.ndarray) else (min, max)
            for end in ends:
                run.dimensionless_time(end(times))
            local = seconds / times_in(numbers, [run.start.units.time])[0]
            last = seconds.astype(float) >= float(run.end)
            if not run.precision.is_float:
                last = numpy.array([t >= as_fraction(run.end) for t in times], dtype=bool)
            local[last] = times_in(numbers, [run.end_time])[0]
            return at_times(run, local, numbers)

    if not len(times):
        return []
    own = times is run.sample_times
    return run.once((states_at, numbers), compute) if own else compute()


def states(run: Solution, times: Sequence[Scalar]) -> list[State]:
    """The states (SI) at dimensionless ``times`` (with guard bits)."""
    mpfr, to_user, unit = run.precision.mpfr, run.precision.to_user, run.start.units.time
    rows: list[Any] = [None] * len(times)
    with mpfr.precision():
        for part in at_times(run, mpfr.array(times), mpfr):
            table = columns_in(part.segment, run.columns.names, part.row, mpfr)
            columns = {name: list(map(mpfr.back, column)) for name, column in table.items()}
            for k, i in enumerate(part.index.tolist()):
                values = {name: to_user(column[k]) for name, column in columns.items()}
                rows[i] = State(to_user(times[i] * unit), values, run.precision)
    return rows


def end_state(run: Solution) -> State:
    """The state (SI) at the end."""
    return run.once(end_state, lambda: states(run, [run.end_time])[0])


def table(
    run: Solution,
    names: Sequence[Name],
    times: Sequence[Fraction] | Array | None = None,
    numbers: Numbers = "float",
) -> dict[Any, Array]:
    """``t`` and the named columns at exact ``times`` in s, by default at the samples.

    Numbers of double are a float64 array with NaN where a value is undefined; wider ones are an
    array of objects, and text is a list, with None there. With a pose that was not recorded the
    columns are those of a run that records it.
    """
    if any(name in POSE_NAMES and name not in run.setup.record for name in names):
        run = with_quadratures(run)
    times = run.sample_times if times is None else times
    arrays: Any = run.precision.numbers
    if run.precision.is_float and numbers != "text":
        arrays = DOUBLES
    kind = object if arrays is run.precision.mpfr else float
    columns: dict[Any, Any] = {name: numpy.empty(len(times), dtype=kind) for name in names}
    for name in names:
        run.columns.dimension(name)
    with rounding_of(arrays):
        for segment, index, row in states_at(run, times, arrays):
            for name, values in columns_in(segment, names, row, arrays).items():
                columns[name][index] = values
        t = seconds_of(run, times) if run.precision.is_float else arrays.of_fractions(times)
        every = {"t": t, **columns}
        return {name: converted(run, values, numbers) for name, values in every.items()}


def with_quadratures(run: Solution) -> Solution:
    """The run with phi, psi, x and y recorded; integrated again if necessary.

    Raises ``InputError``: the axis is exactly vertical at some time.
    """
    if set(RECORDABLE) <= set(run.setup.record):
        return run
    if not run.scene.start.theta.at_pole:
        again = run.once(with_quadratures, lambda: run.again(record=RECORDABLE, events=()))
        if again.status == run.status:
            return again
    raise InputError(
        "pose: got an axis that is exactly vertical at some time, where phi and psi are "
        "undefined; expected another scene"
    )


def seconds_of(run: Solution, times: Sequence[Fraction] | Array) -> Array:
    """Return exact times in s as doubles."""

    def compute() -> Array:
        return numpy.array([float(t) for t in times])

    own = times is run.scene.sample_times
    return run.start.once("seconds", compute) if own else compute()


def converted(run: Solution, values: Array, numbers: Numbers) -> Array:
    """Convert an array in which a run is read for users."""
    precision = run.precision
    if numbers == "float" or precision.is_float:
        doubles = values.astype(float)
        doubles = numpy.where(numpy.isfinite(doubles), doubles, numpy.nan) + 0.0  # no -0.0
        return shortest_texts(doubles) if numbers == "text" else doubles
    if numbers == "text":
        return precision.mpfr.texts(values, precision.decimals)
    return objects(map(precision.mpfr.back, values))


def floats(values: Any) -> Array:
    """Return numbers of any kind as doubles, with NaN for undefined values."""
    if isinstance(values, numpy.ndarray) and values.dtype != object:
        return values.astype(float)
    return numpy.array([numpy.nan if x is None else float(x) for x in values], dtype=float)


def objects(values: Iterable[Any]) -> Array:
    """Return an array of objects."""
    every = list(values)
    array = numpy.empty(len(every), dtype=object)
    array[:] = every
    return array


def event_columns(run: Solution, names: Sequence[Name]) -> dict[Any, Array]:
    """Columns of the events in order of time: name, t, direction, and the columns ``names``.

    An event that ends a segment has the values just before it.
    """
    for name in names:
        if is_drift(name):
            also = ", pose, digits or error:NAME; frame(...) has drifts"
            raise wrong_name("column", name, run.columns.dimensions, also)
        run.columns.dimension(name)  # refuses an unknown name where there are no events too
    arrays: Any = run.precision.numbers
    none, empty = numpy.empty(0), numpy.empty(0, dtype=object)
    columns: dict[Any, list[Array]] = {
        "name": [empty], "t": [none], "direction": [none], **{name: [none] for name in names}
    }  # fmt: skip
    with rounding_of(arrays):
        unit = arrays.number(run.start.units.time)
        for segment in run.segments:
            hits, begin = segment.run.events.hits, arrays.number(segment.begin)
            rows = [(hits.name, hits.time, hits.direction, hits.state)]
            if segment.ended:
                end = tuple(arrays.array([x]) for x in segment.end_row)
                time = arrays.array([segment.end_time])
                rows.append((objects([segment.ended]), time, numpy.array([FALLING]), end))
            for name, time, direction, state in rows:
                table = {"name": name, "t": (time + begin) * unit, "direction": direction}
                if len(name):
                    table |= columns_in(segment, names, state, arrays)
                    for column, values in table.items():
                        columns[column].append(values)
        whole = {name: numpy.concatenate(column) for name, column in columns.items()}
        fixed = {"name": whole.pop("name"), "direction": whole.pop("direction").astype(int)}
        shown = fixed | {name: converted(run, x, "exact") for name, x in whole.items()}
        return {name: shown[name] for name in columns}


# ---- conserved quantities -----------------------------------------------------------------------


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
    conserved = {name for law in integrals(run) for name in (law.name, *law.quantities)}
    drifts = (str(name) for name in names if is_drift(name))
    others = [name for name in drifts if name.removeprefix(DRIFT) not in conserved]
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
    """Relative change since the start of each conserved quantity, at ``sample_times``."""
    return Drifts((name, converted(run, values, "exact")) for name, values in _drifts(run).items())


def _drifts(run: Solution) -> dict[str, Array]:
    """Return the drifts in the arithmetic in which the run is read."""
    arrays: Any = run.precision.numbers
    fn, count = functions_of(arrays), len(run.sample_times)
    kind = arrays.kind if isinstance(arrays, Hardware) else object
    drifts = {each.name: numpy.empty(count, dtype=kind) for each in integrals(run)}
    with rounding_of(arrays):
        first = run.segments[0]
        start = tuple(arrays.array([x]) for x in first.start_row)
        begin = first.columns.array_motion(start, arrays.number, fn)
        for segment, index, row in states_at(run, run.sample_times, arrays):
            if index[-1] == count - 1 and run.status not in ARRIVED:
                row = [x.copy() for x in row]
                for x, value in zip(row, segment.end_row, strict=True):
                    x[-1] = arrays.number(value)
            q = segment.columns.array_motion(tuple(row), arrays.number, fn)
            for each in integrals(run):
                drifts[each.name][index] = drift(each, [begin, q])[1] + 0 * row[0]
    return drifts


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
    drifts = _drifts(run)
    for integral in integrals(run):
        drifts |= dict.fromkeys(integral.quantities, drifts[integral.name])
    columns: dict[str, Any] = {}
    for name in names:
        quantity = name.removeprefix(DRIFT)
        if quantity not in drifts and quantity not in QUANTITIES:
            also, expected = ", or a quantity such as E or D", f"{DRIFT} and one of: "
            raise wrong_name("column", name, drifts, also, expected=expected)
        values = drifts[quantity] if quantity in drifts else _changes(run, quantity)
        columns[name] = converted(run, values, numbers)
    return columns


def _changes(run: Solution, name: str) -> Array:
    values = table(run, [name], None, "exact")[name]
    sizes = [abs(value) for value in values if value is not None and value == value]
    scale = (values[0] and abs(values[0])) or max(sizes, default=0) or 1
    apart = [value if value is None else abs(value - values[0]) / scale for value in values]
    return run.precision.numbers.array(apart)
