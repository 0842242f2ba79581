"""One propagation in double-double or triple-double: ``propagate``, with ``taylor`` for heyoka.

Steps, series, events and ends are its own; equations, event functions and what ends a model are
the ones that heyoka is given.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

from tt_precise.arithmetic import Array, Functions, Scalar
from tt_precise.errors import InputError
from tt_precise.initial_state import InitialState
from tt_precise.integrate.events import EXTREMUM, event_named
from tt_precise.integrate.propagate import (
    FIRST_STEP,
    Pieces,
    Propagation,
    left_the_table,
    without_start,
)
from tt_precise.integrate.quadratures import extended_rates, motion
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.step_limit import longest_step
from tt_precise.integrate.system import MOST_EVENTS, Hit, full_tolerance, terminal_functions
from tt_precise.progress import Progress
from tt_precise.taylor.crossings import Crossings, crossings, ends, values
from tt_precise.taylor.system import Piece, System, number, order_of, split

NEWTONS = 3  # from double to twice, and to three times as many digits, and once more


class _Compiled(NamedTuple):
    """A system whose outputs are the functions called ``terminal``, then those of ``events``."""

    system: System
    terminal: tuple[str, ...]


@lru_cache(maxsize=32)
def _compiled(setup: Setup) -> _Compiled:
    form, record = setup.formulation, setup.record
    names: tuple[str, ...] = ()

    def define(entries: Any, parameters: Any, fn: Functions) -> Any:
        nonlocal names
        body = form.body(parameters)
        q = motion(form, record, body, entries, fn)
        terminal = terminal_functions(form, q, entries[0])
        names = tuple(terminal)
        outputs = [(function, False) for function in terminal.values()]
        for name in setup.events:
            event = event_named(name, form.model)
            rate = name.startswith(EXTREMUM) and not event.slope
            outputs.append((event.function(q), rate))
        return extended_rates(form, record, body, entries, fn), outputs

    entries = len(form.columns) + len(record)
    return _Compiled(System(setup.precision.doubles, entries, len(form.parameters), define), names)


def _system(setup: Setup) -> _Compiled:
    plain = setup.but(tolerance=0.0, contact="", paired=False, options=())
    return _compiled(plain)


def propagate_in_doubles(
    setup: Setup,
    start: InitialState,
    *,
    dense: Pieces | None = None,
    progress: Progress | None = None,
) -> Propagation:
    """As ``propagate``; numbers are guarded ones, rounded where they become doubles.

    Raises
    ------
    InputError
        More than ``MOST_EVENTS`` events happened, or one of them needs a function that is not
        there.
    """
    if setup.options:
        raise InputError(
            f"options: got {', '.join(dict(setup.options))} with precision {setup.precision.name}, "
            "expected none: they are heyoka's"
        )
    run = _Run(setup, start)
    tolerance = float(setup.tolerance or full_tolerance(setup.precision))
    limit = longest_step(start.body, start.vectors, order_of(tolerance), setup.precision)
    longest = math.inf if limit is None else float(limit)
    tiny = FIRST_STEP if setup.events else None
    fn, until = setup.precision.context, start.until
    found = None
    if until:
        first = (*start.state(setup.formulation), *(fn.mpf(0) for _ in setup.record))
        parameters = start.parameters(setup.formulation)
        for piece in run.system.pieces(first, parameters, until, tolerance, fn, longest, tiny):
            found = run.take(piece)
            if dense is not None:
                dense.append(found.read)
            if progress:
                progress(min(1.0, float(found.propagation.time / until)))
            if found.ended:
                break
    done = found.propagation if found else run.nothing(order_of(tolerance))
    return replace(done, hits=without_start(run.hits, run.events, setup, start, FIRST_STEP), steps=run.steps)


class _Taken(NamedTuple):
    read: ReadPiece
    propagation: Propagation
    ended: bool


class ReadPiece:
    """Some steps, read as heyoka's dense output is: ``bounds``, ``n_steps``, states at times."""

    def __init__(self, piece: Piece, high: Scalar, size: int, fn: Functions):
        self._piece, self._size, self._fn = piece, size, fn
        self.bounds, self.n_steps = (number(piece.begins[0], fn), high), len(piece.begins)

    def at(self, times: Sequence[Scalar]) -> Array:
        """Rows at guarded times: axes (time, part, entry)."""
        import numpy

        floats = numpy.array([float(time) for time in times])
        steps = numpy.searchsorted(self._piece.begins[:, 0], floats, side="right") - 1
        steps = numpy.maximum(steps, 0)
        begins = (number(self._piece.begins[k], self._fn) for k in steps)
        parts = self._piece.system.parts
        taus = [split(time - begin, parts) for time, begin in zip(times, begins, strict=True)]
        return self._piece.rows(steps, taus)[:, :, : self._size]

    def __call__(self, time: Scalar) -> tuple[Scalar, ...]:
        return joined(self.at([time])[0], self._fn)


def joined(row: Array, fn: Functions) -> tuple[Scalar, ...]:
    """Guarded numbers of a row (part, entry)."""
    return tuple(number(parts, fn) for parts in row.T.tolist())


class _Run:
    """One run: what has happened in its pieces so far."""

    def __init__(self, setup: Setup, start: InitialState):
        self.setup, self.start = setup, start
        self.system, terminal = _system(setup)
        self.fn, self.precision = setup.precision.context, setup.precision
        self.names = (*terminal, *setup.events)
        bilateral = setup.contact == "bilateral"
        self.terminal = tuple(n for n in terminal if not (bilateral and n == "contact_lost"))
        self.events = {name: event_named(name, setup.formulation.model) for name in setup.events}
        self.directions = (*(-1 for _ in terminal), *(e.direction for e in self.events.values()))
        self.size = len(setup.formulation.columns) + len(setup.record)
        self.first_output = len(self.system.graph.entries)
        self.hits: list[Hit] = []
        self.steps = 0
        self.left = False  # the table, in a run that goes on then
        self.ends: Array | None = None  # of the functions, in the step before

    def nothing(self, order: int) -> Propagation:
        """A propagation to a horizon of zero."""
        zero, state = self.fn.mpf(0), self.start.state(self.setup.formulation)
        row = (*state, *(zero for _ in self.setup.record))
        return Propagation("complete", zero, zero, row, 0, order, ())

    def take(self, piece: Piece) -> _Taken:
        """Events and end in the next piece."""
        until = self.start.until
        terminal = self._happened(piece)
        good, taken = piece.good, len(piece.lengths)
        if terminal:
            status, time, state, steps = *terminal, taken
            steps = int((piece.begins[:, 0] < float(time)).sum())
            self.hits = [hit for hit in self.hits if hit.time < time]
        elif good < taken or self._crawls(piece):
            steps = good if good < taken else taken - 1
            status, time = "failed", self._number(piece.begins[steps])
            state = joined(piece.coefficients[:, steps, 0, : self.size], self.fn)
        elif piece.end_time[0] < float(until):
            status, time, steps = "", self._number(piece.end_time), taken
            state = joined(piece.end_row[:, : self.size], self.fn)
        else:
            status, time, steps = "complete", until, taken
            state = ReadPiece(piece, until, self.size, self.fn)(until)
            if self.setup.contact == "bilateral" and left_the_table(
                self.setup, self.start, self.left
            ):
                status = "contact_ignored"
        self.steps += steps
        made: Any = Propagation(
            status, time, self.fn.mpf(0), state, self.steps, piece.order, ()  # type: ignore[arg-type]
        )  # fmt: skip
        return _Taken(ReadPiece(piece, time, self.size, self.fn), made, bool(status))

    def _number(self, parts: Sequence[float]) -> Scalar:
        return number(parts, self.fn)

    def _crawls(self, piece: Piece) -> bool:
        # steps that would never arrive; the first piece of a run with events is a tiny one
        many = len(piece.lengths) > 1
        advance = self._number(piece.end_time) - self._number(piece.begins[0])
        return many and bool(advance < self.precision.eps * self.start.until)

    def _happened(self, piece: Piece) -> tuple[str, Scalar, tuple[Scalar, ...]] | None:
        """Notes the events of a piece; the first end of the model in it, with time and state."""
        import numpy

        steps = piece.good
        if not steps or not self.names:
            return None
        until = float(self.start.until)
        lengths = numpy.minimum(piece.lengths[:steps], until - piece.begins[:steps, 0])
        powers = lengths[:, None] ** numpy.arange(piece.order + 1)
        columns = slice(self.first_output, self.first_output + len(self.names))
        # (function, step, order)
        series = (piece.coefficients[0][:steps, :, columns] * powers[:, :, None]).transpose(2, 0, 1)
        last = ends(series)
        first = numpy.empty_like(last)
        first[:, 1:] = last[:, :-1]
        first[:, 0] = series[:, 0, 0] if self.ends is None else self.ends
        self.ends = last[:, -1]
        flat = crossings(series.reshape(-1, series.shape[2]), first.ravel())
        function, step = numpy.divmod(flat.which, steps)
        allowed = numpy.array(self.directions)[function]
        wanted = (allowed == 0) | (allowed == flat.direction)
        found = Crossings(*(part[wanted] for part in flat))
        function, step = function[wanted], step[wanted]
        order = numpy.argsort(piece.begins[step, 0] + found.place * lengths[step], kind="stable")
        return self._note(piece, lengths, series, Crossings(*(p[order] for p in found)),
                          function[order], step[order])  # fmt: skip

    def _note(
        self,
        piece: Piece,
        lengths: Array,
        series: Array,
        found: Crossings,
        function: Array,
        step: Array,
    ) -> tuple[str, Scalar, tuple[Scalar, ...]] | None:
        import numpy

        if not len(step):
            return None
        if len(self.hits) + len(step) > MOST_EVENTS:
            raise InputError(
                f"events: got more than {MOST_EVENTS}, expected fewer: ask for a shorter time or "
                "for fewer kinds of them"
            )
        rising = series[function, step][:, 1:] * numpy.arange(1, series.shape[2])
        slope = values(rising, found.place) / lengths[step]
        which = numpy.arange(len(step)), self.first_output + function
        exact = [self.fn.mpf(x) for x in (found.place * lengths[step]).tolist()]
        parts = self.precision.doubles
        for _ in range(NEWTONS):
            rows = piece.rows(step, [split(one, parts) for one in exact])
            there = rows[which[0], :, which[1]]
            exact = [
                one - self._number(value) / d if d else one
                for one, value, d in zip(exact, there.tolist(), slope.tolist(), strict=True)
            ]
        rows = piece.rows(step, [split(one, parts) for one in exact])
        for k, one in enumerate(exact):
            name = self.names[function[k]]
            time = self._number(piece.begins[step[k]]) + one
            state = joined(rows[k, :, : self.size], self.fn)
            if name in self.terminal:
                return name, time, state
            if name == "contact_lost":
                self.left = True
            else:
                self.hits.append(Hit(name, time, int(found.direction[k]), state))
        return None

