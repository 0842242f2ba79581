"""Between Euler angles, vectors and rigid bodies: there and back, beside the poles too."""

import math
import random
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from tt_precise.mechanics import newton
from tt_precise.mechanics.conversion import RigidBodyState, vectors_from_rigid_body
from tt_precise.mechanics.euler import EulerState, euler_from_vectors, vectors_from_euler
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.vectors import cross, horizontal_length
from tt_precise.scene.body import TippeTop

EPS = float(np.finfo(float).eps)
TILTS = ["1", "1e-3", "1e-8", "1e-30", "1e-150"]


def drawn_state(seed: int, theta: float) -> EulerState:
    source = random.Random(seed)
    return EulerState(theta, *(source.uniform(-100, 100) for _ in range(5)))


def back(body: Parameters, state: EulerState, phi: float) -> EulerState:
    return euler_from_vectors(body, vectors_from_euler(body, state, np, phi), np)


@pytest.mark.parametrize("phi", [0.0, 2.2, -0.4])
@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("seed", range(3))
def test_there_and_back_in_double(body: TippeTop, seed: int, tilt: str, phi: float) -> None:
    numbers = body.numbers(float)
    state = drawn_state(seed, float(tilt))
    found = back(numbers, state, phi)
    rate = abs(state.theta_dot) + abs(state.phi_dot) + 2 * abs(state.omega_3)
    glide = math.hypot(state.nu_x, state.nu_y)
    # The small L.x-hat is found among components of size I1 theta_dot, then divided by sin theta.
    # The obvious (Lz - cos theta L.k)/(I1 sin^2 theta) cancels twice.
    scales = (state.theta, rate, rate / math.sin(state.theta), rate, glide, glide)
    bound_eps = 16  # about 8 roundings of size eps each, margin 2
    for one, other, scale in zip(found, state, scales, strict=True):
        assert abs(one - other) <= bound_eps * EPS * scale


@pytest.mark.parametrize("tilt", ["0.1", "1e-8", "1e-30"])
def test_beside_the_inverted_pole_the_sine_is_given(
    numbers: Parameters, tilt: str, mp: Any
) -> None:
    """theta = pi - tilt rounds; with its sine given, the rates keep their digits (at azimuth 0)."""
    offset = mp.mpf(tilt)
    state = EulerState(mp.pi - offset, *map(mp.mpf, (3, -5, 7, 2, -4)))
    known = (mp.sin(offset), -mp.cos(offset))
    vectors = vectors_from_euler(numbers, state, mp, sine_cosine=known)
    assert abs(horizontal_length(mp, vectors.kx, vectors.ky) / known[0] - 1) < 4 * mp.eps
    found = euler_from_vectors(numbers, vectors, mp)
    for one, other in zip(found, state, strict=True):
        assert abs(one - other) <= 200 * mp.eps  # 8 roundings of numbers up to 15
    # Rounding theta leaves a relative error eps/tilt in its sine.
    naive = vectors_from_euler(numbers, state, mp)
    if offset < mp.mpf("1e-20"):
        assert abs(horizontal_length(mp, naive.kx, naive.ky) / known[0] - 1) > 1e3 * mp.eps


def test_the_axis_is_tilted_towards_x_hat(body: TippeTop) -> None:
    numbers = body.numbers(float)
    vectors = vectors_from_euler(numbers, EulerState(0.5, 0.0, 0.0, 0.0, 3.0, 0.0), math, 0.7)
    assert math.atan2(vectors.ky, vectors.kx) == pytest.approx(0.7, abs=4 * EPS)
    assert math.atan2(vectors.vy, vectors.vx) == pytest.approx(0.7, abs=4 * EPS)
    assert vectors.kz == pytest.approx(math.cos(0.5), abs=2 * EPS)


def test_rates_mean_what_their_names_say(numbers: Parameters, mp: Any) -> None:
    """omega of the paper, -phi_dot sin theta 1 + theta_dot 2 + omega_3 3, moves the axis so."""
    theta, phi = mp.mpf("0.9"), mp.mpf("0.3")
    state = EulerState(theta, *map(mp.mpf, (2, -3, 5, 0, 0)))

    def axis(t: Any) -> Any:
        tilt, turn = theta + 2 * t, phi - 3 * t
        return (mp.sin(tilt) * mp.cos(turn), mp.sin(tilt) * mp.sin(turn), mp.cos(tilt))

    h = mp.mpf(10) ** -20
    vectors = vectors_from_euler(numbers, state, mp, phi)
    k_dot = newton.axis_rate(numbers, vectors)
    for ahead, behind, rate in zip(axis(h), axis(-h), k_dot, strict=True):
        assert abs((ahead - behind) / (2 * h) - rate) < mp.mpf(10) ** -38


def test_without_hypot_a_square_root_serves() -> None:
    class Plain:
        sqrt = staticmethod(mpmath.sqrt)

    assert horizontal_length(Plain, 3, 4) == 5
    assert horizontal_length(np, 3e-200, 4e-200) == pytest.approx(5e-200, rel=2 * EPS, abs=0)


def test_poles_have_no_euler_angles(numbers: Parameters, mp: Any) -> None:
    vectors = vectors_from_euler(numbers, EulerState(*map(mp.mpf, (0, 0, 0, 5, 1, 0))), mp)
    assert (vectors.kx, vectors.ky, vectors.kz) == (0, 0, 1)
    with pytest.raises(ZeroDivisionError):
        euler_from_vectors(numbers, vectors, mp)


def quaternion(seed: int) -> tuple[Fraction, ...]:
    source = random.Random(seed)
    return tuple(Fraction(source.randint(-9, 9), source.randint(1, 9)) for _ in range(4))


@pytest.mark.parametrize("seed", range(6))
def test_rigid_bodies_exactly(body: TippeTop, seed: int) -> None:
    """The third column of the rotation matrix, L = I omega, and v_A = s_dot + omega x a."""
    q = quaternion(seed)
    w, x, y, z = q
    norm = sum(n * n for n in q)
    omega = (Fraction(2), Fraction(-3), Fraction(7, 2))
    k = (2 * (x * z + w * y) / norm, 2 * (y * z - w * x) / norm, 1 - 2 * (x * x + y * y) / norm)
    s_dot = tuple(-n for n in cross(omega, newton.contact_arm(body, k)))
    state = RigidBodyState(*(*q, *omega, *s_dot))
    vectors, sinking = vectors_from_rigid_body(body, state)
    assert vectors.k == k
    assert sum(n * n for n in vectors.k) == 1
    assert newton.angular_velocity(body, vectors) == omega
    assert (*vectors.v, sinking) == (0, 0, 0, 0)
    longer = state._replace(qw=3 * w, qx=3 * x, qy=3 * y, qz=3 * z)
    assert vectors_from_rigid_body(body, longer)[0] == vectors
    falling = vectors_from_rigid_body(body, state._replace(vcz=state.vcz - Fraction(1, 10**40)))
    assert falling[1] == -Fraction(1, 10**40)
