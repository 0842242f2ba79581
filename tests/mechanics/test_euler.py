"""The paper's Euler-angle equations: exact answers."""

from fractions import Fraction

import pytest

from tt_precise.mechanics import euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.parameters import Parameters
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


def test_a_top_let_go_swings_back(body: TippeTop) -> None:
    """theta_ddot = -R alpha sin theta g_n/I1, all else at rest."""
    still = state(0, 0, 0, 0, 0)
    rate = euler.rates(body, still, Pythagorean)
    g_n = euler.normal_force(body, still, Pythagorean)
    assert rate.theta_dot == -body.R * body.alpha * Fraction(3, 5) * g_n / body.I1
    assert (rate.theta, rate.phi_dot, rate.omega_3, rate.nu_y) == (0, 0, 0, 0)


def test_a_centred_ball_slides_to_rest() -> None:
    m, R, inertia, g, mu = (Fraction(n, 7) for n in (3, 5, 2, 68, 4))
    ball = Parameters(m, R, Fraction(0), inertia, inertia, g, mu)
    rate = euler.rates(ball, state(0, 0, 0, 7, -11), Pythagorean)
    slowing = -mu * g * (1 + m * R * R / inertia)
    assert (rate.nu_x, rate.nu_y) == (slowing * 7, slowing * -11)


def test_steady_precession_of_a_ball_with_heavy_core() -> None:
    """alpha = 0, mu = 0: free precession I1 phi_dot cos theta = I3 omega_3 keeps theta; eq (2)."""
    ball = Parameters(*(Fraction(n) for n in (1, 1, 0, 5, 4, 10, 0)))
    phi_dot, omega_3 = Fraction(3), Fraction(5 * 3 * 4, 4 * 5)
    free = EulerState(Pythagorean.THETA, Fraction(0), phi_dot, omega_3, Fraction(0), Fraction(0))
    rate = euler.rates(ball, free, Pythagorean)
    assert (rate.theta_dot, rate.phi_dot, rate.omega_3) == (0, 0, 0)
    faster = free._replace(phi_dot=phi_dot + Fraction(1, 10**40))
    assert euler.rates(ball, faster, Pythagorean).theta_dot != 0


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
    assert euler.modified_energy(body, moving, Pythagorean) == expected
    gliding = 2 * body.m if alone.startswith("nu") else shift * contact_speed
    assert euler.translational_energy(body, moving, Pythagorean) == gliding
