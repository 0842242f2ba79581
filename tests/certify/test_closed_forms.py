"""A Monte Carlo of exact problems with closed-form solutions; zeros, and what stays zero."""

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
from tests.conftest import Patch
from tt_precise.certify import NotProved, Problem, balls, enclose, problem_of, zeros
from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.interval_newton import _Part
from tt_precise.certify.onset import Onset
from tt_precise.certify.prover_problem import exact_zeros, form_of
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState

BITS = 120
# A ball that is wide enough contains anything; one that still has half of the digits does not.
USEFUL = arb(2) ** (-BITS // 2)


def problem(
    rates: Callable[..., Any],
    start: Sequence[Any] | Callable[[], Sequence[arb]],
    until: Any,
    *parameters: Fraction,
) -> Problem:
    """``rates`` of the parameters and the entries of the state."""
    begin = start if callable(start) else lambda: list(start)
    return Problem(
        "closed form",
        tuple(f"y{i}" for i in range(len(begin()))),
        lambda given, state, fn: rates(*given, *state),
        lambda: list(map(ball, parameters)),
        begin,
        until if callable(until) else lambda: ball(Fraction(until)),
    )


def oscillator(frequency: Fraction | int, until: int) -> Problem:
    start = arb(1), arb(0)
    return problem(lambda w, x, v: (v, -w * w * x), start, until, Fraction(frequency))


def kepler(eccentricity: Fraction, until: Callable[[], arb]) -> Problem:
    """Planar Kepler motion from the pericentre; u = 1/r is carried along, so f is polynomial."""

    def rates(x: Any, y: Any, vx: Any, vy: Any, u: Any) -> Sequence[Any]:
        cube = u * u * u
        return vx, vy, -x * cube, -y * cube, -(x * vx + y * vy) * cube

    def start() -> Sequence[arb]:
        e = ball(eccentricity)
        return [1 - e, arb(0), arb(0), ((1 + e) / (1 - e)).sqrt(), 1 / (1 - e)]

    return problem(rates, start, until)


def enclosed(problem: Problem, bits: int = BITS) -> Any:
    """To the end."""
    enclosure = enclose(problem, bits)
    assert enclosure.failure is None
    return enclosure


@pytest.mark.parametrize("seed", seeds(4, 60))
def test_an_oscillator_is_contained(seed: int) -> None:
    dice = random.Random(seed)
    frequency = Fraction(dice.randint(1, 400), 100)
    enclosure = enclosed(oscillator(frequency, 20))
    with flint.ctx.workprec(2 * BITS):
        w = ball(frequency)
        for _ in range(20):
            time = ball(Fraction(dice.randint(0, 2000), 100))
            x, v = enclosure.at(time)
            assert x.overlaps((w * time).cos())
            assert v.overlaps(-w * (w * time).sin())
            assert x.rad() < 1e-30
        # negative control: one that is wrong in the 25th digit
        x, _ = enclosure.at(arb(20))
        assert not x.overlaps((w * (1 + ball(Fraction(1, 10**25))) * 20).cos())


@pytest.mark.parametrize("seed", seeds(3, 60))
def test_a_kepler_orbit_is_contained(seed: int) -> None:
    dice = random.Random(seed)
    eccentricity = Fraction(dice.randint(0, 60), 100)
    anomaly = Fraction(dice.randint(100, 1000), 100)

    def when(angle: Fraction) -> arb:
        return ball(angle) - ball(eccentricity) * ball(angle).sin()

    enclosure = enclosed(kepler(eccentricity, lambda: when(anomaly)))
    with flint.ctx.workprec(2 * BITS):
        for part in range(11):
            angle = anomaly * part / 10
            x, y, *_ = enclosure.at(when(angle))
            assert x.overlaps(ball(angle).cos() - ball(eccentricity))
            assert y.overlaps((1 - ball(eccentricity) ** 2).sqrt() * ball(angle).sin())
            assert x.rad() < USEFUL


@pytest.mark.parametrize("seed", seeds(2, 40))
def test_a_steady_precession_is_contained(seed: int) -> None:
    """A top without friction is tilted at a constant angle and goes round: k and L turn about z.

    L' = phi_dot z x L is the moment of the weight's reaction, R alpha m g k x z, if
    phi_dot (I3 omega_3 - I1 phi_dot cos theta) = -R alpha m g.
    """
    dice = random.Random(seed)
    scene = tt.load_scene("frictionless")
    heavy = replace(scene.body, alpha=Fraction(dice.randint(5, 60), 100))
    problem = problem_of(replace(scene, body=heavy))
    theta = Fraction(dice.randint(20, 280), 100)
    turning = Fraction(dice.choice((-1, 1)) * dice.randint(50, 300), 100)

    def start() -> list[arb]:
        body = form_of(scene).body(problem.parameters())
        sine, cosine, rate = ball(theta).sin(), ball(theta).cos(), ball(turning)
        spin = (body.I1 * rate * cosine - body.alpha / rate) / body.I3
        euler = EulerState(None, arb(0), rate, spin, arb(0), arb(0))
        still = vectors_from_euler(body, euler, Balls, sine_cosine=(sine, cosine))
        # the centre of mass rests
        return [*still[:6], arb(0), arb(0)]

    enclosure = enclosed(replace(problem, start=start, until=lambda: arb(3)))
    with flint.ctx.workprec(2 * BITS):
        kx, ky, kz, Lx, Ly, Lz, *rest = start()
        for part in range(7):
            angle = ball(turning) * part / 2
            c, s = angle.cos(), angle.sin()
            exact = [c * kx - s * ky, s * kx + c * ky, kz, c * Lx - s * Ly, s * Lx + c * Ly, Lz]
            found = enclosure.at(arb(part) / 2)
            assert all(a.overlaps(b) for a, b in zip(found, exact + rest, strict=True))
            assert max(a.rad() for a in found) < USEFUL


def test_without_outward_rounding_nothing_is_proved(monkeypatch: Patch) -> None:
    monkeypatch.setattr(balls, "ball", lambda value: ball(value).mid())
    with pytest.raises(NotProved, match="excludes the result"):
        enclose(oscillator(2, 1), BITS)


def test_zeros_of_an_oscillator() -> None:
    steps = enclosed(oscillator(2, 10)).steps
    found = list(zeros(steps, lambda state: state[0]))
    with flint.ctx.workprec(2 * BITS):
        inside = [zero for zero in found if zero.time < 10]
        assert len(inside) == 6
        for k, zero in enumerate(inside):
            assert zero.time.overlaps((2 * k + 1) * arb.pi() / 4)
            assert zero.time.rad() < 1e-30
            assert zero.direction == (-1) ** (k + 1)
    backwards = next(zeros(reversed(steps), lambda state: state[0]))
    assert backwards.time.overlaps(found[-1].time)
    # a zero at the start is passed over
    begun = zeros(steps, lambda state: state[1], begins=Onset(1, -1))
    assert next(begun).time.overlaps(arb.pi() / 2)
    # x - 1 and its derivative vanish at each period; no arithmetic with errors can show that
    with pytest.raises(NotProved, match="undecided"):
        list(zeros(steps, lambda state: state[0] - 1))
    with flint.ctx.workprec(BITS):
        known = [arb.pi() * k for k in (1, 2, 3)]
        begun = zeros(steps, lambda y: y[0] - 1, begins=Onset(2, -1), touches=known)
        assert [zero for zero in begun if zero.time < 10] == []


def test_zeros_of_a_component_that_is_tiny_beside_another() -> None:
    # two oscillators that share a tube, one 1e-25 of the other: the coarse models cannot show it
    # where the small one vanishes, the sharp ones can
    start = [arb(1), arb(0), arb("1e-25").mid(), arb(0)]
    enclosure = enclosed(problem(lambda x, v, y, w: (v, -x, w, -y), start, 6), 200)
    found = [zero for zero in zeros(enclosure.steps, lambda state: state[2]) if zero.time < 6]
    assert len(found) == 2
    with flint.ctx.workprec(400):
        for k, zero in enumerate(found):
            assert zero.time.overlaps((2 * k + 1) * arb.pi() / 2)
            assert zero.time.rad() < 1e-20
            # the coarse ones alone
            step = next(s for s in enclosure.steps if not zero.time > s.finish)
            assert step.tube[2].polynomial(step.piece.end).contains(0)


def test_a_step_in_which_the_end_is_undecided_is_not_delivered() -> None:
    asked: list[Any] = []

    def ends(step: Any) -> bool:
        asked.append(step)
        if len(asked) == 3:
            raise NotProved("contact", "as if")
        return False

    enclosure = enclose(oscillator(2, 20), BITS, ends=ends)
    assert enclosure.failure is not None
    assert len(enclosure.steps) == 2
    with pytest.raises(NotProved, match="proof ends"):
        enclosure.at(asked[2].finish)


def test_a_wide_ball_of_time_is_enclosed_throughout_and_beyond_the_proof_nothing() -> None:
    enclosure = enclosed(oscillator(2, 20))
    with flint.ctx.workprec(BITS):
        x, _ = enclosure.at(arb(10, 8))
        assert len(enclosure.steps) > 6
        assert x.contains(1)
        assert x.contains(-1)
    with pytest.raises(NotProved, match="ends at"):
        enclosure.at(enclosure.finish + 1)


def test_a_solution_that_blows_up_is_enclosed_until_shortly_before() -> None:
    # y' = y^2 with a division, as in g_n: y = 1/(1 - t) has no value at t = 1
    enclosure = enclose(problem(lambda z: (1 / (1 / (z * z)),), [arb(1)], 2), BITS)
    assert enclosure.failure is not None
    with flint.ctx.workprec(BITS):
        assert enclosure.finish > 0.99
        assert enclosure.finish < 1
        (value,) = enclosure.at(arb(0.75))
        assert value.contains(4)
        assert value.rad() < 1e-25


def test_strong_damping_does_not_widen_the_enclosure() -> None:
    # x'' = -60 x' - 500 x: the norm of the equations says exp(60 t), the damping takes it away
    start = [arb(1), arb(-10)]
    enclosure = enclosed(problem(lambda x, v: (v, -60 * v - 500 * x), start, 5))
    with flint.ctx.workprec(2 * BITS):
        for time in (arb(1), arb(3), arb(5)):
            x, _ = enclosure.at(time)
            assert x.overlaps((-10 * time).exp())
            assert x.rad() < 1e-30


def names(problem: Problem) -> set[str]:
    return {problem.columns[i] for i in exact_zeros(problem)}


def test_what_stays_zero_in_the_scenes() -> None:
    still = {"kx", "ky", "Lx", "Ly", "s_dot_x", "s_dot_y"}
    assert names(problem_of(tt.load_scene("upright"))) == still
    assert names(problem_of(tt.load_scene("reference"))) == set()
    rocking = tt.load_scene("rocking")
    assert names(problem_of(rocking)) == {"ky", "Lx", "Lz", "s_dot_y"}
    # a spin however small leaves the plane; zero at the start is not enough
    assert names(problem_of(rocking.varied(omega_3="1e-60"))) == set()
    by_chance = problem(lambda x, y: (1 + 0 * x, x - 1 + y), [arb(1), arb(0)], 1)
    assert names(by_chance) == set()


@pytest.mark.parametrize(
    ("value", "sign"), [(arb(1, "0.9"), 1), (arb(-1, "0.9"), -1), (arb(0, 1), 0)]
)
def test_a_sign_is_told_or_when_it_is_undecided(value: arb, sign: int) -> None:
    # at 1 in the piece's unit of 1/4, of a step from 2 on
    step = SimpleNamespace(begin=arb(2), piece=SimpleNamespace(unit=arb(1) / 4))
    part: Any = SimpleNamespace(_sharp=lambda _: value, step=step)
    if sign:
        assert _Part._sign(part, arb(1)) == sign
    else:
        with pytest.raises(NotProved, match=r"the sign at t = 2\.25 is undecided"):
            _Part._sign(part, arb(1))
