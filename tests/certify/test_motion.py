"""Motions with a closed form, enclosed to their ends; what stays zero; tiny components."""

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import flint
import pytest
from flint import arb

import tt_precise as tt
from tests.certify.conftest import seeds
from tests.certify.harness import Mutant
from tests.certify.mutants import assert_noticed, mutants_of
from tt_precise.certify import Enclosure, NotProved, Problem, enclose, problem_of
from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.motion import _Interval
from tt_precise.certify.problem import EventKind, ProblemPhase
from tt_precise.mechanics.euler import EulerState, vectors_from_euler

BITS = 120
# A ball that is wide enough contains anything; one that still has half of the digits does not.
USEFUL = arb(2) ** (-BITS // 2)


@pytest.fixture(autouse=True)
def precision() -> Any:
    with flint.ctx.workprec(2 * BITS):
        yield


def problem(
    rates: Callable[..., Sequence[Any]], start: Sequence[Any], until: Any, **kinds: EventKind
) -> Problem:
    """A motion that only goes on: ``rates`` of the components of the state."""
    phase = ProblemPhase("landed", lambda y: rates(*y), lambda state: state, lambda y: y[0] * 0 + 1)
    onset = SimpleNamespace(order=lambda function: 1)
    return Problem((phase,), [arb(x) for x in start], arb(until), onset, kinds)


def oscillator(frequency: Any, until: Any, **kinds: EventKind) -> Problem:
    w = frequency
    return problem(lambda x, v: (v, -w * w * x), [1, 0], until, **kinds)


def at(enclosure: Enclosure, time: arb) -> list[arb]:
    return enclosure.state(time)[1]


@pytest.mark.parametrize("seed", seeds(2, 40))
def test_a_steady_precession_is_contained(seed: int) -> None:
    """A top without friction is tilted at a constant angle and goes round: k and L turn about z.

    L' = phi_dot z x L is the moment of the weight's reaction, R alpha m g k x z, if
    phi_dot (I3 omega_3 - I1 phi_dot cos theta) = -R alpha m g.
    """
    dice = random.Random(seed)
    scene = tt.load_scene("frictionless")
    heavy = replace(scene.body, alpha=Fraction(dice.randint(5, 60), 100))
    found = problem_of(replace(scene, body=heavy))
    theta = Fraction(dice.randint(20, 280), 100)
    rate = ball(Fraction(dice.choice((-1, 1)) * dice.randint(50, 300), 100))
    body = heavy.dimensionless(Balls, ball)
    sine, cosine = ball(theta).sin(), ball(theta).cos()
    spin = (body.I1 * rate * cosine - body.alpha / rate) / body.I3
    euler = EulerState(None, arb(0), rate, spin, arb(0), arb(0))
    # the centre of mass rests
    still = vectors_from_euler(body, euler, Balls, sine_cosine=(sine, cosine))[:6]
    start = [*still, arb(0), arb(0)]
    enclosure = enclose(replace(found, start=start, until=arb(3), kinds={}, samples=()), BITS, 40)
    kx, ky, kz, Lx, Ly, Lz, *rest = start
    for part in range(7):
        angle = rate * part / 2
        c, s = angle.cos(), angle.sin()
        exact = [c * kx - s * ky, s * kx + c * ky, kz, c * Lx - s * Ly, s * Lx + c * Ly, Lz]
        state = at(enclosure, arb(part) / 2)
        assert all(a.overlaps(b) for a, b in zip(state, exact + rest, strict=True))
        assert max(a.rad() for a in state) < USEFUL


def test_zeros_of_an_oscillator() -> None:
    kinds = {"x": EventKind(lambda y: y[0]), "rising": EventKind(lambda y: y[1], 1)}
    found = enclose(oscillator(2, 10, **kinds), BITS, 40)
    assert len(found.events["x"]) == 6
    for k, zero in enumerate(found.events["x"]):
        assert zero.time.overlaps((2 * k + 1) * arb.pi() / 4)
        assert zero.time.rad() < 1e-30
        assert zero.direction == (-1) ** (k + 1)
    # a zero at the start is passed over, and so are those in the other direction
    assert found.events["rising"][0].time.overlaps(arb.pi() / 2)
    assert {zero.direction for zero in found.events["rising"]} == {1}
    # x - 1 and its derivative vanish at each period; no arithmetic with errors can show that
    with pytest.raises(NotProved, match="undecided"):
        enclose(oscillator(2, 4, touching=EventKind(lambda y: y[0] - 1)), BITS, 40)


def test_a_bound_is_sought_where_it_is_lowest_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """1,315 halvings in 25 steps; last in, first out, the search takes more than 200,000."""
    enclosure, halved = enclose(oscillator(2, 20), BITS, 40), []
    halves = _Interval.halves

    def counted(part: _Interval) -> Any:
        halved.append(part)
        return halves.fget(part)  # type: ignore[attr-defined]

    monkeypatch.setattr(_Interval, "halves", property(counted))
    assert abs(enclosure.least(lambda y: 2 + y[0] + y[1] * y[1] / 100) - 1) < 0.01
    assert len(halved) < 100 * len(enclosure.steps)


def test_zeros_of_a_component_that_is_tiny_beside_another() -> None:
    # two oscillators that share a tube, one 1e-25 of the other: the coarse models cannot show it
    # where the small one vanishes, the sharp ones can
    start = [arb(1), arb(0), arb("1e-25").mid(), arb(0)]
    small = EventKind(lambda y: y[2])
    found = enclose(problem(lambda x, v, y, w: (v, -x, w, -y), start, 6, small=small), 200, 60)
    zeros = found.events["small"]
    assert len(zeros) == 2
    for k, zero in enumerate(zeros):
        assert zero.time.overlaps((2 * k + 1) * arb.pi() / 2)
        assert zero.time.rad() < 1e-20
        # the coarse ones alone
        step = next(s.step for s in found.steps if not zero.time > s.step.finish)
        assert step.tube[2].p(step.length).contains(0)


def thrown(above: Callable[[Any], Any]) -> Problem:
    """A mass on a damped table, y'' = -(y + y'/2), that lets it go; then y'' = -1/4 until y = 0.

    The table would pull again where y + y'/2 falls to zero, while the mass is still ``above`` it.
    """

    def pull(y: Any) -> Any:
        return y[0] + y[1] / 2

    def state(y: Any) -> Any:
        return y

    table = ProblemPhase("separation", lambda y: (y[1], -pull(y)), state, lambda y: -pull(y))
    free = ProblemPhase(
        "landing", lambda y: (y[1], y[0] * 0 - arb(1) / 4), state, lambda y: y[0],
        positive=False, excluded=(pull, above),
    )  # fmt: skip
    onset = SimpleNamespace(order=lambda function: 0)
    return Problem((table, free), [arb(-1), arb(0)], arb(7), onset)


def test_phases_follow_each_other_by_turns() -> None:
    found = enclose(thrown(lambda y: y[0]), BITS, 40)
    root = arb(15).sqrt()
    gone = 4 * root.atan() / root
    speed = (-gone / 4).exp()  # at the separation; the height is minus half of it
    back = gone + 4 * (speed + (speed * speed - speed / 4).sqrt())
    for name, time in (("separation", gone), ("landing", back)):
        (event,) = found.events[name]
        assert event.time.overlaps(time)
        assert event.time.rad() < 1e-25
    assert found.end is None
    assert [one.phase.ends for one in found.steps][:: len(found.steps) - 1] == ["separation"] * 2


def test_a_table_that_would_push_below_itself_is_not_enclosed() -> None:
    with pytest.raises(NotProved, match="may end otherwise"):
        enclose(thrown(lambda y: -y[0]), BITS, 40)


def test_a_solution_that_blows_up_is_not_enclosed() -> None:
    # y' = y^2 with a division, as in g_n: y = 1/(1 - t) has no value at t = 1
    def rates(y: Any) -> Sequence[Any]:
        return (1 / (1 / (y * y)),)

    with pytest.raises(NotProved):
        enclose(problem(rates, [1], 2), BITS, 40)
    (value,) = at(enclose(problem(rates, [1], 0.75), BITS, 40), arb(0.75))
    assert value.contains(4)
    assert value.rad() < 1e-25


def test_strong_damping_does_not_widen_the_enclosure() -> None:
    # x'' = -60 x' - 500 x: the norm of the equations says exp(60 t), the damping takes it away
    enclosure = enclose(problem(lambda x, v: (v, -60 * v - 500 * x), [1, -10], 5), BITS + 16, 40)
    for time in (arb(1), arb(3), arb(5)):
        x, _ = at(enclosure, time)
        assert x.overlaps((-10 * time).exp())
        assert x.rad() < 1e-30


@mutants_of("motion")
def test_a_dropped_hypothesis_is_noticed(mutant: Mutant) -> None:
    assert_noticed(mutant)
