"""Friction laws: their limits, their agreement with the viscous equations, and the polar form."""

from typing import Any

import numpy
import pytest

from tt_precise.mechanics import friction, newton
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.laws import COULOMB, LAWS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import TippeTop, top_of
from tt_precise.scene.scene import load_scene

BODY: dict[str, Any] = {
    "m": "1.7", "R": "0.6", "alpha": "0.3", "I1": "0.37", "I3": "0.41", "g": "9.82",
}  # fmt: skip


def further(law: str) -> dict[str, str]:
    """The parameters behind mu, from the scene that ships with the law."""
    body = load_scene(LAWS[law].scene).body
    assert body.friction is LAWS[law]
    return dict(zip(body.friction.further, map(str, body.further), strict=True))


def dry(law: str, **keys: str) -> TippeTop:
    return top_of(BODY, {"law": law, "mu": "0.23", **keys})[0]


def test_a_viscous_body_is_handed_on_as_it_is(body: TippeTop) -> None:
    assert friction.viscous_at(body, 1, 2, None) is body
    assert top_of(BODY, {"law": "viscous", "mu": "0.23"})[0] == body


def test_dimensionless_and_si_give_the_same_force(mp: Any, rounded: Any) -> None:
    for top in (dry(law, **further(law)) for law in LAWS):
        si, bare = top.numbers(rounded), top.dimensionless(mp, rounded)
        time = mp.sqrt(si.R / si.g)
        momentum = si.m * si.R**2 / time
        k, L, v = (mp.mpf("0.6"), 0, mp.mpf("0.8")), (1, 2, 3), (mp.mpf("0.3"), mp.mpf("0.1"))
        scaled = NewtonState(*k, *(x / momentum for x in L), *(x * time / si.R for x in v))
        force = Motion(si, NewtonState(*k, *L, *v), mp).force
        other = Motion(bare, scaled, mp).force
        for one, two in zip(force, other, strict=True):
            assert mp.almosteq(one, two * si.m * si.g, rel_eps=mp.mpf("1e-55"))


def test_wrapped_equations_are_those_of_the_law() -> None:
    body = Parameters(1.0, 1.0, 0.3, 0.4, 0.4, 1.0, 0.3, friction=COULOMB)
    state = NewtonState(0.6, 0.0, 0.8, 1.0, 2.0, 3.0, 0.3, 0.4)
    rates = formulation("gliding", "newton", COULOMB).rates(body, state, numpy)
    # mu g_n, whatever the speed: a viscous coefficient of 0.3/0.5
    assert rates == newton.rates(Parameters(1.0, 1.0, 0.3, 0.4, 0.4, 1.0, 0.6), state)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("law=sticky", "friction.law: got 'sticky', expected one of: viscous, regularised"),
        ("law=regularised mu=0.3", "missing key friction.epsilon"),
        ("law=coulomb mu=0.3 epsilon=1", "unknown key friction.epsilon"),
        ("law=regularised mu=0.3 epsilon=0", "epsilon: got 0, expected a number above 0"),
        ("law=stribeck mu=0.3", "friction.epsilon, expected a value; also missing: mu_s, v_s"),
        ("law=stribeck mu=0.3 mu_s=0.2 v_s=1 epsilon=1", "mu_s: got 0.2, expected at least mu"),
        ("law=stribeck mu=0.3 mu_s=0.4 v_s=0 epsilon=1", "v_s: got 0, expected a number above 0"),
        ("law=coulomb mu=-1", "mu: got -1"),
    ],
)
def test_refuses(table: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        top_of(BODY, dict(entry.split("=") for entry in table.split()))


SMALL = Parameters(1.0, 1.0, 0.3, 0.4, 0.5, 1.0, 0.3, friction=COULOMB)
STATE = EulerState(0.7, 0.4, 0.9, 3.0, 0.06, -0.02)


def test_rates_are_finite_where_the_gliding_ends() -> None:
    state = friction.PolarState(0.6, 0.0, 0.8, 1.0, 2.0, 3.0, -numpy.inf, 0.6, 0.8, 0.0)
    rates = friction.polar_rates(SMALL, state, numpy)
    assert numpy.isfinite(rates).all()
    # at v = 0 only the direction moves, and it stays a unit vector
    assert [i for i, rate in enumerate(rates) if rate] == [6, 7, 8]
    assert rates.ex * state.ex + rates.ey * state.ey == pytest.approx(0, abs=4e-15)


def test_a_polar_state_has_the_vectors_it_was_made_of() -> None:
    vectors = NewtonState(0.6, 0.0, 0.8, 1.0, 2.0, 3.0, 0.3, -0.4)
    own = friction.PolarState.of(Motion(SMALL, vectors, numpy))
    assert own.vectors(SMALL, numpy).v[:2] == pytest.approx((0.3, -0.4), rel=1e-15)
    assert own.clock(numpy) == pytest.approx(0.5, rel=1e-15)
    assert newton.normal_force(SMALL, vectors) > 0
