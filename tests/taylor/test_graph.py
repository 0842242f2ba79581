"""Tracing: what a function leaves in a graph, and what the constants in it are worth."""

from collections import Counter
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath

from tt_precise.mechanics.formulations import formulation, integration_form
from tt_precise.mechanics.laws import law_named
from tt_precise.mechanics.quantities import Motion
from tt_precise.taylor.graph import Graph, Traced, constants_of, in_order, numbers


def kinds(model: str, coordinates: str, law: str = "viscous") -> Counter[str]:
    form = integration_form(model, coordinates, law_named(law))
    graph = Graph(len(form.columns), len(form.parameters))
    state = form.State(*graph.components)
    rates = graph.with_turning(form.rates(form.body(graph.parameters), state, graph))
    return Counter(one.kind for one in in_order(graph, rates))


def test_the_gliding_top_takes_its_products_once() -> None:
    # heyoka needs 25 products and quotients for the same text
    found = kinds("gliding", "newton")
    assert found["product"] == 24
    assert found["quotient"] == 1
    assert found["component"] == 8


def test_sines_and_roots_are_taken_where_the_equations_have_them() -> None:
    assert kinds("gliding", "euler")["component"] == 6 + 1  # sin and cos, but the rates lack theta
    assert kinds("gliding", "newton", "regularised")["root"] == 1
    assert kinds("gliding", "newton")["root"] == 0
    stribeck = kinds("gliding", "newton", "stribeck")
    assert (stribeck["exponential"], stribeck["slope"]) == (1, 1)


def test_the_rate_of_the_azimuth_is_taken_without_theta() -> None:
    form = formulation("gliding", "newton", law_named("viscous"))
    graph = Graph(len(form.columns), len(form.parameters))
    q = Motion(form.body(graph.parameters), form.State(*graph.components), graph)
    assert "angle" not in {one.kind for one in in_order(graph, [q.euler.phi_dot])}


def test_equal_expressions_are_one() -> None:
    graph = Graph(2, 1)
    x, y = graph.components
    (a,) = graph.parameters
    assert x * y is y * x
    assert a * x + y is y + a * x or in_order(graph, [a * x + y])
    assert (x + y) - y is x
    assert x - x == 0
    assert 0 * x == 0
    assert 1 * x is x
    assert -1 * (-x) is x


def test_constants_are_computed_in_the_numbers_given() -> None:
    graph = Graph(1, 2)
    (x,) = graph.components
    a, b = graph.parameters
    rate = (1 / a - 1 / b) * x + graph.sqrt(a) / 3 - 2
    with mpmath.workdps(60):
        values = mpmath.mpf(3), mpmath.mpf(7)
        constants = constants_of(in_order(graph, [rate]))
        found = sorted(numbers(constants, values, mpmath.mp).values())
        wanted = sorted([1 / values[0] - 1 / values[1], mpmath.sqrt(3) / 3 - 2])
        assert max(abs(p - q) for p, q in zip(found, wanted, strict=True)) < mpmath.mpf(10) ** -59


def test_a_sum_is_what_its_terms_are() -> None:
    """Evaluated in fractions, a traced polynomial gives what it gives without being traced."""
    graph = Graph(3, 1)
    point, parameter = [Fraction(2, 3), Fraction(-5, 7), Fraction(11, 13)], Fraction(3, 5)

    def polynomial(*given: Any) -> Any:
        x, y, z, a = given
        product = (x + 2 * y - a) * (z - x * a) - 3 * (y - x) * (-y + 1) / a
        return product - (2 * (3 * x + 1) - z) + 5 * (a * (3 - 2 * (y * 7 + a))) - (2 * a - 1) * x

    def value(one: Any) -> Fraction:
        if not isinstance(one, Traced):
            return Fraction(one if isinstance(one, int) else constant[one])
        if one.kind == "component":
            return point[one.args[0]]
        if one.kind == "product":
            return value(one.args[0]) * value(one.args[1])
        offset, terms = one.args
        return value(offset) + sum(value(factor) * value(series) for factor, series in terms)

    traced = polynomial(*graph.components, *graph.parameters)
    fractions = SimpleNamespace(mpf=Fraction)
    constant = numbers(constants_of(in_order(graph, [traced])), [parameter], fractions)
    assert value(traced) == polynomial(*point, parameter)
