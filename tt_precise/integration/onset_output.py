"""The first moments of gliding from rest, from their power series: rows and events."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

from tt_precise.integration.columns import Row
from tt_precise.integration.events import EXTREMUM, event_named
from tt_precise.integration.own_time import RowwiseOutput
from tt_precise.integration.propagate import Propagation
from tt_precise.integration.quadratures import QUADRATURE_SCALE, QUADRATURES, motion
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import Hit
from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.onset import OnsetSeries
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.progress import Progress

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
        if not self.setup.record or not time:
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
        for name in self.setup.events:
            event = event_named(name, "gliding")

            def value(t: Scalar, name: str = name, function: Any = event.function) -> Scalar:
                if name.startswith(EXTREMUM):
                    return fn.diff(lambda s: function(self._motion(s)), t)
                return function(motions[t] if t in motions else self._motion(t))

            values = [value(t) for t in times]
            for before, after, low, high in zip(values, values[1:], times, times[1:], strict=False):
                direction = 1 if after > before else -1
                wanted = not event.direction or event.direction == direction
                if (before > 0) != (after > 0) and wanted:
                    time = fn.findroot(value, (low, high), solver="anderson")
                    state = tuple(map(number, self._row(time)))
                    found.append(Hit(name, number(time), direction, state))
        return sorted(found, key=lambda hit: hit.time)
