"""``Trajectory``: what ``integrate`` returns, and everything that is asked of it afterwards."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from tt_precise.body import Parameters
from tt_precise.errors import InputError
from tt_precise.integrate.precision import Precision
from tt_precise.integrate.start import Beginning
from tt_precise.integrate.system import QUADRATURE_SCALE, Hit, Key, extended_rates, motion
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, Formulation
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.numerals import exact, to_mpmath
from tt_precise.scene import Scene

if TYPE_CHECKING:
    import pandas

    from tt_precise.integrate.inversion import InversionTimes

Status = Literal["complete", "contact_lost", "singular_contact", "pole", "failed"]
Numbers = Literal["native", "float", "text"]

VECTOR_COLUMNS = ("kx", "ky", "kz", "Lx", "Ly", "Lz", "vx", "vy")
EULER_COLUMNS = ("theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
TIME_TOLERANCE = Fraction(1, 10**15)  # of t_end; a t_end printed with 16 digits is still inside


@dataclass(frozen=True)
class Course:
    """How one propagation went, in heyoka's own numbers, dimensionless."""

    status: Status
    time: Any
    state: tuple[Any, ...]
    steps: int
    order: int
    hits: tuple[Hit, ...]
    output: Any


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
            return self.values[name]
        except KeyError:
            raise AttributeError(name) from None

    def as_text(self) -> dict[str, str | None]:
        """Every value in decimals, enough to recover the working precision."""
        return {
            name: None if value is None else self.precision.text(self.precision.context.mpf(value))
            for name, value in self.values.items()
        }


class Trajectory:
    """A solution of a scene, from t = 0 to ``t_end``.

    Look at ``status`` before anything else: only "complete" reached the scene's horizon; the
    others ended where the model ended, and nothing is ever given beyond ``t_end``.

    Attributes
    ----------
    status
        "complete", "contact_lost", "singular_contact", "pole" or "failed".
    t_end
        Where the solution ends, in s.
    steps, order
        Taylor steps taken, and their order.
    state
        ``State`` at ``t_end``.
    """

    def __init__(self, scene: Scene, key: Key, start: Beginning, course: Course):
        self.scene, self.key, self.start, self._course = scene, key, start, course
        self.status: Status = course.status
        self.steps, self.order = course.steps, course.order

    def __repr__(self) -> str:
        return (
            f"<Trajectory of {self.scene.name}: {self.status}, t_end = {self.t_end} s, "
            f"{self.precision.name}, {self.formulation}, {self.steps} steps>"
        )

    @property
    def precision(self) -> Precision:
        """The working precision."""
        return self.key.precision

    @property
    def formulation(self) -> str:
        """The coordinates integrated in: "newton" or "euler"."""
        return self.key.formulation.coordinates

    @cached_property
    def t_end(self) -> Any:
        """Where the solution ends, in s: a float in double, else an mpmath number."""
        return self._leaving(self._end_time * self.start.units.time)

    @cached_property
    def state(self) -> State:
        """The state at ``t_end``."""
        return self._state(self._end_time, self._end_state)

    def at(self, t: str | int | float | Fraction | Any) -> State:
        """The state at time ``t`` (s) from the Taylor series of the step around it.

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end]: a solution is never extrapolated.
        """
        time = self._dimensionless_time(t)
        return self._state(time, self._sample([time])[0])

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to ``t_end``, which is added where it ends early."""
        if self.status == "complete":
            return self.scene.sample_times
        end = _as_fraction(self._end_time * self.start.units.time)
        return (*(t for t in self.scene.sample_times if t < end), end)

    def frame(
        self,
        *names: str,
        times: Iterable[Any] | None = None,
        numbers: Numbers = "native",
    ) -> pandas.DataFrame:
        """A table over time, in SI: column ``t`` and one for each name.

        Parameters
        ----------
        names
            State entries (kx, theta, ...), recorded quadratures, or any quantity; by default
            all vector and Euler columns and what was recorded.
        times
            In s; by default the scene's samples.
        numbers
            "native" (float64 for double, mpmath numbers otherwise), "float" or "text".

        Values that are undefined (Euler rates at a pole) are missing.
        """
        import pandas

        wanted = names or self._default_columns()
        exact_times = self.sample_times if times is None else [_as_fraction(t) for t in times]
        inner_times = [self._dimensionless_time(t) for t in exact_times]
        context = self.precision.context
        columns: dict[str, Any] = {"t": [to_mpmath(t, context) for t in exact_times]}
        if self.precision.name == "double" and numbers != "text":
            columns |= self._evaluate_arrays(wanted, inner_times)
        else:
            columns |= self._evaluate(wanted, self._sample(inner_times))
        return pandas.DataFrame(
            {name: self._column(values, numbers) for name, values in columns.items()}
        )

    @cached_property
    def events(self) -> pandas.DataFrame:
        """All recorded events in order of time: name, t (s), direction, and the state there (SI).

        ``direction`` is +1 where the event's function rises through zero, -1 where it falls.
        """
        import pandas

        guarded = self.precision.guarded
        rows = []
        for hit in sorted(self._course.hits, key=lambda hit: hit.time):
            state = self._state(guarded(hit.time), tuple(map(guarded, hit.state)))
            rows.append(
                {"name": hit.name, "t": state.t, "direction": hit.direction, **state.values}
            )
        names = ["name", "t", "direction", *self._default_columns()]
        return pandas.DataFrame(rows, columns=names)

    @cached_property
    def drift(self) -> dict[str, Any]:
        """Largest relative drift of everything the scene conserves, over samples and end.

        Computed from the states in mpmath with guard bits, not in the working precision.
        """
        return {name: max(values) for name, values in self.drift_over_time().items()}

    def drift_over_time(self) -> dict[str, list[Any]]:
        """Relative drift of everything the scene conserves, at each sample and the end."""
        times = [self._dimensionless_time(t) for t in self.sample_times[:-1]]
        rows = [*self._sample(times), self._end_state]
        exact_start = self._form.start(self.start.vectors, self.start.euler)
        recorded = (self.precision.context.mpf(0),) * len(self.key.record)
        motions = [self._motion((*exact_start, *recorded)), *map(self._motion, rows)]
        return {
            integral.name: drift(integral, motions)[1:]
            for integral in conserved(self.scene)
            if self._has_azimuth or not integral.azimuth
            if self.formulation == "newton" or integral.name != "axis_norm"
        }

    @cached_property
    def error_estimate(self) -> dict[str, Any]:
        """Estimated absolute error of each entry of ``state`` (SI) and of ``t_end`` (s).

        The distance from a run in the next finer arithmetic, which has at least 1,000 times
        smaller errors; that run is made when this is first asked for.
        """
        from tt_precise.integrate.accuracy import error_estimate

        return error_estimate(self)

    @cached_property
    def digits(self) -> float:
        """Significant digits that ``error_estimate`` leaves to the worst entry of ``state``."""
        from tt_precise.integrate.accuracy import digits

        return digits(self)

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending time of the climb, in the three definitions."""
        from tt_precise.integrate.inversion import inversion_times

        return inversion_times(self)

    # ---- from heyoka's numbers to SI -------------------------------------------------------

    @property
    def _form(self) -> Formulation:
        return self.key.formulation

    @cached_property
    def _end_time(self) -> Any:
        if self.status == "complete":
            return self.start.until
        return self.precision.guarded(self._course.time)

    @cached_property
    def _end_state(self) -> tuple[Any, ...]:
        row = tuple(map(self.precision.guarded, self._course.state))
        return self._moved(row, self._end_time - self.precision.guarded(self._course.time))

    def _moved(self, row: tuple[Any, ...], delay: Any) -> tuple[Any, ...]:
        # heyoka takes times rounded to its precision, which costs up to t eps of state at late
        # times; one Euler step over the rounding (about 1e-14) gives that back
        if not delay:
            return row
        rates = extended_rates(
            self._form, self.key.record, self.start.body, row, self.precision.context
        )
        return tuple(x + rate * delay for x, rate in zip(row, rates, strict=True))

    def _dimensionless_time(self, t: Any) -> Any:
        wanted = _as_fraction(t)
        end = self._end_time * self.start.units.time
        slack = to_mpmath(TIME_TOLERANCE, self.precision.context) * end
        time = to_mpmath(wanted, self.precision.context)
        if wanted < 0 or time > end + slack:
            raise InputError(
                f"t: got {float(wanted):.17g} s, expected 0 to {float(end):.17g} s, where the "
                f"trajectory ends ({self.status}); it is never extrapolated"
            )
        return min(time, end) / self.start.units.time

    @cached_property
    def _output(self) -> Any:
        if self._course.output is not None:
            return self._course.output
        from tt_precise.integrate.run import run

        again = run(self.key, self.start, dense=True)
        if again.state != self._course.state:
            raise RuntimeError("the same integration gave another result when it was repeated")
        return again.output

    def _sample(self, times: Sequence[Any]) -> list[tuple[Any, ...]]:
        """States at guarded dimensionless ``times``, in guarded numbers."""
        number, guarded, output = self.precision.number, self.precision.guarded, self._output
        rows = []
        for time in times:
            rounded = number(time)
            if output is None:  # a horizon of zero: no step was taken
                row = tuple(map(guarded, self._course.state))
            else:
                row = tuple(map(guarded, output(rounded)))
            rows.append(self._moved(row, time - guarded(rounded)))
        return rows

    def _sample_arrays(self, times: Sequence[Any]) -> tuple[Any, ...]:
        """The same in double, all times at once: one float64 array for each entry."""
        import numpy

        rounded = numpy.array([float(time) for time in times])
        if self._output is None:
            entries = [numpy.full(len(rounded), float(v)) for v in self._course.state]
        else:
            entries = list(self._output(rounded).T)
        delay = numpy.array([float(t - r) for t, r in zip(times, rounded.tolist(), strict=True)])
        with numpy.errstate(all="ignore"):
            rates = extended_rates(
                self._form, self.key.record, self._float_body, tuple(entries), numpy
            )
            moved = [x + rate * delay for x, rate in zip(entries, rates, strict=True)]
        return tuple(
            numpy.where(numpy.isfinite(m), m, x) for m, x in zip(moved, entries, strict=True)
        )

    @cached_property
    def _float_body(self) -> Parameters:
        body = self.start.body
        return Parameters(**{f.name: float(getattr(body, f.name)) for f in fields(body)})

    def _motion(self, row: tuple[Any, ...]) -> Motion:
        return motion(self._form, self.key.record, self.start.body, row, self.precision.context)

    def _default_columns(self) -> tuple[str, ...]:
        return (*(VECTOR_COLUMNS if self._has_azimuth else ()), *EULER_COLUMNS, *self.key.record)

    @property
    def _has_azimuth(self) -> bool:
        return self.formulation == "newton" or "phi" in self.key.record

    def _evaluate(
        self, names: Sequence[str], rows: Sequence[tuple[Any, ...]]
    ) -> dict[str, list[Any]]:
        motions = [self._motion(row) for row in rows]
        columns: dict[str, list[Any]] = {}
        for name in names:
            factor = self.start.units.of_dimension(self._dimension(name))
            values = [self._entry(name, row, q) for row, q in zip(rows, motions, strict=True)]
            columns[name] = [None if value is None else value * factor for value in values]
        return columns

    def _evaluate_arrays(self, names: Sequence[str], times: Sequence[Any]) -> dict[str, Any]:
        import numpy

        arrays = self._sample_arrays(times)
        q = motion(self._form, self.key.record, self._float_body, arrays, numpy)
        columns = {}
        with numpy.errstate(all="ignore"):
            for name in names:
                factor = float(self.start.units.of_dimension(self._dimension(name)))
                columns[name] = self._entry(name, arrays, q) * factor * numpy.ones(len(times))
        return columns

    def _dimension(self, name: str) -> Any:
        if name in QUANTITIES:
            return QUANTITIES[name].dimension
        if name in self._default_columns():
            return STATE_DIMENSIONS[name]
        raise InputError(
            f"column: got {name[:60]!r}, expected one of: "
            + ", ".join(dict.fromkeys([*self._default_columns(), *QUANTITIES]))
        )

    def _entry(self, name: str, row: tuple[Any, ...], q: Motion) -> Any:
        if name in self.key.record:
            position = len(self._form.columns) + self.key.record.index(name)
            return row[position] * QUADRATURE_SCALE
        if name in VECTOR_COLUMNS:
            return getattr(q.state, name)
        try:
            return QUANTITIES[name].evaluate(q)
        except ZeroDivisionError:  # the direction of lean, and what needs it, ends at the poles
            return None

    def _state(self, time: Any, row: tuple[Any, ...]) -> State:
        columns = self._evaluate(self._default_columns(), [row])
        values = {name: self._leaving(value) for name, (value,) in columns.items()}
        return State(self._leaving(time * self.start.units.time), values, self.precision)

    def _leaving(self, value: Any) -> Any:
        return float(value) if self.precision.name == "double" and value is not None else value

    def _column(self, values: Any, numbers: Numbers) -> Any:
        import numpy

        if isinstance(values, numpy.ndarray):
            return numpy.where(numpy.isfinite(values), values, numpy.nan)
        if numbers == "text":
            return [None if value is None else self.precision.text(value) for value in values]
        if numbers == "float" or self.precision.name == "double":
            missing = float("nan")
            return numpy.array([missing if v is None else float(v) for v in values], dtype=float)
        return numpy.array(values, dtype=object)


def _as_fraction(t: Any) -> Fraction:
    if isinstance(t, float):
        if t != t or t in (float("inf"), float("-inf")):
            raise InputError(f"t: got {t}, expected a finite time in s")
        return Fraction(t)
    if hasattr(t, "_mpf_"):
        sign, mantissa, power, _ = t._mpf_
        value = Fraction(int(mantissa)) * Fraction(2) ** int(power)
        return -value if sign else value
    return exact(t, "t")
