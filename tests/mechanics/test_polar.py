"""Coulomb's friction in polar form: the two forms against the plain equations, and v -> 0."""

from typing import Any

import numpy
import pytest

from tt_precise.mechanics import euler, friction, newton, polar
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.scene.body import Parameters
from tt_precise.scene.laws import COULOMB

BODY = Parameters(1.0, 1.0, 0.3, 0.4, 0.5, 1.0, 0.3, friction=COULOMB)
STATE = EulerState(0.7, 0.4, 0.9, 3.0, 0.06, -0.02)


def test_euler_rates_are_those_of_the_plain_equations(mp: Any) -> None:
    body, state = BODY.map(mp.mpf), EulerState(*map(mp.mpf, STATE))
    own = polar.from_euler(state, mp)
    found = polar.euler_rates(body, own, mp)
    viscous = friction.viscous_at(body, state.nu_x, state.nu_y, mp)
    plain = euler.rates(viscous, state, mp)
    v = polar.speed(own, mp)
    for one, other in zip(found[:4], plain[:4], strict=True):
        assert mp.almosteq(one, v * other, rel_eps=1e-40)
    for e, turning, rate in zip(own[5:7], found[5:7], plain[4:], strict=True):
        assert mp.almosteq(v * found.log_v * e + v * turning, v * rate, rel_eps=1e-40)


def test_both_forms_say_the_same_of_the_speed(mp: Any) -> None:
    body, state = BODY.map(mp.mpf), EulerState(*map(mp.mpf, STATE))
    vectors = vectors_from_euler(body, state, mp)
    one = polar.rates(body, polar.from_vectors(vectors, mp), mp)
    other = polar.euler_rates(body, polar.from_euler(state, mp), mp)
    assert mp.almosteq(one.log_v, other.log_v, rel_eps=1e-40)
    assert mp.almosteq(one.t, other.t, rel_eps=1e-40)


def test_rates_are_finite_where_the_gliding_ends() -> None:
    state = polar.PolarState(0.6, 0.0, 0.8, 1.0, 2.0, 3.0, -numpy.inf, 0.6, 0.8, 0.0)
    rates = polar.rates(BODY, state, numpy)
    assert numpy.isfinite(rates).all()
    # at v = 0 only the direction moves, and it stays a unit vector
    assert [i for i, rate in enumerate(rates) if rate] == [6, 7, 8]
    assert rates.ex * state.ex + rates.ey * state.ey == pytest.approx(0, abs=4e-15)


def test_there_and_back() -> None:
    vectors = NewtonState(0.6, 0.0, 0.8, 1.0, 2.0, 3.0, 0.3, -0.4)
    own = polar.from_vectors(vectors, numpy)
    assert polar.gliding_velocity(own, numpy) == pytest.approx((0.3, -0.4), rel=1e-15)
    assert polar.speed(own, numpy) == pytest.approx(0.5, rel=1e-15)
    assert newton.normal_force(BODY, vectors) > 0
