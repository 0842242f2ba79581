"""``integrate``: a ``Trajectory`` from a scene, in a precision or to a number of digits."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache, cached_property, partial
from typing import TYPE_CHECKING, Any, get_args

import numpy

from tt_precise.integration.columns import POSE, POSE_NAMES, State, expanded
from tt_precise.integration.dense_output import is_doubles
from tt_precise.integration.errors import (
    TIME,
    Errors,
    Later,
    errors_of,
    events_with_errors,
    floats,
    is_estimate,
    table_with_errors,
)
from tt_precise.integration.events import not_alternating
from tt_precise.integration.ladder import Level, integrate_to_digits
from tt_precise.integration.precision import Precision
from tt_precise.integration.reading import (
    Drifts,
    Numbers,
    drift_over_time,
    end_state,
    is_drift,
    rows,
    states,
)
from tt_precise.integration.setup import Events, Setup, asked_for
from tt_precise.integration.solution import PhaseInterval, Solution, solve
from tt_precise.mechanics.parameters import Dimension
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import (
    Array,
    Hints,
    InputError,
    Scalar,
    keyword_advice,
    listed,
    nearest,
    require_name,
)
from tt_precise.scene.numerals import as_fraction, shortest_texts
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from pathlib import Path

    import pandas
    from matplotlib.figure import Figure

    from tt_precise.integration.derivatives import Derivatives
    from tt_precise.integration.inversion import InversionTimes
    from tt_precise.integration.views import Animation


def is_one(t: Any) -> bool:
    """True for one time, not several."""
    return isinstance(t, str) or not isinstance(t, Iterable) or getattr(t, "shape", None) == ()


def each(t: Any) -> Iterable[Scalar]:
    """The times as a sequence, also for one time."""
    return [t] if is_one(t) else t


class Trajectory(Hints):
    """The solution of a scene from t = 0 to ``t_end``, integrated with the arguments ``setup``.

    Look at ``status`` first. A "complete" trajectory reached the scene's horizon. A
    "contact_ignored" trajectory reached the horizon with g_n <= 0 at some time (only with
    ``contact="bilateral"``). Every other trajectory ended where the model ended. No value exists
    beyond ``t_end``.

    Errors are estimated by further runs, which are integrated when errors are first asked for: by
    ``digits=`` of ``integrate``, or by a member or column that returns errors. From then on numbers
    wider than double print with their errors, at any time and in events; poses and drifts, which
    have none, print in all digits.

    Several threads may read from one trajectory. A pickle contains the scene and the set-up, no
    numbers and no code: unpickling integrates again.

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
        ``Derivatives`` by the entries that ``integrate(..., sensitivity=[...])`` names; without
        them there is no such attribute.
    """

    sensitivity: Derivatives
    _parts = ("scene", "scene.body")

    def __init__(self, run: Solution):
        self.run, self.scene, self.setup, self.start = run, run.scene, run.setup, run.start
        self.status = run.status
        self.steps, self.order = run.steps, run.order

    @classmethod
    def of(cls, scene: Scene, setup: Setup) -> Trajectory:
        """Integrate ``scene`` once with the set-up."""
        return cls(solve(scene, setup))

    def again(self, **changes: Any) -> Trajectory:
        """Integrate the scene again, with some fields of the ``Setup`` replaced."""
        return Trajectory(self.run.again(**changes))

    def __reduce__(self) -> tuple[Any, ...]:
        names = self.sensitivity.names if "sensitivity" in self.__dict__ else ()
        return _unpickled, (self.run, names)

    def _where(self, name: str) -> str:
        known = self.run.columns.dimensions
        where = "" if name in known else super()._where(name)
        column = where or nearest(name, known)
        return where or (f'frame("{column}"), plot("{column}") or at(t)' if column else "")

    def __repr__(self) -> str:
        held = "; contact point at rest at t = 0, held by friction" if self._warning else ""
        return (
            f"<Trajectory of {self.scene.name}: {self.status}, t_end = {self.end_text} s, "
            f"{self.precision.name}, {self.formulation}, {self.steps} steps{held}>"
        )

    @property
    def _warning(self) -> str:
        """The scene's warning where friction holds the contact point from the start; else empty."""
        return self.scene.rest_warning if self.pieces[0].model == "rolling" else ""

    @property
    def precision(self) -> Precision:
        """The working precision."""
        return self.setup.precision

    @property
    def formulation(self) -> str:
        """The coordinates of the integration: "newton" or "euler"."""
        return self.setup.formulation.coordinates

    @property
    def tolerance(self) -> Scalar:
        """The relative tolerance of the integration, an mpmath number."""
        return self.run.tolerance

    @property
    def pieces(self) -> tuple[PhaseInterval, ...]:
        """The segments of gliding, rolling, flight and elastic contact; at least one."""
        return self.run.stretches

    @property
    def t_end(self) -> Scalar:
        """The end of the solution in s: a float in double, else an mpmath number."""
        return self.run.t_end

    @property
    def state(self) -> State:
        """The state at ``t_end``."""
        return end_state(self.run).with_errors(self.errors.available_at_end)

    @property
    def end_text(self) -> str:
        """``t_end`` in decimals, with its error if known."""
        error = self.errors.available_at_end.get("t")
        end = self.t_end
        return repr(float(end)) if error is None else self.precision.with_error(end, error)

    def at(self, t: Scalar) -> State:
        """The state at time ``t`` (s) from the Taylor series of the step around it.

        A sequence of times gives one ``State`` whose components are arrays. Numbers have their
        errors as the class says.

        Raises
        ------
        InputError
            ``t`` lies outside [0, t_end]: a solution is never extrapolated.
        """
        times = list(each(t))
        found = states(self.run, list(map(self.run.dimensionless_time, times)))
        state = found[0] if is_one(t) else State.stack(found, self.precision)
        if not self.errors.available:
            return state

        def errors() -> Mapping[Any, Scalar]:
            known = self.errors.at_times(list(map(as_fraction, times)), [*state.values])
            return {n: error[0] for n, error in known.items()} if is_one(t) else known

        return state.with_errors(Later(errors))

    def motion(self, t: Scalar) -> Motion:
        """The dimensionless ``Motion`` at ``t`` (s); raises as ``at`` does.

        The numbers of the ``Motion`` are floats in double, else mpmath numbers.
        """
        ((segment, row),) = rows(self.run, [self.run.dimensionless_time(t)])
        if self.precision.is_float:
            return segment.columns.array_motion(tuple(map(float, row)), float, math)
        return segment.columns.motion(row)

    @property
    def sample_times(self) -> tuple[Fraction, ...]:
        """The scene's exact sample times up to ``t_end``; an early ``t_end`` is added."""
        return self.run.sample_times

    @keyword_advice("every table has t; frame(...).to_csv(FILE) writes a file")
    def frame(
        self,
        *names: Any,
        times: Scalar | Iterable[Scalar] | None = None,
        numbers: Numbers = "float",
        pose: bool = False,
        progress: Progress | None = None,
    ) -> pandas.DataFrame:
        """A table over time, in SI: column ``t`` and one for each name.

        Values that are undefined (Euler rates at a pole) are missing.

        Parameters
        ----------
        names
            Components of the state (kx, theta, ...), recorded quadratures, any quantity, or a
            function of the ``Motion``, also in a list; by default all vector and Euler columns and
            the recorded quadratures. A function is in SI with ``tt.quantity(function, "m/s")``,
            otherwise in units of m = R = g = 1, as the name of its column states (in Euler form
            the azimuth is 0 unless phi is recorded).
            "pose" means the columns of the pose, "pose:xyzw" these columns with the scalar of the
            quaternion last, "error:NAME" the estimated error of a column, "digits" the digits of
            the state's worst component (``error_over_time``), "drift:NAME" the relative change of a
            quantity since the start; it is an error only where the motion conserves the quantity,
            such as lambda, or E without friction.
        times
            In s, one or several; by default the scene's samples.
        numbers
            "float"; "exact" (mpmath numbers in arithmetics wider than double); or "text".
        pose
            Append the pose: quaternion, position and velocity of the centre of mass, angular
            velocity in the inertial and in the body's frame. If phi, psi, x and y were not
            recorded, the scene is integrated again.
        progress
            A function, called with the completed fraction if the series of the steps must be
            computed again.
        """
        import pandas

        if pose:
            names = (*names, POSE)
        columns = self.table(*names, times=times, numbers=numbers, progress=progress)
        if numbers == "exact":
            wanted = [n for n in expanded(names or self.run.columns.names) if n not in POSE_NAMES]
            exact = self.sample_times if times is None else tuple(map(as_fraction, each(times)))
            columns = self._carrying(columns, wanted, partial(self.errors.at_times, exact))
        return pandas.DataFrame(columns)

    def table(
        self,
        *names: Any,
        times: Scalar | Iterable[Scalar] | None = None,
        numbers: Numbers = "float",
        progress: Progress | None = None,
    ) -> dict[str, Array]:
        """The columns of ``frame`` by name, without pandas.

        Floats are arrays, with NaN for undefined values; wider numbers and text are lists, with
        None for undefined values. The text of a double is the shortest that recovers the number.
        """
        require_name("numbers", numbers, get_args(Numbers))
        wanted = expanded(names or self.run.columns.names)
        if times is not None and not is_doubles(times):
            times = tuple(map(as_fraction, each(times)))
        columns = table_with_errors(self.run, wanted, times, numbers, progress)
        return {getattr(name, "name", name): column for name, column in columns.items()}

    @property
    def errors(self) -> Errors:
        """The errors of the run, estimated by reference runs."""
        return errors_of(self.run)

    @property
    def error_estimate(self) -> dict[str, Scalar]:
        """Estimated absolute error of each component of ``state`` (SI) and of ``t_end`` (s)."""
        return self.errors.at_end

    @property
    def digits(self) -> float:
        """Correct digits of the worst component of ``state``, from ``error_estimate``."""
        return self.errors.digits_at_end

    @property
    def digits_throughout(self) -> float:
        """Correct digits of the worst component over all samples, events and ``t_end``."""
        return self.errors.digits_throughout

    def error_over_time(self, *names: Any, beside: Sequence[Trajectory] = ()) -> pandas.DataFrame:
        """Estimated absolute errors (SI) at ``sample_times``: columns t, names, and "digits".

        ``names`` are columns of ``frame``, by default all components of the state. "digits" are the
        correct digits of the state's worst component. The errors are distances from reference runs,
        or from the trajectories ``beside`` of the same scene.
        """
        import pandas

        errors = self._errors_against(beside)
        columns = errors.over_time(expanded(names) or self.run.columns.names)
        named = {getattr(name, "name", name): column for name, column in columns.items()}
        return pandas.DataFrame(named)

    def event_errors(self, *names: Any, beside: Sequence[Trajectory] = ()) -> pandas.DataFrame:
        """Estimated errors of the recorded ``events``: columns name, t, error (s), and "digits".

        The rows and times are those of ``events``. ``names`` are columns of ``frame``, whose errors
        (SI) at the event's time stand before "digits". "digits" are the correct digits of the time
        or of the worst component of the state at this time, whichever are fewer.
        """
        import pandas

        errors = self._errors_against(beside).events(expanded(names))
        named = {getattr(name, "name", name): column for name, column in errors.items()}
        return pandas.DataFrame({**named, "t": self.events["t"].array})

    def _errors_against(self, others: Sequence[Trajectory]) -> Errors:
        return Errors(self.run, [other.run for other in others]) if others else self.errors

    @cached_property
    def events(self) -> pandas.DataFrame:
        """All recorded events in order of time: name, t (s), direction, and the state (SI).

        ``direction`` is +1 where the event's function rises through zero, -1 where it falls. The
        function of ``equator`` is cos theta, which falls where theta rises, that of ``theta_min``
        and ``theta_max`` the rate of cos theta, and that of ``extremum:`` the quantity's rate.
        """
        return self._events(self.run.columns.names, "exact")

    def event_frame(self, *names: Any, numbers: Numbers = "exact") -> pandas.DataFrame:
        """The recorded events in order of time: name, t (s), direction, and the columns ``names``.

        ``names`` are columns as in ``frame``, but no drifts: a quantity, one's own with its errors
        ("error:NAME"), "error:t", and "digits". An event that ends a segment has the values just
        before it. ``numbers`` is as in ``frame``.

        Raises ``InputError``: the run looked for no events.
        """
        found = self._events(names, numbers)
        if not (len(found) or self.setup.events):
            raise InputError(
                f"event_frame: got a run of {self.scene.name} that looked for no events, expected "
                'some: tt.integrate(scene, events=["extremum:g_n"])'
            )
        return found

    def _events(self, names: Sequence[Any], numbers: Numbers) -> pandas.DataFrame:
        import pandas

        require_name("numbers", numbers, get_args(Numbers))
        table = self.event_table(expanded(names))
        named = {getattr(name, "name", name): column for name, column in table.items()}
        if not len(named["name"]):
            return pandas.DataFrame([], columns=list(named))
        if numbers != "exact":
            for name in named.keys() - {"name", "direction"}:
                named[name] = self._as(numbers, named[name])
            return pandas.DataFrame(named)
        wanted = [name for name in table if name not in ("name", "t", "direction")]
        return pandas.DataFrame(self._carrying(named, wanted, self.errors.events, TIME))

    def _carrying(
        self,
        columns: Mapping[str, Array],
        names: Iterable[Any],
        errors: Callable[[Sequence[Any]], Mapping[Any, Array]],
        of_time: str = "",
    ) -> dict[str, Array]:
        """Columns whose wide numbers print with the ``errors`` of ``names``, if these are known."""
        if self.precision.is_float or not self.errors.available:
            return dict(columns)
        of = [name for name in names if not is_estimate(name) and not is_drift(name)]
        known = cache(lambda: errors(of))

        def error(name: Any, row: int) -> float:
            return float(known()[name][row])

        carried = {getattr(name, "name", name): name for name in of}
        if of_time:
            carried["t"] = of_time
        of_each = {
            shown: [
                self.precision.carrying(value, partial(error, name, row))
                for row, value in enumerate(columns[shown])
            ]
            for shown, name in carried.items()
        }
        return {name: of_each.get(name, column) for name, column in columns.items()}

    def _as(self, numbers: Numbers, values: Array) -> Array:
        """Values of events as floats or texts, like a table's."""
        doubles = floats(values)
        if numbers == "float":
            return doubles
        if self.precision.is_float or isinstance(values, numpy.ndarray):  # errors are doubles
            return shortest_texts(doubles)
        return list(map(self.precision.text, values))

    def event_table(
        self, names: Sequence[Any] | None = None, at: Container[str] | None = None
    ) -> dict[Any, Array]:
        """The columns of ``event_frame`` by name, without pandas; by default those of the state.

        With ``at``, only the events of these names have them.
        """
        return events_with_errors(self.run, self.run.columns.names if names is None else names, at)

    @property
    def event_counts(self) -> Counter[str]:
        """Numbers of recorded events by name."""
        return self.run.event_counts

    @property
    def touches(self) -> tuple[str, ...]:
        """Requested events whose function touches zero, stays zero, or is unresolved.

        No event is recorded at such a time; more digits decide. The same function may cross zero at
        other times.
        """
        return self.run.touches

    @property
    def unresolved(self) -> tuple[str, ...]:
        """Requested events whose function is below its error over several extrema: noise.

        Events may be missing, for example where a gliding velocity has decayed below the rounding
        of the arithmetic. More digits decide.
        """
        return self.run.unresolved

    @cached_property
    def suspect_events(self) -> tuple[str, ...]:
        """Events that may be incomplete, because their function rises, or falls, twice in a row.

        Changes of sign within a segment alternate. One that is lost where two segments join breaks
        the alternation, two in one place do not. Minima and maxima of theta are tested together.
        """
        happened = zip(self.events["name"], self.events["direction"], strict=True)
        return not_alternating(happened, self.setup.watched)

    @cached_property
    def drift(self) -> dict[str, Any]:
        """Largest relative drift of each conserved quantity, over samples and end.

        ``drift["lambda"]`` is ``drift["jellett"]``.

        The drifts are computed from the states in finer arithmetic: in long double for double,
        otherwise in mpmath with guard bits.
        """
        number = float if self.precision.is_float else self.precision.context.mpf
        return Drifts((n, number(max(values))) for n, values in self.drift_over_time().items())

    def drift_over_time(self) -> dict[str, Any]:
        """Relative drift of each conserved quantity, at each of ``sample_times``.

        Each drift is a float64 array in double, otherwise a list of mpmath numbers.
        """
        return drift_over_time(self.run)

    @keyword_advice('plot(...).savefig("top.png") saves the picture')
    def plot(
        self, *names: Any, beside: Mapping[str, Trajectory] | None = None, label: str | None = None
    ) -> Figure:
        """A matplotlib ``Figure`` over time with a panel for each of ``names`` (as in ``frame``).

        Without names: theta, energies, normal force, relative drift of the conserved quantities.
        Recorded events are marked. ``plot().savefig("top.png")`` saves it. The panels of ``names``,
        by default theta, have the curves of the trajectories ``beside`` too, under their labels:
        ``plot("theta", "E", beside={"mu = 0.1": other}, label="mu = 0.3")``; ``label`` is that of
        this trajectory, by default the scene's name.
        """
        from tt_precise.integration.views import figure

        return figure(self.run, expanded(names), _runs(beside), label or self.scene.name)

    @keyword_advice('animate("top.html", beside={"mu = 0.1": other}) draws both')
    def animate(
        self,
        path: str | Path | None = None,
        *,
        beside: Mapping[str, Trajectory] | None = None,
        label: str | None = None,
        seconds: float = 12.0,
        fps: int = 20,
        begin: float = 0.0,
        end: float | None = None,
        progress: Progress | None = None,
    ) -> Animation:
        """Write an animation of the top and its track on the table; a notebook shows a page.

        ``path`` ends in .gif, .html, or .mp4 (which needs ffmpeg); by default it is the scene's
        name with .html, and is printed. The tops of the trajectories ``beside`` move at the same
        time, with their labels, as in ``plot``. The animation lasts ``seconds`` with ``fps`` frames
        per second, equally spaced in the trajectory's time from ``begin`` to ``end`` (s; by default
        the whole trajectory). ``progress`` is called with the fraction done; by
        default a terminal shows a bar.
        """
        from tt_precise.integration.views import animate

        if path is None:
            path = f"{self.scene.name}.html"
            print(f"{path}: open it in a browser")
        return animate(
            self.run, path, others=_runs(beside), label=label or "", seconds=seconds, fps=fps,
            begin=begin, end=end, progress=progress,
        )  # fmt: skip

    def _repr_html_(self) -> str:
        from tt_precise.runtime.tables import as_html

        state, shown = self.state, self.precision.with_error
        rows: list[tuple[str, Any]] = [
            ("status", self.status),
            *([("WARNING", self._warning)] if self._warning else []),
            ("t_end", f"{self.end_text} s"),
            ("precision", f"{self.precision.name}, {self.precision.bits} bits"),
            ("formulation", self.formulation),
            ("steps", self.steps),
            *((name, shown(value, state.errors.get(name))) for name, value in state.values.items()),
            *((f"event {name}", f"{n} times") for name, n in self.event_counts.most_common()),
        ]
        return as_html(f"Trajectory of {self.scene.name}", rows)

    def dimension(self, name: str) -> Dimension:
        """The dimension of a column; raises for names that ``frame`` does not know."""
        return self.run.columns.dimension(name)

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending time of the climb by the three definitions.

        If the events were not recorded, the scene is integrated again with the same set-up. Times
        wider than double print with their errors, as the class says; ``inversion_errors`` has the
        errors in every arithmetic.
        """
        from tt_precise.integration.inversion import times_of

        def error(name: str) -> Scalar | None:
            return self.inversion_errors.get(name) if self.errors.available else None

        carrying = self.precision.carrying
        return times_of(self.run).of_each(lambda name, t: carrying(t, partial(error, name)))

    @cached_property
    def inversion_errors(self) -> dict[str, float]:
        """Estimated errors (s) of the times of ``inversion``: equator, t_init_A, ...

        Errors are distances from reference runs, as in ``event_errors``. A time may have a larger
        error if a small change moves it to another nutation, as in definitions B and C.
        """
        from tt_precise.integration.inversion import errors_of_times

        return errors_of_times(self.run)


def _runs(beside: Mapping[str, Trajectory] | None) -> dict[str, Solution]:
    if not isinstance(beside or {}, Mapping):
        raise InputError(
            f"beside: got a {type(beside).__name__}, expected trajectories by their labels, "
            'such as {"mu = 0.1": other}'
        )
    return {label: other.run for label, other in (beside or {}).items()}


def _unpickled(run: Solution, names: Sequence[str]) -> Trajectory:
    return _differentiated(Trajectory(run), names)


def _differentiated(trajectory: Trajectory, names: Iterable[str]) -> Trajectory:
    """Return the trajectory with its ``sensitivity`` to the entries ``names``, if any."""
    if names:
        from tt_precise.integration.derivatives import Derivatives

        trajectory.sensitivity = Derivatives(trajectory.run, listed(names))
    return trajectory


@keyword_advice("numbers of the top and its start: scene.varied(mu=0.2)")
def integrate(
    scene: str | Scene,
    precision: str | None = None,
    *,
    digits: int | None = None,
    formulation: str | None = None,
    events: Events | None = None,
    record: Iterable[str] | None = None,
    bits: int | None = None,
    contact: str = "unilateral",
    tolerance: float = 0.0,
    until: str | float | Fraction | None = None,
    sample_every: str | float | Fraction | None = None,
    sensitivity: Iterable[str] = (),
    progress: Progress | None = None,
) -> Trajectory:
    """Integrate a scene with an adaptive Taylor method.

    Parameters
    ----------
    scene
        A ``Scene``, a shipped name or a path to a TOML file.
    precision
        ``double`` (the default), ``extended``, ``quad`` or ``mp`` (with ``bits``), by heyoka; or
        ``double-double`` (31 digits) or ``triple-double`` (46), by the package's own integrator, a
        hundred times faster than ``quad`` and ``mp``.
    digits
        Instead of a precision: correct significant digits of every component, at every sample, in
        every event and at the end (``Trajectory.digits_throughout``). ``integrate`` tries finer
        precisions and tolerances until the error estimate is small enough;
        ``Trajectory.precision`` has the chosen precision.
    formulation
        ``newton`` (vectors; any start; the default) or ``euler`` (the paper's equations; not at a
        pole).
    events, record
        Events: names from the event catalogue (a list, a string with commas, or "all"), functions
        of the ``Motion`` (their changes of sign), or quantities of ``tt_precise.quantity`` (their
        extrema, ``extremum:NAME``). Record: names of quadratures (phi, psi, x, y). By default the
        scene's events and quadratures.
    contact
        ``unilateral``: the trajectory ends where g_n reaches 0. ``bilateral``: the trajectory may
        start and continue with g_n < 0, which no table can exert; the status is then
        "contact_ignored".
    tolerance
        The relative tolerance; 0 means eps of the precision (eps/16 in double).
    until, sample_every
        Horizon and spacing of the samples in s, instead of the scene's.
    sensitivity
        Entries of [body] and [start], such as theta, omega_3 and mu, by which
        ``trajectory.sensitivity`` differentiates columns and the times of the climb.
    progress
        A function, called with the completed fraction.

    Returns
    -------
    Trajectory
        Its ``status`` is "complete" at the horizon, or tells how the model ended before.

    Raises
    ------
    InputError
        The scene or an argument cannot be used, or the digits cannot be reached.
    """
    loaded = load_scene(scene)
    if until is not None:
        loaded = loaded.varied(until=until)
    if sample_every is not None:
        loaded = loaded.varied(sample_every=sample_every)
    record = None if record is None else listed(record)
    watched = None if events is None else asked_for(events, loaded.model)

    def run(level: Level) -> Solution:
        setup = Setup.of(
            loaded, level.precision, bits=level.bits, tolerance=level.tolerance,
            formulation=formulation, events=watched, record=record, contact=contact,
        )  # fmt: skip
        return solve(loaded, setup, progress)

    if digits is None:
        found = run(Level(precision or "double", tolerance, bits))
        return _differentiated(Trajectory(found), sensitivity)
    for name, given in (("precision", precision), ("bits", bits), ("tolerance", tolerance)):
        if given:
            raise InputError(
                f"digits: got a {name} too, which digits choose; expected one of the two"
            )
    found = integrate_to_digits(digits, loaded, run, euler=formulation == "euler", contact=contact)
    return _differentiated(Trajectory(found), sensitivity)
