"""Variational equations: the derivatives of a solution by its start and by its parameters.

Together with the state x, heyoka integrates d x/d x(s) and d x/d p of the vector form in
dimensionless units, in double, from each time of interest to the next. Products of these pieces
give what an error at one time does at any later one; they stay accurate where friction makes the
whole d x(t)/d x(0) nearly singular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from tt_precise.integration.api import integrate
from tt_precise.integration.equations import Equations
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import Formulation, formulation
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Adaptive
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    from types import ModuleType


@dataclass(frozen=True)
class Sensitivity:
    """A solution and its derivatives at some times, dimensionless.

    ``times`` in s, shape (n,); ``states`` (n, size) in the order of ``columns``; ``transitions``
    (n - 1, size, size) are d x(next time)/d x(time), their last index counts the entries of the
    earlier state; ``pushes`` (n - 1, size, len(parameters)) are d x(next time)/d p with the
    earlier state held; ``values`` are the parameters' own.
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
        import numpy

        found = [numpy.eye(len(self.columns))]
        for step in self.transitions:
            found.append(step @ found[-1])
        return numpy.array(found)

    @cached_property
    def by_parameters(self) -> Array:
        """d x(t)/d p at the same start, shape (n, size, len(parameters))."""
        import numpy

        found = [numpy.zeros((len(self.columns), len(self.parameters)))]
        for step, push in zip(self.transitions, self.pushes, strict=True):
            found.append(step @ found[-1] + push)
        return numpy.array(found)

    @cached_property
    def condition(self) -> Array:
        """How much a relative error of the start and of the parameters grows; shape (n,).

        Relative in the largest entry of the state; the errors of start and parameters at their
        worst, all of one relative size.
        """
        import numpy

        start = self.sizes[0] * numpy.abs(self.by_start).sum(axis=2)
        parameters = (numpy.abs(self.by_parameters) * numpy.abs(self.values)).sum(axis=2)
        return (start + parameters).max(axis=1) / self.sizes

    @cached_property
    def rounding(self) -> Array:
        """How the rounding errors of a whole integration add up, shape (n,).

        If at each of the times an error of relative size 1 is made, which points anywhere, they
        add up like a random walk, to sqrt(sum over s <= t of (||d x(t)/d x(s)|| |x(s)|)^2)/|x(t)|.
        With k steps from one time to the next and eps for the 1, times eps sqrt(k).
        """
        import numpy

        size = len(self.columns)
        since = numpy.empty((len(self.times), size, size))  # d x(t)/d x(s), by s
        found = numpy.empty(len(self.times))
        for now in range(len(self.times)):
            if now:
                since[:now] = self.transitions[now - 1] @ since[:now]
            since[now] = numpy.eye(size)
            growth = numpy.abs(since[: now + 1]).sum(axis=2).max(axis=1)
            found[now] = numpy.sqrt(numpy.sum((growth * self.sizes[: now + 1]) ** 2))
        return found / self.sizes

    @cached_property
    def returning(self) -> float:
        """What ``rounding`` is at the start, after a run to the last time and back."""
        import numpy

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
        import numpy

        return numpy.abs(self.states).max(axis=1)


def sensitivity(scene: str | Scene, times: Sequence[Scalar] | None = None) -> Sensitivity:
    """Derivatives of the solution of ``scene`` at ``times`` (s), which rise from 0.

    By default at the scene's samples; times at which the model has ended are left out.

    Raises
    ------
    InputError
        The scene cannot be used, or the times do not begin with 0 or do not rise.
    """
    import heyoka
    import numpy

    heyoka.set_logger_level_critical()
    scene = load_scene(scene)
    if scene.in_pieces:
        raise InputError(
            f"{scene.name}: got a scene whose motion comes in pieces, expected one set of smooth "
            "equations: derivatives jump where pieces join"
        )
    form = formulation(scene.model, "newton", scene.body.friction)
    start = InitialState.of(scene, precision_named("double").arithmetic)
    moments = [float(t) for t in (scene.sample_times if times is None else times)]
    if moments[:1] != [0.0] or not all(a < b for a, b in pairwise(moments)):
        shown = ", ".join(f"{t:g}" for t in moments[:4])
        raise InputError(f"times: got {shown or 'none'}, expected times in s that rise from 0")
    end = float(integrate(scene, events=(), record=()).t_end)
    moments = [t for t in moments if t <= end]
    integrator = _integrator(heyoka, form)
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
        found = integrator.state.copy()
        states.append(found[:size])
        derivatives.append(found[size:].reshape(size, size + count))
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


def _integrator(heyoka: ModuleType, form: Formulation) -> Adaptive:
    equations = Equations.of(form)
    wanted = [*equations.variables, *(heyoka.par[i] for i in range(len(form.parameters)))]
    system = heyoka.var_ode_sys(equations.system, wanted, order=1)
    made = heyoka.taylor_adaptive(system, [0.0] * len(equations.variables), compact_mode=True)
    names = [str(one) for one in made.vargs]
    if names != [str(one) for one in wanted]:
        raise RuntimeError(f"heyoka orders the derivatives as {names}")
    return made
