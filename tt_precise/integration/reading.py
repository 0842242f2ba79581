"""The states, columns, events and drifts of a ``Solution``.

A run in double is read in arrays of doubles, or of NumPy's long doubles where doubles are not
precise enough; other runs are read in arrays of numbers with guard bits (``mpfr``).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import Any, Literal, NamedTuple

import numpy

from tt_precise.integration.columns import POSE_NAMES, Name, State, vertical
from tt_precise.integration.heyoka_backend import sample_times
from tt_precise.integration.precision import DOUBLES, Hardware, times_in
from tt_precise.integration.solution import Segment, Solution
from tt_precise.integration.zeros import Hits
from tt_precise.mechanics.conserved import OF_QUANTITY, Integral, conserved
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import Array, Scalar, wrong_name
from tt_precise.scene.numerals import shortest_texts
from tt_precise.scene.scene import RECORDABLE

Numbers = Literal["float", "exact", "text"]
DRIFT = "drift:"  # The name of a column of drifts begins so.
FALLING = -1  # the speed where the top sticks, the margin to the cone where it slips


class States(NamedTuple):
    """The states of a run within one segment, at the positions ``index`` of the times."""

    segment: Segment
    index: Array
    row: Sequence[Array]


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
    """Evaluate the states at exact times in s within the trajectory."""

    def compute() -> list[States]:
        with numbers.precision():
            if isinstance(numbers, Hardware) and times is run.scene.sample_times:
                return at_times(run, sample_times(run.start, run.scene), numbers, samples=True)
            seconds, end = numbers.of_fractions(times), times_in(numbers, [run.end])[0]
            doubles = seconds.astype(float)
            for extreme in (doubles.argmin(), doubles.argmax()):
                run.dimensionless_time(times[extreme])
            local = seconds / times_in(numbers, [run.start.units.time])[0]
            last = doubles >= float(end) if run.precision.is_float else seconds >= end
            local[last.astype(bool)] = times_in(numbers, [run.end_time])[0]
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


def table(
    run: Solution,
    names: Sequence[Name],
    times: Sequence[Fraction] | Array | None = None,
    numbers: Numbers = "float",
) -> dict[Any, Array]:
    """``t`` and the named columns at exact ``times`` in s, by default at the samples.

    Undefined values are NaN in float64 arrays, else None. With a pose that was not recorded the
    columns are those of a run that records it.
    """
    if any(name in POSE_NAMES and name not in run.setup.record for name in names):
        run = with_quadratures(run)
    times = run.sample_times if times is None else times
    is_float = run.precision.is_float
    arrays: Any = DOUBLES if is_float and numbers != "text" else run.precision.numbers
    for name in names:
        run.columns.dimension(name)  # refuses an unknown name where there are no times too
    kind = float if is_float else object
    columns: dict[Any, Any] = {name: numpy.empty(len(times), dtype=kind) for name in names}

    def seconds() -> Array:
        return numpy.array(times, dtype=float) if is_float else arrays.of_fractions(times)

    with arrays.precision():
        for segment, index, row in states_at(run, times, arrays):
            for name, values in segment.columns.of_arrays(names, row, arrays).items():
                columns[name][index] = values
        own = times is run.scene.sample_times
        every = {"t": run.start.once("seconds", seconds) if own else seconds(), **columns}
        return {name: converted(run, values, numbers) for name, values in every.items()}


def with_quadratures(run: Solution) -> Solution:
    """The run with phi, psi, x and y recorded; integrated again if necessary."""
    if set(RECORDABLE) <= set(run.setup.record):
        return run
    again = run.once(with_quadratures, lambda: run.again(record=RECORDABLE, events=()))
    if again.status != run.status:
        raise vertical()
    return again


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


def event_columns(run: Solution, names: Sequence[Name]) -> dict[Any, Array]:
    """Columns of the events in order of time: name, t, direction, and ``names``."""
    for name in names:
        run.columns.dimension(name)  # refuses an unknown name where there are no events too
    arrays: Any = run.precision.numbers
    kinds: dict[Any, type] = {"name": object, "direction": int}
    columns: dict[Any, list[Array]] = {
        name: [numpy.empty(0, dtype=kinds.get(name, float))]
        for name in ("name", "t", "direction", *names)
    }
    with arrays.precision():
        unit = arrays.number(run.start.units.time)
        for segment in run.segments:
            parts = [segment.run.events.hits]
            if segment.ended:
                time, *state = (arrays.array([x]) for x in (segment.end_time, *segment.end_row))
                ended = numpy.array([segment.ended], dtype=object)
                parts.append(Hits(ended, time, numpy.array([FALLING]), tuple(state)))
            for hits in filter(len, parts):
                t = (hits.time + arrays.number(segment.begin)) * unit
                rows = {"name": hits.name, "t": t, "direction": hits.direction}
                rows |= segment.columns.of_arrays(names, hits.state, arrays)
                for name, values in rows.items():
                    columns[name].append(values)
        whole = {name: numpy.concatenate(column) for name, column in columns.items()}
        return {n: x if n in kinds else converted(run, x, "exact") for n, x in whole.items()}


def integrals(run: Solution) -> dict[str, Integral]:
    """The integrals of the motion that the run's state determines, by name and by quantity."""
    laws = [
        law
        for law in conserved(run.scene.model, run.scene.body)
        if run.columns.has_azimuth or not law.azimuth
        if run.setup.formulation.coordinates == "newton" or law.name != "axis_norm"
    ]
    return {law.name: law for law in laws} | {name: law for law in laws for name in law.quantities}


def is_drift(name: Name) -> bool:
    """Return whether a column is the drift of a quantity, such as "drift:jellett"."""
    return isinstance(name, str) and name.startswith(DRIFT)


def changes(run: Solution, names: Iterable[Name]) -> str:
    """Return a sentence on the drifts in ``names`` of what the motion does not conserve, or ""."""
    laws, drifts = integrals(run), [str(name) for name in names if is_drift(name)]
    others = [name for name in drifts if name.removeprefix(DRIFT) not in laws]
    kept = ", ".join(dict.fromkeys(law.name for law in laws.values()))
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
    names = {law.name: f"{DRIFT}{law.name}" for law in integrals(run).values()}
    columns = drift_columns(run, names.values(), "exact")
    return Drifts((name, columns[column]) for name, column in names.items())


def drift_columns(
    run: Solution, names: Iterable[str], numbers: Numbers = "float"
) -> dict[str, Array]:
    """The relative drifts of the columns "drift:NAME" at the samples, in finer arithmetic.

    NAME is an integral of the motion or a quantity with its value, or any quantity: the change
    since the start over its value there, or over its largest value if it starts at 0 (``changes``).
    """
    laws, arrays, times = integrals(run), run.precision.numbers, run.sample_times
    known = {n: QUANTITIES[n] for n in QUANTITIES if n in run.columns.dimensions} | laws
    entries: dict[str, Any] = {name: known.get(name.removeprefix(DRIFT)) for name in names}
    for name, entry in entries.items():
        if entry is None:
            also, expected = ", or a quantity such as E or D", f"{DRIFT} and one of: "
            raise wrong_name("column", name, laws, also, expected=expected)
    kind = arrays.kind if isinstance(arrays, Hardware) else object
    drifts = {name: numpy.empty(len(times), dtype=kind) for name in names}
    with arrays.precision():
        first = run.segments[0]
        start = first.columns.array_motion([arrays.array([x]) for x in first.start_row], arrays)
        for segment, index, row in states_at(run, times, arrays):
            q = segment.columns.array_motion(row, arrays)
            for name, entry in entries.items():
                drifts[name][index] = abs(entry.evaluate(q) - entry.evaluate(start)) + 0 * row[0]
        for name, entry in entries.items():
            if isinstance(entry, Integral):
                scale = entry.scale(start)
            else:
                finite = [value for value in drifts[name] if value - value == 0]
                scale = abs(entry.evaluate(start)) or max(finite, default=0)
            drifts[name] = converted(run, drifts[name] / (scale or 1), numbers)
    return drifts
