"""``DenseOutput``: the rows of one propagation at any time, from the Taylor series of its steps.

heyoka evaluates the series of a step in a buffer that its next evaluation overwrites, so one
thread at a time evaluates, and what is returned is a copy.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

from tt_precise.arithmetic import Array, Scalar
from tt_precise.body import Parameters
from tt_precise.errors import InputError
from tt_precise.initial_state import InitialState
from tt_precise.integrate.columns import Row
from tt_precise.integrate.propagate import ARRIVED, Propagation, propagate
from tt_precise.integrate.quadratures import extended_rates
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.times import Times
from tt_precise.numerals import as_fraction, to_mpmath

TIME_TOLERANCE = Fraction(1, 10**15)  # of t_end; a t_end printed with 16 digits is still inside


class DenseOutput:
    """Rows over the time of a propagation, dimensionless: in guarded numbers or in double.

    May be used by several threads at once.
    """

    def __init__(self, setup: Setup, start: InitialState, propagation: Propagation):
        self.setup, self.start, self.propagation = setup, start, propagation
        self.precision = setup.precision
        self._lock = threading.Lock()

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the solution: the exact horizon where it was reached."""
        if self.propagation.status in ARRIVED:
            return self.start.until
        return self._reached

    @cached_property
    def end(self) -> Scalar:
        """The end of the solution in s."""
        return self.end_time * self.start.units.time

    @cached_property
    def start_row(self) -> Row:
        """The row at t = 0, not rounded to heyoka's precision: v = 0 there is exactly 0."""
        zero = self.precision.context.mpf(0)
        return (*self.start.state(self.setup.formulation), *(zero for _ in self.setup.record))

    @cached_property
    def end_row(self) -> Row:
        """The row at ``end_time``."""
        if not self.end_time:
            return self.start_row
        row = tuple(map(self.precision.guarded, self.propagation.state))
        return self._moved(row, self.end_time - self._reached)

    @cached_property
    def _reached(self) -> Scalar:
        return sum(map(self.precision.guarded, (self.propagation.time, self.propagation.time_low)))

    def dimensionless_time(self, t: Any) -> Scalar:
        """A time in s as a guarded dimensionless one.

        Raises
        ------
        InputError
            It lies outside the trajectory.
        """
        wanted = as_fraction(t)
        time = to_mpmath(wanted, self.precision.context)
        if wanted < 0 or time > self._latest:
            raise InputError(
                f"t: got {float(wanted):.17g} s, expected 0 to {float(self.end):.17g} s, where the "
                f"trajectory ends ({self.propagation.status}); it is never extrapolated"
            )
        if time >= self.end or self._as_given(time) == self._as_given(self.end):
            return self.end_time
        return time / self.start.units.time

    @cached_property
    def _latest(self) -> Scalar:
        return self.end * (1 + to_mpmath(TIME_TOLERANCE, self.precision.context))

    def _as_given(self, time: Scalar) -> Scalar:
        return float(time) if self.precision.name == "double" else time

    def rows(self, times: Sequence[Scalar]) -> list[Row]:
        """Rows at guarded dimensionless ``times``, in guarded numbers."""
        number, guarded = self.precision.number, self.precision.guarded
        rows = []
        for time in times:
            if not time or time == self.end_time:
                rows.append(self.end_row if time else self.start_row)
                continue
            rounded = number(time)
            row = tuple(map(guarded, self._interpolated(rounded)))
            rows.append(self._moved(row, time - guarded(rounded)))
        return rows

    def times(self, times: Sequence[Fraction]) -> Times:
        """Exact times in s for ``arrays``; those within ``TIME_TOLERANCE`` of the end are the end.

        Raises
        ------
        InputError
            One lies outside the trajectory.
        """
        import numpy

        for extreme in (min(times, default=Fraction(0)), max(times, default=Fraction(0))):
            self.dimensionless_time(extreme)
        seconds, rounded, delay = Times.of(times, self.start.units.time)
        end = float(self.end_time)
        at_end = seconds >= float(self.end)
        return Times(
            seconds,
            numpy.where(at_end, end, rounded),
            numpy.where(at_end, float(self.end_time - end), delay),
        )

    def arrays(self, times: Times, number: Callable[[Scalar], Any] = float) -> tuple[Array, ...]:
        """The rows of a run in double at all ``times`` at once: an array for each entry.

        ``number`` makes the arrays' numbers of guarded ones: ``float``, or ``long_double``, in
        which an entry keeps what a delay of less than an ulp of time adds to it.
        """
        import numpy

        state, outputs, rounded = self.propagation.state, self._outputs, times.rounded
        kind = type(number(self.precision.context.mpf(0)))
        entries = [numpy.full(len(rounded), x, dtype=kind) for x in state]
        if outputs:  # none for a horizon of zero
            ends = numpy.array([output.bounds[1] for output in outputs[:-1]], dtype=float)
            piece = numpy.searchsorted(ends, rounded)
            for part, output in enumerate(outputs):
                chosen = piece == part
                with self._lock:
                    values = output(rounded[chosen]).T
                for entry, found in zip(entries, values, strict=True):
                    entry[chosen] = found
        start = self.start.map(number).state(self.setup.formulation)
        for entry, value in zip(entries, start, strict=False):
            entry[rounded == 0] = value
        return moved_arrays(self.setup, self.start.body.map(number), tuple(entries), times.delay)

    def _interpolated(self, time: Any) -> tuple[Any, ...]:
        outputs = self._outputs
        if not outputs:
            return self.propagation.state
        output = next((one for one in outputs if time <= one.bounds[1]), outputs[-1])
        with self._lock:
            return tuple(output(time))

    @cached_property
    def _outputs(self) -> tuple[Any, ...]:
        """heyoka's dense outputs, one behind the other; none for a horizon of zero."""
        if self.propagation.outputs or not self.propagation.steps:
            return self.propagation.outputs
        until = self.propagation.time if self.propagation.status == "failed" else None
        again = propagate(self.setup, self.start, until=until, dense=True)
        if again.state != self.propagation.state:
            raise RuntimeError("the same integration gave another result when it was repeated")
        return again.outputs

    def _moved(self, row: Row, delay: Scalar) -> Row:
        # heyoka takes times rounded to its precision, which costs up to t eps of state at late
        # times; one Euler step over the rounding (about 1e-14) gives that back
        if not delay:
            return row
        setup = self.setup
        rates = extended_rates(
            setup.formulation, setup.record, self.start.body, row, self.precision.context
        )
        return tuple(x + rate * delay for x, rate in zip(row, rates, strict=True))


def moved_arrays(
    setup: Setup, body: Parameters, entries: tuple[Array, ...], delay: Array
) -> tuple[Array, ...]:
    """Entries at rounded times, as they are a ``delay`` of less than an ulp of time later.

    ``body`` is the dimensionless one in numbers of the entries' kind.
    """
    import numpy

    with numpy.errstate(all="ignore"):
        rates = extended_rates(setup.formulation, setup.record, body, entries, numpy)
        moved = [x + rate * delay for x, rate in zip(entries, rates, strict=True)]
    # at a pole the rates of phi and psi are undefined; there the entry stands as it is
    return tuple(numpy.where(numpy.isfinite(m), m, x) for m, x in zip(moved, entries, strict=True))
