"""Terms of the equations, dropped by themselves."""

from __future__ import annotations

import math

import sympy

import tt_precise as tt
from benchmarks.dropped_terms import rates_without, term_names
from tt_precise.mechanics import euler
from tt_precise.mechanics.parameters import Parameters

STATE = euler.EulerState(0.7, 1.1, -2.3, 150.0, 0.02, -0.05)


def test_every_term_is_dropped_by_itself_and_dropping_nothing_changes_nothing() -> None:
    body = tt.load_scene("reference").body.numbers(float)
    whole, terms = rates_without(None, euler.rates, body, STATE, math)
    assert whole == list(euler.rates(body, STATE, math))
    assert len(terms) == len(term_names())
    for number in range(len(terms)):
        assert rates_without(number, euler.rates, body, STATE, math)[0] != whole, number


def test_a_dropped_term_is_the_one_that_is_named() -> None:
    names = term_names()
    number = names.index("eq (3) without I3*omega_3*theta_dot")
    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    state = euler.EulerState(*sympy.symbols("theta theta_dot phi_dot omega_3 nu_x nu_y"))
    spoiled, _ = rates_without(number, euler.rates, body, state, sympy)
    whole = euler.rates(body, state, sympy)
    difference = sympy.simplify(whole[2] - spoiled[2])
    expected = body.I3 * state.omega_3 * state.theta_dot / (body.I1 * sympy.sin(state.theta))
    assert sympy.simplify(difference - expected) == 0
    assert [a == b for a, b in zip(whole, spoiled, strict=True)] == [i != 2 for i in range(6)]
