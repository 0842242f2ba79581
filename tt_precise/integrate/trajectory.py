"""``Trajectory``: what ``integrate`` returns, and everything that is asked of it afterwards."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from tt_precise.arithmetic import Scalar
from tt_precise.body import Dimension
from tt_precise.initial_state import InitialState
from tt_precise.integrate.accuracy import End, error_estimate, reference_runs, worst_digits
from tt_precise.integrate.columns import Columns, State
from tt_precise.integrate.contact import require_contact
from tt_precise.integrate.dense_output import DenseOutput
from tt_precise.integrate.inversion import NEEDED, InversionTimes, from_events
from tt_precise.integrate.precision import Precision
from tt_precise.integrate.propagate import ARRIVED, Propagation, Status, propagate
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.system import full_tolerance
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.quantities import Motion, jellett
from tt_precise.numerals import as_fraction, to_mpmath
from tt_precise.progress import Progress
from tt_precise.scene import Scene

if TYPE_CHECKING:
    import pandas

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
        "complete", "contact_ignored", "contact_lost", "singular_contact", "sticking", "pole" or
        "failed".
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
        self._columns = Columns(setup, start)
        self.status: Status = propagation.status
        self.steps, self.order = propagation.steps, propagation.order

    @classmethod
    def of(cls, scene: Scene, setup: Setup, progress: Progress | None = None) -> Trajectory:
        """Integrate ``scene`` once, as ``setup`` says.

        Raises
        ------
        InputError
            The top is not on the table at t = 0.
        """
        start = InitialState.of(scene, setup.precision.arithmetic)
        require_contact(scene.name, start, setup.precision.context, setup.contact)
        return cls._from(scene, setup, start, progress)

    @classmethod
    def _from(
        cls, scene: Scene, setup: Setup, start: InitialState, progress: Progress | None = None
    ) -> Trajectory:
        # wide arithmetics take seconds, so there the dense output is kept at once, not made again
        dense = setup.precision.name in ("quad", "mp")
        return cls(scene, setup, start, propagate(setup, start, dense=dense, progress=progress))

    def again(self, *, rounded_otherwise: bool = False, **changes: Any) -> Trajectory:
        """The same scene integrated again, with some fields of the ``Setup`` replaced.

        With ``rounded_otherwise`` every number of body and start lies on the other side of the
        exact one: what such a run differs by contains what their rounding does to a run.
        """
        setup = self.setup.but(**changes)
        if not rounded_otherwise:
            return Trajectory.of(self.scene, setup)
        start = InitialState.of(self.scene, setup.precision.arithmetic)
        return Trajectory._from(self.scene, setup, start.map(setup.precision.other_side))

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
    def t_end(self) -> Scalar:
        """Where the solution ends, in s: a float in double, else an mpmath number."""
        return self._columns.leaving(self._dense_output.end)

    @cached_property
    def state(self) -> State:
        """The state at ``t_end``."""
        return self._columns.states([self._dense_output.end_time], [self._dense_output.end_row])[0]

    @property
    def end(self) -> End:
        """How and where the solution ends."""
        return End(self.status, self.t_end, self.state.values)

    def at(self, t: str | int | float | Fraction | Any) -> State:
        """The state at time ``t`` (s) from the Taylor series of the step around it.

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end]: a solution is never extrapolated.
        """
        time = self._dense_output.dimensionless_time(t)
        return self._columns.states([time], self._dense_output.rows([time]))[0]

    def motion(self, t: str | int | float | Fraction | Any) -> Motion:
        """What every quantity is computed from at time ``t`` (s), dimensionless (m = R = g = 1).

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end].
        """
        time = self._dense_output.dimensionless_time(t)
        return self._columns.motion(self._dense_output.rows([time])[0])

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to ``t_end``, which is added where it ends early."""
        if self.status in ARRIVED:
            return self.scene.sample_times
        end = as_fraction(self._dense_output.end)
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

        wanted = names or self._columns.names
        exact_times = self.sample_times if times is None else [as_fraction(t) for t in times]
        inner_times = [self._dense_output.dimensionless_time(t) for t in exact_times]
        context = self.precision.context
        columns: dict[str, Any] = {"t": [to_mpmath(t, context) for t in exact_times]}
        if self.precision.name == "double" and numbers != "text":
            columns |= self._columns.of_arrays(wanted, self._dense_output.arrays(inner_times))
        else:
            columns |= self._columns.of_rows(wanted, self._dense_output.rows(inner_times))
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
        states = self._columns.states(
            [guarded(hit.time) for hit in hits], [tuple(map(guarded, hit.state)) for hit in hits]
        )
        rows = [
            {"name": hit.name, "t": state.t, "direction": hit.direction, **state.values}
            for hit, state in zip(hits, states, strict=True)
        ]
        names = ["name", "t", "direction", *self._columns.names]
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
        motions = list(map(self._columns.motion, [self._dense_output.start_row, *rows]))
        return {
            integral.name: drift(integral, motions)[1:]
            for integral in conserved(self.scene)
            if self._columns.has_azimuth or not integral.azimuth
            if self.formulation == "newton" or integral.name != "axis_norm"
        }

    def dimension(self, name: str) -> Dimension:
        """The dimension of a column; refuses names that ``frame`` does not know."""
        return self._columns.dimension(name)

    @cached_property
    def error_estimate(self) -> dict[str, Scalar]:
        """Estimated absolute error of each entry of ``state`` (SI) and of ``t_end`` (s).

        The largest distance from reference runs, which are made when this is first asked for:
        see ``accuracy.reference_runs``.
        """
        return error_estimate(
            self.end, (run.end for run in self.reference_runs()), self.precision.context
        )

    def reference_runs(self) -> Iterator[Trajectory]:
        """The runs that ``error_estimate`` compares this one with, one after the other."""
        for changes in reference_runs(self.setup):
            yield self.again(**changes)

    @cached_property
    def digits(self) -> float:
        """Significant digits that ``error_estimate`` leaves to the worst entry of ``state``."""
        return worst_digits(self.state, self.error_estimate, self.start.units)

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending time of the climb, in the three definitions.

        Integrates again, in the same set-up, if it lacks the events.
        """
        complete = set(NEEDED) <= set(self.setup.events)
        run = self if complete else self.again(events=NEEDED, record=())
        double = self.precision.name == "double"
        return from_events(
            run.events,
            math.pi if double else +self.precision.context.pi,
            mirrored=bool(jellett(self.start.motion(self.precision.context)) < 0),
        )

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
