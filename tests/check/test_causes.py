"""Causes: each hypothesis of the table is named where it holds, and no other one."""

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import POSE, VECTORS, check, rows_of, vectors
from tests.conftest import Patch, more
from tt_precise.check import causes
from tt_precise.check.causes import FailedRows, Hypothesis, power, with_change
from tt_precise.check.checks import DEFAULT_LIMITS, judge
from tt_precise.runtime.values import Check

Change = Callable[[pandas.DataFrame], pandas.DataFrame]


def named(frame: pandas.DataFrame) -> list[tuple[str, str]]:
    result = check(frame, "reference")
    assert result.verdict == "fail", str(result)
    return [(cause.kind, cause.text) for cause in result.causes]


@pytest.mark.parametrize("name", ["g", more("m"), "R", more("alpha"), "I1", more("I3"), "mu"])
def test_one_wrong_number_is_named(name: str) -> None:
    scene = tt.load_scene("reference")
    body = replace(scene.body, **{name: getattr(scene.body, name) * Fraction("1.01")})
    rows = tt.integrate(replace(scene, body=body), until="2").frame(*VECTORS[1:])
    result = check(rows, "reference")
    # the start of another body is another one; L scales with m and R
    if not result.causes:
        assert result["start"].verdict == "fail"
        assert name in ("m", "R", "alpha", "I1", "I3")
    for cause in result.causes:
        assert cause.kind == "parameter"
        assert f"{name} is 1.010" in cause.text


def test_a_fast_clock_and_another_start_are_named() -> None:
    fast = vectors(201).assign(t=lambda frame: 1.01 * frame["t"])
    assert named(fast) == [("clock", "t runs 1.0100 times as fast as the motion")]
    other = tt.integrate(tt.load_scene("reference").varied(omega_3="154.9"), until="1").frame()
    ((kind, text),) = named(other)
    assert kind == "start"
    assert text.startswith("another start than the scene's (Lz")


def test_a_number_that_does_almost_as_well_is_named_too() -> None:
    scene = tt.load_scene("phi-dot-195").varied(sample_every="1/240", until="0.4")
    body = replace(scene.body, I1=scene.body.I1 * Fraction("1.0001"))
    rows = tt.integrate(replace(scene, body=body), events=(), record=("x", "y")).frame(*POSE[1:])
    (cause,) = check(rows, "phi-dot-195", friction="other").causes
    assert cause.text.startswith("I1 is 1.000099 times the scene's, or I3 is 0.99990")


def test_few_digits_are_named() -> None:
    result = check(vectors(201).map(lambda x: float(f"{x:.3g}")), "reference")
    assert result.verdict == "incomplete"
    assert [(each.kind, each.text) for each in result.causes] == [
        ("precision", "the columns are rounded to some 2 digits: write 17")
    ]
    assert result.written == "some 3 digits"


@pytest.mark.parametrize(
    "change",
    [
        lambda f: f.assign(Lz=f["Lz"] * numpy.where(f["t"] > 1, 1.001, 1.0)),
        lambda f: f.assign(vx=f["vx"] + 1e-3 * (f["t"] == 1)),
        lambda f: f.assign(t=1.01 * f["t"], Lz=1.001 * f["Lz"]).round(9),
        lambda f: f.assign(vy=0.0 * f["vy"]),
        lambda f: f.assign(**{name: f[name][0] for name in VECTORS[1:]}),
    ],
    ids=["from 1 s on", "one row", "two causes", "no velocity", "at rest"],
)
def test_a_failure_without_a_hypothesis_has_no_cause(change: Change) -> None:
    frame = change(vectors(201))
    assert named(frame) == []
    assert "not explained" in str(check(frame, "reference", start="other"))


def of(verdict: Any, value: float | None = None, name: str = "equations") -> Check:
    return Check(name, verdict, value, 1e-6)


FAILED, PASSED, OPEN = of("fail", 1.0), of("pass", 0.0), of("open")
DRIFT, CONSTANT = of("fail", 1.0, "jellett"), of("pass", 0.0, "jellett")


@pytest.mark.parametrize(
    ("before", "after", "rest"),
    [
        ([FAILED], [PASSED], 0.0),
        ([FAILED], [of("fail", 0.02)], 0.02),
        ([FAILED], [of("fail", numpy.nan)], numpy.inf),
        ([of("fail", 2e-6)], [of("pass", 5e-7)], numpy.inf),  # a quarter
        ([PASSED], [FAILED], numpy.inf),  # passed before
        ([DRIFT, OPEN], [CONSTANT, OPEN], numpy.inf),  # no deciding check
        ([DRIFT, OPEN], [CONSTANT, PASSED], 0.0),
    ],
)
def test_a_hypothesis_leaves_a_part(before: list[Check], after: list[Check], rest: float) -> None:
    failure = FailedRows(rows_of(vectors(51)), before, lambda rows: iter(after))
    assert failure.rest(Hypothesis("parameter", "", lambda rows: rows)) == rest


@pytest.mark.parametrize(
    ("rests", "named"), [([0.05, 0.02, 0.0, 0.2], ["2"]), ([0.05, 0.02], ["1"]), ([0.2], [])]
)
def test_the_convention_that_leaves_least_is_named(
    rests: list[float], named: list[str], monkeypatch: Patch
) -> None:
    candidates = [(str(i), lambda rows: rows) for i in range(len(rests))]
    monkeypatch.setattr(causes, "candidates", lambda rows: iter(candidates))
    monkeypatch.setattr(FailedRows, "rest", lambda rows, each: rests[int(each.text)])
    explained = causes.explain(rows_of(vectors(9)), [DRIFT], lambda rows: iter([]))
    assert [each.text for each in explained] == named


@pytest.mark.parametrize("friction", ["scene", "other"])
def test_the_power_of_a_pass_is_true(friction: str) -> None:
    """A change half as large again as the power fails; half of it passes."""
    rows = rows_of(vectors(241, 480), friction=friction)
    sizes = power(rows)
    assert {"g", "alpha", "clock"} <= {*sizes}
    deciding = {"scene": ["equations"], "other": ["kinematics", "contact_momentum"]}[friction]
    for name, size in sizes.items():
        for factor, fails in ((1.5, True), (0.5, False)):
            few = with_change(rows.part(slice(0, causes.FEW)), name, factor * size)
            with numpy.errstate(all="ignore"):
                checks = {check.name: check for check in judge(few, DEFAULT_LIMITS)}
            assert any(checks[each].verdict == "fail" for each in deciding) == fails, (name, factor)


def test_rows_that_do_not_resolve_the_force_have_no_power() -> None:
    other, scene = (check(vectors(81, 10), "reference", friction=f) for f in ("other", "scene"))
    assert other.passed  # the scene's own rows
    assert other.would_have_seen == {}
    assert "would have seen" not in str(other)
    assert 0 < scene.would_have_seen["g"] < 1e-4
    assert f"g {100 * scene.would_have_seen['g']:.1g} %" in str(scene)
