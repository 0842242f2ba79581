"""The equations in a turning frame: the same motion as in the inertial one."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

from tt_precise.mechanics import centre, turning
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.turning import TURNING, TurningState
from tt_precise.mechanics.vectors import added, dot, scaled
from tt_precise.scene.body import TippeTop


def small(body: TippeTop) -> Any:
    return replace(body.numbers(Fraction), m=Fraction(1), R=Fraction(1), g=Fraction(1))


def test_there_and_back(body: TippeTop, vector_states: list[NewtonState]) -> None:
    top = small(body)
    for vectors in vector_states:
        state = centre.from_vectors(top, vectors)
        assert turning.to_centre(top, turning.from_centre(top, state)) == state
        q = TURNING.motion(top, TURNING.start(top, vectors, None), None)  # type: ignore[arg-type]
        assert q.state == vectors


def test_without_turning_the_rates_are_those_of_the_centre_of_mass(
    body: TippeTop, vector_states: list[NewtonState]
) -> None:
    top = small(body)
    unit = [one for one in vector_states if sum(k * k for k in one.k) == 1]
    assert unit
    for vectors in unit:
        state = centre.from_vectors(top, vectors)
        there = turning.from_centre(top, state)
        still = turning.rates(turning.top_of(top, there, Fraction(0)), there)
        expected = centre.rates(top, state)
        assert turning.to_centre(top, still) == expected
        rate = Fraction(7, 3)
        turned = turning.rates(turning.top_of(top, there, rate), there)
        pairs = (there.ky, -there.kx, 0, there.ly, -there.lx, 0, there.uy, -there.ux)
        changes = [after - before for after, before in zip(turned, still, strict=True)]
        assert changes == [rate * one for one in pairs]
        # a wrong lambda spoils the spin
        wrong = replace(turning.top_of(top, there, Fraction(0)), lambda_=Fraction(10**6))
        assert turning.to_centre(top, turning.rates(wrong, there)) != expected


def test_the_omega_that_is_read_is_the_one_that_is_integrated_with(
    body: TippeTop, vector_states: list[NewtonState]
) -> None:
    top = small(body)
    for vectors in (one for one in vector_states if sum(k * k for k in one.k) == 1):
        there = turning.from_centre(top, centre.from_vectors(top, vectors))
        whole = turning.top_of(top, there, Fraction(0))
        assert turning.with_its_spin(whole, there) == there
        # an l that rounding has taken away from lambda
        moved = there._replace(lx=there.lx + Fraction(1, 10**6), lz=there.lz - Fraction(1, 10**7))
        read = turning.with_its_spin(whole, moved)
        assert read != moved
        spin = (whole.I1 / whole.I3 - 1) / whole.alpha * (moved.lz - whole.lambda_)
        own = (whole.I1 / whole.I3 - 1) * dot(read.l, read.k)
        assert added(read.l, scaled(own, read.k)) == added(moved.l, scaled(spin, moved.k))


def test_turned_back_is_a_rotation() -> None:
    state = centre.CentreState(*map(Fraction, (1, 2, 3, 4, 5, 6, 7, 8)))
    cosine, sine = Fraction(3, 5), Fraction(4, 5)
    back = turning.turned_back(state, cosine, sine)
    assert (back.kx, back.ky, back.kz) == (Fraction(-1), Fraction(2), 3)
    assert turning.turned_back(back, cosine, -sine) == state
    assert TURNING.parameters == ("alpha", "I1", "I3", "mu", "lambda_", "Omega")
    assert TurningState._fields == TURNING.columns
