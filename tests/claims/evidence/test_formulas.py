"""Printed formulas as text, compared with the mechanics."""

from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import pytest

from tt_precise.claims.evidence import formulas as f
from tt_precise.mechanics.quantities import d


def test_the_point_lies_on_the_relations_of_the_chart_and_has_no_symmetry() -> None:
    at = {name: Fraction(text) for name, text in f.POINT.items()}
    assert at["s"] ** 2 + at["c"] ** 2 == at["S"] ** 2 + at["C"] ** 2 == 1
    sigma = at["m"] * at["R"] ** 2 / at["I3"]
    body: Any = SimpleNamespace(alpha=at["alpha"], gamma=at["I1"] / at["I3"], sigma=sigma)
    assert at["q"] ** 2 == at["I3"] ** 2 * d(body, at["c"])
    generic = [abs(at[name]) for name in at if name not in ("S", "C", "phi", "theta")]
    assert len(set(generic) - {0, 1}) == len(generic)


@pytest.mark.parametrize(
    ("printed", "holds"),
    [
        ("sin(theta)**2", True),
        ("1 - cos(theta)**2 + mu*0", True),
        ("1 - cos(theta)", False),
        ("sin(theta)**2*(1 + R*g/10**30)", False),
    ],
)
def test_equal_holds_for_identities_only(printed: str, holds: bool) -> None:
    judged = f.equal(printed, f.parse("sin(theta)**2"))
    assert judged.holds is holds
    assert ("equal" in judged.measured) is holds
    assert judged.proved


def test_formulas_that_differ_only_beyond_the_point_are_not_called_equal() -> None:
    assert f.POINT["theta_dot"] == "11/5"
    with pytest.raises(ArithmeticError, match="choose another"):
        f.equal("phi_dot + 5*theta_dot - 11", f.parse("phi_dot"))


def test_a_difference_is_a_fraction_of_the_larger_side() -> None:
    assert f.equal("3*R", f.parse("4*R")).measured == f"off by 25.0 % {f.AT_POINT}"


def test_vectors_differ_where_one_component_does() -> None:
    assert f.identity("(R, m)", "(R, m)", "a = b").holds
    assert not f.identity("(R, R)", "(R, m)", "a = b").holds


@pytest.mark.parametrize("text", ["__import__('os')", "open('x')", "len(R)"])
def test_a_formula_calls_no_builtin_function(text: str) -> None:
    with pytest.raises((NameError, KeyError)):
        f.parse(text)


def test_rates_are_those_of_the_motion_and_a_printed_root_that_of_d() -> None:
    assert f.equal("theta_dot", f.rate(f.chart().state.theta)).holds
    assert f.equal("-theta_dot*sin(theta)", f.rate(f.chart().c)).holds
    assert f.identity("0", "rate_of('lambda')", "").holds
    assert f.identity("sqrt(d(cos(theta)))**2", "d(cos(theta))", "").holds
