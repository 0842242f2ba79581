"""In which arithmetic the solution is computed at the rows' own times."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest

import tt_precise as tt
from tt_precise.check.recompute import recomputed
from tt_precise.runtime.progress import silent


@pytest.mark.parametrize(("asked", "arithmetic"), [(8.0, "extended"), (15.0, "quad")])
def test_it_is_computed_with_two_digits_more_than_are_asked_for(
    asked: float, arithmetic: str
) -> None:
    """Double has between 10 and 17 digits after 0.05 s."""
    scene = replace(tt.load_scene("reference"), until=Fraction(1, 20))
    state = tt.integrate(scene).state
    rows = [(Fraction(1, 20), {name: Decimal(getattr(state, name)) for name in ("kx", "Lx")})]
    _, note = recomputed(scene, rows, asked, silent)
    assert note == f"1 rows computed afresh in {arithmetic}"
