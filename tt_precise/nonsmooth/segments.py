"""One segment of a motion, from a ``SegmentStart`` to the next, and the segment's rows over t."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import Row
from tt_precise.integration.dense_output import DenseOutput, Times
from tt_precise.integration.heyoka_backend import propagate, repeating
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.initial_state import InitialState

MOST_SEGMENTS = 10_000  # A run with more segments is refused.


NEWTON_STEPS = 60  # Newton steps from a knot of the series at most; 3 to 10 are needed.


class RowwiseOutput(DenseOutput):
    """Dense output that is read row by row with guard bits, never in arrays."""

    def arrays(
        self,
        times: Times,
        number: Callable[[Scalar], Any] = float,
        progress: Progress | None = None,
    ) -> tuple[Array, ...]:
        """The rows at all ``times``: an array for each entry."""
        mpf = self.precision.context.mpf
        pairs = zip(times.rounded.tolist(), times.delay.tolist(), strict=True)
        rows = self.rows([mpf(a) + mpf(b) for a, b in pairs])
        kind = type(number(mpf(0)))
        if not rows:
            return tuple(numpy.zeros(0, dtype=kind) for _ in self.start_row)
        return tuple(
            numpy.array([number(x) for x in entry], dtype=kind) for entry in zip(*rows, strict=True)
        )


class RegularisedTimeOutput(RowwiseOutput):
    """Rows over the time t of a propagation in a regularised time, whose state contains t.

    ``propagation.time`` is the regularised time; ``end_time`` and all arguments are t.
    """

    @cached_property
    def _t(self) -> int:
        return self.setup.formulation.columns.index("t")

    @cached_property
    def _last_time(self) -> Scalar:
        return self.precision.with_guard_bits(self.propagation.state[self._t])

    def _components(self, times: Sequence[Scalar], progress: Progress | None) -> tuple[Array, ...]:
        rows, delays = [], []
        for time in times:
            row, delay = self.end_row if time else self.start_row, time * 0
            if time and time < self._last_time:
                row, delay = self._nearest(time)
            rows.append(row)
            delays.append(delay)
        return self._shift(rows, delays)

    @cached_property
    def _knots(self) -> list[tuple[Scalar, Any, Any]]:
        """The time, the regularised time and the series at the begin of each step."""
        outputs: list[Any] = []
        self._visit(lambda output, low, high: outputs.append(output), None)
        with_guard_bits = self.precision.with_guard_bits
        return [
            (with_guard_bits(output(own)[self._t]), own, output)
            for output in outputs
            for own in output.times
        ]

    def _nearest(self, time: Scalar) -> tuple[Row, Scalar]:
        """The row at the number of the regularised time nearest to ``time``, and the delay."""
        with_guard_bits, number = self.precision.with_guard_bits, self.precision.number
        knots = self._knots
        place = max(bisect.bisect_right(knots, time, key=lambda knot: knot[0]) - 1, 0)
        _, own, output = knots[place]
        _, later, _ = knots[min(place + 1, len(knots) - 1)]
        # Newton's method from the end of the step where t rises faster: it then comes from one side
        ends = [with_guard_bits(own), with_guard_bits(later)]
        inner = max(ends, key=lambda x: self._clock(tuple(map(with_guard_bits, output(number(x))))))
        best = None
        for _ in range(NEWTON_STEPS):
            row = tuple(map(with_guard_bits, output(number(inner))))
            rest = time - row[self._t]
            if best is not None and abs(rest) >= abs(best[1]):
                break
            best = row, rest
            inner += rest / self._clock(row)
        assert best is not None
        return best

    def _clock(self, row: Row) -> Scalar:
        form = self.setup.formulation
        return form.State(*row[: len(form.columns)]).clock(self.precision.context)

    def _own_delay(self, row: Row, delay: Scalar) -> Scalar:
        return delay / self._clock(row) if delay and row[self._t] else delay * 0


def propagated(setup: Setup, start: InitialState) -> DenseOutput:
    """Return the segment from ``start``, readable over t."""
    propagation = propagate(setup, start)
    again = repeating(setup, start, propagation)
    if not setup.phase.has_clock:
        return DenseOutput(setup, start, propagation, again)
    t = setup.formulation.columns.index("t")
    found = propagation.found
    if len(found.hits):
        found = found._replace(hits=replace(found.hits, time=found.hits.state[:, t]))
    return RegularisedTimeOutput(setup, start, replace(propagation, found=found), again)


class SegmentStart(NamedTuple):
    """A motion at an instant from which a segment begins.

    ``recorded`` are the quadratures so far (scaled), ``until`` is the time left, and ``start`` that
    of the whole run.
    """

    start: InitialState
    q: Motion
    recorded: Row
    until: Scalar

    @classmethod
    def of_run(cls, setup: Setup, start: InitialState) -> SegmentStart:
        """Return the begin of a run."""
        fn = setup.precision.context
        q = Motion(start.body, start.vectors, fn, start.model, euler=start.euler)
        return cls(start, q, tuple(fn.mpf(0) for _ in setup.record), start.until)

    def after(self, output: DenseOutput) -> SegmentStart:
        """Return the end of a segment that begins here."""
        row, layout = output.end_row, output.setup.layout
        q = layout.motion(output.start.body, row, self.q.fn)
        return SegmentStart(
            self.start, q, row[len(layout.form.columns) :], self.until - output.end_time
        )

    def at(self, **components: Scalar) -> SegmentStart:
        """Return the same joint with other entries of the state."""
        q = self.q
        return self._replace(q=Motion(q.body, q.state._replace(**components), q.fn, q.model))

    def at_rest(self) -> SegmentStart:
        """Return the same joint with a contact point at rest."""
        zero = self.q.fn.mpf(0)
        return self.at(vx=zero, vy=zero)

    def entering(self, setup: Setup, until: Scalar = None) -> InitialState:
        """Return the start of a segment that is integrated as ``setup`` says."""
        form = setup.formulation
        return replace(
            self.start,
            model=form.model,
            vectors=self.q.state,
            until=self.until if until is None else until,
            row=(*form.State.of(self.q), *self.recorded),
        )

    def propagated(self, setup: Setup, until: Scalar = None) -> DenseOutput:
        """Return the segment that begins here, readable over t."""
        return propagated(setup, self.entering(setup, until))
