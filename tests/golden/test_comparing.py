"""A trajectory is as far from golden data as it was put there."""

import math
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.golden.conftest import Small
from tt_precise.runtime.values import InputError


def loaded(small: Small) -> pandas.DataFrame:
    return pandas.DataFrame(tt.golden.load("reference", folder=small.folder))


def compared(small: Small, frame: pandas.DataFrame) -> tt.golden.Comparison:
    return tt.golden.compare(frame, "reference", folder=small.folder)


def with_entry(frame: pandas.DataFrame, row: int, name: str, value: object) -> pandas.DataFrame:
    column = frame[name].to_list()
    column[row] = value
    return frame.assign(**{name: pandas.Series(column, dtype=object)})


@pytest.mark.parametrize("kind", ["text", "float", "exact"])
def test_rounded_numbers_agree_as_far_as_they_hold(small: Small, kind: Any) -> None:
    comparison = compared(small, tt.golden.load("reference", kind, folder=small.folder))
    # half an ulp of double is 1.1e-16 of its number
    least, most = (34, 34) if kind in ("exact", "text") else (15.9, 17.5)
    assert least <= comparison.worst <= most
    assert (len(comparison.over_time), comparison.unmatched) == (7, 0)


def test_an_error_shows_in_its_column_at_its_time(small: Small) -> None:
    frame = loaded(small)
    frame = with_entry(frame, 3, "omega_3", frame["omega_3"].to_list()[3] * (1 + 1e-7))
    comparison = compared(small, frame)
    assert comparison.digits["omega_3"] == pytest.approx(7, abs=1e-3)
    assert comparison.digits.drop("omega_3").min() > 15
    assert comparison.over_time["t"].to_list()[comparison.over_time["omega_3"].argmin()] == 0.03


@pytest.mark.parametrize(
    ("row", "name", "value", "digits"),
    [
        # exactly 0 is right, omega_3 = 155 rad/s
        (0, "theta_dot", 155e-9, 9),
        *((2, "theta", missing, 0) for missing in (math.nan, math.inf, None, "")),
    ],
)
def test_near_a_zero_the_angular_velocity_decides_and_what_is_missing_has_no_digits(
    small: Small, row: int, name: str, value: object, digits: int
) -> None:
    comparison = compared(small, with_entry(loaded(small), row, name, value)).digits[name]
    assert comparison == pytest.approx(digits, abs=1e-2 if digits else 0)


def test_a_trajectory_or_a_mapping_is_compared_as_its_table() -> None:
    run = tt.integrate("reference", "quad", until="0.05")
    assert tt.golden.compare(run, "reference").worst > 25
    columns = {"t": [0.0, 0.01], "omega_3": run.frame("omega_3")["omega_3"].to_list()[:2]}
    assert list(tt.golden.compare(columns, "reference").digits.index) == ["omega_3"]
    with pytest.raises(InputError, match="columns: got 0, expected t and any of: "):
        tt.golden.compare([1.0], "reference")


def test_rows_between_golden_times_are_compared_with_an_integration(small: Small) -> None:
    times = [0.0, 0.004, 0.0161, 0.05 + 1e-12, 0.07]
    frame = tt.integrate(small.scene, "quad").frame(times=times[:4], numbers="exact")
    beyond = frame.iloc[[3]].assign(t=times[4])
    comparison = compared(small, pandas.concat([frame, beyond]))
    assert (comparison.unmatched, len(comparison.over_time)) == (1, 4)
    assert comparison.worst > 8
    late = frame.assign(t=[0.0, 0.004, 0.0161 + 1e-6, 0.05])
    assert compared(small, late).worst < 7


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ({"time": [0.0], "theta": [0.1]}, "expected t and any of: kx, ky"),
        ({"t": [0.1], "theta": [0.1]}, "expected times between 0 and 0.06 s"),
        ({"t": [0.0], "theta": ["one"]}, "got 'one', expected a number"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    small: Small, frame: dict[str, list[object]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        compared(small, pandas.DataFrame(frame))
