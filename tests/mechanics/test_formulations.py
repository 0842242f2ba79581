"""Formulations: one motion written in four ways."""

import dataclasses
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import pytest

from tests.mechanics.conftest import slopes
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.formulations import (
    CHEAPER,
    FORMULATIONS,
    MODELS,
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
@pytest.mark.parametrize("start", STARTS)
def test_euler_angles_and_vectors_move_alike(
    start: tuple[int, ...], model: str, numbers: Parameters, mp: Any
) -> None:
    """At azimuth 0 the axis precesses along Y; ``exact`` proves the formulas on the table."""
    newton, euler = formulation(model, "newton"), formulation(model, "euler")
    state = euler.State(*(mp.mpf(n) / 10 for n in start[: len(euler.columns)]))
    (kx, ky, _, Lx, Ly, _, vx, vy) = vectors = state.vectors(numbers, mp)
    turning = [-ky, kx, 0, -Ly, Lx, 0, -vy, vx]
    leaning = slopes(lambda s: s.vectors(numbers, mp), state, euler.rates(numbers, state, mp), mp)
    rates = newton.rates(numbers, newton.State(*vectors[: len(newton.columns)]), mp)
    for lean, turn, rate in zip(leaning, turning, rates, strict=False):
        assert abs(lean + state.phi_dot * turn - rate) < mp.mpf(10) ** -33


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
