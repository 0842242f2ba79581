"""Tracing: the operations of a function in a graph, and the values of its constants."""

from collections import Counter
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest

from tt_precise.mechanics.formulations import integration_form
from tt_precise.mechanics.laws import law_named
from tt_precise.taylor.graph import Graph, Traced, constants_of, in_order, numbers


@pytest.mark.parametrize(
    ("coordinates", "law", "expected"),
    [  # heyoka needs 25 products and quotients for the gliding top
        ("newton", "viscous", {"product": 24, "quotient": 1, "component": 8, "root": 0}),
        ("newton", "regularised", {"root": 1}),
        ("newton", "stribeck", {"exponential": 1, "slope": 1}),
        ("euler", "viscous", {"component": 6 + 1}),  # sin and cos, but the rates lack theta
    ],
)
def test_operations_of_the_gliding_top(
    coordinates: str, law: str, expected: dict[str, int]
) -> None:
    form = integration_form("gliding", coordinates, law_named(law))
    graph = Graph(len(form.columns), len(form.parameters))
    state = form.State(*graph.components)
    rates = graph.with_turning(form.rates(form.body(graph.parameters), state, graph))
    counts = Counter(node.kind for node in in_order(graph, rates))
    assert {kind: counts[kind] for kind in expected} == expected


def test_equal_expressions_are_one() -> None:
    graph = Graph(2, 1)
    x, y = graph.components
    assert x * y is y * x
    assert (x + y) - y is x
    assert x - x == 0
    assert 0 * x == 0
    assert 1 * x is x
    assert -1 * (-x) is x


def test_constants_have_the_digits_of_their_parameters() -> None:
    graph = Graph(1, 2)
    a, b = graph.parameters
    rate = (1 / a - 1 / b) * graph.components[0] + graph.sqrt(a) / 3 - 2
    with mpmath.workdps(60):
        parameters = mpmath.mpf(3), mpmath.mpf(7)
        constants = constants_of(in_order(graph, [rate]))
        values = sorted(numbers(constants, parameters, mpmath.mp).values())
        exact = sorted([1 / parameters[0] - 1 / parameters[1], mpmath.sqrt(3) / 3 - 2])
        assert max(abs(p - q) for p, q in zip(values, exact, strict=True)) < mpmath.mpf(10) ** -59


def test_a_traced_polynomial_has_the_value_of_the_polynomial() -> None:
    graph = Graph(3, 1)
    point, parameter = [Fraction(2, 3), Fraction(-5, 7), Fraction(11, 13)], Fraction(3, 5)

    def polynomial(x: Any, y: Any, z: Any, a: Any) -> Any:
        product = (x + 2 * y - a) * (z - x * a) - 3 * (y - x) * (-y + 1) / a
        return product - (2 * (3 * x + 1) - z) + 5 * (a * (3 - 2 * (y * 7 + a))) - (2 * a - 1) * x

    def value(node: Any) -> Fraction:
        if not isinstance(node, Traced):
            return Fraction(node if isinstance(node, int) else constants[node])
        if node.kind == "component":
            return point[node.args[0]]
        if node.kind == "product":
            return value(node.args[0]) * value(node.args[1])
        offset, terms = node.args
        return value(offset) + sum(value(factor) * value(series) for factor, series in terms)

    traced = polynomial(*graph.components, *graph.parameters)
    nodes = constants_of(in_order(graph, [traced]))
    constants = numbers(nodes, [parameter], SimpleNamespace(mpf=Fraction))
    assert value(traced) == polynomial(point[0], point[1], point[2], parameter)
