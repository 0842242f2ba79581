"""The paper's Euler-angle equations: exact answers; angles and vectors, there and back."""

import math
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from tt_precise.mechanics import newton, quantities
from tt_precise.mechanics.euler import EulerState, euler_from_vectors, vectors_from_euler
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import horizontal_length
from tt_precise.scene.body import TippeTop


class Pythagorean:
    """Sine 3/5 and cosine 4/5 of the only angle there is: Euler form in exact fractions."""

    THETA = Fraction(99)

    @staticmethod
    def sin(angle: Fraction) -> Fraction:
        assert angle == Pythagorean.THETA
        return Fraction(3, 5)

    @staticmethod
    def cos(angle: Fraction) -> Fraction:
        assert angle == Pythagorean.THETA
        return Fraction(4, 5)


def state(*rest: int) -> EulerState:
    return EulerState(Pythagorean.THETA, *map(Fraction, rest))


@pytest.mark.parametrize("alone", ["theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y"])
def test_energies_of_one_motion_alone(body: TippeTop, alone: str) -> None:
    """E~ of each rotation is I omega^2/2 + m (omega x a)^2/2; E_trans of gliding m nu^2/2."""
    s, c = Fraction(3, 5), Fraction(4, 5)
    moving = state(0, 0, 0, 0, 0)._replace(**{alone: Fraction(2)})
    u, shift = body.alpha - c, body.m * body.R**2 / 2 * 4
    contact_speed = {
        "theta_dot": u * u + s * s, "phi_dot": (s * u) ** 2, "omega_3": s * s, "nu_x": 0, "nu_y": 0,
    }[alone]  # fmt: skip
    inertia = {"theta_dot": body.I1, "phi_dot": body.I1 * s * s, "omega_3": body.I3}.get(alone, 0)
    resting = body.m * body.g * body.R * (1 - body.alpha * c)
    expected = resting + 2 * inertia + shift * contact_speed
    q = Motion(body, vectors_from_euler(body, moving, Pythagorean), Pythagorean)
    assert quantities.E_tilde(q) == expected
    gliding = 2 * body.m if alone.startswith("nu") else shift * contact_speed
    assert quantities.E_trans(q) == gliding


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


def test_poles_have_no_euler_angles(numbers: Parameters, mp: Any) -> None:
    vectors = vectors_from_euler(numbers, EulerState(*map(mp.mpf, (0, 0, 0, 5, 1, 0))), mp)
    assert (vectors.kx, vectors.ky, vectors.kz) == (0, 0, 1)
    with pytest.raises(ZeroDivisionError):
        euler_from_vectors(numbers, vectors, mp)
