"""Signs of an event's function at a time: told, or said to be undecided there."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

from flint import arb

from tt_precise.certify.balls import NotProved
from tt_precise.certify.interval_newton import _Part


def sign(value: arb) -> int:
    """At 1 in the piece's unit of 1/4, of a step from 2 on."""
    step = SimpleNamespace(begin=arb(2), piece=SimpleNamespace(unit=arb(1) / 4))
    part: Any = SimpleNamespace(_sharp=lambda _: value, step=step)
    return _Part._sign(part, arb(1))


@pytest.mark.parametrize(("value", "expected"), [(arb(1, "0.9"), 1), (arb(-1, "0.9"), -1)])
def test_a_sign_is_told(value: arb, expected: int) -> None:
    assert sign(value) == expected


def test_an_undecided_sign_says_when() -> None:
    with pytest.raises(NotProved, match=r"the sign at t = 2\.25 is undecided"):
        sign(arb(0, 1))
