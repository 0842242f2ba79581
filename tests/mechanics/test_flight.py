"""Free flight against its equations of motion, its integrals and a plain integration."""

from typing import Any

import mpmath
import pytest

from tt_precise.mechanics import flight
from tt_precise.mechanics.newton import angular_momentum
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import RigidBodyState, cross, rotate, rotation

BODY = (1.7, 0.6, 0.3, 0.37, 0.41, 9.82, 0)


@pytest.fixture
def free(mp: Any) -> tuple[Parameters, RigidBodyState]:
    body = Parameters(*map(mp.mpf, BODY))
    q = [mp.mpf(x) for x in (0.1, 0.7, -0.5, 0.5)]
    size = mp.sqrt(sum(x * x for x in q))
    return body, RigidBodyState(*(x / size for x in q), *map(mp.mpf, (3, -4, 5, 0.1, 0.2, 2)))


def momentum(body: Parameters, state: RigidBodyState) -> Any:
    k = rotate(state[:4], (0, 0, 1))
    return angular_momentum(body, k, (state.wx, state.wy, state.wz))


def test_angular_momentum_and_spin_are_constant(free: Any, mp: Any) -> None:
    body, start = free
    for t in (mp.mpf("0.3"), mp.mpf(7)):
        state = flight.fly(body, start, t, mp)
        for one, other in zip(momentum(body, state), momentum(body, start), strict=True):
            assert abs(one - other) < mp.mpf("1e-55")
        assert abs(sum(x * x for x in state[:4]) - 1) < mp.mpf("1e-55")


def test_the_orientation_turns_with_omega(free: Any, mp: Any) -> None:
    """Each body vector e obeys e_dot = omega x e, by a difference of second order."""
    body, start = free
    t, h = mp.mpf("0.4"), mp.mpf("1e-20")
    here = flight.fly(body, start, t, mp)
    omega = (here.wx, here.wy, here.wz)
    for e in ((1, 0, 0), (0, 1, 0), (0, 0, 1)):
        turns = [flight.fly(body, start, time, mp)[:4] for time in (t + h, t, t - h)]
        ahead, now, behind = (rotate(turn, e) for turn in turns)
        for one, other, rate in zip(ahead, behind, cross(omega, now), strict=True):
            assert abs((one - other) / (2 * h) - rate) < mp.mpf("1e-35")


def test_height_and_speed_are_those_of_a_parabola(free: Any, mp: Any) -> None:
    body, start = free
    t = mp.mpf(2)
    assert flight.fly(body, start, t, mp).vcz == start.vcz - body.g * t
    assert flight.height(body, mp.mpf(3), start.vcz, t) == 3 + 2 * start.vcz - 2 * body.g
    assert rotation((0, 0, 0), t, mpmath) == (1, 0, 0, 0)
