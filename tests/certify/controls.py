"""Closed forms that a program without one of the theorem's hypotheses would exclude.

Each control takes the trusted modules and fails where they claim something false. Polynomials are
coarse, so that errors are far above rounding: ``at(s)`` has to contain every solution from the
set of starts throughout a piece, ``last()`` at its end.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
from flint import arb, arb_mat, arb_poly

import tt_precise as tt
from tests.certify.harness import Refused, enclosing
from tt_precise.certify.balls import Balls, ball
from tt_precise.integration.equations import Layout
from tt_precise.mechanics import formulations
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState

TINY = arb(2) ** -80
CONTROLS: dict[str, Callable[[Any], None]] = {}


def control(check: Callable[[Any], None]) -> Callable[[Any], None]:
    CONTROLS[check.__name__] = check
    return check


def holds(balls: Sequence[arb], exact: Sequence[Any]) -> None:
    pairs = list(zip(balls, exact, strict=True))
    assert all(one.is_finite() and one.overlaps(arb(other)) for one, other in pairs), pairs


def everywhere(one: Any, *exact: Sequence[Any]) -> None:
    """Solutions at the end of a piece: by the bound within it, and by the set that goes on."""
    for state in exact:
        holds(one.at(one.length), state)
        holds(one.last(), state)


def exponential(trusted: Any, start: arb, order: int = 30, rate: int = 1) -> Any:
    return enclosing(trusted, lambda y: [y[0] * rate], [start], order)


# ---- S1 to S4, the end of a piece, the gap to the next ------------------------------------------


@control
def s1_a_coarse_exponential(trusted: Any) -> None:
    """x' = x with four terms: the error of the polynomial is all that there is."""
    one, s = exponential(trusted, arb(1), order=3), arb(2) ** -18
    one.on(s)
    everywhere(one, [s.exp()])
    holds(one.at(s / 2), [(s / 2).exp()])


@control
def s1_errors_of_pieces_add_up(trusted: Any) -> None:
    """The defect at a piece's end, d G: after many pieces all errors are in the set."""
    one, s = exponential(trusted, arb(1), order=3), arb(2) ** -19
    for n in range(1, 41):
        one.on(s)
        everywhere(one, [(s * n).exp()])


@control
def s2_a_ball_of_starts_grows(trusted: Any) -> None:
    """|e0| exp(a S): solutions through both ends of the starts; and no wider than it has to be."""
    one, half = exponential(trusted, arb(1, TINY)), arb(0.5)
    one.on(half)
    everywhere(one, *([end * half.exp()] for end in (1 - TINY, 1 + TINY)))
    assert one.last()[0].rad() < TINY * half.exp() * 1.01


@control
def s2_coupling_counts(trusted: Any) -> None:
    """x' = 20 y, y' = 0: the diagonal of the derivative is zero."""
    one = enclosing(trusted, lambda y: [y[1] * 20, y[1] * 0], [arb(1), arb(1, TINY)], 5)
    one.on(arb(1) / 4)
    everywhere(one, *([1 + 5 * y, y] for y in (1 - TINY, 1 + TINY)))


@control
def s2_the_derivative_belongs_to_the_tube(trusted: Any) -> None:
    """x' = 2^72 x^2: on the polynomial, which is 0, the derivative vanishes; near it, it is 2."""
    steep, x = arb(2) ** 72, arb(2) ** -73
    one = enclosing(trusted, lambda y: [y[0] * y[0] * steep], [arb(0, x)], 5)
    one.on(arb(1) / 8)
    holds(one.at(one.length), [x / (1 - steep * x / 8)])


@control
def s2_a_derivative_that_grows_in_a_piece(trusted: Any) -> None:
    """x' = x^2 from 1: errors grow as 1/(1 - t)^2."""
    one, s = enclosing(trusted, lambda y: [y[0] * y[0]], [arb(1, TINY)], 110), arb(1) / 4
    one.on(s)
    everywhere(one, *([x / (1 - x * s)] for x in (1 - TINY, 1 + TINY)))


@control
def s3_the_flow_turns_a_flat_set(trusted: Any) -> None:
    """A rotation; uncertain in x alone, a quarter of a turn later in v alone."""
    one = enclosing(trusted, lambda y: [y[1], -y[0]], [arb(1, TINY), arb(0)], 40)
    while one.finish < 6:
        one.on(arb(0.5))
        t = one.finish
        everywhere(one, *([x * t.cos(), -x * t.sin()] for x in (1 - TINY, 1 + TINY)))
    assert max(x.rad() for x in one.last()) < 1.05 * TINY


@control
def s3_the_flow_has_an_error(trusted: Any) -> None:
    """A start 2^-75 from the polynomial's is known to 60 digits, P to 12: q is what remains."""
    one = exponential(trusted, arb(1))
    one.on(arb(0.5), shift=arb(2) ** -75)
    holds(one.last(), [arb(0.5).exp()])
    assert one.last()[0].rad() < arb(2) ** -75 * 1e-9


@control
def s4_a_blow_up_is_refused(trusted: Any) -> None:
    """x' = x^2 from [-0.9, 0.9]: the solution through 0.9 ends at t = 1.11."""
    for radius in (arb(0.9), arb(2) ** -60):
        one = enclosing(trusted, lambda y: [y[0] * y[0]], [arb(0, radius)], 10)
        with pytest.raises(Refused, match="S4"):
            one.on(arb(1))


@control
def s4_a_defect_that_leaves_the_tube_is_refused(trusted: Any) -> None:
    one = enclosing(trusted, lambda y: [y[0] * y[0]], [arb(1)], 6)
    with pytest.raises(Refused, match="S4"):
        one.on(arb(0.5))
    # with finer pieces it is enclosed: 1/(1 - t)
    one = enclosing(trusted, lambda y: [y[0] * y[0]], [arb(1)], 40)
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
def units_of_time(trusted: Any) -> None:
    """x' = x in pieces of units 1/8 and 4."""
    for power, s in ((-3, arb(0.5)), (2, arb(1) / 16)):
        one = exponential(trusted, arb(1, TINY))
        one.on(s, power=power)
        everywhere(one, *([x * (s * arb(2) ** power).exp()] for x in (1 - TINY, 1 + TINY)))


# ---- components that stay zero ------------------------------------------------------------------


@control
def a_component_that_stays_zero_is_exact(trusted: Any) -> None:
    """x' = x^2 y from x = 0; no other start is accepted for it."""
    one = enclosing(trusted, lambda y: [y[0] * y[0] * y[1], y[1]], [arb(0), arb(1)], 30)
    assert one.free == [1]
    one.on(arb(0.5))
    assert one.at(arb(0.5))[0].is_zero()
    with pytest.raises(Refused):
        one.advance(0, arb(0.5), [arb(2) ** -90, one.end[1].mid()])


@control
def that_a_component_stays_zero_is_verified(trusted: Any) -> None:
    """x' = y from x = 0 and y = 1, as if x were to stay zero."""
    one = enclosing(trusted, lambda y: [y[1], y[1] * 0], [arb(0), arb(1)], 5)
    assert one.free == [0, 1]
    one.free, one.box, one.basis = [1], arb_mat(1, 1, [arb(0)]), arb_mat([[1]])
    with pytest.raises(Refused, match="stay zero"):
        one.on(arb(1) / 4)


# ---- the scenes' own equations ------------------------------------------------------------------


@control
def a_steady_precession(trusted: Any) -> None:
    """A top without friction that keeps its tilt: k and L turn about the vertical, exactly."""
    for seed in range(2):
        one, exact = _precession(trusted, random.Random(seed))
        for n in range(1, 21):
            one.on(arb(2) ** -7, shift=arb(2) ** -78 if n == 1 else 0)
            everywhere(one, exact(one.finish))
        assert max(x.rad() for x in one.last()) < 1e-21


def _precession(trusted: Any, dice: random.Random) -> tuple[Any, Callable[[arb], list[arb]]]:
    theta, alpha = Fraction(dice.randint(20, 280), 100), Fraction(dice.randint(5, 60), 100)
    rate = ball(Fraction(dice.choice((-1, 1)) * dice.randint(50, 300), 100))
    scene = tt.load_scene("frictionless")
    scene = replace(scene, body=replace(scene.body, alpha=alpha))
    form = formulations.integrated("gliding", "newton", scene.body.friction)
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

    return enclosing(trusted, rates, [kx, ky, kz, Lx, Ly, Lz, *rest], 12), exact


# ---- the models of functions --------------------------------------------------------------------


@control
def models_contain_what_they_cut_off(trusted: Any) -> None:
    """Products, quotients and roots of models of degree 3, at instants of the interval."""
    arithmetic = trusted.checker_arithmetic
    for seed in range(4):
        dice, frame = random.Random(seed), arithmetic.Frame(arb(1), 3)
        a, b = (
            arb_poly([3] + [dice.randint(-40, 40) / arb(64) for _ in range(3)]) for _ in range(2)
        )
        f, g = (arithmetic.TaylorModel(p, frame) for p in (a, b))
        for k in range(9):
            s = arb(k) / 8
            for model, exact in (
                (f * g, a(s) * b(s)), (f / g, a(s) / b(s)), (f.sqrt(), a(s).sqrt()),
            ):  # fmt: skip
                assert model.p.degree() <= 3
                assert model.p(s).overlaps(exact)


@control
def what_is_no_number_is_refused(trusted: Any) -> None:
    """A product of nothing with NaN is nothing in FLINT, so that inverses and roots must raise."""
    arithmetic = trusted.checker_arithmetic
    assert (arb_poly([]) * arb("nan")).length() == 0
    frame = arithmetic.Frame(arb(1), 3)
    for bad in ([], [arb("nan")], [arb(0, 1)], [arb(-1), arb(2)], [arb("nan"), 1]):
        for operation in (lambda x: x.inverse(), lambda x: x.sqrt(), lambda x: 1 / x):
            with pytest.raises((Refused, ZeroDivisionError, ValueError)):
                operation(arithmetic.TaylorModel(arb_poly(bad), frame))


@control
def bounds_are_finite(trusted: Any) -> None:
    """The largest of numbers, NaN among them: comparisons with it are false."""
    assert trusted.checker._top([arb(1), arb(2)]) == 2
    for numbers in ([arb(1), arb("nan")], [arb("nan"), arb(1)], [arb("inf")]):
        with pytest.raises(Refused, match="not finite"):
            trusted.checker._top(numbers)


# ---- zeros --------------------------------------------------------------------------------------


def line(trusted: Any, start: Any = 0, order: int = 5) -> Any:
    """x' = 1."""
    return enclosing(trusted, lambda y: [y[0] * 0 + 1], [arb(start)], order)


def found(zeros: Sequence[tuple[int, arb]], *expected: tuple[int, Any]) -> None:
    assert [way for way, _ in zeros] == [way for way, _ in expected]
    holds([time for _, time in zeros], [time for _, time in expected])


@control
def zeros_have_times_and_directions(trusted: Any) -> None:
    """Of (t - 0.1) (t - 0.3) (t - 0.4) in one piece; of an exponential; of a constant."""
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
        (lambda y: y[0] - third, third),
        (lambda y: (y[0] - third) * (y[0] - third), None),
    ):
        with pytest.raises(Refused, match="undecided"):
            one.zeros(function, until)
    found(one.zeros(lambda y: y[0] - third, arb("0.4")), (1, third))
    assert one.zeros(lambda y: y[0] - third, arb("0.3")) == []


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
    one.vanishing = 1
    with pytest.raises(Refused, match="undecided"):
        one.zeros(lambda y: y[0] * y[0])


@control
def zeros_that_are_double(trusted: Any) -> None:
    """A known double zero is none; one of which nothing is known is refused; others are found."""
    one, tenth, third = line(trusted), arb(1) / 10, arb(1) / 3
    one.on(arb(0.5))

    def touching(y: Any) -> Any:
        return (y[0] - tenth) * (y[0] - tenth)

    assert one.zeros(touching, touches=[tenth]) == []
    found(one.zeros(lambda y: touching(y) * (y[0] - third), touches=[tenth]), (1, third))
    with pytest.raises(Refused, match="undecided"):
        one.zeros(lambda y: touching(y) * (y[0] - third) * (y[0] - third), touches=[tenth])
