"""``Trajectory``: what ``integrate`` returns, and everything that is asked of it afterwards."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from tt_precise.body import Dimension
from tt_precise.initial_state import InitialState
from tt_precise.integrate.dense_output import (
    ARRIVED,
    DenseOutput,
    Propagation,
    State,
    Status,
    as_fraction,
)
from tt_precise.integrate.precision import Precision
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.system import full_tolerance
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.quantities import Motion
from tt_precise.numerals import to_mpmath
from tt_precise.scene import Scene

if TYPE_CHECKING:
    import pandas

    from tt_precise.integrate.inversion import InversionTimes

Numbers = Literal["native", "float", "text"]


class Trajectory:
    """A solution of a scene, from t = 0 to ``t_end``.

    Look at ``status`` before anything else: only "complete" reached the scene's horizon as a
    top on a table; "contact_ignored" got there with g_n <= 0 on the way, which was asked for with
    ``contact="bilateral"``; the others ended where the model ended, and nothing is ever given
    beyond ``t_end``.

    Attributes
    ----------
    status
        "complete", "contact_ignored", "contact_lost", "singular_contact", "pole" or "failed".
    t_end
        Where the solution ends, in s.
    steps, order
        Taylor steps taken, and their order.
    state
        ``State`` at ``t_end``.
    """

    def __init__(self, scene: Scene, setup: Setup, start: InitialState, propagation: Propagation):
        self.scene, self.setup, self.start = scene, setup, start
        self._dense_output = DenseOutput(setup, start, propagation)
        self.status: Status = propagation.status
        self.steps, self.order = propagation.steps, propagation.order

    def __repr__(self) -> str:
        return (
            f"<Trajectory of {self.scene.name}: {self.status}, t_end = {self.t_end} s, "
            f"{self.precision.name}, {self.formulation}, {self.steps} steps>"
        )

    @property
    def precision(self) -> Precision:
        """The working precision."""
        return self.setup.precision

    @property
    def formulation(self) -> str:
        """The coordinates integrated in: "newton" or "euler"."""
        return self.setup.formulation.coordinates

    @property
    def tolerance(self) -> Any:
        """heyoka's relative tolerance that was integrated with, an mpmath number."""
        given = self.precision.context.mpf(self.setup.tolerance)
        return given or full_tolerance(self.precision)

    @cached_property
    def t_end(self) -> Any:
        """Where the solution ends, in s: a float in double, else an mpmath number."""
        return self._dense_output.leaving(self._dense_output.end_time * self.start.units.time)

    @cached_property
    def state(self) -> State:
        """The state at ``t_end``."""
        dense_output = self._dense_output
        return dense_output.states([dense_output.end_time], [dense_output.end_row])[0]

    def at(self, t: str | int | float | Fraction | Any) -> State:
        """The state at time ``t`` (s) from the Taylor series of the step around it.

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end]: a solution is never extrapolated.
        """
        time = self._dense_output.dimensionless_time(t)
        return self._dense_output.states([time], self._dense_output.rows([time]))[0]

    def motion(self, t: str | int | float | Fraction | Any) -> Motion:
        """What every quantity is computed from at time ``t`` (s), dimensionless (m = R = g = 1).

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end].
        """
        return self._dense_output.motion(
            self._dense_output.rows([self._dense_output.dimensionless_time(t)])[0]
        )

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to ``t_end``, which is added where it ends early."""
        if self.status in ARRIVED:
            return self.scene.sample_times
        end = as_fraction(self._dense_output.end_time * self.start.units.time)
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

        wanted = names or self._dense_output.columns
        exact_times = self.sample_times if times is None else [as_fraction(t) for t in times]
        inner_times = [self._dense_output.dimensionless_time(t) for t in exact_times]
        context = self.precision.context
        columns: dict[str, Any] = {"t": [to_mpmath(t, context) for t in exact_times]}
        if self.precision.name == "double" and numbers != "text":
            columns |= self._dense_output.evaluate_arrays(wanted, inner_times)
        else:
            columns |= self._dense_output.evaluate(wanted, self._dense_output.rows(inner_times))
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
        hits = sorted(self._dense_output.propagation.hits, key=lambda hit: hit.time)
        states = self._dense_output.states(
            [guarded(hit.time) for hit in hits], [tuple(map(guarded, hit.state)) for hit in hits]
        )
        rows = [
            {"name": hit.name, "t": state.t, "direction": hit.direction, **state.values}
            for hit, state in zip(hits, states, strict=True)
        ]
        names = ["name", "t", "direction", *self._dense_output.columns]
        return pandas.DataFrame(rows, columns=names)

    @cached_property
    def suspect_events(self) -> tuple[str, ...]:
        """Events of which one may be missing: the function rises, or falls, twice in a row.

        heyoka can miss two roots in one step; then the directions still alternate, but a missed
        single root breaks the pattern. Minima and maxima of theta are looked at together.
        """
        directions: dict[str, list[int]] = {}
        for name, direction in zip(self.events["name"], self.events["direction"], strict=True):
            kind = "turning points" if name in ("theta_min", "theta_max") else name
            directions.setdefault(kind, []).append(int(direction))
        if not {"theta_min", "theta_max"} <= set(self.setup.events):
            directions.pop("turning points", None)
        return tuple(
            name
            for name, signs in directions.items()
            if any(a * b != -1 for a, b in itertools.pairwise(signs))
        )

    @cached_property
    def drift(self) -> dict[str, Any]:
        """Largest relative drift of everything the scene conserves, over samples and end.

        Computed from the states in mpmath with guard bits, not in the working precision.
        """
        return {name: max(values) for name, values in self.drift_over_time().items()}

    def drift_over_time(self) -> dict[str, list[Any]]:
        """Relative drift of everything the scene conserves, at each sample and the end."""
        times = [self._dense_output.dimensionless_time(t) for t in self.sample_times[:-1]]
        rows = [*self._dense_output.rows(times), self._dense_output.end_row]
        exact_start = self.setup.formulation.start(
            self.start.body, self.start.vectors, self.start.euler
        )
        recorded = (self.precision.context.mpf(0),) * len(self.setup.record)
        motions = [
            self._dense_output.motion((*exact_start, *recorded)),
            *map(self._dense_output.motion, rows),
        ]
        return {
            integral.name: drift(integral, motions)[1:]
            for integral in conserved(self.scene)
            if self._dense_output.has_azimuth or not integral.azimuth
            if self.formulation == "newton" or integral.name != "axis_norm"
        }

    def dimension(self, name: str) -> Dimension:
        """The dimension of a column; refuses names that ``frame`` does not know."""
        return self._dense_output.dimension(name)

    @cached_property
    def error_estimate(self) -> dict[str, Any]:
        """Estimated absolute error of each entry of ``state`` (SI) and of ``t_end`` (s).

        The distance from a run that has at least 100 times smaller errors: the same arithmetic at
        its full accuracy where the tolerance is coarser, else the next finer arithmetic. It is
        made when this is first asked for; see ``accuracy.judges``.
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
