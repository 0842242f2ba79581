"""Loaded numbers are the printed ones, and damaged data are not handed out."""

from __future__ import annotations

import math
from decimal import Decimal
from typing import TYPE_CHECKING

import pandas
import pytest

import tt_precise as tt
from tt_precise.golden import store
from tt_precise.golden.store import TRAJECTORY
from tt_precise.runtime.errors import InputError

if TYPE_CHECKING:
    from tests.golden.conftest import Small
    from tt_precise.golden.loading import Numbers


def test_floats_are_correctly_rounded(small: Small) -> None:
    frame = tt.golden.load("reference", folder=small.folder)
    text = store.read("reference", small.folder).trajectory
    for name in text.columns:
        assert frame[name].dtype == float
        nearest = [float(cell) for cell in text.column(name)]
        assert frame[name].to_list() == nearest
        for value, cell in zip(frame[name], text.column(name), strict=True):
            error = abs(Decimal(value) - Decimal(cell))
            assert error <= Decimal(math.ulp(value)) / 2


def test_brings_events_and_manifest(small: Small) -> None:
    frame = tt.golden.load("reference", folder=small.folder)
    assert frame.manifest["digits"] == 34
    assert list(frame.events.columns[:3]) == ["name", "t", "direction"]
    assert frame.events["direction"].isin([-1, 1]).all()
    assert frame.events["t"].is_monotonic_increasing
    assert type(frame[["t", "theta"]]) is pandas.DataFrame


def test_text_is_as_published(small: Small) -> None:
    frame = tt.golden.load("reference", "text", folder=small.folder)
    assert frame["kx"].iloc[0] == "9.983341664682815230681419841062203e-2"
    assert frame["t"].iloc[1] == "0.01"


def test_mpmath_numbers_keep_all_digits(small: Small) -> None:
    numbers = tt.golden.load("reference", "native", folder=small.folder)
    text = tt.golden.load("reference", "text", folder=small.folder)
    context = numbers["kx"].iloc[0].context
    for value, cell in zip(numbers["kx"], text["kx"], strict=True):
        assert Decimal(context.nstr(value, 34)) == Decimal(cell)


@pytest.mark.parametrize("numbers", ["float", "native", "mpmath"])
def test_undefined_entries_are_missing(numbers: Numbers) -> None:
    frame = tt.golden.load("upright", numbers)
    assert frame["phi_dot"].isna().all()
    assert not frame["omega_3"].isna().any()


def test_a_changed_digit_is_not_loaded(small: Small) -> None:
    path = small.folder / "reference" / TRAJECTORY
    path.write_text(path.read_text().replace("9.98334166468281523068", "9.98334166468281523067"))
    with pytest.raises(InputError, match=r"trajectory.csv got changed.*golden verify"):
        tt.golden.load("reference", folder=small.folder)


def test_unknown_scenes_and_kinds_are_refused(small: Small) -> None:
    with pytest.raises(InputError, match="expected one of: reference"):
        tt.golden.load("nowhere", folder=small.folder)
    with pytest.raises(InputError, match="expected one of: native, float, text"):
        tt.golden.load("reference", "decimal", folder=small.folder)  # type: ignore[arg-type]
