"""A case whose output is not a number fails, whichever entry it is: ``max`` passes over NaN."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy
import pytest

from tt_precise.extremes import geometry, horizons, sensitivity
from tt_precise.extremes.case import NotFiniteError
from tt_precise.integration import integrate


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


def spoiling(entry: str) -> Any:
    return lambda *arguments, **options: Spoiled(integrate(*arguments, **options), entry)


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
def test_an_entry_of_a_state(
    case: Any, arguments: tuple[str, ...], entry: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert case(*arguments).holds
    spoiled = spoiling(entry)
    if case is geometry.start_at_a_pole:
        monkeypatch.setattr(geometry, "integrate", spoiled)
        spoiled = ""
    with pytest.raises(NotFiniteError):
        case(*arguments, spoiled)


def test_an_integral_of_a_long_run(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("theta_dot", *horizons.LONG["frictionless"])
    columns = {name: numpy.array([1e-30, 1e-30]) for name in names}
    found = "complete", numpy.array([0.0, 1.0]), columns
    monkeypatch.setattr(horizons, "_sampled", lambda *_: found)
    assert horizons.long_run("frictionless", "1e3").holds
    columns["E"][1] = math.nan
    with pytest.raises(NotFiniteError):
        horizons.long_run("frictionless", "1e3")


def test_derivatives(monkeypatch: pytest.MonkeyPatch) -> None:
    how = sensitivity._sensitivity("contact-lost")
    transitions = numpy.array(how.transitions)
    transitions[-1] = math.nan
    spoiled = replace(how, transitions=transitions)
    monkeypatch.setattr(sensitivity, "_sensitivity", lambda _: spoiled)
    with pytest.raises(NotFiniteError):
        sensitivity.lambda_carried_along("contact-lost")
