"""What a single integration refuses before it begins."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise.integration import integrate, once
from tt_precise.integration.once import _require_euler_angles
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Inclination, Scene


@pytest.mark.parametrize(("name", "bits"), [("double", 53), ("quad", 113)])
@pytest.mark.parametrize(("of_eps", "told_apart"), [("2", True), ("199/100", False)])
def test_euler_angles_begin_where_theta_is_told_apart_from_pi(
    reference: Scene, name: str, bits: int, of_eps: str, told_apart: bool
) -> None:
    """Numbers between 2 and 4 are 2 eps apart."""
    offset = Fraction(of_eps) * Fraction(1, 2 ** (bits - 1))
    near = replace(reference.start, theta=Inclination(offset, True))
    refused = nullcontext() if told_apart else pytest.raises(InputError, match="is equal to pi in")
    with refused:
        _require_euler_angles(replace(reference, start=near), precision_named(name))


@pytest.mark.parametrize("how", [{}, {"tolerance": 1e-9}, {"precision": "extended"}])
@pytest.mark.parametrize("estimated", [True, False])
def test_what_an_estimate_needs_is_compiled_ahead_where_one_is_wanted(
    reference: Scene, how: dict[str, Any], estimated: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ahead: list[Setup] = []
    monkeypatch.setattr(once, "compile_ahead", ahead.append)
    trajectory = integrate(reference.varied(until="0.01"), estimated=estimated, **how)
    setups = [run.setup for run in trajectory.reference_runs]
    assert len(setups) == 1
    assert ahead == (setups if estimated else [])
