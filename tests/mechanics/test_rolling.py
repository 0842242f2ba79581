"""The rolling limit: exact answers in rational arithmetic."""

from fractions import Fraction
from typing import Any

from tt_precise.mechanics import newton, rolling
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.rolling import RollingEulerState, RollingState
from tt_precise.mechanics.vectors import added
from tt_precise.scene.body import TippeTop


def still(state: NewtonState) -> NewtonState:
    return state._replace(vx=Fraction(0), vy=Fraction(0))


def test_the_constraint_force_stops_the_contact(body: TippeTop, states: list[NewtonState]) -> None:
    for state in map(still, states):
        force = rolling.constraint_force(body, state)
        assert newton.contact_acceleration(body, state, force) == (0, 0, 0)
        pushed = added(force, (0, Fraction(1, 10**40), 0))
        assert newton.contact_acceleration(body, state, pushed) != (0, 0, 0)


def test_a_centred_ball_rolls_on() -> None:
    ball = Parameters(*(Fraction(n) for n in (3, 2, 0, 5, 5, 10, 1)))
    state = RollingState(*map(Fraction, (0, 1, 0, 3, 4, 5)))
    assert rolling.constraint_force(ball, NewtonState(*state, 0, 0)) == (0, 0, 30)
    assert not any(rolling.rates(ball, state)[3:])


def test_upright_top_rocks_at_the_known_frequency(numbers: Parameters, mp: Any) -> None:
    """Small rocking without spin: theta_ddot = -m g R alpha theta/(I1 + m R^2 (1 - alpha)^2)."""
    tilt = mp.mpf(10) ** -20
    rate = rolling.euler_rates(numbers, RollingEulerState(tilt, 0, 0, 0), mp)
    inertia = numbers.I1 + numbers.m * (numbers.R * (1 - numbers.alpha)) ** 2
    expected = -numbers.m * numbers.g * numbers.R * numbers.alpha * tilt / inertia
    # The next term is theta^2 = 1e-40 smaller.
    assert abs(rate.theta_dot / expected - 1) < mp.mpf(10) ** -38
    assert abs(rate.theta_dot / (expected * (1 + mp.mpf(10) ** -30)) - 1) > mp.mpf(10) ** -38
    assert (rate.theta, rate.phi_dot, rate.omega_3) == (0, 0, 0)
