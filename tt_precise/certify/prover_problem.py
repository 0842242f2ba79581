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

from flint import arb

from tt_precise.certify.balls import Balls, NotProved, ball
from tt_precise.integration.equations import QUADRATURE_SCALE, Layout
from tt_precise.mechanics import formulations
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.parameters import Units
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import Arithmetic, Functions, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene
from tt_precise.taylor.graph import Constant, Graph, Operand, constants_of, in_order, numbers
from tt_precise.taylor.series import Series, SeriesFunctions


class _Functions(SeriesFunctions, Balls):
    """Those of balls, and of power series over them or over Taylor models."""

    def hypot(self, x: Scalar, y: Scalar) -> Scalar:  # type: ignore[override]
        return self.sqrt(x * x + y * y) if isinstance(x, Series) else Balls.hypot(x, y)


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
        alone = [result for result in self._results if isinstance(result, Constant)]
        self._constants = [*constants_of(self._nodes), *alone]

    def __call__(self, parameters: Sequence[Scalar], state: Sequence[Scalar]) -> list[Scalar]:
        """The rates, in the arithmetic of the state; parameters are balls."""
        known: dict[Scalar, Scalar] = dict(numbers(self._constants, parameters, Balls))

        def value(operand: Scalar) -> Scalar:
            return known[operand] if isinstance(operand, Operand) else operand

        for node in self._nodes:
            if node.kind == "entry":
                known[node] = state[node.args[0]]
            elif node.kind == "sum":
                offset, terms = node.args
                scaled = [_times(value(factor), known[operand]) for factor, operand in terms]
                if isinstance(offset, Operand) or offset != 0:
                    scaled.append(value(offset))
                known[node] = reduce(add, scaled)
            elif node.kind == "root":
                known[node] = known[node.args[0]].sqrt()
            else:
                a, b = map(value, node.args)
                known[node] = a * b if node.kind == "product" else a / b
        return [value(operand) for operand in self._results]


def _times(factor: Scalar, value: Scalar) -> Scalar:
    if isinstance(factor, int):
        return value if factor == 1 else -value
    return value * factor


@dataclass(frozen=True)
class Problem:
    """y' = rates(parameters, y, fn), y(0) = start, for exact real parameters and start.

    ``rates`` is generic in the arithmetic, analytic, and free of time. ``parameters`` and
    ``start`` return balls around the exact numbers, in the working precision of the moment: as
    tight as one asks. ``form`` is the formulation of a scene that they are from, if they are.
    """

    name: str
    columns: tuple[str, ...]
    rates: Callable[[Sequence[Scalar], Sequence[Scalar], Functions], Sequence[Scalar]]
    parameters: Callable[[], Sequence[arb]]
    start: Callable[[], Sequence[arb]]
    until: Callable[[], arb]
    form: Formulation | None = None

    @cached_property
    def traced(self) -> Equations:
        """``rates`` with each operation once, for arithmetics in which they are long."""
        return Equations(self.rates, len(self.parameters()), len(self.columns))

    def rates_at(self, state: Sequence[Scalar]) -> Sequence[Scalar]:
        """The rates in the arithmetic of ``state``: Taylor models, dual numbers."""
        return self.traced(self.parameters(), state)


@dataclass(frozen=True)
class Phase:
    """Equations that hold until ``function`` falls to zero, which is the event ``ends``."""

    ends: str
    form: Formulation
    function: Callable[[Motion], Scalar]


def contact_force(q: Motion) -> Scalar:
    """What a top stays on the table by."""
    return QUANTITIES["g_n"].evaluate(q)


def phases_of(scene: Scene) -> tuple[Phase, ...]:
    """What a motion consists of: one phase, or contact and flight by turns, which may begin.

    Raises ``NotProved``: it changes its equations in a way that proofs do not cover, or they
    contain a function that balls lack.
    """
    spring, law = scene.body.spring, scene.body.friction
    if scene.flies or spring == "hunt-crossley":
        what = "flight after contact" if scene.flies else f"a {spring} table"
        raise NotProved("equations", f"{what} changes them in a way that proofs do not cover")
    missing = law.missing(Balls)
    if missing:
        raise NotProved(
            "equations", f"{law.name} friction needs {' and '.join(missing)}, proofs have none"
        )
    form = formulations.integrated(scene.model, "newton", law)
    if scene.model == "flight":
        return (Phase("landed", form, lambda q: q.state.height),)
    if not spring:
        return (Phase("contact_lost", form, contact_force),)
    pressed = Phase("separation", formulations.elastic(spring, "newton", law), contact_force)
    return pressed, Phase(
        "landing", formulations.raised("newton", spring), lambda q: q.state.height
    )


def problem_of(
    scene: Scene, form: Formulation | None = None, begins: Sequence[arb] | None = None
) -> Problem:
    """The scene in vectors and dimensionless units (m = R = g = 1), the axis at azimuth 0.

    The state is that of ``form``, by default of ``form_of``; recorded quadratures follow, scaled
    down as in ``integration.equations``. It ``begins`` as the scene says, or in another state.

    Raises
    ------
    NotProved
        As ``phases_of``.
    """
    form = form or form_of(scene)

    def rates(
        parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
    ) -> Sequence[Scalar]:
        return Layout(form, scene.record).rates(form.body(parameters), tuple(state), fn)

    def parameters() -> Sequence[arb]:
        return InitialState.of(scene, BALLS).parameters(form)

    def start() -> Sequence[arb]:
        if begins is not None:
            return begins
        first = InitialState.of(scene, BALLS)
        state = (first.pressed_in(Balls) if scene.body.spring else first).state(form)
        return [*map(arb, state), *(arb(0) for _ in scene.record)]

    def until() -> arb:
        return dimensionless_time(scene, scene.until)

    return Problem(
        scene.name, (*form.columns, *scene.record), rates, parameters, start, until, form
    )


def form_of(scene: Scene) -> Formulation:
    """The equations that are enclosed at first, in vectors; others have the same columns."""
    return phases_of(scene)[0].form


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
    vanishing = frozenset(i for i, value in enumerate(start) if value == 0)
    while vanishing:
        state = [arb(0) if i in vanishing else value + arb(0, BOX) for i, value in enumerate(start)]
        rates = problem.rates(problem.parameters(), state, Balls)
        staying = frozenset(i for i in vanishing if arb(rates[i]) == 0)
        if staying == vanishing:
            break
        vanishing = staying
    return vanishing


def without(problem: Problem, zeros: frozenset[int]) -> Problem:
    """The problem in the remaining components."""
    size = len(problem.columns)
    free = [i for i in range(size) if i not in zeros]

    def rates(
        parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
    ) -> Sequence[Scalar]:
        whole = restored(state, zeros, size, 0)
        reduced_rates = problem.rates(parameters, whole, fn)
        return [reduced_rates[i] for i in free]

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


def motion_of(scene: Scene, form: Formulation | None = None) -> Callable[..., Motion]:
    """The scene's dimensionless ``Motion`` at entries of its state, in any arithmetic."""
    form = form or form_of(scene)
    parameters, width = problem_of(scene, form).parameters, len(form.columns)

    def motion(state: Sequence[Scalar]) -> Motion:
        return form.motion(form.body(parameters()), form.State(*state[:width]), FUNCTIONS)

    return motion


def observed(
    scene: Scene, evaluate: Callable[[Motion], Scalar], form: Formulation | None = None
) -> Function:
    """``evaluate`` of the scene's ``Motion`` as a function of the state's entries."""
    motion = motion_of(scene, form)
    return lambda state: evaluate(motion(state))


def columns_in_si(scene: Scene, state: Sequence[arb]) -> dict[str, arb | None]:
    """Vector and Euler columns and recorded quadratures of one enclosed state, in SI.

    None where a value is undefined, or not bounded (Euler angles at a pole).
    """
    motion = motion_of(scene)(state)
    names = [*motion.state._fields, *EulerState._fields, *scene.record]
    recorded = [value * QUADRATURE_SCALE for value in state[len(form_of(scene).columns) :]]
    units = units_of(scene)
    columns: dict[str, arb | None] = {}
    for name, value in zip(names, [*motion.state, *motion.euler, *recorded], strict=True):
        number = arb(value) * units.of_dimension(formulations.STATE_DIMENSIONS[name])
        columns[name] = number if number.is_finite() else None
    return columns
