"""Truncated series against closed forms."""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from typing import Any

import numpy
import pytest

from tt_precise.mechanics import newton
from tt_precise.mechanics.taylor import (
    Growing,
    SeriesTape,
    TaylorSeries,
    integral,
    solution,
)
from tt_precise.scene.scene import load_scene

EPS = numpy.finfo(float).eps


def test_products_and_quotients_of_geometric_series() -> None:
    # 1/(1 - h) = 1 + h + h^2 + ..., its square has the coefficients 1, 2, 3, ...
    h = TaylorSeries(numpy.array([[0.0], [1.0], [0.0], [0.0], [0.0]]))
    geometric = 1 / (1 - h)
    assert geometric.c[:, 0].tolist() == [1] * 5
    assert (geometric * geometric).c[:, 0].tolist() == [1, 2, 3, 4, 5]
    assert (geometric / geometric).c[:, 0].tolist() == [1, 0, 0, 0, 0]
    assert (geometric * geometric).rate[:, 0].tolist() == [2, 6, 12, 20]


def test_arrays_stand_on_either_side() -> None:
    array = numpy.array([2.0, 3.0])
    h = TaylorSeries(numpy.array([[1.0, 1.0], [1.0, 1.0]]))
    for found in (array * h, h * array):
        assert isinstance(found, TaylorSeries)
        assert found.c.tolist() == [[2, 3], [2, 3]]
    assert (array + h).c.tolist() == [[3, 4], [1, 1]]
    assert (array - h).c.tolist() == [[1, 2], [-1, -1]]
    assert (h / array).c.tolist() == [[1 / 2, 1 / 3], [1 / 2, 1 / 3]]


def test_the_series_of_an_oscillator() -> None:
    t = numpy.linspace(0, 3, 7)
    x, v = solution(lambda s: (s[1], -s[0]), [numpy.sin(t), numpy.cos(t)], 12)
    derivatives = (numpy.sin(t), numpy.cos(t), -numpy.sin(t), -numpy.cos(t))
    for k in range(13):
        numpy.testing.assert_allclose(
            x.c[k], derivatives[k % 4] / factorial(k), rtol=0, atol=4 * EPS / factorial(k)
        )
    assert (v.c[0] == numpy.cos(t)).all()


@pytest.mark.parametrize(
    "function",
    [
        lambda x: x * x * x,
        lambda x: (1 + x) * (x - 3) * (3 - x),
        lambda x: 2 * x / 3 - x * 5,
        lambda x: x / (1 + x),
        lambda x: (2 - x) / (x * x) / x,
        lambda x: 2 / x - 1 / (x * x),
        lambda x: (1 + x * x).sqrt() * x,
        lambda x: 1 / x.sqrt() + -x,
    ],
)
def test_a_series_that_grows_is_the_series_of_what_is_written(
    function: Callable[[TaylorSeries], TaylorSeries],
) -> None:
    """x = x0 + t, y' = f(x): coefficient k of f is k + 1 times coefficient k + 1 of y."""
    x0 = numpy.array([0.75, 1.0, 2.5])
    x, y = solution(lambda s: (1.0 + 0.0 * s[0], function(s[0])), [x0, numpy.zeros(3)], 8)
    assert (x.c[1] == 1).all()
    expected = function(TaylorSeries(x.c)).c
    assert abs(expected[3]).min() > 1e-3 or not expected[4:].any()
    assert y.rate == pytest.approx(expected[:8], rel=1e-13, abs=1e-13)


def test_hermites_rule_is_exact_up_to_its_degree_and_not_beyond() -> None:
    for terms in (1, 2, 3, 5, 8, 13):
        for degree, exact in ((2 * terms - 1, True), (2 * terms, False)):
            # h^degree about 0 and about 1, over [0, 1]; its integral is 1/(degree + 1)
            left = numpy.zeros((1, 2 * terms + 1, 1))
            left[0, degree] = 1
            right = numpy.array(
                [
                    [
                        [factorial(degree) / factorial(j) / factorial(degree - j)]
                        for j in range(degree + 1)
                    ]
                ]
            )
            found = integral(left[:, :terms], right[:, :terms], numpy.ones(1), terms)[0, 0]
            error = abs(found * (degree + 1) - 1)
            # the weights alternate: their sum loses up to 2^terms eps
            assert (error < 2 ** (2 * terms) * EPS) == exact, (terms, degree, error)


def test_the_root_squared_is_the_series() -> None:
    c = numpy.array([[4.0, 9.0], [1.0, -2.0], [0.5, 3.0], [-0.25, 1.0]])
    root = TaylorSeries(c).sqrt()
    assert root.c[0].tolist() == [2, 3]
    assert (root * root).c == pytest.approx(c, rel=4 * EPS)


def test_an_operation_is_done_once_and_only_where_it_is_needed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = load_scene("reference")
    body = scene.body.numbers(float)
    start = numpy.random.default_rng(1).uniform(0.1, 1, (8, 5))
    taken: list[int] = []

    def coefficients() -> numpy.ndarray:
        def rates(state: tuple[Any, ...]) -> tuple[Any, ...]:
            found = newton.rates(body, newton.NewtonState(*state))
            tape = state[0].tape
            taken.append(len(tape.needed(found)))
            return tuple(found)

        return numpy.array([series.c for series in solution(rates, list(start), 9)])

    shared = coefficients()
    # every operation for itself, as written
    monkeypatch.setattr(Growing, "_once", lambda a, what, b, step: Growing(a.tape, step, a, b))
    monkeypatch.setattr(SeriesTape, "needed", lambda tape, wanted: tape.nodes)
    assert (coefficients() == shared).all()
    assert taken[0] < 0.7 * taken[1]


def test_zeros_of_either_sign_are_two_numbers() -> None:
    tape = SeriesTape(1, 1)
    x = Growing(tape, lambda c, k: c[k])
    assert x + 1.0 is x + 1.0
    assert x * 2.0 is not x * 2
    assert x + 0.0 is not x + -0.0
    assert x - x is not x + x
