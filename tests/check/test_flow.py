"""The flow of equations: closed forms, and an error that is not beyond its bound."""

import math
from collections.abc import Callable
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tt_precise.check.flow import EPS, MOST_STEPS, WIDEST, flow, propagate
from tt_precise.mechanics.newton import NewtonState

ONE = numpy.ones(1)


def oscillator(y: Any) -> list[Any]:
    return [y[1], -y[0]]


def growing(y: Any) -> list[Any]:
    return [y[0]]


def test_every_row_ends_after_its_own_span_of_either_sign() -> None:
    spans = numpy.array([1e-4, 0.1, -1.0, 1.0, 15.0, 0.0])
    start = numpy.array([[1.0, 1.0, 2.0, 2.0, 2.0, 3.0], 6 * [0.0]])
    found = propagate(oscillator, start, spans, numpy.ones(2), numpy.full(6, 1e-13))
    wanted = numpy.array([start[0] * numpy.cos(spans), -start[0] * numpy.sin(spans)])
    rounding = 4 * EPS * found.growth
    assert (abs(found.state - wanted) <= found.error + rounding).all()
    assert (found.error < 1e-10).all()
    assert (found.reached == 1).all()


@pytest.mark.parametrize("wanted", [1e-6, 1e-8, 1e-10])
def test_the_bound_is_what_is_wanted_and_holds(wanted: float) -> None:
    spans = numpy.linspace(0.01, 3, 100)
    start = numpy.ones((1, 100))
    found = propagate(growing, start, spans, ONE, numpy.full(100, wanted))
    error = abs(found.state[0] - numpy.exp(spans))
    assert (found.error <= min(30 * wanted, WIDEST)).all()
    assert (error <= found.error + 4 * EPS * found.growth).all()


@pytest.mark.parametrize("span", [1.0, 5.0, 10.0])
def test_the_growth_is_that_of_the_solution(span: float) -> None:
    """To a quarter: a neighbour is carried by eight midpoint steps."""
    found = propagate(growing, ONE[None], span * ONE, ONE, 1e-12 * ONE)
    assert found.growth[0] == pytest.approx(math.exp(span), rel=0.25)
    assert abs(found.state[0, 0] - math.exp(span)) <= found.error[0] + 4 * EPS * found.growth[0]


@pytest.mark.parametrize(
    ("rates", "start", "span", "least", "most"),
    [
        # x = 1/(1 - t)
        (lambda y: [y[0] * y[0]], [1.0], 2.0, 0.3, 0.5),
        (growing, [math.nan], 1.0, 0.0, 0.0),
        (oscillator, [1.0, 0.0], 1e4, 0.0, MOST_STEPS * 4 / 1e4),
        # a kink, which no order goes through
        (lambda y: [1.0 + 0 * y[0], numpy.sign(y[0] - 0.3)], [0.0, 0.0], 1.0, 0.2, 0.31),
    ],
)
def test_what_cannot_be_carried_is_given_up_where_it_cannot(
    rates: Callable[..., Any], start: list[float], span: float, least: float, most: float
) -> None:
    y = numpy.array(start)[:, None]
    found = propagate(rates, y, span * ONE, numpy.ones(len(y)), 1e-12 * ONE)
    assert found.error[0] == numpy.inf
    assert least <= found.reached[0] <= most


def test_an_end_out_of_reach_is_given_up_as_soon_as_that_is_known() -> None:
    """All rows halve their steps to 1/32 of the span, a few of them until a step succeeds."""
    evaluated = 0

    def counted(y: Any) -> list[Any]:
        nonlocal evaluated
        evaluated += y.shape[1]
        return oscillator(y)

    count = 200
    start = numpy.array([numpy.ones(count), numpy.zeros(count)])
    found = propagate(
        counted, start, numpy.full(count, 1e4), numpy.ones(2), numpy.full(count, 1e-9)
    )
    assert (found.error == numpy.inf).all()
    known = found.reached[~numpy.isnan(found.reached)]
    assert 0 < len(known) < count / 10
    assert (known > 0).all()
    assert (known < MOST_STEPS * 16 / 1e4).all()  # no step is longer than 16 rad
    assert evaluated < 200 * count  # 1,500 a row where all go on


@pytest.mark.parametrize("span", [0.5, 2.0, 2.8])
def test_what_is_watched_is_never_below_its_bound(span: float) -> None:
    """The parabola (t - t0)^2 and a cosine, beside points of the steps and between them."""
    middles = numpy.linspace(0, span, 50)
    start = numpy.array([-middles, numpy.cos(middles), numpy.sin(middles)])
    found = propagate(
        lambda y: [numpy.ones_like(y[0]), -y[2], y[1]], start, numpy.full(50, span),
        numpy.ones(3), numpy.full(50, 1e-10), lambda y: y[0] ** 2,
    )  # fmt: skip
    assert (found.least <= 0).all()
    assert (found.least >= -(span**2) / 10).all()


def test_no_row_depends_on_the_others() -> None:
    """Rows at rest, gliding and beyond reach in one call; the same bits alone."""
    scene = tt.load_scene("coulomb-stick-slip")
    run = tt.integrate(scene, events=(), record=())
    frame = run.frame(*NewtonState._fields, times=[0.0, 0.05, float(run.t_end) * 0.9])
    entries = numpy.array([frame[name] for name in NewtonState._fields], float)
    body, sizes = scene.body.numbers(float), abs(entries).max(axis=1) + 1e-9
    spans, wanted = numpy.array([0.001, 0.002, 0.0015]), numpy.full(3, 1e-13)
    together = flow(scene, body, NewtonState(*entries), spans, sizes, wanted, watched=True)
    for row in range(3):
        one = slice(row, row + 1)
        alone = flow(
            scene, body, NewtonState(*entries[:, one]), spans[one], sizes, wanted[one], watched=True
        )
        assert numpy.array_equal(alone.state[:, 0], together.state[:, row])
        assert (alone.error[0], alone.least[0]) == (together.error[row], together.least[row])


def test_how_far_rows_come_is_not_sought_where_few_steps_are_allowed() -> None:
    start, far = numpy.array([[1.0], [0.0]]), 1e4 * ONE
    for most, sought in ((MOST_STEPS, True), (1, False)):
        found = propagate(oscillator, start, far, numpy.ones(2), 1e-9 * ONE, most=most)
        assert found.error[0] == numpy.inf
        assert (found.reached[0] > 0) == sought
