"""Segments in a regularised time, whose state contains t."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy

from tt_precise.integration.columns import Row
from tt_precise.integration.dense_output import DenseOutput, Times
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Scalar

NEWTON_STEPS = 60  # at most; from a knot of the series 3 to 10 are needed


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
    def _reached(self) -> Scalar:
        return self.precision.with_guard_bits(self.propagation.state[self._t])

    def rows(self, times: Sequence[Scalar], progress: Progress | None = None) -> list[Row]:
        """Rows at guarded dimensionless ``times``, in guarded numbers."""
        rows = []
        for time in times:
            if not time or time >= self._reached:
                rows.append(self.end_row if time else self.start_row)
            else:
                rows.append(self._row_at(time))
        return rows

    @cached_property
    def _knots(self) -> list[tuple[Scalar, Any, Any]]:
        """The time, the regularised time and the series at the begin of each step."""
        outputs: list[Any] = []
        self._read(lambda output, low, high: outputs.append(output), None)
        with_guard_bits = self.precision.with_guard_bits
        return [
            (with_guard_bits(output(own)[self._t]), own, output)
            for output in outputs
            for own in output.times
        ]

    def _row_at(self, time: Scalar) -> Row:
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
            if best is not None and abs(rest) >= abs(best[0]):
                break
            best = rest, row
            inner += rest / self._clock(row)
        assert best is not None
        return self._moved(best[1], best[0])

    def _clock(self, row: Row) -> Scalar:
        form = self.setup.formulation
        return form.State(*row[: len(form.columns)]).clock(self.precision.context)

    def _moved(self, row: Row, delay: Scalar) -> Row:
        # the delay is one of t, and rates are those along the own time
        return super()._moved(row, delay / self._clock(row) if delay and row[self._t] else 0)
