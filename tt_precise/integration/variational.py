"""Variational equations: derivatives of a solution with respect to start and parameters.

Together with the state x, heyoka integrates d x/d x(s) and d x/d p of the vector form in
dimensionless units, in double, from each time of interest to the next. Products of these pieces
give the effect of an error at one time on any later time. They stay accurate where friction makes
the whole d x(t)/d x(0) nearly singular.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy

from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.equations import Equations
from tt_precise.integration.errors import SMALL, deviations
from tt_precise.integration.events import EVENTS
from tt_precise.integration.inversion import NEEDED, from_events
from tt_precise.integration.precision import precision_named
from tt_precise.integration.run import integrated
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, Formulation, formulation
from tt_precise.mechanics.parameters import Units
from tt_precise.mechanics.quantities import QUANTITIES, Motion, jellett
from tt_precise.runtime.values import Adaptive, Array, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import as_fraction
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from types import ModuleType

    import pandas

Trajectory: TypeAlias = Any  # its module imports this module
COARSER = 2.0**-44  # the tolerance of the run whose distance is the error: 256 eps
START_BITS = 300  # in which the start is differentiated, by central differences
NUDGE = 2**-90  # of an entry, or of 1
COLUMNS = ("theta", "omega_3")  # that are differentiated by default
LITTLE = 2.0**-40  # by which events are moved, of the 117 bits of their times


@dataclass(frozen=True)
class Sensitivity:
    """A solution and its derivatives at some times, dimensionless.

    ``times`` in s, shape (n,); ``states`` (n, size) in the order of ``columns``; ``transitions`` (n
    - 1, size, size) are d x(next time)/d x(time), their last index counts the entries of the
    earlier state; ``pushes`` (n - 1, size, len(parameters)) are d x(next time)/d p with the earlier
    state held; ``values`` are the values of the parameters.
    """

    columns: tuple[str, ...]
    parameters: tuple[str, ...]
    times: Array
    states: Array
    transitions: Array
    pushes: Array
    values: Array

    @cached_property
    def by_start(self) -> Array:
        """d x(t)/d x(0), shape (n, size, size)."""
        products = [numpy.eye(len(self.columns))]
        for step in self.transitions:
            products.append(step @ products[-1])
        return numpy.array(products)

    @cached_property
    def by_parameters(self) -> Array:
        """d x(t)/d p at the same start, shape (n, size, len(parameters))."""
        sums = [numpy.zeros((len(self.columns), len(self.parameters)))]
        for step, push in zip(self.transitions, self.pushes, strict=True):
            sums.append(step @ sums[-1] + push)
        return numpy.array(sums)

    @cached_property
    def condition(self) -> Array:
        """The growth of a relative error of the start and of the parameters; shape (n,).

        Relative in the largest entry of the state; the errors of start and parameters at their
        worst, all of one relative size.
        """
        start = self.sizes[0] * numpy.abs(self.by_start).sum(axis=2)
        parameters = (numpy.abs(self.by_parameters) * numpy.abs(self.values)).sum(axis=2)
        return (start + parameters).max(axis=1) / self.sizes

    @cached_property
    def rounding(self) -> Array:
        """The sum of the rounding errors of a whole integration, shape (n,).

        If an error of relative size 1 with random direction is made at each of the times, the
        errors add up as a random walk to sqrt(sum over s <= t of (||d x(t)/d x(s)||
        |x(s)|)^2)/|x(t)|. With k steps between the times and eps instead of 1, multiply by eps
        sqrt(k).
        """
        size = len(self.columns)
        since = numpy.empty((len(self.times), size, size))  # d x(t)/d x(s), by s
        walk = numpy.empty(len(self.times))
        for now in range(len(self.times)):
            if now:
                since[:now] = self.transitions[now - 1] @ since[:now]
            since[now] = numpy.eye(size)
            growth = numpy.abs(since[: now + 1]).sum(axis=2).max(axis=1)
            walk[now] = numpy.sqrt(numpy.sum((growth * self.sizes[: now + 1]) ** 2))
        return walk / self.sizes

    @cached_property
    def returning(self) -> float:
        """``rounding`` at the start after a run to the last time and back."""
        back = numpy.eye(len(self.columns))  # d x(0)/d x(s)
        total = 0.0
        for now, size in enumerate(self.sizes):
            if now:
                back = back @ numpy.linalg.inv(self.transitions[now - 1])
            growth = float(numpy.abs(back).sum(axis=1).max())
            total += 2 * (growth * float(size)) ** 2
        return float(total**0.5 / self.sizes[0])

    @cached_property
    def sizes(self) -> Array:
        """The largest entry of each state, shape (n,)."""
        return numpy.abs(self.states).max(axis=1)


def sensitivity(
    scene: str | Scene, times: Sequence[Scalar] | None = None, tolerance: float = 0.0
) -> Sensitivity:
    """Derivatives of the solution of ``scene`` at ``times`` (s), which rise from 0.

    By default at the scene's samples; times after the end of the model are left out.

    Raises ``InputError``: the scene cannot be used, or the times do not rise from 0.
    """
    import heyoka

    heyoka.set_logger_level_critical()
    scene = load_scene(scene)
    _require_one_piece(scene)
    form = formulation(scene.model, "newton", scene.body.friction)
    start = InitialState.of(scene, precision_named("double").arithmetic)
    moments = [float(t) for t in (scene.sample_times if times is None else times)]
    if moments[:1] != [0.0] or not all(a < b for a, b in pairwise(moments)):
        shown = ", ".join(f"{t:g}" for t in moments[:4])
        raise InputError(f"times: got {shown or 'none'}, expected times in s that rise from 0")
    end = float(integrated(scene, Setup.of(scene, events=(), record=())).end)
    moments = [t for t in moments if t <= end]
    integrator = _integrator(heyoka, form, tolerance)
    size, count = len(form.columns), len(form.parameters)
    values = [float(x) for x in start.parameters(form)]
    integrator.pars[:] = values
    integrator.time = 0.0
    unit = numpy.hstack([numpy.eye(size), numpy.zeros((size, count))])
    state = numpy.array([float(x) for x in start.state(form)], dtype=float)
    states, derivatives = [state], []
    for t in moments[1:]:
        integrator.state[:] = [*states[-1], *unit.ravel()]
        integrator.propagate_until(t / float(start.units.time))
        extended = integrator.state.copy()
        states.append(extended[:size])
        derivatives.append(extended[size:].reshape(size, size + count))
    together = numpy.array(derivatives).reshape(-1, size, size + count)
    return Sensitivity(
        columns=form.columns,
        parameters=form.parameters,
        times=numpy.array(moments),
        states=numpy.array(states),
        transitions=together[:, :, :size],
        pushes=together[:, :, size:],
        values=numpy.array(values),
    )


def _require_one_piece(scene: Scene) -> None:
    if scene.in_pieces:
        raise InputError(
            f"{scene.name}: got a scene whose motion comes in pieces, expected one set of smooth "
            "equations: derivatives jump where pieces join"
        )


def _integrator(heyoka: ModuleType, form: Formulation, tolerance: float) -> Adaptive:
    equations = Equations.of(form)
    wanted = [*equations.variables, *(heyoka.par[i] for i in range(len(form.parameters)))]
    system = heyoka.var_ode_sys(equations.system, wanted, order=1)
    # the bits of level 3, compiled in a third of the time
    options = {"compact_mode": True, "opt_level": 1, "tol": tolerance}
    return heyoka.taylor_adaptive(system, [0.0] * len(equations.variables), **options)


class Derivatives:
    """Derivatives of a trajectory's columns and climb by entries of its scene.

    ``names`` are entries of [body] and [start], in the units of the scene's file. By the
    variational equations in double; an error is the distance from the result with ``COARSER``.
    """

    def __init__(self, run: Trajectory, names: Sequence[str]):
        self.run, self.names = run, tuple(names)
        _require_one_piece(run.scene)
        self._form = formulation(run.scene.model, "newton", run.scene.body.friction)
        self._by_start = [_by_entry(run.scene, self._form, name) for name in names]

    def frame(self, *columns: str) -> pandas.DataFrame:
        """At the scene's samples: ``t``, and for each column and name "d COLUMN/d NAME" (SI).

        "error:" before a name stands for the estimated error. By default theta and omega_3.
        """
        import pandas

        columns = columns or COLUMNS
        for column in columns:
            if column not in {*VECTOR_COLUMNS, *QUANTITIES}:
                raise InputError(
                    f"sensitivity: got {column!r:.60}, expected a column or a quantity"
                )
        fine, coarse = self._paths
        at = numpy.searchsorted(fine.times, [float(t) for t in self.run.sample_times])
        at = at[at < len(fine.times)]
        table = {"t": fine.times[at]}
        for number, name in enumerate(self.names):
            slopes, others = (self._at(how, number, at, columns) for how in (fine, coarse))
            for column in columns:
                table[f"d {column}/d {name}"] = slopes[column]
                table[f"error:d {column}/d {name}"] = abs(slopes[column] - others[column])
        return pandas.DataFrame(table)

    @cached_property
    def climb(self) -> pandas.DataFrame:
        """Rows for times of the climb, such as "A.t_end": t (s), "d/d NAME", "error:d/d NAME"."""
        import pandas

        times = self._times_of_climb(self._events)
        table = {"t": {name: float(t) for name, t in times.items()}}
        for number, name in enumerate(self.names):
            slopes, others = (self._climb_by(how, number) for how in self._paths)
            table[f"d/d {name}"] = slopes
            table[f"error:d/d {name}"] = {time: abs(slopes[time] - others[time]) for time in slopes}
        return pandas.DataFrame(table)

    def spread(self, sigmas: Mapping[str, float], *columns: str) -> pandas.DataFrame:
        """Columns at the last sample and times of the climb (SI): "value" and "sigma".

        To first order, from independent errors of entries with standard deviations ``sigmas``, in
        the units of the scene's file; other entries are exact. By default theta and omega_3.
        """
        import pandas

        for name, sigma in sigmas.items():
            if name not in self.names or not 0 <= sigma < numpy.inf:
                known = ", ".join(self.names)
                raise InputError(f"spread: got {name}: {sigma}, expected sigmas of any of: {known}")
        columns = columns or COLUMNS
        end = self.frame(*columns).iloc[-1]
        values = self.run.frame([*columns], times=[end["t"]]).iloc[-1]
        values = {quantity: values[quantity] for quantity in columns} | self.climb["t"].to_dict()
        slopes = {
            name: {quantity: end[f"d {quantity}/d {name}"] for quantity in columns}
            | self.climb[f"d/d {name}"].to_dict()
            for name in sigmas
        }
        table = pandas.DataFrame({"value": values})
        errors = pandas.DataFrame(slopes, index=table.index) * [*sigmas.values()]
        table["sigma"] = numpy.linalg.norm(errors, axis=1)
        return table

    @cached_property
    def _events(self) -> dict[str, Array]:
        """The events that define the climb, from a run in double."""
        double = precision_named("double")
        run = self.run.again(precision=double, tolerance=0.0, events=NEEDED, record=())
        return {
            name: numpy.asarray(column)
            for name, column in run.event_table(("theta", "phi_dot")).items()
        }

    @cached_property
    def _paths(self) -> tuple[Sensitivity, Sensitivity]:
        times = sorted({*map(float, self.run.sample_times), *self._events["t"].tolist(), 0.0})
        fine, coarse = (sensitivity(self.run.scene, times, tol) for tol in (0.0, COARSER))
        return fine, coarse

    def _at(
        self, how: Sensitivity, number: int, at: Array, columns: Sequence[str], delay: Scalar = 0.0
    ) -> dict[str, Array]:
        """Derivatives of columns (SI) by a name, at times (s) whose derivative is ``delay``."""
        units, by_units = self._units(number)
        stretched = (delay - how.times[at] * by_units.time / units.time) / units.time
        q = self._moving(how, number, at, stretched)
        carried = Units(*(a + 1j * SMALL * b for a, b in zip(units, by_units, strict=True)))
        slopes = {}
        for name in columns:
            vector = name in VECTOR_COLUMNS
            dimension = STATE_DIMENSIONS[name] if vector else QUANTITIES[name].dimension
            with numpy.errstate(all="ignore"):
                value = getattr(q.state, name) if vector else QUANTITIES[name].evaluate(q)
            slopes[name] = (value * carried.of_dimension(dimension)).imag / SMALL
        return slopes

    def _units(self, number: int) -> tuple[Units, Units]:
        units = Units(*map(float, self.run.start.units))
        return units, Units(*self._by_start[number][2])

    def _moving(self, how: Sensitivity, number: int | None, at: Array, delay: Scalar) -> Motion:
        """The dimensionless motion, with its deviation by a name (if any) and by ``delay``."""
        form, states = self._form, how.states[at].T
        rates = form.rates(form.body(how.values), form.State(*states), numpy)
        moved = [rate * delay for rate in rates]
        by_body = numpy.zeros(len(how.values))
        if number is not None:
            by_state, by_body, _ = self._by_start[number]
            carried = how.by_start[at] @ by_state + how.by_parameters[at] @ by_body
            moved = [a + b for a, b in zip(moved, carried.T, strict=True)]
        entries = [x + 1j * SMALL * dx for x, dx in zip(states, moved, strict=True)]
        body = form.body(list(how.values + 1j * SMALL * by_body))
        with numpy.errstate(all="ignore"):
            return form.motion(body, form.State(*entries), deviations())

    def _climb_by(self, how: Sensitivity, number: int) -> dict[str, float]:
        """The derivatives of the times of the climb, by a small change of its events."""
        events, context = self._events, self.run.start.units.time.context
        at = numpy.searchsorted(how.times, events["t"])
        units, by_units = self._units(number)
        aside, ahead = (self._moving(how, *kind) for kind in ((number, at, 0.0), (None, at, 1.0)))
        late = numpy.zeros_like(events["t"], dtype=float)
        for name in NEEDED:
            here = events["name"] == name
            by_name, by_time = (EVENTS[name].function(q).imag[here] for q in (aside, ahead))
            late[here] = -by_name / by_time
        late = late * units.time + events["t"] * by_units.time / units.time
        moved = {"t": late, **self._at(how, number, at, ("theta", "phi_dot"), late)}
        size = context.mpf(LITTLE)
        ends = []
        for sign in (1, -1):
            shifted = {
                name: [context.mpf(x) + sign * size * context.mpf(dx) for x, dx in
                       zip(events[name].tolist(), moved[name].tolist(), strict=True)]
                for name in moved
            }  # fmt: skip
            ends.append(self._times_of_climb({**events, **shifted}))
        return {name: float((t - ends[1][name]) / (2 * size)) for name, t in ends[0].items()}

    def _times_of_climb(self, events: Mapping[str, Array]) -> dict[str, Scalar]:
        context = self.run.start.units.time.context
        mirrored = bool(jellett(self.run.start.motion(context)) < 0)
        climbs = from_events(events, context.pi, mirrored=mirrored)
        known = {f"{name[-1]}.{name[:-2]}": t for name, t in climbs.times.items()}
        every = {"equator": climbs.equator, **known}
        return {name: t for name, t in every.items() if t is not None}


def _by_entry(
    scene: Scene, form: Formulation, name: str
) -> tuple[Array, Array, tuple[float, float, float]]:
    """Derivatives of the dimensionless start, of the parameters and of the units by an entry."""
    arithmetic = precision_named("mp", START_BITS).arithmetic
    of_body = scene.body.in_file_units().items()
    known = {key: value for key, value in of_body if isinstance(value, Fraction)} | {
        key: getattr(scene.start, key)
        for key in ("theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
    }
    known["theta"] = as_fraction(scene.start.theta.radians(arithmetic.fn, arithmetic.exact))
    if name not in known:
        raise InputError(f"sensitivity: got {name!r:.60}, expected any of: {', '.join(known)}")
    value = Fraction(known[name])
    size = (abs(value) or 1) * Fraction(NUDGE)
    sides, apart = [], Fraction(0)
    for sign in (1, -1):
        beside = scene
        try:
            beside = scene.varied(**{name: value + sign * size})
            apart += size
        except InputError:  # at the end of a range, as mu = 0 is; the other side will do
            if not apart and sign < 0:
                raise
        start = InitialState.of(beside, arithmetic)
        sides.append([*start.state(form), *start.parameters(form), *start.units])
    slopes = [float((a - b) / arithmetic.exact(apart)) for a, b in zip(*sides, strict=True)]
    entries = len(form.columns)
    state, body, units = slopes[:entries], slopes[entries:-3], slopes[-3:]
    return numpy.array(state), numpy.array(body), (units[0], units[1], units[2])
