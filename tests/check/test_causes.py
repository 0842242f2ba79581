"""Causes: each hypothesis of the table is named where it holds, and no other one."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check, rows_of
from tests.conftest import more
from tt_precise.check import causes
from tt_precise.check.causes import FailedRows, Hypothesis, power, with_change
from tt_precise.check.checks import DEFAULT_LIMITS, judge
from tt_precise.check.rows import Rows
from tt_precise.runtime.values import Check


def named(frame: pandas.DataFrame, scene: str = "reference", **options: Any) -> list[str]:
    result = check(frame, scene, **options)
    assert result.verdict == "fail", str(result)
    return [f"{cause.kind}: {cause.text}" for cause in result.causes]


@pytest.mark.parametrize("name", ["g", more("m"), "R", more("alpha"), "I1", more("I3"), "mu"])
def test_one_wrong_number_is_named(name: str) -> None:
    scene = tt.load_scene("reference")
    number = getattr(scene.body, name) * Fraction("1.01")
    other = replace(scene, body=replace(scene.body, **{name: number}))
    rows = tt.integrate(other, until="2").frame(*VECTORS[1:])
    found = check(rows, "reference")
    texts = [cause.text for cause in found.causes]
    # the start of another body is another one; L scales with m and R
    if texts:
        assert f"{name} is 1.010" in texts[0]
        assert found.causes[0].kind == "parameter"
    else:
        assert found["start"].verdict == "fail"
    assert texts or name in ("m", "R", "alpha", "I1", "I3")


def test_a_fast_clock_and_another_start_are_named(healthy: Healthy) -> None:
    frame = healthy("reference", 201, 2)[VECTORS]
    fast = frame.assign(t=1.01 * frame["t"])
    assert named(fast) == ["clock: t runs 1.0100 times as fast as the motion"]
    other = tt.integrate(tt.load_scene("reference").varied(omega_3="154.9"), until="1").frame()
    assert named(other)[0].startswith("start: another start than the scene's (Lz")
    assert check(other, "reference", start="other").passed


def test_few_digits_are_named(healthy: Healthy) -> None:
    frame = healthy("reference", 201, 2)[VECTORS]
    frame = frame.map(lambda x: float(f"{x:.3g}"))
    result = check(frame, "reference")
    assert result.verdict == "incomplete"
    assert [(one.kind, one.text) for one in result.causes] == [
        ("precision", "the columns are rounded to some 2 digits: write 17")
    ]
    assert result.written == "some 3 digits"


@pytest.mark.parametrize(
    "change",
    [
        lambda f: f.assign(Lz=f["Lz"] * numpy.where(f["t"] > 1, 1.001, 1.0)),  # from 1 s on
        lambda f: f.assign(vx=f["vx"] + 1e-3 * (f["t"] == 1)),  # one row
        lambda f: f.assign(t=1.01 * f["t"], Lz=1.001 * f["Lz"]),  # two causes
        lambda f: f.assign(vy=0.0 * f["vy"]),
    ],
)
def test_what_no_hypothesis_explains_has_no_cause(
    healthy: Healthy, change: Callable[[pandas.DataFrame], pandas.DataFrame]
) -> None:
    frame = change(healthy("reference", 201, 2)[VECTORS])
    assert [text for text in named(frame) if not text.startswith("start")] == []
    assert "not explained" in str(check(frame, "reference", start="other"))


def rest(rows: Rows, before: list[Check], after: list[Check]) -> float:
    """Return the rest of a hypothesis that changes nothing, whose checks are ``after``."""
    failure = FailedRows(rows, before, lambda rows: iter(after))
    return failure.rest(Hypothesis("parameter", "", lambda rows: rows))


def test_a_hypothesis_leaves_a_part_of_a_failure(healthy: Healthy) -> None:
    rows = rows_of(healthy("reference", 51, 0.5)[VECTORS])
    passed = [Check("equations", "pass", 0.0, 1e-6)]
    for before, after, part in (
        (1.0, 0.0, 0.0),
        (2e-6, 5e-7, numpy.inf),  # passes, but leaves a quarter: another number may too
        (1.0, 0.02, 0.02),
        (1.0, numpy.nan, numpy.inf),
    ):
        left = [Check("equations", "pass" if after <= 1e-6 else "fail", after, 1e-6)]
        assert rest(rows, [Check("equations", "fail", before, 1e-6)], left) == part
        # a check that passed before must not fail
        assert (rest(rows, passed, left) < 1) == (after <= 1e-6)
    # without a deciding check nothing is explained
    before_, open_ = Check("jellett", "fail", 1.0, 1e-6), Check("equations", "open")
    for after_, part in ((open_, numpy.inf), (passed[0], 0.0)):
        assert rest(rows, [before_, open_], [Check("jellett", "pass", 0.0, 1e-6), after_]) == part


def test_of_conventions_the_one_that_leaves_nothing_is_named(healthy: Healthy) -> None:
    rows = rows_of(healthy("reference", 51, 0.5)[VECTORS])
    rests = {"a": 0.05, "b": 0.02, "c": 0.0, "d": 0.2}

    class Asked(FailedRows):
        def rest(self, hypothesis: Hypothesis) -> float:
            return rests[hypothesis.text]

    def best(names: str) -> str | None:
        changes: Iterator[Any] = ((name, lambda rows: rows) for name in names)
        found = causes._best(Asked(rows, [], lambda rows: iter([])), changes)
        return found and found.text

    assert [best(names) for names in ("abcd", "abd", "d", "")] == ["c", "b", None, None]


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_the_power_of_a_pass_is_true(healthy: Healthy, friction: str) -> None:
    """A change half as large again as the power fails; a tenth of it passes."""
    rows = rows_of(healthy("reference", 241, 0.5)[VECTORS], friction=friction)
    sizes = power(rows)
    assert {"g", "alpha", "clock"} <= {*sizes}
    deciding = {"scene": ["equations"], "other": ["kinematics", "contact_momentum"]}[friction]
    for name, size in sizes.items():
        for factor, fails in ((1.5, True), (0.05, False)):
            few = with_change(rows.part(slice(0, causes.FEW)), name, factor * size)
            with numpy.errstate(all="ignore"):
                checks = {check.name: check for check in judge(few, DEFAULT_LIMITS)}
            assert any(checks[one].verdict == "fail" for one in deciding) == fails, (name, factor)


def test_rows_that_do_not_resolve_the_force_have_no_power(healthy: Healthy) -> None:
    result = check(healthy("reference", 81, 8)[VECTORS], "reference", friction="other")
    assert result.passed  # the scene's own rows
    assert result.would_have_seen == {}
    assert "would have seen" not in str(result)
    scene = check(healthy("reference", 81, 8)[VECTORS], "reference")
    assert 0 < scene.would_have_seen["g"] < 1e-4
    assert f"g {100 * scene.would_have_seen['g']:.1g} %" in str(scene)
