"""Dense output of what is known in a time of its own, and of the first moments of gliding.

Such segments are read row by row in guarded numbers.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from typing import Any

from tt_precise.integration.columns import Row
from tt_precise.integration.dense_output import DenseOutput, Propagation, Times
from tt_precise.integration.equations import QUADRATURE_SCALE, QUADRATURES, motion
from tt_precise.integration.events import Event, Hit
from tt_precise.integration.onset import OnsetSeries
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Scalar

NEWTON_STEPS = 60  # at most; from a knot of the series 3 to 10 are taken


class RowwiseOutput(DenseOutput):
    """Dense output that is read row by row in guarded numbers, and never in arrays."""

    def arrays(
        self,
        times: Times,
        number: Callable[[Scalar], Any] = float,
        progress: Progress | None = None,
    ) -> tuple[Array, ...]:
        """The rows at all ``times``: an array for each entry."""
        import numpy

        mpf = self.precision.context.mpf
        pairs = zip(times.rounded.tolist(), times.delay.tolist(), strict=True)
        rows = self.rows([mpf(a) + mpf(b) for a, b in pairs])
        kind = type(number(mpf(0)))
        if not rows:
            return tuple(numpy.zeros(0, dtype=kind) for _ in self.start_row)
        return tuple(
            numpy.array([number(x) for x in entry], dtype=kind) for entry in zip(*rows, strict=True)
        )


class OwnTimeOutput(RowwiseOutput):
    """Rows of a propagation whose state has the time t as an entry, over that time.

    ``propagation.time`` is its own time's; ``end_time`` and everything that is asked for is t.
    """

    @cached_property
    def _t(self) -> int:
        return self.setup.formulation.columns.index("t")

    @cached_property
    def _reached(self) -> Scalar:
        return self.precision.guarded(self.propagation.state[self._t])

    def rows(self, times: Sequence[Scalar], progress: Progress | None = None) -> list[Row]:
        """Rows at guarded dimensionless ``times``, in guarded numbers."""
        found = []
        for time in times:
            if not time or time >= self._reached:
                found.append(self.end_row if time else self.start_row)
            else:
                found.append(self._row_at(time))
        return found

    @cached_property
    def _knots(self) -> list[tuple[Scalar, Any, Any]]:
        """The time, the own time and the series of each step's begin."""
        outputs: list[Any] = []
        self._read(lambda output, low, high: outputs.append(output), None)
        guarded = self.precision.guarded
        return [
            (guarded(output(own)[self._t]), own, output)
            for output in outputs
            for own in output.times
        ]

    def _row_at(self, time: Scalar) -> Row:
        guarded, number = self.precision.guarded, self.precision.number
        knots = self._knots
        place = max(bisect.bisect_right(knots, time, key=lambda one: one[0]) - 1, 0)
        _, own, output = knots[place]
        _, later, _ = knots[min(place + 1, len(knots) - 1)]
        # Newton's method from the end of the step where t rises faster: it then comes from one side
        ends = [guarded(own), guarded(later)]
        inner = max(ends, key=lambda x: self._clock(tuple(map(guarded, output(number(x))))))
        best = None
        for _ in range(NEWTON_STEPS):
            row = tuple(map(guarded, output(number(inner))))
            rest = time - row[self._t]
            if best is not None and abs(rest) >= abs(best[0]):
                break
            best = rest, row
            inner += rest / self._clock(row)
        assert best is not None
        return self._moved(best[1], best[0])

    def _clock(self, row: Row) -> Scalar:
        form = self.setup.formulation
        assert form.clock is not None
        return form.clock(form.State(*row[: len(form.columns)]), self.precision.context)

    def _moved(self, row: Row, delay: Scalar) -> Row:
        # the delay is one of t, and rates are those along the own time
        return super()._moved(row, delay / self._clock(row) if delay and row[self._t] else 0)


PLACES = 16  # at which events look for changes of sign
TERMS_OF_MP = 0.35  # for each bit: fewer series terms cost accuracy, more of them only time


def terms_for(bits: int) -> int:
    """How many coefficients are used in an arithmetic of so many bits."""
    return int(TERMS_OF_MP * bits) + 2


class OnsetOutput(RowwiseOutput):
    """Rows of an ``OnsetSeries`` over its time; its states are those of the polar ``setup``."""

    def __init__(self, setup: Setup, start: InitialState, onset: OnsetSeries, quadratures: Row):
        self.onset, self.quadratures = onset, quadratures
        context = setup.precision.context
        self.arrives = onset.until >= start.until
        self._until = start.until if self.arrives else onset.until
        super().__init__(setup, start, None)  # type: ignore[arg-type]
        number = setup.precision.number
        self.propagation = Propagation(
            status="complete" if self.arrives else "fast",
            time=number(self._until),
            time_low=number(context.mpf(0)),
            state=tuple(map(number, self.end_row)),
            steps=1,
            order=onset.coefficients.shape[1] - 1,
            hits=tuple(self._hits()),
        )

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the series, or of the horizon if that comes first."""
        return self._until

    @cached_property
    def start_row(self) -> Row:
        """The row at rest; ln v is -infinity there."""
        return self._row(self.precision.context.mpf(0))

    @cached_property
    def end_row(self) -> Row:
        """The row at ``end_time``."""
        return self._row(self._until)

    def rows(self, times: Sequence[Scalar], progress: Progress | None = None) -> list[Row]:
        """Rows at guarded dimensionless ``times``."""
        return [self._row(time) for time in times]

    def _row(self, time: Scalar) -> Row:
        return (*self._state(time), *self._recorded(time))

    def _state(self, time: Scalar) -> Row:
        fn = self.precision.context
        *body, v, ex, ey = self.onset.at(time, fn)
        glide = fn.log(v) if v > 0 else -fn.inf
        if self.setup.formulation.coordinates == "euler":
            # the direction in the frame of the axis, as a gliding velocity of size 1
            euler = euler_from_vectors(self.start.body, NewtonState(*(*body, ex, ey)), fn)
            return (*euler[:4], glide, euler.nu_x, euler.nu_y, time)
        return (*body, glide, ex, ey, time)

    def _recorded(self, time: Scalar) -> Row:
        if not time:
            return self.quadratures
        fn = self.precision.context

        def rate(name: str) -> Callable[[Scalar], Scalar]:
            return lambda t: QUANTITIES[QUADRATURES[name]].evaluate(self._vector_motion(t))

        return tuple(
            before + fn.quad(rate(name), [0, time], method="gauss-legendre") / QUADRATURE_SCALE
            for name, before in zip(self.setup.record, self.quadratures, strict=True)
        )

    def _vector_motion(self, time: Scalar) -> Motion:
        fn = self.precision.context
        *body, v, ex, ey = self.onset.at(time, fn)
        state = NewtonState(*(*body, v * ex, v * ey))
        return Motion(self.start.body, state, fn)

    def _motion(self, time: Scalar) -> Motion:
        setup, fn = self.setup, self.precision.context
        quadratures = tuple(fn.mpf(0) for _ in setup.record)
        row = (*self._state(time), *quadratures)
        return motion(setup.formulation, setup.record, self.start.body, row, fn)

    def _hits(self) -> list[Hit]:
        fn, number = self.precision.context, self.precision.number
        times = (
            [self._until * k / PLACES for k in range(1, PLACES + 1)] if self.setup.events else []
        )
        motions = dict(zip(times, map(self._motion, times), strict=True))
        found = []
        for name, event in self.setup.watched.items():
            value = partial(self._value, event, motions)
            values = [value(t) for t in times]
            for before, after, low, high in zip(values, values[1:], times, times[1:], strict=False):
                direction = 1 if after > before else -1
                wanted = not event.direction or event.direction == direction
                if (before > 0) != (after > 0) and wanted:
                    time = fn.findroot(value, (low, high), solver="anderson")
                    state = tuple(map(number, self._row(time)))
                    found.append(Hit(name, number(time), direction, state))
        return sorted(found, key=lambda hit: hit.time)

    def _value(self, event: Event, motions: Mapping[Scalar, Motion], t: Scalar) -> Scalar:
        if event.of_rate:
            return self.precision.context.diff(lambda s: event.function(self._motion(s)), t)
        return event.function(motions[t] if t in motions else self._motion(t))
