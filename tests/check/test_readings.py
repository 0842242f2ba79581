"""Which readings of columns are tried, and that two at once are one after the other."""

from __future__ import annotations

from itertools import permutations
from typing import Any

import numpy

import tt_precise as tt
from tt_precise.check.units import CONVENTIONS, OMEGA, READINGS, readings


def test_two_conventions_at_once_are_tried_after_each_alone() -> None:
    assert len(CONVENTIONS) > 3
    tried = [name for name, _ in readings()]
    pairs = [f"{one} and {other}" for one, other in permutations(CONVENTIONS, 2)]
    assert tried == [*READINGS, *pairs]
    assert [name for name, _ in readings(alone=True)] == list(READINGS)


def test_of_two_at_once_the_second_reads_what_the_first_gives() -> None:
    one, other = "the quaternion has its scalar last", "the angular velocity is in the body frame"
    body: Any = tt.load_scene("reference").body.numbers(float)
    names = ("qw", "qx", "qy", "qz", *OMEGA)
    given = dict(zip(names, numpy.array([[0.5, 0.1, 0.7, 0.5, 1.0, 2.0, 3.0]]).T, strict=True))
    first = READINGS[one](given, body)
    assert first is not None
    second = READINGS[other]({**given, **first}, body)
    assert second is not None
    both = dict(readings())[f"{one} and {other}"]
    assert both(given, body) == {**first, **second}
    assert both({"t": given["qw"]}, body) is None
