"""Scenes with dry friction: two formulations, integrals, limits, and what refuses them."""

from typing import Any

import pytest

import tt_precise as tt
from tests.conftest import RATIOS, more
from tests.nonsmooth.conftest import orders
from tt_precise.scene.scene import Scene

TABLES: dict[str, Any] = {
    "model": "gliding",
    "start": {"theta": "0.3", "omega_3": "155", "nu_y": "0.92"},
    "run": {"until": "0.1"},
}
BODY = {name: value for name, value in RATIOS.items() if name != "mu"}


def dry(law: str, mu: str = "0.05", **more: str) -> Scene:
    friction = {"law": law, "mu": mu, **more}
    return Scene.of(name="dry", body=BODY, friction=friction, **TABLES)


STRIBECK = dry("stribeck", "0.04", mu_s="0.06", v_s="0.3", epsilon="0.01")


@pytest.mark.parametrize("scene", [dry("coulomb"), dry("regularised", epsilon="0.01"), STRIBECK])
def test_two_formulations_agree_and_the_laws_of_conservation_hold(scene: Scene) -> None:
    # double-double compiles the Euler form faster than double
    newton, euler = (
        tt.integrate(scene, "double-double", formulation=f) for f in ("newton", "euler")
    )
    frame, other = newton.frame(numbers="float"), euler.frame(numbers="float")
    for name in ("theta", "phi_dot", "omega_3", "nu_x", "nu_y"):
        assert frame[name].to_numpy() == pytest.approx(other[name].to_numpy(), rel=1e-14)
    assert float(newton.drift["jellett"]) < 1e-17
    found = tt.check.conservation(frame, scene)
    assert found.passed
    assert {one.name for one in found.checks if one.verdict == "pass"} >= {"jellett", "energy"}


def test_laws_that_are_one_law_have_one_motion() -> None:
    flat = dry("stribeck", mu_s="0.05", v_s="0.3", epsilon="0.01")
    ends = [tt.integrate(one).state.values for one in (flat, dry("regularised", epsilon="0.01"))]
    assert ends[0] == pytest.approx(ends[1], rel=1e-11, abs=0)
    plain = tt.integrate(Scene.of(name="plain", body=RATIOS, **TABLES))
    assert plain.frame().equals(tt.integrate(dry("viscous", "0.3")).frame())


@pytest.mark.parametrize(
    ("precision", "digits"), [("double-double", 28), more("triple-double", 43)]
)
def test_several_doubles_have_an_exponential(precision: str, digits: int) -> None:
    truth, found = tt.integrate(STRIBECK, "mp").state, tt.integrate(STRIBECK, precision).state
    for name, value in found.values.items():
        assert abs(value - getattr(truth, name)) <= 10.0**-digits * max(abs(value), 1)
    assert tt.integrate(STRIBECK, digits=25).digits_throughout >= 25


def test_epsilon_to_zero_is_coulomb_at_order_2_while_the_top_glides() -> None:
    # 1/sqrt(v^2 + epsilon^2) = 1/v - epsilon^2/(2 v^3) + ...
    softened = [dry("regularised", epsilon=width) for width in ("0.02", "0.01", "0.005")]
    found = orders(dry("coulomb"), softened, "theta theta_dot nu_x nu_y", 2)
    assert found == pytest.approx([2, 2], abs=0.1)
