"""A body without symmetry in its numbers, and seeded states, as exact fractions."""

import random
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import mpmath
import pytest

from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.scene.body import TippeTop
from tt_precise.scene.numerals import to_mpmath

DIGITS = 60


@pytest.fixture
def body() -> TippeTop:
    """Parameters all different from 1 and from each other, so that a missing factor shows."""
    return TippeTop.from_ratios(
        m="1.7", R="0.6", alpha="0.3", I1="0.37", I3="0.41", g="9.82", mu="0.23"
    )


@pytest.fixture
def mp() -> Any:
    """An mpmath context of 60 digits."""
    context = mpmath.MPContext()
    context.dps = DIGITS
    return context


@pytest.fixture
def rounded(mp: Any) -> Callable[[Fraction], Any]:
    """Fractions to numbers of ``mp``."""
    return lambda value: to_mpmath(value, mp)


def draw(seed: int) -> Callable[[], Fraction]:
    """A source of fractions between -2 and 2."""
    source = random.Random(seed)
    return lambda: Fraction(source.randint(-2000, 2000), 1000)


@pytest.fixture
def states() -> list[NewtonState]:
    """States with an exactly rational unit axis, anywhere on the sphere."""
    states = []
    for seed in range(8):
        number = draw(100 + seed)
        a, b = number(), number()
        n = 1 + a * a + b * b
        axis = (2 * a / n, 2 * b / n, (1 - a * a - b * b) / n)
        states.append(NewtonState(*axis, *(number() for _ in range(5))))
    return states


def slopes(function: Callable[[Any], Sequence[Any]], state: Any, rates: Any, mp: Any) -> list[Any]:
    """Derivatives of what a function of a state returns along its rates, by central differences.

    A step of 1e-20 errs by 1e-40 times a third derivative (up to 1e4).
    """
    h = mp.mpf(10) ** -20
    ahead, behind = (
        function(type(state)(*(x + step * r for x, r in zip(state, rates, strict=True))))
        for step in (h, -h)
    )
    return [(a - b) / (2 * h) for a, b in zip(ahead, behind, strict=True)]


@pytest.fixture
def numbers(body: TippeTop, rounded: Callable[[Fraction], Any]) -> Parameters:
    """The body in numbers of ``mp``."""
    return body.numbers(rounded)
