"""Threshold formulas: their dimension, their limits, and what the remarks say of them."""

import dataclasses
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy
import pytest

from tt_precise.mechanics import newton, thresholds
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import ENERGY, JELLETT, Dimension, Parameters, Units
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.vectors import added, dot, scaled, subtracted
from tt_precise.scene.body import TippeTop

Round = Callable[[Fraction], Any]
ANGULAR_MOMENTUM = Dimension.of("kg m^2/s")

FORMULAS: dict[str, tuple[Dimension, Callable[[Parameters, Any, Any], Any]]] = {
    "lambda_thres": (JELLETT, lambda b, x, fn: thresholds.lambda_thres(b, fn)),
    "lambda_up": (JELLETT, lambda b, x, fn: thresholds.lambda_up(b, fn)),
    "L0": (ANGULAR_MOMENTUM, lambda b, x, fn: thresholds.L0(b, x)),
    "L1": (ANGULAR_MOMENTUM, lambda b, x, fn: thresholds.L1(b, x)),
    "D0": (ANGULAR_MOMENTUM, thresholds.D0),
    "D1": (ANGULAR_MOMENTUM, thresholds.D1),
    "E0": (ENERGY, lambda b, x, fn: thresholds.E0(b, x)),
    "E1": (ENERGY, lambda b, x, fn: thresholds.E1(b, x)),
    "T_upp": (Dimension(0, 0, 1), lambda b, x, fn: thresholds.T_upp(b, x, thresholds.L0(b, x), fn)),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_dimensionless_form_is_si_in_other_units(
    name: str, body: TippeTop, numbers: Parameters, mp: Any, rounded: Round
) -> None:
    dimension, formula = FORMULAS[name]
    units = Units.of(body, mp, rounded)
    lambda_ = mp.mpf("1.25")
    truth = formula(numbers, lambda_, mp)
    small = formula(body.dimensionless(mp, rounded), lambda_ / units.of_dimension(JELLETT), mp)
    assert abs(small * units.of_dimension(dimension) / truth - 1) < mp.mpf(10) ** -56
    wrong = dimension._replace(time=dimension.time + 1)
    assert abs(small * units.of_dimension(wrong) / truth - 1) > mp.mpf("0.1")


def energy_and_lambda(body: TippeTop, state: NewtonState) -> tuple[Fraction, Fraction]:
    q = Motion(body, state, None)
    return QUANTITIES["E"].evaluate(q), QUANTITIES["lambda"].evaluate(q)


def least_of(body: TippeTop, state: NewtonState) -> NewtonState:
    """The state of least energy with the axis and the lambda of ``state``: at rest, L along I a."""
    k, a = state.k, newton.contact_arm(body, state.k)
    turned = added(scaled(body.I1, a), scaled((body.I3 - body.I1) * dot(a, k), k))
    L = scaled(dot(state.L, a) / dot(a, turned), turned)
    still = NewtonState(*k, *L, 0, 0)
    # the centre of mass is at rest where v_A = omega x a
    return NewtonState(*k, *L, *newton.contact_velocity_rel_cm(body, still)[:2])


def test_least_energy_is_that_of_the_least_state(body: TippeTop, states: list[NewtonState]) -> None:
    """E = U(z) + (L - L*).I^-1 (L - L*)/2 + m s_dot^2/2, exactly."""
    for state in states:
        energy, lambda_ = energy_and_lambda(body, state)
        least = least_of(body, state)
        bound = thresholds.least_energy(body, state.kz, lambda_)
        more = subtracted(state.L, least.L)
        turning = dot(more, newton.inverse_inertia(body, state.k, more)) / 2
        assert energy == bound + turning + QUANTITIES["E_trans"].evaluate(Motion(body, state, None))
        lowest, same_lambda = energy_and_lambda(body, least)
        assert (lowest, same_lambda) == (bound, lambda_)
        faulty = dataclasses.replace(body, I1=body.I1 * Fraction(101, 100))
        assert thresholds.least_energy(faulty, state.kz, lambda_) != bound


@pytest.mark.parametrize("z", ["-0.6", "0.4"])
def test_the_least_energy_is_stationary_where_the_top_tumbles(
    numbers: Parameters, mp: Any, z: str
) -> None:
    lambda_ = mp.sqrt(thresholds.tumbling_lambda_squared(numbers, mp.mpf(z)))
    slope = mp.diff(lambda cosine: thresholds.least_energy(numbers, cosine, lambda_), mp.mpf(z))
    weight = numbers.m * numbers.g * numbers.R * numbers.alpha
    assert abs(slope) < mp.mpf("1e-20") * weight


def test_energy_excludes_exactly_up_to_the_barrier(body: TippeTop) -> None:
    lambda_, small = Fraction(3), Fraction(1, 10**40)
    for z in (Fraction(99, 100), Fraction(-99, 100)):
        barrier = max(
            thresholds.least_energy(body, z * i / thresholds.BARRIERS, lambda_)
            for i in range(thresholds.BARRIERS)
        )
        assert thresholds.energy_excludes(body, barrier - small, lambda_, z)
        assert not thresholds.energy_excludes(body, barrier, lambda_, z)
    equator = thresholds.least_energy(body, Fraction(0), lambda_)
    at_equator = least_of(body, NewtonState(1, 0, 0, 0, 0, lambda_ / body.R, 0, 0))
    # a state at the equator with that energy exists: it is not excluded from being there
    energy, same = energy_and_lambda(body, at_equator)
    assert (energy, same) == (equator, lambda_)
    assert not thresholds.energy_excludes(body, energy, lambda_, Fraction(0))


def test_a_motion_has_the_energy_for_where_it_is(body: TippeTop, states: list[NewtonState]) -> None:
    """A motion at kz has the energy to be at kz; arrays answer entry by entry."""
    for state in states:
        energy, lambda_ = energy_and_lambda(body, state)
        assert not thresholds.energy_excludes(body, energy, lambda_, state.kz, to=state.kz)
        floor = thresholds.least_energy(body, state.kz, lambda_) - Fraction(1, 1000)
        assert thresholds.energy_excludes(body, floor, lambda_, state.kz, to=state.kz)
    numbers = body.numbers(float)
    z, energies = numpy.array([0.9, 0.9, -0.9]), numpy.array([0.0, 1e9, 0.0])
    found = thresholds.energy_excludes(numbers, energies, 3.0, z)
    assert found.tolist() == [True, False, True]
