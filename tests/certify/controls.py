"""Closed forms that a program without one of the theorem's hypotheses would exclude.

Each control takes the trusted modules and fails where they claim something false. Polynomials are
coarse, so that errors are far above rounding: ``step.at(s)`` has to contain every solution from the
set of starts throughout a piece, ``states.state`` at its end.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import flint
import pytest
from flint import arb, arb_mat, arb_poly, fmpq

import tt_precise as tt
from tests.certify.harness import BITS, Enclosing
from tt_precise.certify.balls import Balls, NotProved, ball
from tt_precise.integration.equations import Layout
from tt_precise.integration.events import Event
from tt_precise.mechanics import formulations
from tt_precise.mechanics.euler import EulerState, vectors_from_euler

TINY = arb(2) ** -80
GUARD = 40  # bits of the controls beyond those of the enclosures
CONTROLS: dict[str, Callable[[Any], None]] = {}


def control(check: Callable[[Any], None]) -> Callable[[Any], None]:
    CONTROLS[check.__name__] = check
    return check


def run(name: str, trusted: Any) -> None:
    """Try a control on the trusted modules; it fails where they claim something false."""
    with flint.ctx.workprec(BITS + GUARD):
        CONTROLS[name](trusted)


def holds(balls: Sequence[arb], exact: Sequence[Any]) -> None:
    pairs = list(zip(balls, exact, strict=True))
    assert all(one.is_finite() and one.overlaps(arb(other)) for one, other in pairs), pairs


def everywhere(one: Any, *exact: Sequence[Any]) -> None:
    """Solutions at the end of a piece: by the bound within it, and by the set that goes on."""
    for state in exact:
        holds(one.step.at(one.step.length), state)
        holds(one.states.state, state)


def exponential(trusted: Any, start: arb, order: int = 30, rate: Any = 1) -> Any:
    return Enclosing(trusted, lambda y: [y[0] * rate], [start], order)


# ---- S1 to S4, the end of a piece, the gap to the next ------------------------------------------


@control
def s1_a_coarse_exponential(trusted: Any) -> None:
    """x' = x with four terms: the error of the polynomial is all that there is."""
    one, s = exponential(trusted, arb(1), order=3), arb(2) ** -18
    one.on(s)
    everywhere(one, [s.exp()])
    holds(one.step.state(s / 2), [(s / 2).exp()])
    for outside in (-s, 2 * s):
        with pytest.raises(NotProved, match="in a step"):
            one.step.state(outside)


@control
def s1_errors_of_pieces_add_up(trusted: Any) -> None:
    """The defect at a piece's end, d G: after many pieces all errors are in the set."""
    one, s = exponential(trusted, arb(1), order=3), arb(2) ** -19
    for n in range(1, 41):
        one.on(s)
        everywhere(one, [(s * n).exp()])


@control
def s1_a_constant_defect_grows(trusted: Any) -> None:
    """x' = a x + c with c in a ball: the defect d is constant, and its effect is d G, not d S."""
    growth, c = arb(2).exp(), arb(0, TINY)
    for a, rates in ((8, lambda y: [y[0] * 8 + c]), (arb(0.5), lambda y: [y[0] / 2 + c])):
        one = Enclosing(trusted, rates, [arb(1)], 40)
        one.on(arb(2) / a)
        everywhere(one, *([growth + x * (growth - 1) / a] for x in (-TINY, TINY)))


@control
def s2_a_ball_of_starts_grows(trusted: Any) -> None:
    """|e0| exp(a S): solutions through both ends of the starts; and no wider than it has to be."""
    one, half = exponential(trusted, arb(1, TINY)), arb(0.5)
    one.on(half)
    everywhere(one, *([end * half.exp()] for end in (1 - TINY, 1 + TINY)))
    assert one.states.state[0].rad() < TINY * half.exp() * 1.01


@control
def s2_coupling_counts(trusted: Any) -> None:
    """x' = 20 y, y' = 0: the diagonal of the derivative is zero."""
    one = Enclosing(trusted, lambda y: [y[1] * 20, y[1] * 0], [arb(1), arb(1, TINY)], 5)
    one.on(arb(1) / 4)
    everywhere(one, *([1 + 5 * y, y] for y in (1 - TINY, 1 + TINY)))


@control
def s2_the_derivative_belongs_to_the_tube(trusted: Any) -> None:
    """x' = 2^72 x^2: on the polynomial, which is 0, the derivative vanishes; near it, it is 2."""
    steep, x = arb(2) ** 72, arb(2) ** -73
    one = Enclosing(trusted, lambda y: [y[0] * y[0] * steep], [arb(0, x)], 5)
    one.on(arb(1) / 8)
    holds(one.step.at(one.step.length), [x / (1 - steep * x / 8)])


@control
def s2_a_derivative_that_grows_in_a_piece(trusted: Any) -> None:
    """x' = x^2 from 1: errors grow as 1/(1 - t)^2."""
    one, s = Enclosing(trusted, lambda y: [y[0] * y[0]], [arb(1, TINY)], 110), arb(1) / 4
    one.on(s)
    everywhere(one, *([x / (1 - x * s)] for x in (1 - TINY, 1 + TINY)))


@control
def s3_the_flow_turns_a_flat_set(trusted: Any) -> None:
    """A rotation; uncertain in x alone, a quarter of a turn later in v alone."""
    one = Enclosing(trusted, lambda y: [y[1], -y[0]], [arb(1, TINY), arb(0)], 40)
    while one.states.time < 6:
        one.on(arb(0.5))
        t = one.states.time
        everywhere(one, *([x * t.cos(), -x * t.sin()] for x in (1 - TINY, 1 + TINY)))
    assert max(x.rad() for x in one.states.state) < 1.05 * TINY


@control
def s3_the_flow_has_an_error(trusted: Any) -> None:
    """A start 2^-75 from the polynomial's is known to 60 digits, P to 12: q is what remains."""
    one = exponential(trusted, arb(1), rate=arb(1) / 8)  # so that G > 1
    one.on(arb(4), shift=arb(2) ** -75)
    holds(one.states.state, [arb(0.5).exp()])
    assert one.states.state[0].rad() < arb(2) ** -75 * 1e-9


@control
def s4_a_blow_up_is_refused(trusted: Any) -> None:
    """x' = x^2 from [-0.9, 0.9]: the solution through 0.9 ends at t = 1.11."""
    for radius in (arb(0.9), arb(2) ** -60):
        one = Enclosing(trusted, lambda y: [y[0] * y[0]], [arb(0, radius)], 10)
        with pytest.raises(NotProved, match="S4"):
            one.on(arb(1))


@control
def s4_a_defect_that_leaves_the_tube_is_refused(trusted: Any) -> None:
    one = Enclosing(trusted, lambda y: [y[0] * y[0]], [arb(1)], 6)
    with pytest.raises(NotProved, match="S4"):
        one.on(arb(0.5))
    # with finer pieces it is enclosed: 1/(1 - t)
    one = Enclosing(trusted, lambda y: [y[0] * y[0]], [arb(1)], 40)
    for n in range(1, 9):
        one.on(arb(1) / 16)
        everywhere(one, [1 / (1 - arb(n) / 16)])


@control
def gaps_between_pieces_count(trusted: Any) -> None:
    """Pieces that begin 2^-90 from where the last one ended."""
    one = exponential(trusted, arb(1))
    for n in (1, 2, 3):
        one.on(arb(0.25), shift=arb(2) ** -90)
        everywhere(one, [(arb(n) / 4).exp()])


@control
def guesses_that_are_none_are_refused(trusted: Any) -> None:
    """Polynomials in balls or without numbers, P(0) = 0, weights and lengths below zero."""
    coarse = lambda *_: [arb_poly([1, arb(1, 0.5)])] * 2  # noqa: E731
    endless = lambda *_: [arb_poly([1, arb("inf")])] * 2  # noqa: E731
    zeros = lambda *_: [[arb_poly([0])] * 2] * 2  # noqa: E731
    wide = lambda *_: [[arb_poly([int(i == j), arb(1, 1)]) for j in (0, 1)] for i in (0, 1)]  # noqa: E731
    for why, guess in (
        ("polynomial is not exact", {"taylor": coarse}),
        ("polynomial is not exact", {"taylor": endless}),
        ("polynomial is not exact", {"flow": wide}),
        ("is not 1", {"flow": zeros}),
        ("weight is not positive", {"weights": lambda band: [arb(1), arb(-0.5)]}),
        ("weight is not positive", {"weights": lambda band: [arb(1), arb("inf")]}),
        ("weight is not positive", {"weights": lambda band: [arb("nan"), arb(1)]}),
    ):
        one = Enclosing(trusted, lambda y: [y[0] + y[1], y[1]], [arb(1), arb(1)], 30, **guess)
        with pytest.raises(NotProved, match=why):
            one.on(arb(0.25))
    for length in (arb(0.25, 0.01), arb(-0.25), arb(0), arb("nan")):
        with pytest.raises(NotProved, match="positive length"):
            exponential(trusted, arb(1)).on(length)


# ---- the weights of the norm, any of which are right --------------------------------------------


def lopsided(power: int) -> list[Callable[..., list[arb]]]:
    return [lambda band, n=n: [arb(1), arb(2) ** n] for n in (-power, 0, power)]


TINIER = arb(2) ** -100


@control
def any_weights_of_a_coarse_polynomial(trusted: Any) -> None:
    """Two exponentials that do not know each other, with four terms; many steps."""
    s = arb(2) ** -23
    for weights in lopsided(16):
        one = Enclosing(trusted, lambda y: [y[0], y[1]], [arb(1), arb(1)], 3, weights=weights)
        for n in range(1, 6):
            one.on(s)
            everywhere(one, [(s * n).exp()] * 2)


@control
def any_weights_of_a_ball_of_starts(trusted: Any) -> None:
    """Both exponentials from balls of starts, with many terms."""
    for weights in lopsided(16):
        for way in (1, -1):
            starts = [arb(1), arb(1, TINIER)][::way]
            one = Enclosing(trusted, lambda y: [y[0], y[1]], starts, 30, weights=weights)
            one.on(arb(0.5))
            exact = arb(0.5).exp()
            everywhere(one, *([exact, end * exact][::way] for end in (1 - TINIER, 1 + TINIER)))


@control
def any_weights_of_coupled_components(trusted: Any) -> None:
    """x' = y/2, y' = 0, either way round."""
    for weights in lopsided(4):
        for way in (1, -1):
            start = [arb(1), arb(1, TINIER)][::way]
            one = Enclosing(trusted, _coupled(way), start, 5, weights=weights)
            one.on(arb(1) / 4)
            everywhere(one, *([1 + y / 8, y][::way] for y in (1 - TINIER, 1 + TINIER)))


def _coupled(way: int) -> Callable[[Sequence[Any]], list[Any]]:
    return lambda y: [y[::way][1] * arb(0.5), y[0] * 0][::way]


@control
def any_weights_of_the_flow(trusted: Any) -> None:
    """x' = x + 256 y, y' = y, either way round; y begins 2^-100 from the polynomial's start."""
    t = arb(2) ** -24
    for weights in lopsided(12):
        for way in (1, -1):
            start, shift = [arb(1), arb(1)], [arb(0), TINIER][::way]
            one = Enclosing(trusted, _growing(way), start, 20, weights=weights)
            one.on(t, shift=shift)
            holds(one.states.state, [(1 + 256 * t) * t.exp(), t.exp()][::way])


def _growing(way: int) -> Callable[[Sequence[Any]], list[Any]]:
    return lambda y: [y[::way][0] + y[::way][1] * 256, y[::way][1]][::way]


# ---- components that stay zero ------------------------------------------------------------------


@control
def a_component_that_stays_zero_is_exact(trusted: Any) -> None:
    """x' = x^2 y from x = 0; no other start is accepted for it."""
    one = Enclosing(trusted, lambda y: [y[0] * y[0] * y[1], y[1]], [arb(0), arb(1)], 30)
    assert one.states.free == [1]
    one.on(arb(0.5))
    assert one.step.at(arb(0.5))[0].is_zero()
    # a rate that is always zero does not make it so
    one = Enclosing(trusted, lambda y: [y[0] * 0, y[1]], [arb(0), arb(1)], 30)
    assert one.states.free == [1]
    begin = [arb(2) ** -90, arb(1)]
    with pytest.raises(NotProved, match="stay zero"):
        trusted.kernel.advance(one.rates, one.states, arb(0.5), begin)


@control
def that_a_component_stays_zero_is_verified(trusted: Any) -> None:
    """x' = y from x = 0 and y = 1, as if x were to stay zero."""
    one = Enclosing(trusted, lambda y: [y[1], y[1] * 0], [arb(0), arb(1)], 5)
    assert one.states.free == [0, 1]
    one.states = replace(
        one.states, free=[1], box=arb_mat(1, 1, [arb(0)]), basis=arb_mat([[arb(1)]])
    )
    with pytest.raises(NotProved, match="stay zero"):
        one.on(arb(1) / 4)


# ---- the scenes' own equations ------------------------------------------------------------------


@control
def a_steady_precession(trusted: Any) -> None:
    """A top without friction that keeps its tilt: k and L turn about the vertical, exactly."""
    for seed in range(2):
        one, exact = _precession(trusted, random.Random(seed))
        for n in range(1, 21):
            one.on(arb(2) ** -7, shift=arb(2) ** -78 if n == 1 else 0)
            everywhere(one, exact(one.states.time))
        assert max(x.rad() for x in one.states.state) < 1e-21


def _precession(trusted: Any, dice: random.Random) -> tuple[Any, Callable[[arb], list[arb]]]:
    theta, alpha = Fraction(dice.randint(20, 280), 100), Fraction(dice.randint(5, 60), 100)
    rate = ball(Fraction(dice.choice((-1, 1)) * dice.randint(50, 300), 100))
    scene = tt.load_scene("frictionless")
    scene = replace(scene, body=replace(scene.body, alpha=alpha))
    form = formulations.integration_form("gliding", "newton", scene.body.friction)
    body = scene.body.dimensionless(Balls, ball)
    sine_cosine = ball(theta).sin(), ball(theta).cos()
    spin = (body.I1 * rate * sine_cosine[1] - body.alpha / rate) / body.I3
    euler = EulerState(None, arb(0), rate, spin, arb(0), arb(0))
    vectors = vectors_from_euler(body, euler, Balls, sine_cosine=sine_cosine)
    kx, ky, kz, Lx, Ly, Lz, *_ = vectors
    rest = [arb(0), arb(0)]

    def exact(t: arb) -> list[arb]:
        c, s = (rate * t).cos(), (rate * t).sin()
        return [c * kx - s * ky, s * kx + c * ky, kz, c * Lx - s * Ly, s * Lx + c * Ly, Lz, *rest]

    def rates(y: Sequence[Any]) -> list[Any]:
        return Layout(form).rates(body, tuple(y), Balls)

    return Enclosing(trusted, rates, [kx, ky, kz, Lx, Ly, Lz, *rest], 12), exact


# ---- the models of functions --------------------------------------------------------------------


@control
def models_contain_what_they_cut_off(trusted: Any) -> None:
    """Products, quotients, roots, exponentials of models of degree 3, at instants of [0, 1]."""
    models, quarter = trusted.models, arb(1) / 4
    for seed in range(4):
        dice, frame = random.Random(seed), models.Frame(arb(1), 3)
        radius = arb(2) ** -6 if seed % 2 else arb(0)
        a, b = (
            arb_poly([3] + [dice.randint(-40, 40) / arb(64) for _ in range(3)]) for _ in range(2)
        )
        f, g = (models.TaylorModel(p + arb(0, radius), frame) for p in (a, b))
        for k, sign in itertools.product(range(9), (-1, 1)):
            s = arb(k) / 8
            x, y = (p(s) + sign * radius for p in (a, b))
            for model, exact in (
                (f * g, x * y), (f / g, x / y), (f.sqrt(), x.sqrt()),
                ((f * quarter).exp(), (x * quarter).exp()),
            ):  # fmt: skip
                assert model.p.degree() <= 3
                assert model.p(s).overlaps(exact)
        constant = models.TaylorModel(arb_poly([arb(0, radius)]), frame).exp()
        holds([constant.p(arb(0))] * 2, [radius.exp(), (-radius).exp()])
    # errors as large as the functions: 1/4 to 7/4, and exp(t/4 - 1) within a unit of the exponent
    frame = models.Frame(arb(3), 1)
    g = models.TaylorModel(arb_poly([arb(1, 0.75)]), frame)
    rise = models.TaylorModel(arb_poly([arb(-1, 1), arb(0.25)]), frame).exp()
    holds([x.p(arb(3)) for x in (1 / g, g.sqrt(), rise)], [4, 0.5, arb(0.75).exp()])


@control
def what_is_no_number_is_refused(trusted: Any) -> None:
    """In FLINT the product of the polynomial 0 with NaN is 0, so that these must raise."""
    models = trusted.models
    assert (arb_poly([]) * arb("nan")).length() == 0
    frame = models.Frame(arb(1), 3)
    for bad in ([], [arb("nan")], [arb(1, 1.5)], [arb(-1), 2], [arb("nan"), 1], [1, arb("nan")]):
        for operation in (lambda x: x.inverse(), lambda x: x.sqrt(), lambda x: 1 / x):
            with pytest.raises(NotProved):
                operation(models.TaylorModel(arb_poly(bad), frame))
    for bad in ([arb("nan")], [1, arb("nan")], [1, arb("inf")]):
        with pytest.raises(NotProved):
            models.TaylorModel(arb_poly(bad), frame).exp()


@control
def constants_are_finite(trusted: Any) -> None:
    """Neither in the equations nor in the start; a product with a zero would hide them."""
    with pytest.raises(NotProved, match="not finite"):
        Enclosing(trusted, lambda y: [y[0] * arb("nan"), y[1]], [arb(0), arb(1)], 5)
    with pytest.raises(NotProved, match="not finite"):
        Enclosing(trusted, lambda y: [y[0], y[1] * 0], [arb(1), arb("nan")], 5)


@control
def an_exponential_in_the_equations(trusted: Any) -> None:
    """x' = exp(x) from x = 0: x = -log(1 - t)."""
    one = Enclosing(trusted, lambda y: [y[0].exp()], [arb(0, TINY)], 90)
    for n in range(1, 5):
        one.on(arb(1) / 8)
        everywhere(one, *([-((-end).exp() - arb(n) / 8).log()] for end in (-TINY, TINY)))


# ---- zeros --------------------------------------------------------------------------------------


def line(trusted: Any, start: Any = 0, order: int = 5) -> Any:
    """x' = 1."""
    return Enclosing(trusted, lambda y: [y[0] * 0 + 1], [arb(start)], order)


def found(zeros: Sequence[tuple[int, arb]], *expected: tuple[int, Any]) -> None:
    assert [way for way, _ in zeros] == [way for way, _ in expected]
    holds([time for _, time in zeros], [time for _, time in expected])


@control
def zeros_have_times_and_directions(trusted: Any) -> None:
    """Functions: (t - 0.1) (t - 0.3) (t - 0.4) in one step; an exponential; a constant."""
    one = line(trusted)
    one.on(arb(0.5))
    roots = [arb(1) / 10, arb(3) / 10, arb(4) / 10]
    found(
        one.zeros(lambda y: (y[0] - roots[0]) * (y[0] - roots[1]) * (y[0] - roots[2])),
        (1, roots[0]), (-1, roots[1]), (1, roots[2]),
    )  # fmt: skip
    # neither of a close pair is passed over, nor found where there is none
    close = roots[1] + arb(2) ** -30
    found(one.zeros(lambda y: (y[0] - roots[1]) * (y[0] - close)), (-1, roots[1]), (1, close))
    assert one.zeros(lambda y: (y[0] - roots[1]) * (y[0] - roots[1]) + arb(2) ** -60) == []
    assert one.zeros(lambda y: y[0] * 0 + 0) == []
    one = exponential(trusted, arb(1))
    one.on(arb(0.5))
    found(one.zeros(lambda y: y[0] - arb("1.3")), (1, arb("1.3").log()))


@control
def zeros_of_all_solutions(trusted: Any) -> None:
    """The times at which all solutions from a ball of starts reach 1.3."""
    one = exponential(trusted, arb(1, TINY))
    one.on(arb(0.5))
    for start in (1 - TINY, 1 + TINY):
        found(one.zeros(lambda y: y[0] - arb("1.3")), (1, (arb("1.3") / start).log()))


@control
def zeros_that_are_undecided_are_refused(trusted: Any) -> None:
    """At the end of a piece; at the end of the search; two or none."""
    one = line(trusted)
    one.on(arb(0.5))
    third = arb(1) / 3
    for function, until in (
        (lambda y: y[0] - arb(0.5), None),
        (lambda y: y[0] - third, arb(third.mid(), arb(2) ** -100)),
        (lambda y: (y[0] - third) * (y[0] - third), None),
    ):
        with pytest.raises(NotProved, match="undecided"):
            one.zeros(function, until)
    found(one.zeros(lambda y: y[0] - third, arb("0.4")), (1, third))
    assert one.zeros(lambda y: y[0] - third, arb("0.3")) == []
    one.on(arb(0.5))
    with pytest.raises(NotProved, match="undecided"):
        one.zeros(lambda y: y[0] - arb(0.5))


@control
def zeros_begin_after_the_start(trusted: Any) -> None:
    """t, t (t - 0.01) and t^2 (t - 0.01) vanish at 0, which is no event; 0.01 is one."""
    one, soon = line(trusted), arb(1) / 100
    one.on(arb(0.5))
    for order, function, expected in (
        (1, lambda y: y[0], []),
        (1, lambda y: y[0] * (y[0] - soon), [(1, soon)]),
        (2, lambda y: y[0] * y[0] * (y[0] - soon), [(1, soon)]),
    ):
        one.vanishing = order
        found(one.zeros(function), *expected)
    # of one that vanishes to an order which is not known nothing is said
    for one.vanishing, function in ((1, lambda y: y[0] * y[0]), (0, lambda y: y[0])):
        with pytest.raises(NotProved, match="undecided"):
            one.zeros(function)


@control
def zeros_that_are_double(trusted: Any) -> None:
    """A known double zero is none; one of which nothing is known is refused; others are found."""
    one, tenth, third = line(trusted), arb(1) / 10, arb(1) / 3
    one.on(arb(0.5))

    def touching(y: Any) -> Any:
        return (y[0] - tenth) * (y[0] - tenth)

    assert one.zeros(touching, double=[tenth]) == []
    found(one.zeros(lambda y: touching(y) * (y[0] - third), double=[tenth]), (1, third))
    with pytest.raises(NotProved, match="undecided"):
        one.zeros(lambda y: touching(y) * (y[0] - third) * (y[0] - third), double=[tenth])


# ---- the start of a motion ----------------------------------------------------------------------


@control
def orders_at_the_start(trusted: Any) -> None:
    """Exact coefficients stand beside balls, some of which contain zero by their radius alone."""
    start, models = trusted.problem, trusted.models
    nothing, root = start.Formal.of(0), start.FormalFunctions().sqrt(fmpq(2))
    wide = arb(0, 1)

    def onset(formal: Sequence[Any], balls: Sequence[Any]) -> Any:
        series = [models.PowerSeries(lambda c, n: arb(1), list(first)) for first in (formal, balls)]
        return start.Onset(lambda: series[0], lambda: series[1])

    def order(formal: Sequence[Any], balls: Sequence[Any]) -> int:
        found: int = onset(formal, balls).order(lambda motion: motion)
        return found

    assert order([nothing], [arb(3)]) == 0
    assert order([nothing, nothing], [wide, wide, arb(-2)]) == 2
    assert onset([nothing], [wide, arb(-2)]).sign(lambda motion: motion, 1) == -1
    assert onset([nothing], [wide, arb(2)]).sign(lambda motion: motion, 1) == 1
    for formal in (start.Formal.of(1), root, root - 1, root * root - 1):
        with pytest.raises(NotProved, match="order 1"):
            order([nothing, formal], [wide, wide, arb(1)])
    assert order([nothing, root * root - 2], [wide, wide, arb(1)]) == 2


# ---- whole motions ------------------------------------------------------------------------------


def moving(trusted: Any, *phases: Any, start: Sequence[Any], until: Any, **more: Any) -> Any:
    """Enclose a motion through phases of (ends, rates, function, other fields)."""
    problem = trusted.problem
    made = tuple(
        problem.ProblemPhase(ends, rates, lambda state: state, function, **fields)
        for ends, rates, function, fields in phases
    )
    onset = SimpleNamespace(order=more.pop("order", lambda _: 0), sign=lambda *_: 1)
    numbers = [arb(x) for x in start]
    events = more.pop("kinds", {})
    kinds = {name: Event(name, function, "", *way) for name, (function, *way) in events.items()}
    stated = problem.Problem(made, numbers, arb(until), onset, kinds, **more)
    return trusted.motion.enclose(stated, BITS, 30)


# height and velocity of a stone, which falls from the height 1 on a table in sqrt(2)
FALL: Any = ("landed", lambda y: [y[1], y[1] * 0 - 1], lambda y: y[0], {})
# the last phase of a motion that only goes on
ON: Any = ("landed", lambda y: [y[0] * 0 + 1], lambda y: y[0] * 0 + 1, {})


@control
def a_fall_ends_on_the_table(trusted: Any) -> None:
    samples = [arb(n) / 10 for n in range(21)]
    found = moving(trusted, FALL, start=[1, 0], until=2, samples=samples)
    assert found.end is not None
    holds([found.end.time, *found.end.state], [arb(2).sqrt(), 0, -arb(2).sqrt()])
    assert len(found.samples) == 15
    for t, (_, state) in zip(samples, found.samples, strict=False):
        holds(state, [1 - t * t / 2, -t])
    assert found.events["landed"] == [found.end]


@control
def a_horizon_before_the_end(trusted: Any) -> None:
    """Also where the function would rise again within the step."""
    assert moving(trusted, FALL, start=[1, 0], until=arb(2).sqrt() - arb(2) ** -40).end is None
    dip: Any = ("landed", ON[1], lambda y: (y[0] - arb("0.03")) * (y[0] - arb("0.04")), {})
    holds([moving(trusted, dip, start=[0], until=1).end.time], [arb("0.03")])


@control
def an_end_at_the_horizon_is_undecided(trusted: Any) -> None:
    with pytest.raises(NotProved, match="undecided"):
        moving(trusted, FALL, start=[1, 0], until=arb(2).sqrt())


@control
def a_sample_at_the_end_is_undecided(trusted: Any) -> None:
    with pytest.raises(NotProved, match="undecided"):
        moving(trusted, FALL, start=[1, 0], until=2, samples=[arb(2).sqrt()])


@control
def a_motion_that_is_over_is_refused(trusted: Any) -> None:
    for height in (0, -1, arb(0, 1)):
        with pytest.raises(NotProved, match="begin"):
            moving(trusted, FALL, start=[height, 0], until=1)


# a spring at its end, x = cos t, lets go where x falls to 0, at pi/2; then the stone flies on
SPRING: Any = ("separation", lambda y: [y[1], -y[0]], lambda y: y[0], {})
FLIGHT = ("landing", lambda y: [y[1], y[1] * 0], lambda y: y[0] + 1)


@control
def a_ball_that_falls_out_of_a_spring(trusted: Any) -> None:
    flight = (*FLIGHT, {"positive": False, "glides": False})
    low = lambda y: y[0] + arb(0.125)  # noqa: E731
    kinds, samples = {"low": (low,), "gliding": (low, 0, True)}, [arb(1), arb(1.75)]
    found = moving(trusted, SPRING, flight, start=[1, 0], until=2, samples=samples, kinds=kinds)
    (left,) = found.events["separation"]
    holds([left.time, *left.state], [arb.pi() / 2, 0, -1])
    holds(found.samples[0][1], [arb(1).cos(), -arb(1).sin()])
    holds(found.samples[1][1], [arb.pi() / 2 - arb(1.75), -1])
    holds(found.state(arb.pi() / 2 + TINY)[1], [-TINY, -1])
    holds([one.time for one in found.events["low"]], [low([arb.pi() / 2])])
    assert found.events["gliding"] == []


@control
def equations_that_end_otherwise_are_refused(trusted: Any) -> None:
    """In flight x (x + 1/4) falls to zero at x = -1/4: allowed where x is positive, so not here."""
    quarter = arb(1) / 4

    def again(y: Any) -> Any:
        return -y[0] * (y[0] + quarter)

    for allowed, positive in ((True, lambda y: y[0] * 0 + 1), (False, lambda y: y[0])):
        flight = (*FLIGHT, {"positive": False, "excluded": (again, positive)})
        if allowed:
            assert moving(trusted, SPRING, flight, start=[1, 0], until=2).end is None
            continue
        with pytest.raises(NotProved, match="otherwise"):
            moving(trusted, SPRING, flight, start=[1, 0], until=2)


@control
def a_step_is_made_again_from_the_same_states(trusted: Any) -> None:
    """x' = 1; x - 1/8 is undecided at the end of the first step, which is 1/8 long."""
    samples = [arb(n) / 100 for n in range(40)]
    kinds = {"crossing": (lambda y: y[0] - arb(1) / 8,)}
    found = moving(trusted, ON, start=[0], until=arb("0.4"), samples=samples, kinds=kinds)
    holds([state[0] for _, state in found.samples], samples)
    holds([one.time for one in found.events["crossing"]], [arb(1) / 8])
    assert len(found.steps) > 1


def _chebyshev(y: Any) -> Any:
    """The polynomial of degree 4 that goes to and fro between 1 and -1 while t < 1/8."""
    square = (16 * y[0] - 1) * (16 * y[0] - 1)
    return 8 * square * square - 8 * square + 1


@control
def a_bound_of_a_function(trusted: Any) -> None:
    """Functions until t = 0.4: (t - 1/3)^2, 1 - t, and a polynomial that goes to and fro."""
    found = moving(trusted, ON, start=[0], until=arb("0.4"))
    third = arb(1) / 3
    for function, least in (
        (lambda y: (y[0] - third) * (y[0] - third), 0), (lambda y: 1 - y[0], arb("0.6")),
        (_chebyshev, -1),
    ):  # fmt: skip
        bound = found.least(function)
        assert not bound > least
        assert bound > least - 2e-8
    with pytest.raises(NotProved):
        found.least(lambda y: y[0] * arb("nan"))


@control
def events_that_are_double_zeros(trusted: Any) -> None:
    """1 - cos t vanishes twice wherever sin t rises through zero."""
    rates = lambda y: [y[1], -y[0]]  # noqa: E731
    turning: Any = ("landed", rates, lambda y: y[0] * 0 + 1, {})
    double = lambda y: 1 - y[0]  # noqa: E731
    kinds = {"double": (double,), "falling": (lambda y: y[0], -1)}
    doubles = {"double": (lambda y: -y[1], 1)}
    order = lambda f: 2 if f is double else 1  # noqa: E731
    found = moving(
        trusted, turning, start=[1, 0], until=7, kinds=kinds, doubles=doubles, order=order
    )
    assert found.events["double"] == []
    holds([one.time for one in found.events["falling"]], [arb.pi() / 2])
