"""The exact initial value problem to enclose, and the functions observed along its motion.

A ``Problem`` is independent of scenes, so that closed forms can test the kernel. ``problem_of``
makes the problem of a scene in vectors and dimensionless units (m = R = g = 1), the axis at
azimuth 0.

``Onset`` decides to which order a function vanishes at the start, and the sign that follows. A ball
around zero cannot decide that a number is zero; ``Formal`` numbers can: they are exact in
t = tan(theta/2) and in one square root, for the scene's own start. A function vanishes to the order
n if its Taylor coefficients before the n-th are formally zero and the ball of the n-th excludes
zero. Both decisions are about exact numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from operator import attrgetter
from typing import Any

from flint import arb, fmpq, fmpq_poly

from tt_precise.certify.balls import Balls, NotProved, ball
from tt_precise.certify.models import Field, PowerSeries, coefficient, solution
from tt_precise.integration.equations import Layout
from tt_precise.integration.events import Event, catalogue, event_named
from tt_precise.mechanics import compliant, formulations
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.nonsmooth.lifting import pressed
from tt_precise.nonsmooth.phases import elastic, raised
from tt_precise.runtime.values import Arithmetic, Functions, Scalar
from tt_precise.scene.scene import InitialState, Scene

BALLS = Arithmetic(Balls, ball)
contact_force = QUANTITIES["g_n"].evaluate  # Keeps a top on the table while it is positive.
_height = attrgetter("state.height")
VANISHING = 6  # The highest order that is tried; each costs a term of two power series.
NONE, ONE, ZERO = fmpq_poly([]), fmpq_poly([1]), fmpq(0)

Function = Callable[[Any], Scalar]  # Of the motion in a state.


class Onset:
    """Orders and signs of functions of a motion at t = 0.

    ``formal`` and ``balls`` are the motion as power series in time, in the two arithmetics.
    """

    def __init__(self, formal: Callable[[], Any], balls: Callable[[], Any]):
        self.formal, self.balls = cache(formal), cache(balls)

    def order(self, function: Function) -> int:
        """Return the order to which a function vanishes.

        Raises ``NotProved``: that is undecided.
        """
        for order in range(VANISHING + 1):
            if not self._coefficient(function, order).contains(0):
                return order
            if Formal.of(coefficient(function(self.formal()), order)):
                break
        raise NotProved("zeros", f"a sign at t = 0 is undecided, in order {order}")

    def sign(self, function: Function, order: int) -> int:
        """Return the sign of the coefficient of that ``order``, which is not zero."""
        return 1 if self._coefficient(function, order) > 0 else -1

    def _coefficient(self, function: Function, order: int) -> arb:
        return arb(coefficient(function(self.balls()), order))


class Formal(Field):
    """An exact number (a + r b)/c: polynomials in t = tan(theta/2), r the root of ``square``.

    It is zero if a and b are. (What has another a or b may still be zero; balls decide.)
    """

    def __init__(self, a: fmpq_poly, b: fmpq_poly, c: fmpq_poly, square: fmpq = ZERO):
        common = a.gcd(b).gcd(c) * c.leading_coefficient()  # a gcd leads with 1, and so will c
        self.a, self.b, self.c, self.square = a / common, b / common, c / common, square

    @classmethod
    def of(cls, x: Scalar) -> Formal:
        """Return a rational number as a formal number; a formal number stays unchanged."""
        return x if isinstance(x, Formal) else cls(fmpq_poly([x]), NONE, ONE)

    def __bool__(self) -> bool:
        return bool(self.a) or bool(self.b)

    def __add__(self, other: Scalar) -> Formal:
        y = Formal.of(other)
        a, b = self.a * y.c + y.a * self.c, self.b * y.c + y.b * self.c
        return Formal(a, b, self.c * y.c, self.square or y.square)

    def __neg__(self) -> Formal:
        return Formal(-self.a, -self.b, self.c, self.square)

    def __mul__(self, other: Scalar) -> Formal:
        y, square = Formal.of(other), self.square or Formal.of(other).square
        a, b = self.a * y.a + self.b * y.b * square, self.a * y.b + self.b * y.a
        return Formal(a, b, self.c * y.c, square)

    def inverse(self) -> Formal:
        """Return the reciprocal.

        Raises ``NotProved``: the number is formally zero.
        """
        norm = self.a * self.a - self.b * self.b * self.square
        if not norm:
            raise NotProved("zeros", "a division by zero at t = 0")
        return Formal(self.a * self.c, -self.b * self.c, norm, self.square)

    def exp(self) -> Formal:
        raise NotProved("zeros", "an exponential at t = 0 is no formal number")


class FormalFunctions:
    """Functions at one start, which may contain the root of one number that is not a square."""

    square = ZERO

    sin = staticmethod(lambda angle: Formal(fmpq_poly([0, 2]), NONE, fmpq_poly([1, 0, 1])))
    cos = staticmethod(lambda angle: Formal(fmpq_poly([1, 0, -1]), NONE, fmpq_poly([1, 0, 1])))
    acos = staticmethod(lambda x: arb.nan())  # an angle is no formal number

    def exp(self, x: Scalar) -> Scalar:
        return x.exp() if isinstance(x, PowerSeries) else Formal.of(x).exp()

    def sqrt(self, x: Scalar) -> Scalar:
        """Return the root of a rational number.

        Raises ``NotProved``: it is not rational, or the second irrational root.
        """
        if isinstance(x, PowerSeries):
            return x.sqrt(self.sqrt)
        y = Formal.of(x)
        if y.b or max(y.a.degree(), y.c.degree()) > 0:
            raise NotProved("zeros", "the root of a number that is not rational, at t = 0")
        square = y.a[0] / y.c[0]
        if all(whole.is_square() for whole in (square.p, square.q)):
            return Formal.of(fmpq(square.p.isqrt(), square.q.isqrt()))
        if self.square not in (ZERO, square):
            raise NotProved("zeros", "the roots of two numbers at t = 0")
        self.square = square
        return Formal(NONE, ONE, ONE, square)


@dataclass(frozen=True)
class ProblemPhase:
    """Equations that hold until ``function`` falls to zero, which is the event ``ends``.

    ``motion`` turns a state into the argument of functions. A phase that begins ``positive`` has
    to begin with a positive function. Where ``excluded[0]`` falls to zero in the phase,
    ``excluded[1]`` has to be positive, or the equations no longer hold; ``excluded[0]`` rises
    through a simple zero where the phase begins.
    """

    ends: str
    rates: Callable[[Sequence[Scalar]], Sequence[Scalar]]
    motion: Callable[[Sequence[Scalar]], Any]
    function: Function
    positive: bool = True
    glides: bool = True
    excluded: tuple[Function, Function] | None = None


@dataclass(frozen=True)
class Problem:
    """A motion from ``start`` at t = 0 to ``until``, through its ``phases`` by turns.

    ``onset`` decides how functions begin at t = 0; ``kinds`` are the events to be enclosed, and
    ``samples`` the times at which the state is. At the zeros of ``doubles[name][0]`` in the
    direction ``doubles[name][1]`` the function of an event is known to have a double zero.
    """

    phases: tuple[ProblemPhase, ...]
    start: Sequence[arb]
    until: arb
    onset: Any
    kinds: Mapping[str, Event] = field(default_factory=dict)
    samples: Sequence[arb] = ()
    doubles: Mapping[str, tuple[Function, int]] = field(default_factory=dict)


def problem_of(scene: Scene) -> Problem:
    """Return the problem of a scene, in balls of the working precision.

    Raises ``NotProved``: the scene changes its equations in a way that proofs do not cover, or does
    not begin as its model requires.
    """
    forms = _forms(scene)
    start = _pressed(scene, InitialState.of(scene, BALLS), Balls)
    phases = tuple(_phase(scene, start, *form) for form in forms)
    (_, form, _), *_ = forms
    first = list(map(arb, start.first_row(form, scene.record)))
    if not all(arb(x).is_finite() for x in (*first, *start.parameters(form))):
        raise NotProved("balls", "a parameter or an initial value is not finite")
    if scene.body.spring and not _height(phases[0].motion(first)) < 0:
        raise NotProved("contact", "the top may begin above the elastic table")
    onset = _onset(scene, form)
    samples = [ball(seconds) / start.units.time for seconds in scene.sample_times]
    kinds = {name: event_named(name, scene.model) for name in catalogue(scene.model)}
    doubles = _mirrored(scene, onset)
    return Problem(phases, first, start.until, onset, kinds, samples, doubles)


def _forms(scene: Scene) -> list[tuple[str, Formulation, Function]]:
    """Return the end of each phase of a motion, its equations, and the decreasing function."""
    law, spring = scene.body.friction, scene.body.spring
    if scene.flies or spring == "hunt-crossley":
        which = "flight after contact" if scene.flies else f"a {spring} table"
        raise NotProved("equations", f"{which} changes them in a way that proofs do not cover")
    if scene.model == "flight":
        return [("landed", raised(), _height)]
    if not spring:
        form = formulations.integration_form(scene.model, "newton", law)
        return [("contact_lost", form, contact_force)]
    return [
        ("separation", elastic(spring, law), contact_force),
        ("landing", raised(spring), _height),
    ]


def _phase(
    scene: Scene, start: InitialState, ends: str, form: Formulation, function: Function
) -> ProblemPhase:
    size, layout = len(form.columns), Layout(form, scene.record)
    return ProblemPhase(
        ends,
        lambda y: layout.rates(start.body, tuple(y), Balls),
        lambda y: form.motion(start.body, form.State(*y[:size]), Balls),
        function,
        positive=ends != "landing",
        glides=form.model != "flight",
        excluded=(_pull, _height) if ends == "landing" else None,
    )


def _pressed(scene: Scene, start: InitialState, fn: Functions) -> InitialState:
    return pressed(start, fn) if scene.body.spring else start


def _onset(scene: Scene, form: Formulation) -> Onset:
    formal = FormalFunctions()

    def series(of: Callable[[], InitialState], fn: Functions) -> Callable[[], Motion]:
        def motion() -> Motion:
            start = _pressed(scene, of(), fn)
            rates = lambda y: form.rates(start.body, form.State(*y), fn)  # noqa: E731
            y = solution(rates, start.state(form))
            return form.motion(start.body, form.State(*y), fn)

        return motion

    rational = Arithmetic(formal, lambda x: fmpq(x.numerator, x.denominator))
    return Onset(
        series(lambda: InitialState.in_si(scene, rational), formal),
        series(lambda: InitialState.of(scene, BALLS), Balls),
    )


def _mirrored(scene: Scene, onset: Onset) -> dict[str, tuple[Function, int]]:
    """Return the turning points at which phi_dot is zero without changing its sign, if any.

    Without friction, and rolling, the equations for k and L admit reversal of time together with a
    mirror that is a vertical plane. At a turning point of theta k and L go over into themselves by
    the plane that contains the axis, so the motion before it is the mirror image of that after it,
    and phi_dot is the same. Where the motion starts from a turning point with phi_dot = 0, every
    second turning point, the next one of the same kind, has this phi_dot, and its derivative is 0.
    """
    turn = event_named("theta_max", scene.model).function
    loses = (scene.body.mu and scene.model == "gliding") or scene.body.spring
    if loses or not scene.start.theta_dot == 0 == scene.start.phi_dot:
        return {}
    try:
        return {"phi_dot_zero": (turn, onset.sign(turn, 1))} if onset.order(turn) == 1 else {}
    except NotProved:
        return {}


def _pull(q: Motion) -> Scalar:
    """The pull of an elastic table by the formula of its force, without the cut at zero."""
    return compliant.pull(q.body, q.state.height, q.state.rise)
