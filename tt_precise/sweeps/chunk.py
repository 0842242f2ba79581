"""One task of a sweep: the results of some hundred rows from their start values.

Input and output are arrays. The result of a row depends only on the row, not on other rows of the
chunk.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from functools import cached_property

import numpy

from tt_precise.integration.equations import longest_step
from tt_precise.integration.events import Event
from tt_precise.integration.inversion import (
    InversionEvents,
    InversionTimes,
    TurningPoints,
    from_inversion_events,
)
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import ended_at_start
from tt_precise.mechanics import thresholds
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.formulations import Formulation, integration_form
from tt_precise.mechanics.parameters import NAMES, Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, jellett
from tt_precise.runtime.values import Arithmetic, Array
from tt_precise.scene.initial_state import InitialState
from tt_precise.sweeps.alone import columns_alone, in_lanes
from tt_precise.sweeps.columns import (
    SMALLEST_FORCE,
    TIMES,
    Detector,
    Statistic,
    detectors,
    extremes,
    outcomes,
    statistic_named,
)
from tt_precise.sweeps.events import EARLY, Events, exactly
from tt_precise.sweeps.lanes import Build, LaneResult, LaneStart, lanes
from tt_precise.sweeps.specification import SweepSpec
from tt_precise.taylor.series import Sized, SizedFunctions

# A function's value in double decides its sign if it exceeds this part of the size of its terms,
# some 30 roundings; below, the exact start decides.
SURE_SIGN = 2.0**-48
START_BITS, ZERO = 300, 2.0**-250  # of the exact start; a smaller value is zero
DOUBLE = precision_named("double")
FLOATS = Arithmetic(math, float)
# Events whose functions are a positive multiple of a rate of the start, or of minus it.
RATES = {"theta_min": "theta_dot", "phi_dot_zero": "phi_dot"}


def compute(spec: SweepSpec, values: Array, batch: int) -> dict[str, Array]:
    """Columns of results of the rows that start from ``values``, shape (rows, names).

    Returns lists for "outcome" and float64 or int64 arrays for the rest, in the order of the rows.
    """
    if not in_lanes(spec.scene):
        rows = (dict(zip(spec.names, row, strict=True)) for row in values.tolist())
        return columns_alone(map(spec.scene_of, rows), spec.record, spec.contact)
    with numpy.errstate(all="ignore"):  # what overflows is NaN in its row, whose status says why
        return _computed(spec, values, batch).columns()


def _computed(spec: SweepSpec, values: Array, batch: int) -> _Integrated:
    form = integration_form(spec.scene.model, "newton")
    starts = _starts(spec, values)
    model, wanted = spec.scene.model, extremes(spec.record)
    build = Build(model, spec.contact, batch, detectors(spec.record, model), wanted)
    ended: list[LaneResult | None] = []
    for start in starts:
        # without contact to begin with it ends there
        status = ended_at_start(start, spec.contact, DOUBLE.context)
        ended.append(status and LaneResult(status, 0.0, numpy.array(start.state(form)), 0))
    moving = numpy.array([row for row, result in enumerate(ended) if result is None], dtype=int)
    signs = _start_signs(spec, form, build.detectors, values, starts)
    with lanes(build) as integrator:
        order = integrator.order
        lane_results = integrator.integrate(
            [_lane_start(form, starts[row], order) for row in moving], signs[:, moving]
        )
    for row, result in zip(moving, lane_results.results, strict=True):
        ended[row] = result
    events = lane_results.events._replace(row=moving[lane_results.events.row])
    results = [result for result in ended if result is not None]
    peaks = {
        statistic: (moving[owner], states)
        for statistic, (owner, states) in lane_results.extremes.items()
    }
    return _Integrated(spec, form, build, starts, results, events, peaks, signs)


def _starts(spec: SweepSpec, values: Array) -> list[InitialState]:
    rows = [dict(zip(spec.names, row, strict=True)) for row in values.tolist()]
    if spec.derived:
        return [InitialState.of(spec.scene_of(row), FLOATS) for row in rows]
    first = InitialState.of(spec.scene, FLOATS)
    return [first.from_another(spec.scene.start, FLOATS, row) for row in rows]


def _start_signs(
    spec: SweepSpec,
    form: Formulation,
    detectors: Sequence[Detector],
    values: Array,
    starts: Sequence[InitialState],
) -> Array:
    """The signs (detectors, rows) of the functions at the exact starts; 0 for a zero."""
    sized = form.State(*(Sized(x, abs(x)) for x in numpy.array([s.state(form) for s in starts]).T))
    body = Parameters(**{name: _column(starts, name) for name in NAMES})
    q = form.motion(body.numbers(exactly), sized, SizedFunctions())
    signs = numpy.empty((len(detectors), len(starts)), dtype=int)
    for number, detector in enumerate(detectors):
        name = detector.event.name
        if name in RATES:  # the start itself has this rate
            rates = numpy.array([getattr(start.euler, RATES[name]) for start in starts])
            tilted = numpy.array([start.vectors.kx != 0 for start in starts])
            rising = -1 if detector.turning else 1
            signs[number] = rising * numpy.sign(rates) * tilted
            continue
        found = detector.event.function(q)
        value, size = found.value, found.size
        signs[number] = numpy.sign(value)
        for row in numpy.flatnonzero((numpy.abs(value) <= SURE_SIGN * size) & (size > 0)):
            signs[number, row] = _exact_sign(spec, detector.event, values[row])
    return signs


def _exact_sign(spec: SweepSpec, event: Event, values: Array) -> int:
    """The sign of a function at a row's exact start."""
    finest = precision_named("mp", START_BITS)
    scene = spec.scene_of(dict(zip(spec.names, values.tolist(), strict=True)))
    value = event.function(InitialState.of(scene, finest.arithmetic).motion(finest.context))
    return 0 if abs(value) < ZERO else 1 if value > 0 else -1


def _column(starts: Sequence[InitialState], name: str) -> Array:
    return numpy.array([float(getattr(start.body, name)) for start in starts])


def _lane_start(form: Formulation, start: InitialState, order: int) -> LaneStart:
    longest = longest_step(start.body, start.vectors, order, DOUBLE)
    return LaneStart(
        start.state(form),
        start.parameters(form),
        start.until,
        math.inf if longest is None else float(longest),
    )


class _Integrated:
    """The rows of a chunk after the integration: everything is evaluated for all at once."""

    def __init__(
        self,
        spec: SweepSpec,
        form: Formulation,
        build: Build,
        starts: Sequence[InitialState],
        results: Sequence[LaneResult],
        events: Events,
        peaks: Mapping[Statistic, tuple[Array, Array]],
        signs: Array,
    ):
        self.peaks = peaks
        self.spec, self.form, self.starts, self.results = spec, form, starts, results
        self.detectors = build.detectors
        self.rows = len(starts)
        self.owner, self.times, self.states = events.row, events.time, events.state
        self.kind = 2 * events.detector + (events.direction > 0)
        self._drop_starts(signs)

    def columns(self) -> dict[str, Array]:
        """All columns of the rows, in SI."""
        times = self._inversion_times()
        unit = numpy.array([start.units.time for start in self.starts])
        columns: dict[str, Array] = {"outcome": self._outcomes(times)}
        ends = [climb.times for climb in times]
        for name in TIMES:
            columns[name] = numpy.array([end[name] for end in ends], dtype=float) * unit
        lost = [result.status == "contact_lost" and result.time > 0 for result in self.results]
        columns["min_g_n"] = numpy.where(lost, 0.0, self._values(SMALLEST_FORCE))
        columns["jellett_drift"] = self._drift()
        columns["steps"] = numpy.array([result.steps for result in self.results], dtype=numpy.int64)
        ended = numpy.array([result.time for result in self.results]) * unit
        complete = [result.status == "complete" for result in self.results]
        columns["t_stop"] = numpy.where(complete, float(self.spec.scene.until), ended)
        for name in self.spec.record:
            columns[name] = self._extra_column(name, columns, times, unit)
        return columns

    def _extra_column(
        self, name: str, columns: Mapping[str, Array], times: Sequence[InversionTimes], unit: Array
    ) -> Array:
        statistic = statistic_named(name)
        if statistic is not None:
            return self._values(statistic)
        if name == "t_equator":
            return numpy.array([climb.equator for climb in times], dtype=float) * unit
        if name == "lambda_ratio":
            q = self._start_motion
            return jellett(q) / thresholds.lambda_thres(q.body, numpy)
        if name.startswith("nu_crossing"):
            climbs = numpy.array([climb.equator for climb in times], dtype=float)
            return self._nearest(climbs, after=name.endswith("end")) * unit
        which = name.removeprefix("climb_")
        return columns[f"t_end_{which}"] - columns[f"t_init_{which}"]

    def _nearest(self, climbs: Array, *, after: bool) -> Array:
        """Time of the nearest crossing of nu_y and nu_x on one side of the climb."""
        chosen = self._events("nu_crossing", rising=not after)
        owner, times = self.owner[chosen], self.times[chosen]
        beyond = times > climbs[owner] if after else times < climbs[owner]
        nearest = numpy.full(self.rows, numpy.nan)
        nearer = numpy.fmin if after else numpy.fmax
        nearer.at(nearest, owner[beyond], times[beyond])
        return nearest

    def _outcomes(self, times: Sequence[InversionTimes]) -> list[str]:
        q = self._end_motion
        crossed = numpy.array([climb.equator is not None for climb in times], dtype=bool)
        falling = self.spec.contact == "unilateral" or self.spec.scene.model == "rolling"
        energy, ones = QUANTITIES["E"].evaluate(q), numpy.ones(self.rows)
        complete = outcomes(q.body, q.k[2] * ones, jellett(q), energy, crossed, falling)
        return [
            name if result.status == "complete" else result.status
            for result, name in zip(self.results, complete, strict=True)
        ]

    # ---- evaluation ------------------------------------------------------------------------

    def _motion(self, states: Array, owner: Array) -> Motion:
        body = Parameters(**{name: column[owner] for name, column in self._bodies.items()})
        return self.form.motion(body, self.form.State(*states.T), numpy)

    @cached_property
    def _bodies(self) -> dict[str, Array]:
        return {name: _column(self.starts, name) for name in NAMES}

    @cached_property
    def _start_motion(self) -> Motion:
        states = numpy.array([start.state(self.form) for start in self.starts])
        return self._motion(states, numpy.arange(self.rows))

    @cached_property
    def _end_motion(self) -> Motion:
        states = numpy.array([result.state for result in self.results])
        return self._motion(states, numpy.arange(self.rows))

    def _events(self, name: str, rising: bool | None = None) -> Array:
        """Positions of the events with this name, in one direction or in both."""
        number = next(n for n, detector in enumerate(self.detectors) if detector.event.name == name)
        mine = self.kind // 2 == number
        return numpy.flatnonzero(mine if rising is None else mine & (self.kind % 2 == rising))

    @cached_property
    def _turning_points(self) -> tuple[Array, Motion]:
        chosen = self._events("theta_min")
        return self.owner[chosen], self._motion(self.states[chosen], self.owner[chosen])

    def _values(self, statistic: Statistic) -> Array:
        """Return the start, end, smallest or largest value of a quantity in each row."""
        kind, wanted = statistic.kind, QUANTITIES[statistic.quantity]
        ones = numpy.ones(self.rows)
        start = wanted.evaluate(self._start_motion) * ones
        end = wanted.evaluate(self._end_motion) * ones
        if not statistic.extreme:
            extreme = start if kind == "start" else end
        else:
            owner, q = self._turning_points
            if statistic.quantity != "theta":
                owner, states = self.peaks[statistic]
                q = self._motion(states, owner)
            smaller = numpy.fmin if kind == "min" else numpy.fmax
            extreme = smaller(start, end)
            smaller.at(extreme, owner, wanted.evaluate(q) * numpy.ones(len(owner)))
        unit = numpy.array(
            [float(beginning.units.of_dimension(wanted.dimension)) for beginning in self.starts]
        )
        return extreme * unit

    def _drift(self) -> Array:
        start, end = jellett(self._start_motion), jellett(self._end_motion)
        owner, q = self._turning_points
        # the scale of a trajectory's drift, which is not lambda where lambda is 0
        scale = INTEGRALS["jellett"].scale
        scales = numpy.array([scale(one.motion(FLOATS.fn)) or 1.0 for one in self.starts])
        drift: Array = numpy.abs(end - start) / scales
        numpy.fmax.at(drift, owner, numpy.abs(jellett(q) - start[owner]) / scales[owner])
        return drift

    def _inversion_times(self) -> list[InversionTimes]:
        owner, q = self._turning_points
        chosen, theta = self._events("theta_min"), QUANTITIES["theta"].evaluate(q)
        phi_dot = self._mirrored_phi_dot(q, owner)

        def turning_points(rising: bool) -> list[TurningPoints]:
            mine = self.kind[chosen] % 2 == rising
            columns = (column[mine] for column in (self.times[chosen], theta, phi_dot))
            return list(
                map(TurningPoints, *(self._by_row(column, owner[mine]) for column in columns))
            )

        def times(name: str) -> list[list[float]]:
            mine = self._events(name)
            return self._by_row(self.times[mine], self.owner[mine])

        columns = (
            times("equator"), turning_points(False), turning_points(True), times("phi_dot_zero"),
            times("Lk_equals_Lz"), times("Lk_equals_minus_Lz"), self._climbs_backwards(),
        )  # fmt: skip
        return [
            from_inversion_events(InversionEvents(*row), math.pi)
            for row in zip(*columns, strict=True)
        ]

    def _climbs_backwards(self) -> list[bool]:
        """True where phi_dot, with the sign of lambda, is negative at a row's first crossing."""
        mine = self._events("equator")
        owner = self.owner[mine]
        phi_dot = self._mirrored_phi_dot(self._motion(self.states[mine], owner), owner)
        return [any(value < 0 for value in row[:1]) for row in self._by_row(phi_dot, owner)]

    def _mirrored_phi_dot(self, q: Motion, owner: Array) -> Array:
        sign = numpy.sign(jellett(self._start_motion))[owner]
        return QUANTITIES["phi_dot"].evaluate(q) * sign

    def _by_row(self, column: Array, owner: Array) -> list[list[float]]:
        cuts = numpy.searchsorted(owner, numpy.arange(self.rows + 1)).tolist()
        items = column.tolist()  # numbers of NumPy's are slow
        return [items[start:end] for start, end in itertools.pairwise(cuts)]

    def _drop_starts(self, signs: Array) -> None:
        """Remove the events of functions that vanish at the start, next to the start."""
        keep = (self.times >= EARLY) | (signs[self.kind // 2, self.owner] != 0)
        self.kind, self.owner = self.kind[keep], self.owner[keep]
        self.times, self.states = self.times[keep], self.states[keep]
