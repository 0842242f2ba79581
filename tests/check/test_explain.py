"""Causes of failures: conventions, one number, precision, rows; nothing where none explains."""

import pandas
import pytest

from tests.check.conftest import VECTORS, Engine, Healthy, check
from tests.check.test_cases import CASES


def causes(frame: pandas.DataFrame, friction: str = "scene") -> str:
    """The causes of a file that does not pass, in one line."""
    found = check(frame, "reference", friction=friction)
    assert found.verdict != "pass"
    return " | ".join(f"{cause.kind}: {cause.text}" for cause in found.causes)


NUMBERS = {
    "no gyroscopic term": "no gyroscopic term",
    "I1 a hundredth more": "I1 is 1.0100 times the scene's",
    "I3 a hundredth more": "I3 is 1.010 times the scene's",
    "gravity is 9": "g is 0.916 times the scene's",
    "alpha a hundredth more": "alpha is 1.010 times the scene's",
    "mass a tenth more": "m is 1.100 times the scene's",
    "mu a tenth more": "mu is 1.100 times the scene's",
    "torsional friction": "about the vertical, as torsional friction is",
}


@pytest.mark.parametrize("fault", NUMBERS)
def test_the_number_is_named(engine: Engine, fault: str) -> None:
    assert NUMBERS[fault] in causes(engine(500, 0.5, fault=fault))


@pytest.mark.parametrize("fault", ["friction pushes"])
def test_what_is_no_number_is_not_named(engine: Engine, fault: str) -> None:
    found = check(engine(500, 0.5, fault=fault), "reference", friction="other")
    assert (found.verdict, found.causes) == ("fail", ())


def test_a_clock_is_named(engine: Engine) -> None:
    frame = engine(60)
    for factor in (1.05, 1.01):
        found = causes(frame.assign(t=factor * frame.t), friction="other")
        assert found == f"clock: t runs {factor:.3f} times as fast as the motion"


def test_a_row_and_a_jump_are_named(healthy: Healthy) -> None:
    frame = healthy("reference", 801)[VECTORS]
    alone = frame.copy()
    alone["Lz"] = alone.Lz.where(alone.index != 400, 1.001 * alone.Lz)
    assert causes(alone) == "rows: the row at t = 4 s (number 401) alone is wrong"
    jump = frame.copy()
    jump.loc[401:, "Lz"] *= 1.001
    assert causes(jump) == "rows: from t = 4.01 s on the rows do not follow"


@pytest.mark.parametrize(
    ("case", "world"), [("unity_left_handed", "left-handed-y-up"), ("yup_body_axis_y", "y-up")]
)
@pytest.mark.parametrize("friction", ["scene", "other"])
def test_a_world_is_named_and_the_file_passes_in_it(case: str, world: str, friction: str) -> None:
    file = CASES / case / "top.csv"
    found = check(file, "reference", friction=friction)
    assert found.verdict == "fail"
    assert {cause.kind for cause in found.causes} == {"convention"}
    text = "; ".join(cause.text for cause in found.causes)
    assert f'world="{world}"' in text
    assert 'axis="y"' in text
    # digits that nobody asked for are not listed as passed
    assert "golden" not in str(found).split("passed:")[1].split("\nopen")[0]
    found = check(file, "reference", friction=friction, world=world, axis="y")
    assert found.failures == ()
