"""The registry of cases, and what counts as a failure: NaN does, whichever entry it is."""

from __future__ import annotations

import math
import os
import subprocess
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy
import pytest
from msgspec import to_builtins

from tt_precise.extremes import case as registry
from tt_precise.extremes import geometry, horizons, sensitivity
from tt_precise.extremes.case import NotFiniteError
from tt_precise.integration import integrate


def one(function: Any = registry.CaseOutcome, name: str = "name", **arguments: Any) -> Any:
    arguments = arguments or {"measured": "well"}
    # a machine under load may take minutes to start a worker
    family = registry.Family("topic", name, "theory", function, {}, limit_s=3600)
    return registry.ExtremeCase(family, arguments)


def test_what_goes_wrong_fails_alone_in_one_line() -> None:
    hanging = one(subprocess.run, "hangs", args=["sleep", "600"])
    hanging = replace(hanging, family=replace(hanging.family, limit_s=0.2))
    chosen = [
        one(name="first"),
        hanging,
        one(os._exit, "crashes", status=3),
        one(int, "raises", x="two\nlines" + "x" * 1000),
        one(name="not a number", measured="well", value=math.nan),
        one(name="infinite", measured="well", steps=math.inf),
        one(name="last"),
    ]
    fractions: list[float] = []
    records = registry.run_all(chosen, fractions.append, workers=2)
    assert [record.name for record in records] == [case.name for case in chosen]
    assert [record.verdict for record in records] == ["pass", *["fail"] * 5, "pass"]
    for record, said in zip(
        records[1:4], ("after 0.2 s", "exit status 3", "TypeError: "), strict=True
    ):
        assert said in record.found
    assert fractions[-1] == 1
    failed = registry.failure("two\nlines" + "x" * 1000)
    assert failed.measured.startswith("two lines")
    assert len(failed.measured) <= 200


def test_findings_of_a_case_are_one() -> None:
    held = [registry.within(value, 3, "eps").holds for value in (3, 3.1, math.nan)]
    assert held == [True, False, False]
    assert registry.equal("complete", "complete").holds
    assert registry.equal("pole", "complete").measured == "pole, not complete"
    both = registry.merged((registry.within(1, 2), registry.equal("a", "b")))
    assert (both.holds, both.value) == (False, 1)
    assert both.measured == "1 (allowed: 2); a, not b"
    both = registry.merged((registry.equal("a", "a"), registry.within(3, 4)))
    assert (both.holds, both.value) == (True, 3)
    assert one(registry.merged, "nothing", findings=()).outcome().verdict == "fail"
    drawn = registry.merged((registry.CaseOutcome("a", data={"x": 1.0}), registry.CaseOutcome("b")))
    assert drawn.data == {"x": 1.0}
    assert registry.finite([1.0, None, 2]) == [1.0, 2]
    with pytest.raises(registry.NotFiniteError):
        registry.finite([1.0, math.nan])


def test_over_makes_a_case_of_each_combination(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_registered", {})

    @registry.case(
        "k = {k}, {word}",
        source="theory",
        control={"truth": "c"},
        over={"k": (1, 2), "word": ("a", "b")},
    )
    def echo(k: int, word: str, truth: str = "") -> registry.Findings:
        """The word comes
        back."""
        return registry.equal(truth or word, word)

    made = list(registry._registered.values())
    assert [case.name for case in made] == ["k = 1, a", "k = 1, b", "k = 2, a", "k = 2, b"]
    outcomes = [case.outcome() for case in made]
    assert [outcome.verdict for outcome in outcomes] == ["pass"] * 4
    assert outcomes[0].expected == "The word comes back."
    assert made[0].outcome(**made[0].family.control).verdict == "fail"
    (family,) = registry.families(outcomes)
    ((name, _, _),) = registry.family_rows(family)
    assert name == "k = …, … (4 cases)"
    with pytest.raises(ValueError, match="got it twice"):
        registry.case("k = 1, a", source="s", control={})(echo)


def test_the_document_has_the_agreed_keys() -> None:
    printed = to_builtins(registry.Extremes.of([one().outcome()]))
    assert printed["verdict"] == "pass"
    assert {"name", "expected", "found", "verdict", "value"} <= printed["cases"][0].keys()
    failed = registry.Extremes.of([one().outcome(), one(measured="badly", holds=False).outcome()])
    assert failed.verdict == "fail"


def test_a_failed_case_has_the_row_of_its_family() -> None:
    good, bad = one().outcome(), one(measured="badly", holds=False).outcome()
    assert registry.family_rows([good, bad, good]) == [(bad.name, "badly", bad)]


class Spoiled:
    """A trajectory whose states have NaN in place of one entry."""

    def __init__(self, run: Any, entry: str):
        self._run, self._entry = run, entry

    def __getattr__(self, name: str) -> Any:
        return getattr(self._run, name)

    @property
    def state(self) -> Any:
        return self._without(self._run.state)

    def at(self, t: Any) -> Any:
        return self._without(self._run.at(t))

    def _without(self, state: Any) -> Any:
        return SimpleNamespace(**{**dict(state.values), self._entry: math.nan})


@pytest.mark.parametrize(
    ("case", "arguments", "entry"),
    [
        (horizons.sampling, ("1e-9", "1e-8"), "kx"),
        (horizons.sampling, ("1e-9", "1e-8"), "vy"),
        (horizons.no_time_at_all, ("0", "double"), "theta_dot"),
        (horizons.no_time_at_all, ("0", "double"), "nu_y"),
        (geometry.start_at_a_pole, ("0", "double"), "kx"),
        (geometry.start_at_a_pole, ("0", "double"), "vy"),
    ],
)
def test_a_nan_in_a_state_fails_the_case(
    case: Any, arguments: tuple[Any, ...], entry: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert registry.merged(case(*arguments)).holds

    def spoiled(*given: Any, **options: Any) -> Spoiled:
        return Spoiled(integrate(*given, **options), entry)

    if case is geometry.start_at_a_pole:
        monkeypatch.setattr(geometry, "integrate", spoiled)
    else:
        arguments = (*arguments, spoiled)
    with pytest.raises(NotFiniteError):
        case(*arguments)


def test_a_nan_in_an_integral_fails_the_case(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("theta_dot", *horizons.LONG["frictionless"])
    columns = {name: numpy.array([1e-30, 1e-30]) for name in names}
    found = "complete", numpy.array([0.0, 1.0]), columns
    monkeypatch.setattr(horizons, "_sampled", lambda *_: found)
    assert registry.merged(horizons.long_run("frictionless", "1e3")).holds
    columns["E"][1] = math.nan
    with pytest.raises(NotFiniteError):
        horizons.long_run("frictionless", "1e3")


def test_a_nan_in_a_derivative_fails_the_case(monkeypatch: pytest.MonkeyPatch) -> None:
    how = sensitivity._sensitivity("contact-lost")
    transitions = numpy.array(how.transitions)
    transitions[-1] = math.nan
    spoiled = replace(how, transitions=transitions)
    monkeypatch.setattr(sensitivity, "_sensitivity", lambda _: spoiled)
    with pytest.raises(NotFiniteError):
        sensitivity.lambda_propagated("contact-lost")
