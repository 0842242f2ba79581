"""The smallest amount of a planted fault that fails."""

from pathlib import Path

import pandas
import pytest

from benchmarks import fault_amounts
from benchmarks.fault_amounts import Fault, faults, markdown, right, smallest


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_nothing_wrong_does_not_fail(friction: str) -> None:
    assert smallest(Fault("nothing", lambda hertz, amount: right(hertz)), 240, friction) is None


def test_a_clock_is_seen_in_small_amounts() -> None:
    (clock,) = (one for one in faults() if one.name == "the clock")
    found = smallest(clock, 240, "other")
    assert found is not None
    assert found <= 1e-3


def test_the_table_of_the_documentation_is_the_measured_one() -> None:
    found = pandas.read_csv(fault_amounts.OUT)
    page = Path("docs/explanation/measured.md").read_text("utf-8")
    assert [one.name for one in faults()] == found["fault"].tolist()
    assert markdown(found) in page
