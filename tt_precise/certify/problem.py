"""The exact initial value problem that is to be enclosed, and what is observed of its states.

Components that are exactly zero for all time are left out: balls around zero cannot prove a zero.
But if f_i = 0 for each i of a set Z wherever all y_j, j in Z, are zero, then a solution that starts
there stays there (it solves the problem without them, and solutions are unique). f_i is evaluated
with exact zeros in Z and balls of positive radius elsewhere: an exactly zero result means that f_i
vanishes on that box, hence, being analytic, wherever the y_j are zero. Upright and inverted spin,
and rocking in a plane, are such solutions.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, reduce
from operator import add

import flint
from flint import arb

from tt_precise.certify.balls import Balls, NotProved, ball
from tt_precise.integration.equations import QUADRATURE_SCALE, extended_rates
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, Formulation, integrated
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Arithmetic, Functions, Scalar
from tt_precise.scene.body import Parameters, Units
from tt_precise.scene.scene import Scene
from tt_precise.taylor.graph import Constant, Graph, Operand, constants_of, in_order, numbers
from tt_precise.taylor.series import SeriesFunctions


class _Functions(SeriesFunctions, Balls):
    """Those of balls, and of power series over them or over Taylor models."""


BALLS = Arithmetic(Balls, ball)
FUNCTIONS = _Functions(Balls)
Function = Callable[[Sequence[Scalar]], Scalar]  # of a state


class Equations:
    """A right-hand side as a graph: each operation once, for arithmetics in which they are long."""

    def __init__(
        self, rates: Callable[..., Sequence[Scalar]], parameters: int, variables: int
    ) -> None:
        graph = Graph(variables, parameters)
        self._results = list(rates(graph.parameters, list(graph.entries), graph))
        self._nodes = in_order(graph, self._results)
        alone = [one for one in self._results if isinstance(one, Constant)]
        self._constants = [*constants_of(self._nodes), *alone]

    def __call__(self, parameters: Sequence[Scalar], state: Sequence[Scalar]) -> list[Scalar]:
        """The rates, in the arithmetic of the state; parameters are balls."""
        known: dict[Scalar, Scalar] = dict(numbers(self._constants, parameters, Balls))

        def value(one: Scalar) -> Scalar:
            return known[one] if isinstance(one, Operand) else one

        for node in self._nodes:
            if node.kind == "entry":
                known[node] = state[node.args[0]]
            elif node.kind == "sum":
                offset, terms = node.args
                scaled = [_times(value(factor), known[one]) for factor, one in terms]
                if isinstance(offset, Operand) or offset != 0:
                    scaled.append(value(offset))
                known[node] = reduce(add, scaled)
            elif node.kind == "root":
                known[node] = known[node.args[0]].sqrt()
            else:
                a, b = map(value, node.args)
                known[node] = a * b if node.kind == "product" else a / b
        return [value(one) for one in self._results]


def _times(factor: Scalar, value: Scalar) -> Scalar:
    if isinstance(factor, int):
        return value if factor == 1 else -value
    return value * factor


@dataclass(frozen=True)
class Problem:
    """y' = rates(parameters, y, fn), y(0) = start, for exact real parameters and start.

    ``rates`` is generic in the arithmetic, analytic, and free of time. ``parameters`` and
    ``start`` return balls around the exact numbers, in the working precision of the moment: as
    tight as one asks. ``scene`` is where it comes from, if it does.
    """

    name: str
    columns: tuple[str, ...]
    rates: Callable[[Sequence[Scalar], Sequence[Scalar], Functions], Sequence[Scalar]]
    parameters: Callable[[], Sequence[arb]]
    start: Callable[[], Sequence[arb]]
    until: Callable[[], arb]
    scene: Scene | None = None

    @cached_property
    def traced(self) -> Equations:
        """``rates`` with each operation once, for arithmetics in which they are long."""
        return Equations(self.rates, len(self.parameters()), len(self.columns))


def problem_of(scene: Scene) -> Problem:
    """The scene in vectors and dimensionless units (m = R = g = 1), the axis at azimuth 0.

    The state is that of ``form_of``; recorded quadratures follow, scaled down as in
    ``integration.equations``.

    Raises
    ------
    NotProved
        The scene changes its equations on the way (flight, an elastic table), or they contain a
        function that balls lack.
    """
    if scene.lifts:
        raise NotProved(
            "equations", "flight and elastic tables change them on the way; proofs cover one set"
        )
    missing = scene.body.friction.missing(Balls)
    if missing:
        raise NotProved(
            "equations",
            f"{scene.body.law} friction needs {' and '.join(missing)}, proofs have none",
        )
    form = form_of(scene)

    def rates(
        parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
    ) -> Sequence[Scalar]:
        return extended_rates(form, scene.record, body_of(scene, parameters), tuple(state), fn)

    known: dict[int, Sequence[arb]] = {}

    def parameters() -> Sequence[arb]:
        precision = flint.ctx.prec
        if precision not in known:
            known[precision] = InitialState.of(scene, BALLS).parameters(form)
        return known[precision]

    def start() -> Sequence[arb]:
        state = InitialState.of(scene, BALLS).state(form)
        return [*map(arb, state), *(arb(0) for _ in scene.record)]

    def until() -> arb:
        return dimensionless_time(scene, scene.until)

    return Problem(
        scene.name, (*form.columns, *scene.record), rates, parameters, start, until, scene
    )


def form_of(scene: Scene) -> Formulation:
    """The equations that are enclosed: those that heyoka integrates, in vectors."""
    return integrated(scene.model, "newton", scene.body.friction)


def body_of(scene: Scene, parameters: Sequence[Scalar]) -> Parameters:
    """The dimensionless body whose open parameters are given."""
    return form_of(scene).body(parameters)


def units_of(scene: Scene) -> Units:
    """Mass, length and time units of the scene's dimensionless form in SI, as balls."""
    return Units.of(scene.body, Balls, ball)


def dimensionless_time(scene: Scene, seconds: Fraction) -> arb:
    """An exact time in s as a ball in units of sqrt(R/g)."""
    return ball(seconds) / units_of(scene).time


BOX = arb(2) ** -20  # half an edge; any positive number will do


def exact_zeros(problem: Problem) -> frozenset[int]:
    """Positions of components that are zero at the start and stay so."""
    start = problem.start()
    found = frozenset(i for i, value in enumerate(start) if value == 0)
    while found:
        state = [arb(0) if i in found else value + arb(0, BOX) for i, value in enumerate(start)]
        rates = problem.rates(problem.parameters(), state, Balls)
        staying = frozenset(i for i in found if arb(rates[i]) == 0)
        if staying == found:
            break
        found = staying
    return found


def without(problem: Problem, zeros: frozenset[int]) -> Problem:
    """The problem in the remaining components."""
    size = len(problem.columns)
    free = [i for i in range(size) if i not in zeros]

    def rates(
        parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
    ) -> Sequence[Scalar]:
        whole = restored(state, zeros, size, 0)
        found = problem.rates(parameters, whole, fn)
        return [found[i] for i in free]

    def start() -> Sequence[arb]:
        values = problem.start()
        return [values[i] for i in free]

    return replace(
        problem, columns=tuple(problem.columns[i] for i in free), rates=rates, start=start
    )


def restored(
    values: Sequence[Scalar], zeros: frozenset[int], size: int, zero: Scalar
) -> list[Scalar]:
    """The values with ``zero`` in the places that were left out."""
    remaining = iter(values)
    return [zero if i in zeros else next(remaining) for i in range(size)]


class Observer:
    """A scene's dimensionless ``Motion`` at entries of its state: balls, bands or slopes of bands.

    Functions of one observer share what they compute of the state that they saw last.
    """

    def __init__(self, scene: Scene):
        self.form, self._parameters = form_of(scene), problem_of(scene).parameters
        self._scene = scene
        self._last: tuple[Sequence[Scalar], int, Motion] | None = None

    def motion(self, state: Sequence[Scalar]) -> Motion:
        """The motion; a state is not to be changed after it was seen."""
        precision = flint.ctx.prec
        if self._last is None or self._last[0] is not state or self._last[1] != precision:
            body = body_of(self._scene, self._parameters())
            vectors = self.form.State(*state[: len(self.form.columns)])
            self._last = state, precision, self.form.motion(body, vectors, FUNCTIONS)
        return self._last[2]

    def of(self, evaluate: Callable[[Motion], Scalar]) -> Function:
        """``evaluate`` as a function of the state's entries."""
        return lambda state: evaluate(self.motion(state))


def observed(scene: Scene, evaluate: Callable[[Motion], Scalar]) -> Function:
    """``evaluate`` of the scene's ``Motion`` as a function of the state's entries."""
    return Observer(scene).of(evaluate)


def columns_in_si(scene: Scene, state: Sequence[arb]) -> dict[str, arb | None]:
    """Vector and Euler columns and recorded quadratures of one enclosed state, in SI.

    None where a value is undefined, or not bounded (Euler angles at a pole).
    """
    motion = Observer(scene).motion(state)
    names = [*NewtonState._fields, *EulerState._fields, *scene.record]
    recorded = [value * QUADRATURE_SCALE for value in state[len(form_of(scene).columns) :]]
    units = units_of(scene)
    found: dict[str, arb | None] = {}
    for name, value in zip(names, [*motion.state, *motion.euler, *recorded], strict=True):
        number = arb(value) * units.of_dimension(STATE_DIMENSIONS[name])
        found[name] = number if number.is_finite() else None
    return found
