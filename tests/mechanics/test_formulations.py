"""Formulations: one motion written in four ways."""

import dataclasses
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.formulations import (
    CHEAPER,
    FORMULATIONS,
    MODELS,
    STATE_DIMENSIONS,
    formulation,
    integration_form,
)
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import TippeTop

Round = Callable[[Fraction], Any]
EVERY = pytest.mark.parametrize(
    "form",
    [*FORMULATIONS.values(), *CHEAPER.values()],
    ids=lambda f: f"{f.model}-{f.coordinates}-{f.State.__name__}",
)
START = EulerState(*(Fraction(n, 10) for n in (9, 21, -13, 34, 5, -8)))


def beginning(form: Any, body: TippeTop, mp: Any, rounded: Round) -> Any:
    """Return the start in the coordinates of ``form``."""
    given = START if form.model == "gliding" else START._replace(nu_x=Fraction(0), nu_y=Fraction(0))
    euler = EulerState(*map(rounded, given))
    numbers = body.numbers(rounded)
    vectors = vectors_from_euler(numbers, euler, mp)
    return form.State.of(Motion(numbers, vectors, mp, form.model, euler=euler))


@EVERY
def test_state_has_its_columns_and_dimensions(
    form: Any, body: TippeTop, numbers: Parameters, mp: Any, rounded: Round
) -> None:
    state = beginning(form, body, mp, rounded)
    assert tuple(state._fields) == form.columns
    assert set(form.columns) <= set(STATE_DIMENSIONS)
    rate = form.rates(numbers, state, mp)
    assert rate._fields == state._fields


# theta to nu_y
STARTS = [(9, 21, -13, 34, 5, -8), (25, -7, 4, -52, 0, 9),
          (-14, 3, 8, 5, -7, 0), (31, 40, -2, 90, 2, 3)]  # fmt: skip


@pytest.mark.parametrize("model", ["gliding", "rolling"])
def test_every_quantity_is_that_of_every_formulation(
    model: str, body: TippeTop, numbers: Parameters, mp: Any, rounded: Round
) -> None:
    newton, *others = (
        form.motion(numbers, beginning(form, body, mp, rounded), mp)
        for kind in (formulation, integration_form)
        for form in (kind(model, "newton"), kind(model, "euler"))
    )
    assert isinstance(newton, Motion)
    for motion in others:
        for name, quantity in QUANTITIES.items():
            one, other = quantity.evaluate(newton), quantity.evaluate(motion)
            assert abs(one - other) <= mp.mpf(10) ** -55 * max(1, abs(one)), name
        assert motion.model == model


@pytest.mark.parametrize("model", MODELS)
def test_euler_angles_and_vectors_move_alike(model: str, numbers: Parameters, mp: Any) -> None:
    """A step later, but for the step's square; ``exact`` proves the formulas for all states."""
    for start in STARTS:
        moved_by_vectors, moved_by_angles = moved(model, start, numbers, mp)
        bound = mp.mpf(10) ** -44
        for expected, found in zip(moved_by_vectors, moved_by_angles, strict=True):
            assert abs(expected - found) < bound


def moved(
    model: str, start: tuple[int, ...], top: Parameters, mp: Any
) -> tuple[list[Any], list[Any]]:
    """The vectors a step later, by the equations in vectors and by those in angles."""
    newton, euler = formulation(model, "newton"), formulation(model, "euler")
    step = mp.mpf(10) ** -25
    entries = ([mp.mpf(n) / 10 for n in start] + [mp.mpf(0)] * 9)[: len(euler.columns)]

    def at(entries: Any, turn: Any) -> list[Any]:
        """k, L, v_A and what follows, where the axis leans towards the angle ``turn``."""
        angles = [*entries[:6], 0, 0][: len(EulerState._fields)]
        kx, ky, kz, Lx, Ly, Lz, vx, vy = vectors_from_euler(top, EulerState(*angles), mp)
        c, s = mp.cos(turn), mp.sin(turn)
        turned = (c * kx - s * ky, s * kx + c * ky, kz, c * Lx - s * Ly, s * Lx + c * Ly, Lz)
        whole = [*turned, c * vx - s * vy, s * vx + c * vy, *entries[6:]]
        return whole[: len(newton.columns)]

    state = euler.State(*entries)
    slopes = euler.rates(top, state, mp)
    later = [x + step * slope for x, slope in zip(entries, slopes, strict=True)]
    here = at(entries, 0)
    rates = newton.rates(top, newton.State(*here), mp)
    by_angles = at(later, step * state.phi_dot)
    assert max(abs(now - was) for was, now in zip(here, by_angles, strict=True)) > mp.mpf(10) ** -27
    return [was + step * slope for was, slope in zip(here, rates, strict=True)], by_angles


@EVERY
def test_equations_use_the_listed_parameters_only(
    form: Any, body: TippeTop, mp: Any, rounded: Round
) -> None:
    """Dimensionless: m = R = g = 1; the others are listed, and each listed one matters."""
    small = body.dimensionless(mp, rounded)
    state = beginning(form, body, mp, rounded)
    truth = form.rates(small, state, mp)
    for name in ("alpha", "I1", "I3", "mu"):
        changed = dataclasses.replace(small, **{name: getattr(small, name) * mp.mpf("1.1")})
        assert (form.rates(changed, state, mp) != truth) is (name in form.parameters), name


@pytest.mark.parametrize(
    ("model", "coordinates", "said"),
    [
        ("gliding", "Newton", "got 'Newton', expected one of: newton, euler"),
        ("gliding", "", "expected one of: newton, euler"),
        # an elastic table's formulations are those of ``elastic``
        ("linear", "newton", "model: got 'linear', expected one of: gliding, rolling"),
    ],
)
def test_refuses(model: str, coordinates: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        formulation(model, coordinates)
