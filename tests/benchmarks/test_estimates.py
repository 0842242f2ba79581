"""What is claimed of errors holds on random scenes, and a false claim is found."""

from dataclasses import replace
from fractions import Fraction

import pytest

from benchmarks import estimates
from benchmarks.work_precision.findings import OPTIMISM, TradeoffTables, findings
from tt_precise.integration import integrate

SAMPLE = (0, 3, 6, 14)  # gliding, rolling, one that leaves the table; 5 to 12 digits


@pytest.mark.parametrize("seed", SAMPLE)
def test_digits_are_delivered_and_estimated(seed: int) -> None:
    found = estimates.row(estimates.sample(seed))
    assert found["right"] >= found["wanted"]
    assert found["right"] - 1 <= found["estimated"] <= found["right"] + OPTIMISM


def test_a_spoiled_truth_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A comparison that ignores the rounding of mu: 1e-9 off, and nobody noticed."""
    one = estimates.sample(SAMPLE[0])
    body = replace(one.scene.body, mu=one.scene.body.mu * (1 + Fraction(1, 10**6)))
    wrong = integrate(replace(one.scene, body=body), digits=one.wanted)
    wrong.scene = one.scene
    assert wrong.digits_throughout - estimates.right_throughout(wrong) > OPTIMISM


@pytest.mark.slow
def test_estimates_of_a_thousand_cases_are_not_optimistic() -> None:
    found = estimates.table()
    print(*findings(TradeoffTables(None, estimates=found)), sep="\n")
    ran = found[found["status"] != "raised"]
    assert len(ran) > 0.99 * estimates.SAMPLES
    assert (ran["right"] >= ran["wanted"]).all()
    excess = ran["estimated"] - ran["right"]
    assert excess.max() <= OPTIMISM
