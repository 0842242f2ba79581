"""Variational equations: derivatives of a solution with respect to start and parameters.

Together with the state x, heyoka integrates d x/d x(s) and d x/d p of the vector form in
dimensionless units, in double, from each time of interest to the next. Products of these matrices
give the effect of an error at one time on any later time. The products stay accurate where friction
makes d x(t)/d x(0) nearly singular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy

from tt_precise.integration.equations import Equations
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import formulation
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene


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


def sensitivity(scene: str | Scene, times: Sequence[Scalar] | None = None) -> Sensitivity:
    """Derivatives of the solution of ``scene``, whose equations do not change, at ``times``.

    The times (s) rise from 0 and lie before the end of the model; by default the scene's samples.
    """
    import heyoka

    scene = load_scene(scene)
    form = formulation(scene.model, "newton", scene.body.friction)
    start = InitialState.of(scene, precision_named("double").arithmetic)
    moments = [float(t) for t in (scene.sample_times if times is None else times)]
    size, count = len(form.columns), len(form.parameters)
    equations = Equations.of(form)
    wanted = [*equations.variables, *(heyoka.par[i] for i in range(count))]
    # the bits of level 3, compiled in a third of the time
    integrator = heyoka.taylor_adaptive(
        heyoka.var_ode_sys(equations.system, wanted, order=1), [0.0] * size,
        compact_mode=True, opt_level=1,
    )  # fmt: skip
    values = [float(x) for x in start.parameters(form)]
    integrator.pars[:] = values
    unit = numpy.hstack([numpy.eye(size), numpy.zeros((size, count))])
    states = [numpy.array([float(x) for x in start.state(form)], dtype=float)]
    derivatives = numpy.empty((len(moments) - 1, size, size + count))
    for step, t in enumerate(moments[1:]):
        integrator.state[:] = [*states[-1], *unit.ravel()]
        integrator.propagate_until(t / float(start.units.time))
        extended = integrator.state.copy()
        states.append(extended[:size])
        derivatives[step] = extended[size:].reshape(size, size + count)
    return Sensitivity(
        columns=form.columns,
        parameters=form.parameters,
        times=numpy.array(moments),
        states=numpy.array(states),
        transitions=derivatives[:, :, :size],
        pushes=derivatives[:, :, size:],
        values=numpy.array(values),
    )
