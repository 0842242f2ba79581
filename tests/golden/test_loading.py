"""Loaded numbers are the printed ones, with events and manifest."""

from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.golden.conftest import Small
from tt_precise.golden import store
from tt_precise.runtime.values import InputError


@pytest.mark.parametrize("numbers", ["float", "exact", "text"])
def test_numbers_are_those_of_the_tables(small: Small, numbers: Any) -> None:
    table = store.read_files("reference", small.folder).trajectory
    frame = tt.golden.load("reference", numbers, folder=small.folder)
    for name in table.columns:
        for value, cell in zip(frame[name], table.column(name), strict=True):
            kind = {"float": float, "text": str}.get(numbers) or value.context.mpf
            assert value == kind(cell)


def test_a_frame_has_events_and_manifest(small: Small) -> None:
    frame = tt.golden.load("reference", folder=small.folder)
    assert frame.manifest["digits"] == 34
    assert list(frame.events.columns[:3]) == ["name", "t", "direction"]
    assert type(frame[["t", "theta"]]) is pandas.DataFrame
    frame.manifest["digits"] = 0
    assert tt.golden.load("reference", folder=small.folder).manifest["digits"] == 34


def test_undefined_entries_are_missing() -> None:
    frame = tt.golden.load("upright")
    assert frame["phi_dot"].isna().all()
    assert not frame["omega_3"].isna().any()


def test_unknown_scenes_and_kinds_are_refused(small: Small) -> None:
    with pytest.raises(InputError, match="expected one of: reference"):
        tt.golden.load("nowhere", folder=small.folder)
    with pytest.raises(InputError, match="expected one of: exact, float, text"):
        tt.golden.load("reference", "decimal", folder=small.folder)  # type: ignore[arg-type]
