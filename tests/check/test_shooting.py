"""Solutions followed over a span: closed forms, and an error that is not beyond its bound."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy
import pytest

from tt_precise.check.equations import EPS, MOST_STEPS, follow

ONE = numpy.ones(1)


def oscillator(y: tuple[Any, ...]) -> list[Any]:
    return [y[1], -y[0]]


def growing(y: tuple[Any, ...]) -> list[Any]:
    return [1.0 * y[0]]


def exploding(y: tuple[Any, ...]) -> list[Any]:
    return [y[0] * y[0]]


def test_every_row_ends_after_its_own_span() -> None:
    spans = numpy.array([0.1, 1.0, 15.0])
    start = numpy.array([[1.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
    found = follow(oscillator, start, spans, numpy.ones(2), 1e-9)
    wanted = numpy.array([start[0] * numpy.cos(spans), -start[0] * numpy.sin(spans)])
    assert (abs(found.state - wanted) <= found.error).all()
    assert (found.error < 100 * EPS).all()  # 24 steps of a motion in which nothing grows
    assert (found.reached == spans).all()


@pytest.mark.parametrize("span", [1.0, 5.0, 10.0])
def test_the_error_bound_grows_as_the_solution_does(span: float) -> None:
    found = follow(growing, numpy.array([[1.0]]), span * ONE, ONE, 1e-6)
    error = abs(found.state[0, 0] - math.exp(span))
    assert error <= found.error[0]
    assert 4 * EPS * math.exp(span) < found.error[0] < 400 * EPS * math.exp(span)


@pytest.mark.parametrize(
    ("rates", "start", "span", "least", "most"),
    [
        # 4 eps e^t passes 1e-9 at t = 14; some eps a step come on top
        (growing, 1.0, 30.0, 8.0, 14.0),
        # x = 1/(1 - t)
        (exploding, 1.0, 2.0, 0.9, 1.0),
        (growing, math.nan, 1.0, 0.0, 0.0),
    ],
)
def test_what_cannot_be_followed_is_given_up_where_it_cannot(
    rates: Callable[..., Any], start: float, span: float, least: float, most: float
) -> None:
    with numpy.errstate(all="ignore"):
        found = follow(rates, numpy.array([[start]]), span * ONE, ONE, 1e-9)
    assert found.error[0] == numpy.inf
    assert least <= found.reached[0] <= most


def test_steps_have_an_end() -> None:
    found = follow(oscillator, numpy.array([[1.0], [0.0]]), 1e6 * ONE, numpy.ones(2), 1e-6)
    assert found.error[0] == numpy.inf
    # a step is some e^-2 of the radius that twenty terms show: 20!^(1/20) = 8.3
    assert found.reached[0] == pytest.approx(MOST_STEPS * 8.3 * math.exp(-2), rel=0.1)
