"""The motion of the centre of mass: the same top as in the published vectors."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.mechanics import centre, newton
from tt_precise.mechanics.centre import CentreState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.scene.body import TippeTop


def test_there_and_back(body: TippeTop, vector_states: list[NewtonState]) -> None:
    for vectors in vector_states:
        state = centre.from_vectors(body, vectors)
        assert centre.to_vectors(body, state) == vectors
        assert centre.velocity(body, state) == Motion(body, vectors, None).s_dot


def test_the_same_motion_as_in_vectors(
    body: TippeTop, vector_states: list[NewtonState], mp: Any, rounded: Any
) -> None:
    numbers = body.numbers(rounded)
    h = mp.mpf(10) ** -20
    for exact in vector_states:
        vectors = NewtonState(*map(rounded, exact))
        state = centre.from_vectors(numbers, vectors)
        rate = centre.rates(numbers, state)
        ahead, behind = (
            centre.to_vectors(
                numbers, CentreState(*(x + sign * h * r for x, r in zip(state, rate, strict=True)))
            )
            for sign in (1, -1)
        )
        truth = newton.rates(numbers, vectors)
        for one, other, right in zip(ahead, behind, truth, strict=True):
            # Central differences of step 1e-20 err by 1e-40 times a third derivative.
            assert abs((one - other) / (2 * h) - right) < mp.mpf(10) ** -34
        off = newton.rates(replace(numbers, mu=numbers.mu * (1 + mp.mpf(10) ** -30)), vectors)
        assert abs((ahead.vx - behind.vx) / (2 * h) - off.vx) > mp.mpf(10) ** -33


def test_no_friction_no_horizontal_force(body: TippeTop) -> None:
    ice = replace(body, mu=Fraction(0))
    state = CentreState(*map(Fraction, (3, 0, 4, 2, -3, 5, 7, -11)))._replace(
        kx=Fraction(3, 5), kz=Fraction(4, 5)
    )
    assert centre.rates(ice, state)[6:] == (0, 0)
    assert all(centre.rates(body, state)[6:])


@pytest.mark.parametrize("side", [1, -1])
def test_a_vertical_spin_that_glides_is_only_braked(body: TippeTop, side: int) -> None:
    """v_A = s_dot there; friction mu m g v brakes it, with the lever R (1 -+ alpha)."""
    state = CentreState(*map(Fraction, (0, 0, side, 0, 0, 5, 2, 0)))
    rate = centre.rates(body, state)
    height = body.R * (1 - side * body.alpha)
    braking = body.mu * body.m * body.g * 2
    assert rate == (0, 0, 0, 0, height * braking, 0, -braking / body.m, 0)
