"""What contact_velocity says where the contact point leaves the table."""

from __future__ import annotations

from collections.abc import Callable

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import Healthy


@pytest.fixture
def frame(healthy: Healthy, rigid_body: Callable[[pandas.DataFrame], pandas.DataFrame]) -> Healthy:
    return lambda *size: rigid_body(healthy("reference", *size))


def contact_velocity(frame: pandas.DataFrame, scene: str | tt.Scene = "reference") -> str:
    found = tt.check.conservation(frame, scene, friction="other")["contact_velocity"]
    assert (found.note == "") == (found.verdict == "pass")
    return found.note


def test_a_soft_contact_is_recognised_and_the_limit_that_is_named_is_enough(
    frame: Healthy, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert contact_velocity(frame()) == ""
    soft = frame(801, 1)
    # sinks and rises by 20 um, 30 times a second
    soft["vcz"] += 1e-5 * 190 * numpy.cos(190 * soft["t"])
    said = contact_velocity(soft)
    assert said.startswith("it sinks and rises by 2e-05 m, as a soft contact does")
    limit = float(said.rpartition("=")[2])
    assert limit < 1e-2
    limits = {"contact_velocity": limit}
    found = tt.check.conservation(soft, "reference", friction="other", limits=limits)
    assert found["contact_velocity"].verdict == "pass"
    monkeypatch.setattr("tt_precise.check.sources.BLOCK_ROWS", 50)
    assert contact_velocity(soft) == said


def test_another_arm_is_recognised(frame: Healthy) -> None:
    """The rows have alpha R = 6 mm; 1 per cent is too little for the guard of units."""
    said = contact_velocity(frame(), tt.load_scene("reference").varied(alpha="0.303"))
    assert said == (
        "its height follows the axis: alpha R = 0.006 m would keep it on the table, the scene "
        "has 0.00606 m"
    )


def test_a_top_that_flies_is_no_soft_contact(frame: Healthy) -> None:
    flying = frame(801, 1)
    flying["vcz"] += 0.1 * flying["t"]  # 5 cm high in the end
    assert tt.check.conservation(flying, "reference", friction="other")[
        "contact_velocity"
    ].note == ""  # fmt: skip
