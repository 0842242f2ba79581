"""Elastic tables: the force at the bounds of contact, and what it stores."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.mechanics import compliant
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.parameters import SPRINGS, Parameters
from tt_precise.scene.body import TippeTop

Round = Callable[[Fraction], Any]
STIFFNESS, DAMPING = 70, Fraction(3, 7)


def table(body: TippeTop, spring: str, rounded: Round) -> Parameters:
    return replace(
        body.numbers(rounded), spring=spring, stiffness=rounded(Fraction(STIFFNESS)),
        damping=rounded(DAMPING),
    )  # fmt: skip


@pytest.mark.parametrize("spring", SPRINGS)
def test_contact_ends_before_a_pull(spring: str, body: TippeTop, mp: Any, rounded: Round) -> None:
    """Above that rate of rising the table would hold the top back."""
    here = table(body, spring, rounded)
    height = -mp.mpf(1) / 100
    end = -STIFFNESS * height / here.damping if spring == "linear" else 1 / here.damping
    assert abs(compliant.pull(here, height, end)) < mp.mpf(10) ** -50
    for rise in (end * mp.mpf("0.9"), end * mp.mpf("1.1")):
        state = LiftedState(0, 0, 1, 0, 0, 0, 0, 0, height, rise)
        pushes = compliant.normal_force(here, state, mp) > 0
        assert pushes == (rise < end)
        assert (compliant.pull(here, height, rise) < 0) == pushes


@pytest.mark.parametrize("spring", SPRINGS)
def test_what_is_stored_is_the_work(spring: str, body: TippeTop, mp: Any, rounded: Round) -> None:
    here, depth = table(body, spring, rounded), mp.mpf("0.3")

    def force(zeta: Any) -> Any:
        """Times the rate of the depth zeta^2."""
        lifted = LiftedState(0, 0, 0, 0, 0, 0, 0, 0, compliant.height(zeta), 0)
        return compliant.normal_force(here, lifted, mp) * 2 * zeta

    found = compliant.stored_energy(here, -depth, mp)
    assert abs(found / mp.quad(force, [0, mp.sqrt(depth)]) - 1) < 100 * mp.eps
    assert compliant.stored_energy(here, depth, mp) == 0
