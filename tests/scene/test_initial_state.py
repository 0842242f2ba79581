"""A scene's start as numbers of an arithmetic: rounded once, the same in SI and dimensionless."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

from tt_precise.mechanics.formulations import STATE_DIMENSIONS, formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import Arithmetic
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import load_scene

SCENES = ("reference", "rolling", "flight", "elastic-linear")


def wide() -> Arithmetic:
    context: Any = mpmath.MPContext()
    context.dps = 50
    return Arithmetic(context, lambda value: to_mpmath(Fraction(value), context))


@pytest.mark.parametrize("name", SCENES)
def test_si_is_the_dimensionless_start_times_its_units(name: str) -> None:
    scene, arithmetic = load_scene(name), wide()
    plain, si = InitialState.of(scene, arithmetic), InitialState.in_si(scene, arithmetic)
    assert (plain.body.m, plain.body.R, plain.body.g) == (1, 1, 1)
    for entry, value in plain.vectors._asdict().items():
        unit = plain.units.of_dimension(STATE_DIMENSIONS[entry])
        other = getattr(si.vectors, entry)
        # vx is the difference of terms of the size of omega R: 10 eps of these
        assert abs(value * unit - other) <= 10 * arithmetic.fn.eps * (abs(other) + 4 * abs(unit))
    assert plain.until * plain.units.time == pytest.approx(si.until, rel=1e-45)


def test_near_the_inverted_pole_the_tilt_keeps_its_digits() -> None:
    scene = load_scene("reference").varied(theta="pi - 1e-300")
    start = InitialState.of(scene, Arithmetic(numpy, float))
    assert start.vectors.kx == pytest.approx(1e-300, rel=1e-15)
    assert start.vectors.kz == -1
    # theta itself is pi in double, which is why the vectors do not use it
    assert start.euler.theta == numpy.pi


def test_a_state_is_that_of_the_formulation_and_computed_once() -> None:
    start = InitialState.of(load_scene("reference"), Arithmetic(numpy, float))
    form = formulation("gliding", "newton")
    assert start.state(form) == tuple(start.vectors)
    assert start.state(form) is start.state(form)
    assert start.first_row(form, ("phi", "x"))[-2:] == (0, 0)
    assert start.parameters(form) == tuple(
        start.body.numbers_by_name[name] for name in ("alpha", "I1", "I3", "mu")
    )
    moved = start.map(lambda x: x + 0)
    assert isinstance(moved.vectors, NewtonState)
    assert moved.vectors == start.vectors
