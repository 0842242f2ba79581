"""Elastic tables: two forms of one motion, and the force at the bounds of contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.mechanics import compliant
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import FORMULATIONS, Formulation, raised
from tt_precise.scene.body import SPRINGS, Parameters, TippeTop

Round = Callable[[Fraction], Any]
STIFFNESS, DAMPING = 70, Fraction(3, 7)
FORMS = {
    "flight": (raised("newton"), raised("euler")),
    **{name: (FORMULATIONS[name, "newton"], FORMULATIONS[name, "euler"]) for name in SPRINGS},
}


def table(body: TippeTop, spring: str, rounded: Round) -> Parameters:
    return replace(
        body.numbers(rounded), spring=spring, stiffness=rounded(Fraction(STIFFNESS)),
        damping=rounded(DAMPING),
    )  # fmt: skip


@pytest.mark.parametrize("model", FORMS)
@pytest.mark.parametrize("start", [(9, 21, -13, 34, 5, -8, 3, 2), (25, -7, 4, -52, 0, 9, 1, -4)])
def test_both_coordinates_move_alike(
    model: str, start: tuple[int, ...], body: TippeTop, mp: Any, rounded: Round
) -> None:
    """From the angles a step later, the vectors of a step later, but for the step's square."""
    newton, euler = FORMS[model]
    here = table(body, model, rounded)
    step, entries = mp.mpf(10) ** -25, [mp.mpf(n) / 10 for n in start]

    def at(form: Formulation, entries: Any, turn: Any) -> list[Any]:
        """k, L, v_A, and how the point stands above the table, leaning towards ``turn``."""
        c, s = mp.cos(turn), mp.sin(turn)
        kx, ky, kz, Lx, Ly, Lz, vx, vy = vectors_from_euler(here, EulerState(*entries[:6]), mp)
        turned = (c * kx - s * ky, s * kx + c * ky, kz, c * Lx - s * Ly, s * Lx + c * Ly, Lz)
        return [*turned, c * vx - s * vy, s * vx + c * vy, *entries[6:]]

    entries += [mp.mpf(0)] * (len(euler.columns) - len(entries))
    state = euler.State(*entries)
    slopes = euler.rates(here, state, mp)
    pace = euler.clock(state, mp) if euler.clock else 1
    later = [x + step * slope for x, slope in zip(entries, slopes, strict=True)]
    first = at(euler, entries, 0)
    moved = at(euler, later, step * pace * state.phi_dot)
    rates = newton.rates(here, newton.State(*first), mp)
    for was, slope, now in zip(first, rates, moved, strict=True):
        assert abs(now - was - step * slope) < mp.mpf(10) ** -43
    assert max(abs(now - was) for was, now in zip(first, moved, strict=True)) > mp.mpf(10) ** -27


@pytest.mark.parametrize("spring", SPRINGS)
def test_contact_ends_where_the_force_would_pull(
    spring: str, body: TippeTop, mp: Any, rounded: Round
) -> None:
    """Above that rate of rising the table would hold the top back."""
    here = table(body, spring, rounded)
    height = -mp.mpf(1) / 100
    end = -STIFFNESS * height / here.damping if spring == "linear" else 1 / here.damping
    assert abs(compliant.reach(here, height, end)) < mp.mpf(10) ** -50
    for rise in (end * mp.mpf("0.9"), end * mp.mpf("1.1")):
        state = LiftedState(0, 0, 1, 0, 0, 0, 0, 0, height, rise)
        pushes = compliant.normal_force(here, state, mp) > 0
        assert pushes == (rise < end)
        assert (compliant.reach(here, height, rise) < 0) == pushes


@pytest.mark.parametrize("spring", SPRINGS)
def test_what_is_stored_is_the_integral_of_the_force(
    spring: str, body: TippeTop, mp: Any, rounded: Round
) -> None:
    here, depth = table(body, spring, rounded), mp.mpf("0.3")

    def force(zeta: Any) -> Any:
        """Times the rate of the depth zeta^2."""
        lifted = LiftedState(0, 0, 0, 0, 0, 0, 0, 0, compliant.height(zeta), 0)
        return compliant.normal_force(here, lifted, mp) * 2 * zeta

    found = compliant.stored_energy(here, -depth, mp)
    assert abs(found / mp.quad(force, [0, mp.sqrt(depth)]) - 1) < 100 * mp.eps
    assert compliant.stored_energy(here, depth, mp) == 0
