"""The states, columns, events and drifts of a ``Solution``.

A run in double is read in arrays of doubles, or of NumPy's long doubles where doubles are not
precise enough; other runs are read in arrays of numbers with guard bits (``mpfr``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager
from fractions import Fraction
from typing import Any, Literal, NamedTuple

import numpy

from tt_precise.integration.columns import POSE_NAMES, Name, State, vertical
from tt_precise.integration.events import ARRIVED
from tt_precise.integration.heyoka_backend import sample_times
from tt_precise.integration.precision import DOUBLES, Hardware, times_in
from tt_precise.integration.solution import Segment, Solution
from tt_precise.integration.zeros import Hits
from tt_precise.mechanics.conserved import OF_QUANTITY, Integral, conserved, drift
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import Array, Scalar, wrong_name
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
    row: Sequence[Array]


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
        with rounding_of(numbers):
            if isinstance(numbers, Hardware) and times is run.scene.sample_times:
                return at_times(run, sample_times(run.start, run.scene), numbers, samples=True)
            array = numpy.asarray(times)
            for extreme in (array.min(), array.max()):
                run.dimensionless_time(extreme)
            seconds = numbers.of_fractions(times)
            local = seconds / times_in(numbers, [run.start.units.time])[0]
            if run.precision.is_float:
                last = seconds.astype(float) >= float(run.end)
            else:
                last = numpy.array([t >= as_fraction(run.end) for t in times], dtype=bool)
            local[last] = times_in(numbers, [run.end_time])[0]
            return at_times(run, local, numbers)

    if not len(times):
        return []
    own = times is run.sample_times
    return run.once((states_at, numbers), compute) if own else compute()


def state_at(run: Solution, time: Scalar) -> State:
    """The state (SI) at a dimensionless ``time`` (with guard bits)."""
    precision, mpfr = run.precision, run.precision.mpfr
    with mpfr.precision():
        ((segment, _, row),) = at_times(run, mpfr.array([time]), mpfr)
        columns = segment.columns.of_arrays(run.columns.names, row, mpfr)
        values = {name: precision.to_user(mpfr.back(x[0])) for name, x in columns.items()}
    return State(precision.to_user(time * run.start.units.time), values, precision)


def end_state(run: Solution) -> State:
    """The state (SI) at the end."""
    return run.once(end_state, lambda: state_at(run, run.end_time))


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
    is_float = run.precision.is_float
    arrays: Any = DOUBLES if is_float and numbers != "text" else run.precision.numbers
    columns = _columns(run, names, times, arrays)
    with rounding_of(arrays):
        t = numpy.array(times, dtype=float) if is_float else arrays.of_fractions(times)
        every = {"t": t, **columns}
        return {name: converted(run, values, numbers) for name, values in every.items()}


def _columns(
    run: Solution, names: Sequence[Name], times: Sequence[Fraction] | Array, arrays: Any
) -> dict[Any, Array]:
    """Return named columns in an arithmetic of arrays."""
    kind = arrays.kind if isinstance(arrays, Hardware) else object
    columns: dict[Any, Any] = {name: numpy.empty(len(times), dtype=kind) for name in names}
    for name in names:
        run.columns.dimension(name)  # refuses an unknown name where there are no times too
    with rounding_of(arrays):
        for segment, index, row in states_at(run, times, arrays):
            for name, values in segment.columns.of_arrays(names, row, arrays).items():
                columns[name][index] = values
    return columns


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
    raise vertical()


def converted(run: Solution, values: Array, numbers: Numbers) -> Array:
    """Convert an array in which a run is read for users."""
    precision = run.precision
    if numbers == "float" or precision.is_float:
        doubles = values.astype(float)
        doubles = numpy.where(numpy.isfinite(doubles), doubles, numpy.nan) + 0.0  # no -0.0
        return shortest_texts(doubles) if numbers == "text" else doubles
    if numbers == "text":
        return precision.mpfr.texts(values, precision.decimals)
    return numpy.array(list(map(precision.mpfr.back, values)), dtype=object)


# ---- events -------------------------------------------------------------------------------------


def events_of(run: Solution) -> Iterator[tuple[Segment, Hits]]:
    """Yield the events inside each segment, then the one that ends it, with the state before it."""
    arrays: Any = run.precision.numbers
    for segment in run.segments:
        yield segment, segment.run.events.hits
        if segment.ended:
            name, direction = numpy.array([segment.ended], dtype=object), numpy.array([FALLING])
            time, *state = (arrays.array([x]) for x in (segment.end_time, *segment.end_row))
            yield segment, Hits(name, time, direction, tuple(state))


def event_columns(run: Solution, names: Sequence[Name]) -> dict[Any, Array]:
    """Columns of the events in order of time: name, t, direction, and the columns ``names``.

    An event that ends a segment has the values just before it.
    """
    for name in names:
        run.columns.dimension(name)  # refuses an unknown name where there are no events too
    arrays: Any = run.precision.numbers
    kinds: dict[Any, type] = {"name": object, "direction": int}
    columns: dict[Any, list[Array]] = {
        name: [numpy.empty(0, dtype=kinds.get(name, float))]
        for name in ("name", "t", "direction", *names)
    }
    with rounding_of(arrays):
        unit = arrays.number(run.start.units.time)
        for segment, hits in events_of(run):
            if len(hits):
                t = (hits.time + arrays.number(segment.begin)) * unit
                rows = {"name": hits.name, "t": t, "direction": hits.direction}
                rows |= segment.columns.of_arrays(names, hits.state, arrays)
                for name, values in rows.items():
                    columns[name].append(values)
        whole = {name: numpy.concatenate(column) for name, column in columns.items()}
        return {n: x if n in kinds else converted(run, x, "exact") for n, x in whole.items()}


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
    laws = integrals(run)
    conserved = {f"{DRIFT}{name}" for law in laws for name in (law.name, *law.quantities)}
    others = [str(name) for name in names if is_drift(name) and name not in conserved]
    kept = ", ".join(law.name for law in laws)
    text = f"{', '.join(others)}: changes since the start, no errors; this motion conserves {kept}"
    return text if others else ""


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


def _drifts(run: Solution) -> Drifts:
    """Return the drifts in the arithmetic in which the run is read."""
    arrays: Any = run.precision.numbers
    count, first, laws = len(run.sample_times), run.segments[0], integrals(run)
    kind = arrays.kind if isinstance(arrays, Hardware) else object
    drifts = Drifts((law.name, numpy.empty(count, dtype=kind)) for law in laws)
    with rounding_of(arrays):
        begin = first.columns.array_motion([arrays.array([x]) for x in first.start_row], arrays)
        for segment, index, row in states_at(run, run.sample_times, arrays):
            if index[-1] == count - 1 and run.status not in ARRIVED:
                row = [x.copy() for x in row]
                for x, value in zip(row, segment.end_row, strict=True):
                    x[-1] = arrays.number(value)
            q = segment.columns.array_motion(row, arrays)
            for law in laws:
                drifts[law.name][index] = drift(law, [begin, q])[1] + 0 * row[0]
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
    drifts, columns = _drifts(run), {}
    for name in names:
        quantity = name.removeprefix(DRIFT)
        if quantity in drifts or OF_QUANTITY.get(quantity) in drifts:
            values = drifts[quantity]
        elif quantity in QUANTITIES:
            values = _changes(run, quantity)
        else:
            also, expected = ", or a quantity such as E or D", f"{DRIFT} and one of: "
            raise wrong_name("column", name, drifts, also, expected=expected)
        columns[name] = converted(run, values, numbers)
    return columns


def _changes(run: Solution, name: str) -> Array:
    """Return the changes of a quantity over its value at the start, or its largest one."""
    arrays: Any = run.precision.numbers
    values = _columns(run, [name], run.sample_times, arrays)[name]
    with rounding_of(arrays):
        sizes = abs(values)
        largest = max(sizes[(values - values == 0).astype(bool)], default=0)
        return abs(values - values[0]) / (sizes[0] or largest or 1)
