"""``Trajectory``: what ``integrate`` returns, and everything that is asked of it afterwards."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Container, Iterable, Sequence
from fractions import Fraction
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, get_args

from tt_precise.integration.columns import POSE, POSE_NAMES, Name, State, expanded
from tt_precise.integration.dense_output import ARRIVED, Status
from tt_precise.integration.errors import Errors
from tt_precise.integration.events import not_alternating
from tt_precise.integration.inversion import NEEDED, InversionTimes, from_events
from tt_precise.integration.precision import Precision
from tt_precise.integration.run import integrated
from tt_precise.integration.segments import DIGITS, ERROR, Numbers, Run, Stretch
from tt_precise.integration.setup import Setup, full_tolerance
from tt_precise.mechanics.conserved import conserved
from tt_precise.mechanics.quantities import Motion, jellett
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.scene.body import Dimension
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.scene.scene import RECORDABLE, Scene

if TYPE_CHECKING:
    from pathlib import Path

    import pandas
    from matplotlib.figure import Figure

    from tt_precise.integration.variational import Derivatives


def is_estimate(name: Name) -> bool:
    """Whether a column of ``frame`` is one of estimated errors."""
    return isinstance(name, str) and (name == DIGITS or name.startswith(ERROR))


class Trajectory:
    """A solution of a scene, from t = 0 to ``t_end``; made by integrating as ``setup`` says.

    Look at ``status`` before anything else: only "complete" reached the scene's horizon as a
    top on a table; "contact_ignored" got there with g_n <= 0 on the way, which was asked for with
    ``contact="bilateral"``; the others ended where the model ended, and nothing is ever given
    beyond ``t_end``.

    Several threads may read from one trajectory. A pickle of it holds the scene and the set-up, no
    numbers and no code: it is integrated again where it is unpickled.

    Attributes
    ----------
    status
        "complete", "contact_ignored", "contact_lost", "singular_contact", "landed", "pole" or
        "failed".
    t_end
        Where the solution ends, in s.
    steps, order
        Taylor steps taken, and their order.
    state
        ``State`` at ``t_end``.
    sensitivity
        ``Derivatives`` by what ``integrate`` was given as ``sensitivity``, else None.
    """

    sensitivity: Derivatives | None = None

    def __init__(self, scene: Scene, run: Run, *, opposite_rounding: bool = False):
        self.scene, self.run, self.setup, self.start = scene, run, run.setup, run.start
        self.status: Status = run.status
        self.steps, self.order = run.steps, run.order
        self._opposite_rounding = opposite_rounding

    @classmethod
    def of(
        cls,
        scene: Scene,
        setup: Setup,
        progress: Progress | None = None,
        *,
        opposite_rounding: bool = False,
    ) -> Trajectory:
        """The scene integrated once, as the set-up says."""
        run = integrated(scene, setup, progress, opposite_rounding=opposite_rounding)
        return cls(scene, run, opposite_rounding=opposite_rounding)

    def again(self, *, opposite_rounding: bool = False, **changes: Any) -> Trajectory:
        """The same scene integrated again, with some fields of the ``Setup`` replaced.

        With ``opposite_rounding`` every number of body and start lies on the other side of the
        exact one: what such a run differs by contains what their rounding does to a run.
        """
        setup = self.setup.but(**changes)
        return Trajectory.of(self.scene, setup, opposite_rounding=opposite_rounding)

    def __reduce__(self) -> tuple[Any, ...]:
        # made again where it is unpickled: heyoka's own pickles are machine code
        make = partial(Trajectory.of, opposite_rounding=self._opposite_rounding)
        return make, (self.scene, self.setup)

    def __repr__(self) -> str:
        return (
            f"<Trajectory of {self.scene.name}: {self.status}, t_end = {self.shown_end} s, "
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
    def tolerance(self) -> Scalar:
        """heyoka's relative tolerance that was integrated with, an mpmath number."""
        return self.precision.context.mpf(self.setup.tolerance) or full_tolerance(self.precision)

    @property
    def pieces(self) -> tuple[Stretch, ...]:
        """Stretches of gliding, rolling, flight and contact, where there are several; else one."""
        return self.run.stretches

    @cached_property
    def t_end(self) -> Scalar:
        """Where the solution ends, in s: a float in double, else an mpmath number."""
        return self.run.columns.to_user(self.run.end)

    @property
    def state(self) -> State:
        """The state at ``t_end``; numbers wider than double print with their error, once known."""
        state, errors = self._end_state, self.errors.known_at_end
        carrying = self.precision.carrying
        values = {name: carrying(value, errors.get(name)) for name, value in state.values.items()}
        return State(state.t, values, state.precision, errors)

    @property
    def shown_end(self) -> str:
        """``t_end`` in decimals, with its error where the end was found and that is known."""
        error = self.errors.known_at_end.get("t")
        end = self.t_end
        return repr(float(end)) if error is None else self.precision.with_error(end, error)

    @cached_property
    def _end_state(self) -> State:
        return self.run.states([self.run.end_time])[0]

    @property
    def values_at_end(self) -> dict[str, Scalar]:
        """``t_end`` (s) and the entries of the state there (SI)."""
        return {"t_end": self.t_end, **self._end_state.values}

    def at(self, t: Scalar) -> State:
        """The state at time ``t`` (s) from the Taylor series of the step around it.

        A sequence of times gives one ``State`` whose entries are arrays.

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end]: a solution is never extrapolated.
        """
        several = hasattr(t, "__len__") and not isinstance(t, str)
        times = [self.run.dimensionless_time(one) for one in (t if several else [t])]
        states = self.run.states(times)
        return State.joined(states, self.precision) if several else states[0]

    def motion(self, t: Scalar) -> Motion:
        """What quantities are computed from at ``t`` (s), dimensionless; refused as by ``at``."""
        return self.run.motions([self.run.dimensionless_time(t)])[0]

    @cached_property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to ``t_end``, which is added where it ends early."""
        if self.status in ARRIVED:
            return self.scene.sample_times
        end = as_fraction(self.run.end)
        return (*(t for t in self.scene.sample_times if t < end), end)

    def frame(
        self,
        *names: Any,
        times: Iterable[Scalar] | None = None,
        numbers: Numbers = "float",
        pose: bool = False,
        progress: Progress | None = None,
    ) -> pandas.DataFrame:
        """A table over time, in SI: column ``t`` and one for each name.

        Values that are undefined (Euler rates at a pole) are missing.

        Parameters
        ----------
        names
            State entries (kx, theta, ...), recorded quadratures, any quantity, or a function of
            the ``Motion`` (``Quantity.of``), also in a list; by default all vector and Euler
            columns and what was recorded. "pose" stands for the columns of the pose, "pose:xyzw"
            for them with the scalar of the quaternion last. "error:" before a name stands for its
            estimated error, "digits" for those of the state's worst entry (``error_over_time``).
        times
            In s; by default the scene's samples.
        numbers
            "float"; "exact" (mpmath numbers in arithmetics wider than double); or "text".
        pose
            Give the pose, behind ``names`` if there are any: quaternion, position and velocity of
            the centre of mass, angular velocity in the inertial and in the body's frame. Where
            phi, psi, x and y were not recorded, the scene is integrated once more.
        progress
            Called with the fraction done, where the series of the steps have to be made (again).
        """
        import numpy
        import pandas

        if pose:
            names = (*names, POSE)
        columns = self.table(*names, times=times, numbers=numbers, progress=progress)
        if numbers == "text" or not (numbers == "float" or self.run.in_arrays):
            return pandas.DataFrame(columns)
        # pandas takes one array much faster than many
        return pandas.DataFrame(numpy.array(list(columns.values())).T, columns=list(columns))

    def table(
        self,
        *names: Any,
        times: Iterable[Scalar] | None = None,
        numbers: Numbers = "float",
        progress: Progress | None = None,
    ) -> dict[str, Array]:
        """The columns of ``frame`` by name, without pandas.

        Floats are arrays with NaN where a value is undefined; wider numbers, and text, are lists
        with None there. Text of double is the shortest that recovers the number.
        """
        if numbers not in get_args(Numbers):
            raise InputError(
                f"numbers: got {numbers!r}, expected one of: {', '.join(get_args(Numbers))}"
            )
        wanted = expanded(names or self.run.columns.names)
        found = self._columns(wanted, times, numbers, progress)
        return {getattr(name, "name", name): column for name, column in found.items()}

    def _columns(
        self,
        wanted: Sequence[Name],
        times: Iterable[Scalar] | None,
        numbers: Numbers,
        progress: Progress | None,
    ) -> dict[Any, Array]:
        exact = self.sample_times if times is None else tuple(map(as_fraction, times))
        if any(map(is_estimate, wanted)):
            if times is not None:
                raise InputError("times: got some beside estimated errors, expected the samples'")
            plain = [name for name in wanted if not is_estimate(name)]
            found = self._columns(plain or ["theta"], None, numbers, progress)
            return self._with_errors(found, wanted, numbers)
        missing = [name for name in wanted if name in POSE_NAMES and name not in self.setup.record]
        if not missing:
            return self.run.table(wanted, exact, numbers, progress)
        run = self.with_quadratures
        plain = [name for name in wanted if name not in missing]
        found = self.run.table(plain, exact, numbers)
        found = run.run.table(missing, self._alike(exact, run), numbers) | found
        return {name: found[name] for name in ("t", *wanted)}

    def _with_errors(
        self, table: dict[Any, Array], wanted: Sequence[Name], numbers: Numbers
    ) -> dict[Any, Array]:
        estimates = {name: str(name).removeprefix(ERROR) for name in wanted if is_estimate(name)}
        errors = self.errors.over_time([name for name in estimates.values() if name != DIGITS])
        found: dict[Any, Array] = {"t": table["t"]}
        for name in wanted:
            if name in estimates:
                values = errors[estimates[name]]
                found[name] = shortest_texts(values) if numbers == "text" else values
            else:
                found[name] = table[name]
        return found

    @cached_property
    def errors(self) -> Errors:
        """What is known of the run's errors, by reference runs."""
        return Errors(self)

    @property
    def error_estimate(self) -> dict[str, Scalar]:
        """Estimated absolute error of each entry of ``state`` (SI) and of ``t_end`` (s)."""
        return self.errors.at_end

    @property
    def digits(self) -> float:
        """Significant digits that ``error_estimate`` leaves to the worst entry of ``state``."""
        return self.errors.digits_at_end

    @property
    def digits_throughout(self) -> float:
        """Significant digits that hold at every sample, in every event, and in ``t_end``."""
        return self.errors.digits_throughout

    def error_over_time(self, *names: Any, beside: Sequence[Trajectory] = ()) -> pandas.DataFrame:
        """Estimated absolute errors (SI) at ``sample_times``: columns t, names, and "digits".

        ``names`` are columns of ``frame``, by default all entries of the state. "digits" are the
        significant ones of the worst entry of the state. By reference runs, or by other
        trajectories of the scene, which are given as ``beside``.
        """
        import pandas

        errors = Errors(self, beside) if beside else self.errors
        found = errors.over_time(expanded(names) or self.run.columns.names)
        return pandas.DataFrame({getattr(name, "name", name): one for name, one in found.items()})

    def event_errors(self, *, beside: Sequence[Trajectory] = ()) -> pandas.DataFrame:
        """Estimated errors of the recorded ``events``: columns name, t, error (s), and "digits".

        "digits" are the significant ones of the worst entry of the state at the event, or of its
        time, where that has fewer: beside itself, or the unit of time where that is longer.
        """
        import pandas

        return pandas.DataFrame((Errors(self, beside) if beside else self.errors).events())

    def _alike(self, times: Sequence[Fraction], run: Trajectory) -> tuple[Fraction, ...]:
        """``times`` in another run of the scene, whose end stands for that of this one."""
        if self.status in ARRIVED:
            return tuple(times)
        end, other = (as_fraction(one.run.end) for one in (self, run))
        return tuple(other if t >= end else t for t in times)

    @cached_property
    def with_quadratures(self) -> Trajectory:
        """The same run with phi, psi, x and y recorded; made now where they were not.

        Refused where the axis is exactly vertical at the start or on the way.
        """
        if set(RECORDABLE) <= set(self.setup.record):
            return self
        if not self.scene.start.theta.at_pole:
            run = self.again(record=RECORDABLE, events=())
            if run.status == self.status:
                return run
        raise InputError(
            "pose: got an axis that is exactly vertical at some time, where phi and psi are "
            "undefined; expected another scene"
        )

    @cached_property
    def events(self) -> pandas.DataFrame:
        """All recorded events in order of time: name, t (s), direction, and the state there (SI).

        ``direction`` is +1 where the event's function rises through zero, -1 where it falls.
        """
        return self.run.events()

    def event_table(
        self, names: Sequence[str] | None = None, at: Container[str] | None = None
    ) -> dict[str, Array]:
        """The columns of ``events`` by name, without pandas, and of the state those ``names``.

        ``at`` names events; elsewhere entries of the state may be missing.
        """
        return self.run.event_columns(self.run.columns.names if names is None else names, at)

    @property
    def event_counts(self) -> Counter[str]:
        """How often each event was recorded."""
        return self.run.event_counts

    @property
    def touches(self) -> tuple[str, ...]:
        """Events asked for whose functions were seen to touch zero, or stay there, not cross it.

        That is no event; the same function may cross zero elsewhere.
        """
        return self.run.touches

    @cached_property
    def suspect_events(self) -> tuple[str, ...]:
        """Events of which one may be missing: the function rises, or falls, twice in a row.

        heyoka can miss two roots in one step; then the directions still alternate, but a missed
        single root breaks the pattern. Minima and maxima of theta are looked at together.
        """
        found = zip(self.events["name"], self.events["direction"], strict=True)
        return not_alternating(found, self.setup.watched)

    @cached_property
    def drift(self) -> dict[str, Scalar]:
        """Largest relative drift of everything the scene conserves, over samples and end.

        Computed from the states in finer numbers than theirs: for double in long double, otherwise
        in mpmath with guard bits.
        """
        number = self.precision.context.mpf
        return {name: number(max(values)) for name, values in self.drift_over_time().items()}

    def drift_over_time(self) -> dict[str, Sequence[Scalar]]:
        """Relative drift of everything the scene conserves, at each of ``sample_times``.

        In double a float64 array for each integral, otherwise a list of mpmath numbers.
        """
        integrals = [
            integral
            for integral in conserved(self.scene.model, self.scene.body)
            if self.run.columns.has_azimuth or not integral.azimuth
            if self.formulation == "newton" or integral.name != "axis_norm"
        ]
        return self.run.drift(integrals, self.sample_times)

    def plot(self, *names: Any) -> Figure:
        """A matplotlib ``Figure`` over time: a panel for each of ``names``, as of ``frame``.

        Without names: theta, energies, normal force, relative drift of what is conserved; recorded
        events are marked. ``tt_precise.runtime.plotting.save`` writes it.
        """
        from tt_precise.integration.views import figure

        return figure(self, expanded(names))

    def animate(
        self,
        path: str | Path,
        *,
        seconds: float = 12.0,
        fps: int = 20,
        begin: float = 0.0,
        end: float | None = None,
        progress: Progress | None = None,
    ) -> Path:
        """Write a moving picture of the top and its track on the table.

        ``path`` ends in .gif, .html, or .mp4 (which needs ffmpeg). The picture plays ``seconds``
        with ``fps`` frames in each, equally spaced in the trajectory's time from ``begin`` to
        ``end`` (s; by default all of it). ``progress`` is called with the fraction done.
        """
        from tt_precise.integration.views import animate

        return animate(
            self, path, seconds=seconds, fps=fps, begin=begin, end=end, progress=progress
        )

    def _repr_html_(self) -> str:
        from tt_precise.integration.views import notebook_table

        return notebook_table(self)

    def dimension(self, name: str) -> Dimension:
        """The dimension of a column; refuses names that ``frame`` does not know."""
        return self.run.columns.dimension(name)

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending time of the climb, in the three definitions.

        Integrates again, in the same set-up, if it lacks the events.
        """
        complete = set(NEEDED) <= set(self.setup.watched)
        run = self if complete else self.again(events=NEEDED, record=())
        return from_events(
            run.event_table(("theta", "phi_dot"), at=("theta_min", "theta_max", "equator")),
            math.pi if self.precision.is_float else +self.precision.context.pi,
            mirrored=bool(jellett(self.start.motion(self.precision.context)) < 0),
        )
