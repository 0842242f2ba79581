"""Requested digits: what is accepted, and which setting comes next; without any integration."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from tt_precise.integration import integrate, to_digits
from tt_precise.integration.cost_table import Setting, cost_with_estimate
from tt_precise.integration.precision import DOUBLES
from tt_precise.integration.to_digits import (
    HOPE,
    SPARE,
    WIDENINGS,
    WORTH_A_TRY,
    integrate_to_digits,
)
from tt_precise.runtime.errors import InputError


class Runs:
    """Stands for the integration: each run has the digits of its setting, changed by ``change``."""

    def __init__(self, change: float = 0.0, least: float = 0.0):
        self.change, self.least = change, least
        self.settings: list[Setting] = []

    def __call__(self, setting: Setting) -> Any:
        self.settings.append(setting)
        digits = max(setting.digits + self.change, self.least)
        scene = SimpleNamespace(name="a scene")
        precision = SimpleNamespace(name=setting.precision, bits=setting.bits)
        return SimpleNamespace(
            status="complete", digits_throughout=digits, scene=scene, precision=precision
        )


@pytest.mark.parametrize(
    ("beyond", "enough"), [(SPARE, True), (SPARE / 2, False), (0.0, False), (-SPARE / 2, False)]
)
def test_the_spare_digits_are_on_top_of_those_requested(beyond: float, enough: bool) -> None:
    """The estimate errs by a tenth of a digit, so one that just says 9 is no promise of 9."""
    runs = Runs()
    first = integrate_to_digits(9, None, runs)
    assert first.digits_throughout >= 9 + SPARE
    short = Runs(9 + beyond - runs.settings[0].digits)
    integrate_to_digits(9, None, short)
    assert (len(short.settings) == 1) == enough


def test_the_first_setting_has_the_spare_digits_by_the_table() -> None:
    for wanted in range(1, 40):
        runs = Runs()
        integrate_to_digits(wanted, None, runs)
        *tried, last = runs.settings
        assert last.digits >= wanted + SPARE
        assert len(tried) <= 1
        for one in tried:
            assert wanted + SPARE - HOPE <= one.digits < wanted + SPARE
            assert WORTH_A_TRY * cost_with_estimate(one) <= cost_with_estimate(last)


def test_a_much_cheaper_setting_is_tried_where_it_may_suffice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without several doubles, of which none is that much cheaper than the next."""
    monkeypatch.setattr(to_digits, "is_available", lambda name: name not in DOUBLES)
    runs = Runs(change=1.4)
    integrate_to_digits(12, None, runs)
    (only,) = runs.settings
    assert only.precision == "double"
    assert only.digits < 12 + SPARE  # by the table it lacks some


def test_what_a_scene_loses_is_added_to_the_next_setting() -> None:
    runs = Runs(change=-3.0)
    found = integrate_to_digits(9, None, runs)
    assert found.digits_throughout >= 9 + SPARE
    first, *between, last = runs.settings
    assert first.digits < last.digits
    assert last.digits >= 9 + SPARE + 3
    # double at full accuracy costs more with its reference run than several doubles with theirs
    assert between == []


def test_a_scene_that_loses_everything_is_given_up() -> None:
    runs = Runs(change=-1e6)
    with pytest.raises(InputError, match="digits: got 9, but mp with"):
        integrate_to_digits(9, None, runs)
    bits = [setting.bits for setting in runs.settings if setting.precision == "mp"]
    assert len(bits) == WIDENINGS - 1  # the first is in triple-double
    assert bits == sorted(set(bits))


@pytest.mark.parametrize("more", [{"tolerance": 1e-3}, {"options": {"compact_mode": True}}])
def test_what_digits_choose_is_not_given_too(more: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="too, which digits choose; expected it with a precision"):
        integrate("reference", digits=8, **more)
