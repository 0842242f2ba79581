"""The tops whose contact force blows up."""

from __future__ import annotations

from fractions import Fraction

import pytest

from tt_precise.extremes.contact import NAMES, blow_up, blowing_up, lost_first


@pytest.mark.parametrize("name", NAMES)
def test_both_tops_have_the_papers_moments_of_inertia(name: str) -> None:
    body = blowing_up(name).body
    assert body.I1 / (body.m * body.R**2) == Fraction(131, 350)
    assert body.I3 / (body.m * body.R**2) == Fraction(2, 5)


def test_the_heavier_top_blows_up_unless_it_is_let_go() -> None:
    assert blow_up(NAMES[6]).holds
    assert lost_first(NAMES[6]).holds
    assert not lost_first(NAMES[6], contact="bilateral").holds
