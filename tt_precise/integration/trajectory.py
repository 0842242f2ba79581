"""``integrate``: a ``Trajectory`` from a scene, in a precision or to a number of digits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, get_args

import numpy

from tt_precise.integration import errors
from tt_precise.integration.columns import POSE, State, expanded
from tt_precise.integration.reading import Drifts, Numbers, drift_over_time, state_at
from tt_precise.integration.setup import Events, Setup, asked_for
from tt_precise.integration.solution import SLOW, Solution, solve
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, InputError, Scalar, listed, require_name
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from pathlib import Path

    import pandas
    from matplotlib.figure import Figure

    from tt_precise.integration.derivatives import Derivatives
    from tt_precise.integration.inversion import InversionTimes
    from tt_precise.integration.views import Page


class Trajectory:
    """The solution of a scene from t = 0 to ``t_end``, integrated with the arguments ``setup``.

    Look at ``status`` first: "complete" at the scene's horizon, "contact_ignored" there after
    g_n <= 0 (only with ``contact="bilateral"``); otherwise the model ended at ``t_end``:
    "contact_lost", "singular_contact", "landed", "pole" or "failed".

    ``t_end`` (s) is a float in double, else an mpmath number; ``sample_times`` (s) are exact, an
    early end among them. ``pieces`` are the segments of gliding, rolling, flight and elastic
    contact, as ``PhaseInterval``. ``event_counts`` are numbers of events by name; ``touches`` names
    the events whose function has a double zero, stays zero, or is ``unresolved``: lost in rounding
    for a while. No event is recorded there, and more digits decide. ``precision`` is the
    ``Precision``, ``formulation`` "newton" or "euler", ``tolerance`` relative, an mpmath number;
    ``steps`` and ``order`` are those of Taylor. ``sensitivity``, as ``Derivatives``, exists for
    ``integrate(..., sensitivity=[...])``.

    Errors are estimated by a further run, which is integrated when they are first asked for.
    Several threads may read from one trajectory. Unpickling integrates again.
    """

    sensitivity: Derivatives

    def __init__(self, run: Solution, sensitivity: Iterable[str] = ()):
        self.run, self.scene, self.setup, self.start = run, run.scene, run.setup, run.start
        self.status, self.steps, self.order = run.status, run.steps, run.order
        self.precision, self.formulation = run.precision, run.setup.formulation.coordinates
        self.pieces, self.t_end, self.sample_times = run.pieces, run.t_end, run.sample_times
        self.event_counts, self.touches = run.event_counts, run.events_with("touches")
        self.unresolved, self.tolerance = run.events_with("unresolved"), run.tolerance
        self.errors = errors.errors_of(run)
        self._names = listed(sensitivity)
        if self._names:
            from tt_precise.integration.derivatives import Derivatives

            self.sensitivity = Derivatives(run, self._names)

    def again(self, **changes: Any) -> Trajectory:
        """Integrate the scene again, with some fields of the ``Setup`` replaced."""
        return Trajectory(self.run.again(**changes))

    def __reduce__(self) -> tuple[Any, ...]:
        return Trajectory, (self.run, self._names)

    def __repr__(self) -> str:
        held = self.pieces[0].model == "rolling" and self.scene.rest_warning
        warning = "; contact point at rest at t = 0, held by friction" if held else ""
        return (
            f"<Trajectory of {self.scene.name}: {self.status}, t_end = {float(self.t_end)!r} s, "
            f"{self.precision.name}, {self.formulation}, {self.steps} steps{warning}>"
        )

    def _repr_html_(self) -> str:
        """Events and state; digits of a slow precision only if they were computed before."""
        from tt_precise.runtime.files import as_html

        estimated = self.errors.available or self.precision.name not in SLOW
        rows = [("correct digits", f"{self.digits:.1f}")] if estimated else []
        rows += [(f"event {name}", f"{n} times") for name, n in self.event_counts.most_common()]
        return as_html(repr(self).strip("<>"), rows) + self.state._repr_html_()

    @property
    def state(self) -> State:
        """The state at ``t_end``; it prints with its errors once these are known."""
        state = self.run.once(state_at, lambda: state_at(self.run, self.run.end_time))
        by_name = dict(self.errors.at_end) if self.errors.available else {}
        if end := by_name.pop("t_end", 0):
            by_name["t"] = end
        return State(state.t, state.values, self.precision, by_name)

    def at(self, t: Scalar) -> State:
        """The state at time ``t`` (s) from the Taylor series of the step around it.

        Raises ``InputError``: ``t`` lies outside [0, t_end]; a solution is never extrapolated.
        """
        return state_at(self.run, self.run.dimensionless_time(t))

    def frame(
        self,
        *names: Any,
        times: Scalar | Iterable[Scalar] | None = None,
        numbers: Numbers = "float",
        pose: bool = False,
    ) -> pandas.DataFrame:
        """A table over time, in SI: column ``t`` and one for each name.

        Values that are undefined (Euler rates at a pole) are missing: NaN among floats, else None.

        Parameters
        ----------
        names
            Components of the state (kx, theta, ...), recorded quadratures, any quantity, or a
            function of the ``Motion``, also in a list; by default the state and the quadratures. A
            function is in SI with ``tt.quantity(function, "m/s")``, otherwise in units of
            m = R = g = 1. "pose" means the columns of the pose, "pose:xyzw" the scalar of the
            quaternion last, "error:NAME" the estimated error of a column, "digits" the digits of
            the state's worst component, "drift:NAME" the relative change of a quantity since the
            start: an error only where the motion conserves the quantity.
        times
            In s, one or several; by default the scene's samples.
        numbers
            "float"; "exact" (mpmath numbers in arithmetics wider than double); or "text", of a
            double the shortest that recovers it.
        pose
            Append the pose. The scene is integrated again if phi, psi, x and y were not recorded.
        """
        import pandas

        names = (*names, POSE) if pose else names
        return pandas.DataFrame(self.table(*names, times=times, numbers=numbers))

    def table(
        self,
        *names: Any,
        times: Scalar | Iterable[Scalar] | None = None,
        numbers: Numbers = "float",
    ) -> dict[str, Array]:
        """The columns of ``frame`` by name, without pandas."""
        require_name("numbers", numbers, get_args(Numbers))
        doubles = isinstance(times, numpy.ndarray) and times.dtype.kind == "f" and times.ndim == 1
        if times is not None and not (doubles and self.precision.is_float):
            several = isinstance(times, Iterable) and not isinstance(times, str)
            several = several and getattr(times, "shape", None) != ()
            times = tuple(map(as_fraction, times if several else [times]))
        columns = expanded(names or self.run.columns.names)
        return errors.table_with_errors(self.run, columns, times, numbers)

    @property
    def error_estimate(self) -> dict[str, Scalar]:
        """Estimated absolute error of each component of ``state`` (SI) and of ``t_end`` (s)."""
        return self.errors.at_end

    @property
    def digits(self) -> float:
        """Correct digits of the worst component of ``state``."""
        return self.errors.digits_at_end

    @property
    def digits_throughout(self) -> float:
        """Correct digits of the worst component over all samples, events and ``t_end``."""
        return self.errors.digits_throughout

    @cached_property
    def events(self) -> pandas.DataFrame:
        """All recorded events in order of time: name, t (s), direction, and the state (SI).

        ``direction`` is +1 where the event's function rises through zero, -1 where it falls; the
        function of ``equator`` is cos theta, that of ``theta_min`` and ``theta_max`` its rate.
        """
        return self.event_frame(self.run.columns.names)

    def event_frame(self, *names: Any) -> pandas.DataFrame:
        """``events`` with the columns ``names`` as in ``frame``, but no drifts; also "error:t".

        An event that ends a segment has the values just before it.
        """
        import pandas

        return pandas.DataFrame(self.event_table(expanded(names)))

    def event_table(self, names: Sequence[Any] | None = None) -> dict[str, Array]:
        """The columns of ``event_frame``, by default those of the state."""
        names = self.run.columns.names if names is None else names
        return errors.events_with_errors(self.run, names)

    @cached_property
    def drift(self) -> dict[str, Any]:
        """Largest relative drift of each conserved quantity; "lambda" means "jellett"."""
        number = float if self.precision.is_float else self.precision.context.mpf
        drifts = drift_over_time(self.run)
        return Drifts((name, number(max(values))) for name, values in drifts.items())

    def plot(
        self, *names: Any, beside: Mapping[str, Trajectory] | None = None, label: str | None = None
    ) -> Figure:
        """A matplotlib ``Figure`` over time with a panel for each of ``names`` (as in ``frame``).

        Without names: theta, energies, normal force, drifts. The trajectories ``beside`` have
        curves under their labels: ``plot("theta", beside={"mu = 0.1": other}, label="mu = 0.3")``;
        ``label`` is that of this trajectory, by default the scene's name.
        """
        from tt_precise.integration.views import figure

        others = {its_label: other.run for its_label, other in (beside or {}).items()}
        return figure(self.run, expanded(names), others, label or self.scene.name)

    def animate(
        self,
        path: str | Path | None = None,
        *,
        beside: Mapping[str, Trajectory] | None = None,
        **options: Any,
    ) -> Page:
        """Write a page on which the top moves, with its track on the table; a notebook shows it.

        ``path`` ends in .html; by default it is the scene's name, and is printed. The tops of the
        trajectories ``beside`` move too; labels are as in ``plot``. Times are from ``begin`` to
        ``end`` (s; by default the whole trajectory), at first in about ``seconds`` (12).
        """
        from tt_precise.integration.views import animate

        if path is None:
            path = f"{self.scene.name}.html"
            print(f"{path}: open it in a browser")
        others = {its_label: other.run for its_label, other in (beside or {}).items()}
        return animate(self.run, path, others, **options)

    @cached_property
    def inversion(self) -> InversionTimes:
        """Initiation and ending time of the climb by the three definitions."""
        from tt_precise.integration.inversion import times_of

        return times_of(self.run)

    @cached_property
    def inversion_errors(self) -> dict[str, float]:
        """Estimated errors (s) of the times of ``inversion``: equator, t_init_A, ...

        A time has a larger error if a small change moves it to another nutation.
        """
        from tt_precise.integration.inversion import errors_of_times

        return errors_of_times(self.run)


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
        ``double`` (the default), ``double-double`` (31 digits) or ``triple-double`` (46) by the
        package's own integrator, or ``quad`` and ``mp`` (with ``bits``) by heyoka.
    digits
        Instead of a precision: correct significant digits of every component, at every sample, in
        every event and at the end (``Trajectory.digits_throughout``), by the estimated errors.
    formulation
        ``newton`` (vectors; the default) or ``euler`` (the paper's equations; not at a pole).
    events, record
        Events: names of the catalogue (a list, a string with commas, or "all"), functions of the
        ``Motion`` (their changes of sign), or quantities of ``tt.quantity`` (their extrema).
        Record: names of quadratures (phi, psi, x, y). By default the scene's.
    contact
        ``unilateral``: the trajectory ends where g_n reaches 0. ``bilateral``: it may start and
        continue with g_n < 0, which no table can exert; the status is then "contact_ignored".
    tolerance
        The relative tolerance; 0 means eps of the precision (eps/16 in double).
    until, sample_every
        Horizon and spacing of the samples in s, instead of the scene's.
    sensitivity
        Entries of the scene by which ``trajectory.sensitivity`` differentiates.
    progress
        A function, called with the completed fraction; by default a terminal or notebook shows
        the progress of slow precisions.

    Raises
    ------
    InputError
        The scene or an argument cannot be used, or the digits cannot be reached.
    """
    run_table = {"until": until, "sample_every": sample_every}
    changes = {name: value for name, value in run_table.items() if value is not None}
    loaded = load_scene(scene).varied(**changes) if changes else load_scene(scene)
    record = None if record is None else listed(record)
    watched = None if events is None else asked_for(events, loaded.model)

    def run(level: errors.Level) -> Solution:
        setup = Setup.of(
            loaded, level.precision, bits=level.bits, tolerance=level.tolerance,
            formulation=formulation, events=watched, record=record, contact=contact,
        )  # fmt: skip
        return solve(loaded, setup, progress)

    if digits is None:
        level = errors.Level(precision or "double", tolerance, bits)
        return Trajectory(run(level), sensitivity)
    if precision or bits or tolerance:
        raise InputError("digits: got a precision, bits or a tolerance too, which digits choose")
    return Trajectory(errors.integrate_to_digits(digits, loaded, run), sensitivity)
