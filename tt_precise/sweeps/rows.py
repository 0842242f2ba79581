"""From starts to rows: integrate the starts, and compute the columns of the results.

SIMD lanes integrate smooth motions (viscous friction, or rolling, on a rigid table); all others are
integrated one by one. Neither the values nor the bits of a row depend on the other rows.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy

from tt_precise.integration import inversion
from tt_precise.integration.events import event_named
from tt_precise.integration.heyoka_backend import pooled
from tt_precise.integration.setup import ended_at_start
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.formulations import integration_form
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.thresholds import lambda_thres
from tt_precise.runtime.values import Arithmetic, Array
from tt_precise.scene.scene import InitialState
from tt_precise.sweeps import columns as names
from tt_precise.sweeps.batch import BatchIntegrator, LaneEnd, LaneSteps
from tt_precise.sweeps.columns import DOUBLE, SMALLEST_FORCE, Statistic, rows_of
from tt_precise.sweeps.starts import Sweep
from tt_precise.sweeps.zeros import CLIMB, TURN, PeakSearch, RowZeros, ZeroSearch

FLOATS = Arithmetic(math, float)


def integrate_rows(sweep: Sweep, values: Array, lanes: int) -> dict[str, Array]:
    """Integrate from ``values``, shape (rows, names); return the columns of the results."""
    if not sweep.has_lanes:
        return rows_of(map(sweep.scene_of, values.tolist()), sweep.record, sweep.contact)
    with numpy.errstate(all="ignore"):  # a row that overflows is NaN and has failed
        return _Lanes(sweep, values, lanes).columns()


class _Lanes:
    """Rows that are integrated in lanes, and evaluated all at once."""

    def __init__(self, sweep: Sweep, values: Array, lanes: int):
        form, record = integration_form(sweep.scene.model, "newton"), sweep.record
        self._sweep, self._form, self._starts = sweep, form, _initial_states(sweep, values)
        self._bodies = numpy.array([start.parameters(form) for start in self._starts]).T
        states = numpy.array([start.state(form) for start in self._starts]).T
        self._first = self._motion(states)
        events = [event_named(name, sweep.scene.model) for name in names.event_names(record)]
        self._zeros = ZeroSearch(form, self._bodies, states, events)
        self._peaks = PeakSearch(form, self._bodies, names.extremes(record))
        without_contact = (ended_at_start(s, sweep.contact, DOUBLE.context) for s in self._starts)
        self._ends = [
            LaneEnd(status or "", 0.0, state, 0)
            for status, state in zip(without_contact, states.T, strict=True)
        ]
        with pooled(_integrator, (form, sweep.contact, lanes)) as integrator:
            integrator.integrate(self._starts, self._ends, self._search)
        self._last = self._motion(numpy.array([end.state for end in self._ends]).T)
        turns = self._zeros.zeros(TURN)
        self._turns, self._at_turns = turns, self._motion(turns.state, turns.row)

    def _search(self, steps: LaneSteps) -> None:
        self._zeros.search(steps)
        self._peaks.search(steps)

    def columns(self) -> dict[str, Array]:
        """Return all columns of the rows, in SI."""
        times, ends = self._times, self._ends
        lost = [end.status == "contact_lost" and end.time > 0 for end in ends]
        arrived = [end.status == "complete" for end in ends]
        stop = self._seconds(end.time for end in ends)
        return {
            "outcome": self._outcomes(),
            **{name: self._seconds(climb.times[name] for climb in times) for name in names.TIMES},
            "min_g_n": numpy.where(lost, 0.0, self._statistic(SMALLEST_FORCE)),
            "jellett_drift": self._drift(),
            "steps": numpy.array([end.steps for end in ends], dtype=numpy.int64),
            "t_stop": numpy.where(arrived, float(self._sweep.scene.until), stop),
            **{name: self._extra(name) for name in self._sweep.record},
        }

    def _extra(self, name: str) -> Array:
        statistic = names.statistic_named(name)
        if statistic is not None:
            return self._statistic(statistic)
        if name == "t_equator":
            return self._seconds(climb.equator for climb in self._times)
        if name == "lambda_ratio":
            return self._value("lambda", self._first) / lambda_thres(self._first.body, numpy)
        if name in names.CROSSINGS:
            zeros, which = self._zeros.zeros("nu_crossing"), names.CROSSINGS.index(name)
            crossings = self._by_row(zeros.row, zeros.time, zeros.rising)
            return self._seconds(
                names.neighbours(zip(*mine, strict=True), climb.equator)[which]
                for mine, climb in zip(crossings, self._times, strict=True)
            )
        definition = name.removeprefix("climb_")
        return self._seconds(getattr(climb, definition).duration for climb in self._times)

    def _outcomes(self) -> list[str]:
        lambda_, energy = self._value("lambda", self._last), self._value("E", self._last)
        crossed = numpy.array([climb.equator is not None for climb in self._times])
        falling = self._sweep.contact == "unilateral" or self._sweep.scene.model == "rolling"
        complete = names.outcomes(
            self._last.body, self._last.state.kz, lambda_, energy, crossed, falling
        )
        statuses = [end.status for end in self._ends]
        return numpy.where(numpy.equal(statuses, "complete"), complete, statuses).tolist()

    def _drift(self) -> Array:
        """Return the largest relative change of lambda, at the end and at turning points."""
        first, last, turning = (
            self._value("lambda", q) for q in (self._first, self._last, self._at_turns)
        )
        drift: Array = numpy.abs(last - first)
        numpy.fmax.at(drift, self._turns.row, numpy.abs(turning - first[self._turns.row]))
        # the scale is that of a trajectory's drift, which is not lambda where lambda is 0
        scale = INTEGRALS["jellett"].scale
        return drift / [scale(start.motion(FLOATS.fn)) or 1.0 for start in self._starts]

    def _statistic(self, statistic: Statistic) -> Array:
        """Return a quantity at the start or the end, or its extreme value, in SI."""
        name, kind = statistic.quantity, statistic.kind
        dimension = QUANTITIES[name].dimension
        unit = [float(start.units.of_dimension(dimension)) for start in self._starts]
        first, last = self._value(name, self._first), self._value(name, self._last)
        if not statistic.extreme:
            return (first if kind == "start" else last) * unit
        choose = numpy.fmin if kind == "min" else numpy.fmax
        extreme: Array = choose(first, last)
        if name == "theta":
            choose.at(extreme, self._turns.row, self._value(name, self._at_turns))
        else:
            extreme = choose(extreme, self._peaks.values()[statistic])
        return extreme * unit

    @cached_property
    def _times(self) -> list[inversion.InversionTimes]:
        """The times of the climb of each row; a top with lambda < 0 is its mirror image."""
        mirror, turns = numpy.sign(self._value("lambda", self._first)), self._turns
        theta = self._value("theta", self._at_turns)
        rate = self._value("phi_dot", self._at_turns) * mirror[turns.row]
        climbs = self._zeros.zeros(CLIMB)
        climbs = RowZeros(*(column[..., ~climbs.rising] for column in climbs))  # of cos theta

        def turning_points(rising: bool) -> Iterable[inversion.TurningPoints]:
            some = turns.rising == rising
            columns = (column[some] for column in (turns.time, theta, rate))
            return itertools.starmap(
                inversion.TurningPoints, self._by_row(turns.row[some], *columns)
            )

        def times(name: str) -> Iterable[list[float]]:
            zeros = climbs if name == CLIMB else self._zeros.zeros(name)
            return (mine for (mine,) in self._by_row(zeros.row, zeros.time))

        there = self._value("phi_dot", self._motion(climbs.state, climbs.row)) * mirror[climbs.row]
        backwards = (bool(rates) and rates[0] < 0 for (rates,) in self._by_row(climbs.row, there))
        marks = zip(
            times(CLIMB),
            turning_points(False),
            turning_points(True),
            *map(times, ("phi_dot_zero", "Lk_equals_Lz", "Lk_equals_minus_Lz")),
            backwards,
            strict=True,
        )
        events = itertools.starmap(inversion.InversionEvents, marks)
        return [inversion.from_inversion_events(each, math.pi) for each in events]

    def _motion(self, states: Array, row: Array | slice = slice(None)) -> Motion:
        body = self._form.body([*self._bodies[:, row]])
        return self._form.motion(body, self._form.State(*states), numpy)

    def _value(self, name: str, q: Motion) -> Array:
        value: Array = QUANTITIES[name].evaluate(q) + numpy.zeros(q.state.kz.shape)
        return value

    def _seconds(self, times: Iterable[float | None]) -> Array:
        units = numpy.array([start.units.time for start in self._starts])
        return numpy.array([*times], dtype=float) * units

    def _by_row(self, row: Array, *columns: Array) -> Iterable[list[list[Any]]]:
        """Split columns that are ordered by row; a list of columns for each row."""
        cuts = numpy.searchsorted(row, numpy.arange(len(self._starts) + 1)).tolist()
        lists = [column.tolist() for column in columns]  # NumPy's own numbers are slow
        for begin, end in itertools.pairwise(cuts):
            yield [column[begin:end] for column in lists]


def _initial_states(sweep: Sweep, values: Array) -> list[InitialState]:
    if sweep.changes_body:
        return [InitialState.of(sweep.scene_of(row), FLOATS) for row in values.tolist()]
    first = InitialState.of(sweep.scene, FLOATS)
    rows = (dict(zip(sweep.names, row, strict=True)) for row in values.tolist())
    return [first.from_another(sweep.scene.start, FLOATS, row) for row in rows]


def _integrator(key: tuple[Any, ...]) -> BatchIntegrator:
    return BatchIntegrator(*key)
