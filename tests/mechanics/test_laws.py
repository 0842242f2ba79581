"""Friction laws: their coefficients, bounds and ranges, against their formulas by hand."""

from __future__ import annotations

import math
import pickle
from types import SimpleNamespace
from typing import Any

import mpmath
import pytest

from tt_precise.mechanics.laws import LAWS, Law, law_named
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

# |F_f|/g_n at a speed, as the formulas of ``force`` say
FORCES: dict[str, Any] = {
    "viscous": lambda v, mu: mu * v,
    "regularised": lambda v, mu, eps: mu * v / math.hypot(v, eps),
    "coulomb": lambda v, mu: mu,
    "stribeck": lambda v, mu, mu_s, v_s, eps: (
        (mu + (mu_s - mu) * math.exp(-((v / v_s) ** 2))) * v / math.hypot(v, eps)
    ),
}


def values_of(law: Law) -> tuple[float, ...]:
    """The parameters in the scene that ships with the law."""
    body = load_scene(law.scene).body
    return (float(body.mu), *map(float, body.further))


every_law = pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.name)


@every_law
@pytest.mark.parametrize("speed", [1e-3, 0.1, 2.0])
def test_the_force_is_that_of_the_formula(law: Law, speed: float) -> None:
    values = values_of(law)
    coefficient = law.coefficient(speed**2, math, *values)
    assert coefficient * speed == pytest.approx(FORCES[law.name](speed, *values), rel=1e-14)
    wrong = law.coefficient(speed**2, math, values[0] * 1.001, *values[1:])
    assert wrong * speed != pytest.approx(FORCES[law.name](speed, *values), rel=1e-14)
    assert float(law.coefficient(mpmath.mpf(speed) ** 2, mpmath, *values)) == pytest.approx(
        coefficient, rel=1e-14
    )


@every_law
def test_the_bound_holds_at_every_higher_speed(law: Law) -> None:
    values = values_of(law)
    for slowest in (1e-6, 1e-2, 1.0):
        bound = law.largest(slowest, *values)
        speeds = [slowest * 1.3**n for n in range(60)]
        assert all(law.coefficient(v * v, math, *values) <= bound * (1 + 1e-15) for v in speeds)


@every_law
def test_a_law_says_of_itself_what_is_true(law: Law) -> None:
    speeds = [1e-6, 1e-3, 1.0]
    coefficients = {law.coefficient(v * v, math, *values_of(law)) for v in speeds}
    assert (len(coefficients) == 1) is law.constant
    slow = law.coefficient(1e-30, math, *values_of(law))
    assert (slow < 1e6) is law.smooth_at_rest
    assert load_scene(law.scene).body.friction is law
    assert law.further == tuple(parameter.name for parameter in law.parameters)[1:]
    assert pickle.loads(pickle.dumps(law)) is law


def test_the_functions_that_an_arithmetic_lacks_are_named() -> None:
    roots = SimpleNamespace(sqrt=math.sqrt)
    assert law_named("stribeck").missing(roots) == ["exp"]
    assert law_named("coulomb").missing(roots) == []


def test_an_unknown_law_is_refused() -> None:
    with pytest.raises(InputError, match=r"got 'dry', expected one of: viscous, "):
        law_named("dry")
