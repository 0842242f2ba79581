"""Test that wrong code fails, in a process of its own: equations are compiled once."""

import math
import subprocess
import sys
from types import SimpleNamespace
from typing import Any

import pytest

from tests.conftest import more
from tests.extremes.faults import FAULTS, coarse_tolerance
from tt_precise.extremes import cases, judges
from tt_precise.extremes.judges import EdgeCase, conserves, is_refused, judge_value


@pytest.mark.parametrize("fault", [f if f is coarse_tolerance else more(f) for f in FAULTS])
def test_a_fault_makes_cases_fail(fault: Any) -> None:
    words = [sys.executable, "-m", "tests.extremes.faults", fault.__name__, *FAULTS[fault]]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert set(done.stdout.splitlines()) == set(FAULTS[fault])


@pytest.mark.parametrize("value", [10.1, -1.0, math.inf, math.nan])
def test_a_value_beyond_the_limit_fails(value: float) -> None:
    run: Any = SimpleNamespace(status="complete")
    assert judge_value(10.0, cases()[0], "eps", run).passes
    assert not judge_value(value, cases()[0], "eps", run).passes
    assert not judge_value(1.0, cases()[0], "eps", SimpleNamespace(status="pole")).passes  # type: ignore[arg-type]


def test_neither_nan_nor_another_refusal_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not is_refused(EdgeCase("contact", "a name", is_refused, {"nonsense": "1"})).passes
    run, drift = SimpleNamespace(precision=SimpleNamespace(eps=1e-16)), {"E": 0.0, "L_z": math.nan}
    vars(run).update(drift=drift, steps=1, status="complete")
    monkeypatch.setattr(judges, "integrate", lambda *_, **__: run)
    assert not conserves(EdgeCase("contact", "a name", conserves, {}, 1)).passes
