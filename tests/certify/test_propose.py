"""Lengths of steps: they end at the horizon, fall with the costs of a step, and give up."""

from types import SimpleNamespace
from typing import Any

import pytest
from flint import arb

from tt_precise.certify.balls import NotProved
from tt_precise.certify.propose import LONGER, MOST_FAILURES, Proposer

EQUATIONS: Any = SimpleNamespace(order=40, bits=200)
# defect, error of the flow, growth of errors: all far below their bounds
FREE = (2.0**-250, 1e-12, 1.0 + 1e-9)


def step(length: float, costs: tuple[float, float, float]) -> Any:
    return SimpleNamespace(length=arb(length), costs=costs, equations=EQUATIONS)


def size(proposer: Proposer, left: float = 1e9) -> float:
    """The length of the next step in the problem's unit of time."""
    power, length = proposer.next(left)
    return float(length) * 2.0**power


def test_a_step_ends_just_beyond_the_horizon() -> None:
    assert size(Proposer(EQUATIONS), left=1e-3) == pytest.approx(1e-3, rel=1e-5)
    assert size(Proposer(EQUATIONS), left=1e-3) >= 1e-3


def test_a_cheap_step_is_followed_by_a_longer_one_and_a_dear_one_is_made_again() -> None:
    proposer = Proposer(EQUATIONS)
    power, length = proposer.next(1e9)
    assert proposer.accepts(step(float(length), FREE))
    assert size(proposer) == pytest.approx(LONGER * float(length) * 2.0**power, rel=1e-5)
    for costs in ((1.0, *FREE[1:]), (FREE[0], 1.0, FREE[2]), (*FREE[:2], 1e30)):
        proposer = Proposer(EQUATIONS)
        power, length = proposer.next(1e9)
        assert not proposer.accepts(step(float(length), costs))
        assert size(proposer) < 0.8 * float(length) * 2.0**power


def test_steps_that_do_not_verify_are_halved_until_none_helps() -> None:
    proposer = Proposer(EQUATIONS)
    first = size(proposer)
    for failures in range(MOST_FAILURES):
        proposer.shorten(ArithmeticError("the tube is left"))
        assert size(proposer) == pytest.approx(first / 2.0 ** (failures + 1), rel=1e-5)
    with pytest.raises(NotProved, match="the tube is left"):
        proposer.shorten(ArithmeticError("the tube is left"))


def test_a_short_rest_is_one_step_in_a_unit_of_its_own() -> None:
    power, length = Proposer(EQUATIONS).next(1e-12)
    assert 1 / 16 <= length <= 1 / 2
    assert 1e-12 < float(length) * 2.0**power < 1e-8
