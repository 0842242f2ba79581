"""From heyoka's own numbers to states and quantities in SI, at any time of a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from numbers import Integral
from typing import Any, Literal

from tt_precise.body import Dimension, Parameters
from tt_precise.errors import InputError
from tt_precise.initial_state import InitialState
from tt_precise.integrate.precision import Precision
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.system import QUADRATURE_SCALE, Hit, extended_rates, motion
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.numerals import exact, to_mpmath

Status = Literal[
    "complete", "contact_ignored", "contact_lost", "singular_contact", "pole", "failed"
]
ARRIVED: tuple[Status, ...] = ("complete", "contact_ignored")  # at the scene's horizon

VECTOR_COLUMNS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER_COLUMNS = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
TIME_TOLERANCE = Fraction(1, 10**15)  # of t_end; a t_end printed with 16 digits is still inside


@dataclass(frozen=True)
class Propagation:
    """How one propagation went, in heyoka's own numbers, dimensionless.

    The end is at ``time`` + ``time_low``: a step to an event ends between two numbers.
    """

    status: Status
    time: Any
    time_low: Any
    state: tuple[Any, ...]
    steps: int
    order: int
    hits: tuple[Hit, ...]
    outputs: tuple[Any, ...]


@dataclass(frozen=True)
class State:
    """A state at one time, in SI: ``t`` in s, then name to number, None where undefined.

    Names are those of the trajectory file: kx ... vy, theta ... nu_y, and what was recorded.
    """

    t: Any
    values: dict[str, Any]
    precision: Precision

    def __getattr__(self, name: str) -> Any:
        try:
            # through __dict__, which is empty while a copy is being made
            return self.__dict__["values"][name]
        except KeyError:
            raise AttributeError(name) from None

    def as_text(self) -> dict[str, str | None]:
        """Every value in decimals, enough to recover the working precision."""
        return {
            name: None if value is None else self.precision.text(self.precision.context.mpf(value))
            for name, value in self.values.items()
        }


class DenseOutput:
    """One propagation, read: guarded dimensionless rows inside, SI outside.

    A row is the state with the recorded quadratures behind it, as guarded mpmath numbers.
    """

    def __init__(self, setup: Setup, start: InitialState, propagation: Propagation):
        self.setup, self.start, self.propagation = setup, start, propagation
        self.form, self.precision = setup.formulation, setup.precision

    @cached_property
    def end_time(self) -> Any:
        """Dimensionless end of the solution: the exact horizon where it was reached."""
        if self.propagation.status in ARRIVED:
            return self.start.until
        return self._reached

    @cached_property
    def start_row(self) -> tuple[Any, ...]:
        """The row at t = 0, not rounded to heyoka's precision: v = 0 there is exactly 0."""
        start, zero = self.start, self.precision.context.mpf(0)
        first = self.form.start(start.body, start.vectors, start.euler)
        return (*first, *(zero for _ in self.setup.record))

    @cached_property
    def end_row(self) -> tuple[Any, ...]:
        """The row at ``end_time``."""
        if not self.end_time:
            return self.start_row
        row = tuple(map(self.precision.guarded, self.propagation.state))
        return self._moved(row, self.end_time - self._reached)

    @cached_property
    def _reached(self) -> Any:
        return sum(map(self.precision.guarded, (self.propagation.time, self.propagation.time_low)))

    def _moved(self, row: tuple[Any, ...], delay: Any) -> tuple[Any, ...]:
        # heyoka takes times rounded to its precision, which costs up to t eps of state at late
        # times; one Euler step over the rounding (about 1e-14) gives that back
        if not delay:
            return row
        rates = extended_rates(
            self.form, self.setup.record, self.start.body, row, self.precision.context
        )
        return tuple(x + rate * delay for x, rate in zip(row, rates, strict=True))

    def dimensionless_time(self, t: Any) -> Any:
        """A time in s as a guarded dimensionless one; refused outside the trajectory."""
        wanted = as_fraction(t)
        time = to_mpmath(wanted, self.precision.context)
        end = self._end
        if wanted < 0 or time > self._latest:
            raise InputError(
                f"t: got {float(wanted):.17g} s, expected 0 to {float(end):.17g} s, where the "
                f"trajectory ends ({self.propagation.status}); it is never extrapolated"
            )
        if time >= end or self.leaving(time) == self.leaving(end):
            return self.end_time
        return time / self.start.units.time

    @cached_property
    def _end(self) -> Any:
        return self.end_time * self.start.units.time

    @cached_property
    def _latest(self) -> Any:
        return self._end * (1 + to_mpmath(TIME_TOLERANCE, self.precision.context))

    @cached_property
    def _outputs(self) -> tuple[Any, ...]:
        """heyoka's dense outputs, one behind the other; none for a horizon of zero."""
        if self.propagation.outputs or not self.propagation.steps:
            return self.propagation.outputs
        from tt_precise.integrate.propagate import propagate

        until = self.propagation.time if self.propagation.status == "failed" else None
        again = propagate(self.setup, self.start, until=until, dense=True)
        if again.state != self.propagation.state:
            raise RuntimeError("the same integration gave another result when it was repeated")
        return again.outputs

    def _interpolated(self, time: Any) -> Any:
        for output in self._outputs:
            if time <= output.bounds[1]:
                return output(time)
        return self._outputs[-1](time) if self._outputs else self.propagation.state

    def rows(self, times: Sequence[Any]) -> list[tuple[Any, ...]]:
        """States at guarded dimensionless ``times``, in guarded numbers."""
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

    def arrays(self, times: Sequence[Any]) -> tuple[Any, ...]:
        """The same in double, all times at once: one float64 array for each entry."""
        import numpy

        rounded = numpy.array([float(time) for time in times])
        if self._outputs:
            ends = numpy.array([output.bounds[1] for output in self._outputs[:-1]], dtype=float)
            piece = numpy.searchsorted(ends, rounded)
            # all times of a piece at once: a call with one time returns a buffer that the next
            # call overwrites
            entries = [numpy.empty(len(rounded)) for _ in self.propagation.state]
            for number, output in enumerate(self._outputs):
                chosen = piece == number
                for entry, values in zip(entries, output(rounded[chosen]).T, strict=True):
                    entry[chosen] = values
        else:  # a horizon of zero
            entries = [numpy.full(len(rounded), float(x)) for x in self.propagation.state]
        for entry, value in zip(entries, self._float_start, strict=False):
            entry[rounded == 0] = value
        delay = numpy.array([float(t - r) for t, r in zip(times, rounded.tolist(), strict=True)])
        return self.moved_arrays(tuple(entries), delay)

    def moved_arrays(self, entries: tuple[Any, ...], delay: Any) -> tuple[Any, ...]:
        """Entries at rounded times, as they are a ``delay`` of less than an ulp of time later."""
        import numpy

        with numpy.errstate(all="ignore"):
            rates = extended_rates(
                self.form, self.setup.record, self._float_body, tuple(entries), numpy
            )
            moved = [x + rate * delay for x, rate in zip(entries, rates, strict=True)]
        # at a pole the rates of phi and psi are undefined; there the entry stands as it is
        return tuple(
            numpy.where(numpy.isfinite(m), m, x) for m, x in zip(moved, entries, strict=True)
        )

    @cached_property
    def _float_start(self) -> tuple[float, ...]:
        start = self.start.map(float)
        return tuple(self.form.start(start.body, start.vectors, start.euler))

    @cached_property
    def _float_body(self) -> Parameters:
        return self.start.body.map(float)

    def motion(self, row: tuple[Any, ...]) -> Motion:
        """The ``Motion`` of a row."""
        return motion(self.form, self.setup.record, self.start.body, row, self.precision.context)

    @property
    def columns(self) -> tuple[str, ...]:
        """Default columns: vectors where the azimuth is known, Euler state, quadratures."""
        return (*(VECTOR_COLUMNS if self.has_azimuth else ()), *EULER_COLUMNS, *self.setup.record)

    @property
    def has_azimuth(self) -> bool:
        """Whether the direction of lean is known, and not only the Euler rates."""
        return self.form.coordinates == "newton" or "phi" in self.setup.record

    def evaluate(
        self, names: Sequence[str], rows: Sequence[tuple[Any, ...]]
    ) -> dict[str, list[Any]]:
        """Named columns (SI) of ``rows``; None where a quantity is undefined."""
        motions = [self.motion(row) for row in rows]
        columns: dict[str, list[Any]] = {}
        for name in names:
            factor = self.start.units.of_dimension(self.dimension(name))
            values = [self._entry(name, row, q) for row, q in zip(rows, motions, strict=True)]
            columns[name] = [None if value is None else value * factor for value in values]
        return columns

    def evaluate_arrays(self, names: Sequence[str], times: Sequence[Any]) -> dict[str, Any]:
        """The same in double at guarded dimensionless ``times``; NaN where undefined."""
        return self.columns_of(names, self.arrays(times))

    def columns_of(self, names: Sequence[str], arrays: tuple[Any, ...]) -> dict[str, Any]:
        """Named columns (SI) of entries in double, an array each; NaN where undefined."""
        import numpy

        q = motion(self.form, self.setup.record, self._float_body, arrays, numpy)
        columns = {}
        with numpy.errstate(all="ignore"):
            for name in names:
                factor = float(self.start.units.of_dimension(self.dimension(name)))
                columns[name] = self._entry(name, arrays, q) * factor * numpy.ones(len(arrays[0]))
        return columns

    def dimension(self, name: str) -> Dimension:
        """The dimension of a column; refuses unknown names."""
        if name in QUANTITIES:
            return QUANTITIES[name].dimension
        if name in self.columns:
            return STATE_DIMENSIONS[name]
        raise InputError(
            f"column: got {name[:60]!r}, expected one of: "
            + ", ".join(dict.fromkeys([*self.columns, *QUANTITIES]))
        )

    def _entry(self, name: str, row: tuple[Any, ...], q: Motion) -> Any:
        if name in self.setup.record:
            position = len(self.form.columns) + self.setup.record.index(name)
            return row[position] * QUADRATURE_SCALE
        if name in VECTOR_COLUMNS:
            return getattr(q.state, name)
        try:
            return QUANTITIES[name].evaluate(q)
        except ZeroDivisionError:  # the direction of lean, and what needs it, ends at the poles
            return None

    def states(self, times: Sequence[Any], rows: Sequence[tuple[Any, ...]]) -> list[State]:
        """The ``State`` (SI) of each row, at guarded dimensionless times."""
        columns = self.evaluate(self.columns, rows)
        unit, leaving = self.start.units.time, self.leaving
        return [
            State(
                leaving(time * unit),
                dict(zip(columns, map(leaving, row), strict=True)),
                self.precision,
            )
            for time, row in zip(times, zip(*columns.values(), strict=True), strict=True)
        ]

    def leaving(self, value: Any) -> Any:
        """A number as users get it: a float in double, else the guarded mpmath number."""
        return float(value) if self.precision.name == "double" and value is not None else value


def as_fraction(t: Any) -> Fraction:
    """The exact value of a time given as a string, or as an int, fraction, float of any kind.

    Raises
    ------
    InputError
        It is no finite number.
    """
    if hasattr(t, "_mpf_"):
        sign, mantissa, power, _ = t._mpf_
        if t - t != 0:
            raise InputError(f"t: got {t}, expected a finite time in s")
        value = Fraction(int(mantissa)) * Fraction(2) ** int(power)
        return -value if sign else value
    if isinstance(t, bool):
        return exact(t, "t")
    if isinstance(t, Integral):  # NumPy's integers too
        return Fraction(int(t))
    if not hasattr(t, "as_integer_ratio"):
        return exact(t, "t")
    try:
        return Fraction(*map(int, t.as_integer_ratio()))
    except (ValueError, OverflowError):
        raise InputError(f"t: got {t}, expected a finite time in s") from None
