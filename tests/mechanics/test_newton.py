"""The vector equations, of the contact point and of the centre of mass, against known motions."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tests.mechanics.conftest import slopes
from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import added, cross, dot
from tt_precise.scene.body import TippeTop

RATIOS = [(3, 4), (5, 12), (-8, 15), (20, 21)]


def tilted(state: Any = (0, 0, 0, 0, 0), rise: int = 4, run: int = 3) -> NewtonState:
    """The axis at the angle of a Pythagorean triangle, towards X."""
    root = Fraction(rise**2 + run**2)
    length = Fraction(int(root**0.5))
    assert length**2 == root
    return NewtonState(run / length, Fraction(0), rise / length, *map(Fraction, state))


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("spin", [0, 5, -7])
def test_vertical_spins_are_steady(body: TippeTop, side: int, spin: int) -> None:
    state = NewtonState(*map(Fraction, (0, 0, side, 0, 0, spin, 0, 0)))
    assert not any(newton.rates(body, state))
    assert newton.normal_force(body, state) == body.m * body.g


@pytest.mark.parametrize(("run", "rise"), RATIOS)
def test_gravity_rights_a_top_let_go(body: TippeTop, run: int, rise: int) -> None:
    """g_n = m g I1/(I1 + m R^2 alpha^2 sin^2 theta): the table yields as the top starts to fall.

    Torque R alpha sin theta g_n about -Y: the centre of mass swings below the centre.
    """
    state = tilted(run=run, rise=rise)
    arm = body.R * body.alpha * state.kx
    g_n = body.m * body.g / (1 + body.m * arm**2 / body.I1)
    assert newton.normal_force(body, state) == g_n
    rate = newton.rates(body, state)
    assert (rate.Lx, rate.Ly, rate.Lz) == (0, -arm * g_n, 0)
    assert (rate.kx, rate.ky, rate.kz) == (0, 0, 0)


def test_a_centred_ball_slides_to_rest() -> None:
    """alpha = 0, I1 = I3 = I: v_dot = -mu g (1 + m R^2/I) v, whatever the spin."""
    m, R, inertia, g, mu = (Fraction(n, 7) for n in (3, 5, 2, 68, 4))
    ball = Parameters(m, R, Fraction(0), inertia, inertia, g, mu)
    state = tilted((2, -3, 5, 7, -11))
    rate = newton.rates(ball, state)
    assert newton.normal_force(ball, state) == m * g
    slowing = -mu * g * (1 + m * R * R / inertia)
    assert (rate.vx, rate.vy) == (slowing * 7, slowing * -11)
    assert (rate.Lx, rate.Ly, rate.Lz) == (-R * mu * m * g * -11, R * mu * m * g * 7, 0)


def test_gyroscopic_axis(body: TippeTop) -> None:
    """L along k leaves the axis where it is; L along z precesses it at |L|/I1."""
    state = tilted((0, 0, 0, 0, 0))
    along = state._replace(Lx=2 * state.kx, Lz=2 * state.kz)
    assert newton.axis_rate(body, along) == (0, 0, 0)
    about_z = state._replace(Lz=Fraction(2))
    assert newton.axis_rate(body, about_z) == (0, 2 * state.kx / body.I1, 0)


def test_axis_moves_as_the_body_turns(body: TippeTop, states: list[NewtonState]) -> None:
    """k_dot = L x k/I1 = omega x k, orthogonal to k; eq (1)."""
    for state in states:
        k_dot = newton.axis_rate(body, state)
        assert k_dot == cross(newton.angular_velocity(body, state), state.k)
        assert dot(k_dot, state.k) == 0


def test_contact_velocity_is_omega_cross_a(body: TippeTop, states: list[NewtonState]) -> None:
    for state in states:
        a, omega = newton.contact_arm(body, state.k), newton.angular_velocity(body, state)
        found = newton.contact_velocity_rel_cm(body, state)
        assert found == cross(omega, a) != cross(omega, added(a, (0, Fraction(1, 10**40), 0)))


def test_denominator_is_singular_where_eq_7_says(body: TippeTop) -> None:
    """At theta = pi/2: I1 + m R^2 alpha (alpha - mu nu_x) = 0."""
    lever = body.m * body.R**2 * body.alpha
    nu_x = (body.I1 / lever + body.alpha) / body.mu
    state = NewtonState(*map(Fraction, (1, 0, 0, 0, 0, 0, nu_x, 0)))
    _, denominator = newton.contact_terms(body, state)
    assert denominator == 0
    with pytest.raises(ZeroDivisionError):
        newton.rates(body, state)
    assert newton.contact_terms(replace(body, mu=body.mu / 2), state)[1] > 0


def test_centre_of_mass_there_and_back(body: TippeTop, states: list[NewtonState]) -> None:
    for vectors in states:
        state = newton.CentreState.of(Motion(body, vectors, None))
        assert state.vectors(body) == vectors
        assert state.centre(body)() == Motion(body, vectors, None).s_dot


def test_the_same_motion_as_in_vectors(
    numbers: Parameters, states: list[NewtonState], mp: Any, rounded: Any
) -> None:
    off = replace(numbers, mu=numbers.mu * (1 + mp.mpf(10) ** -30))
    for exact in states:
        vectors = NewtonState(*map(rounded, exact))
        state = newton.CentreState.of(Motion(numbers, vectors, None))
        rates = newton.centre_rates(numbers, state)
        found = slopes(lambda s: s.vectors(numbers), state, rates, mp)
        for one, right in zip(found, newton.rates(numbers, vectors), strict=True):
            assert abs(one - right) < mp.mpf(10) ** -34
        assert abs(found[6] - newton.rates(off, vectors).vx) > mp.mpf(10) ** -33


def test_the_momentum_about_the_lowest_point_by_hand(body: TippeTop) -> None:
    # a x v = (0, 3, -2)
    expected = (10, 20 - 3 * body.m, 30 + 2 * body.m)
    assert newton.contact_momentum(body, (1, 2, 3), (10, 20, 30), (1, 0, 0)) == expected
