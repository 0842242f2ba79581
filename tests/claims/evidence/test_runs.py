"""Shared computations: variants of scenes, settled values, the past, the paper's own way."""

from fractions import Fraction
from typing import Any

import pytest

from tt_precise.claims import evidence
from tt_precise.claims.evidence.backwards import past
from tt_precise.claims.evidence.paper_odeint import paper_odeint, state_errors
from tt_precise.integration import integrate
from tt_precise.runtime.errors import InputError

SHORT = evidence.variant(until="0.3")


def test_a_variant_changes_what_it_names_and_nothing_else() -> None:
    scene = evidence.variant(mu="0.5", phi_dot="195", until="2")
    assert scene.body.mu == Fraction(1, 2)
    assert scene.start.phi_dot == 195
    assert scene.until == 2
    assert evidence.variant(scene, mu="0.3", phi_dot="0", until="8") == evidence.variant()


def test_a_variant_is_checked_like_a_scene() -> None:
    with pytest.raises(InputError):
        evidence.variant(mu="-1")


def test_settled_values_agree_with_a_finer_run() -> None:
    found = evidence.at("theta", "0.25", SHORT)
    assert found.digits >= 15
    finer = integrate(SHORT, "mp", bits=160).at("0.25").theta
    assert abs(found.value - finer) < abs(finer) * 10**-28


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["reference", "below-threshold"])
def test_fine_values_are_those_of_quad(scene: str) -> None:
    """More digits than are ever printed, at the end and on the way; and the same events."""
    fine, quad = (evidence.trajectory(scene, name) for name in (evidence.FINE, "quad"))
    assert quad.precision.name == "quad" != fine.precision.name
    assert fine.event_counts == quad.event_counts
    assert max(fine.drift["jellett"], quad.drift["jellett"]) < 1e-27
    for name in ("theta", "phi_dot", "E"):
        for t in (quad.t_end, quad.t_end / 3):
            values = [run.frame(name, times=[str(t)])[name].iloc[0] for run in (fine, quad)]
            assert abs(values[0] - values[1]) < abs(values[1]) * 10**-22


def test_extrema_are_not_missed_between_samples() -> None:
    values = evidence.turning_values("g_n", SHORT)["value"]
    sampled = evidence.sampled(SHORT, ("g_n",), "0.0001")["g_n"]
    assert values.min() <= sampled.min()
    assert values.min() == pytest.approx(sampled.min(), rel=1e-4)


def test_the_past_leads_back_to_where_it_came_from() -> None:
    scene = evidence.variant(until="0.1")
    later = integrate(scene, "double").state
    text = {name: repr(getattr(later, name)) for name in ("theta_dot", "phi_dot", "omega_3")}
    text |= {name: repr(getattr(later, name)) for name in ("nu_x", "nu_y")}
    again = evidence.variant(scene, theta=repr(later.theta), **text)
    back, origin = past(again), past(scene)
    assert origin.contact_lost
    assert back.t == pytest.approx(origin.t - 0.1, abs=1e-7)


def test_the_own_way_is_close_and_its_errors_are_seen() -> None:
    own = paper_odeint(SHORT)
    assert 1e-13 < own.jellett_drift < 1e-9
    assert 1e-12 < state_errors(SHORT)["theta"] < 1e-6


def test_double_does_not_confirm_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing else takes milliseconds: the least value has the digits of double, not 20."""
    monkeypatch.setattr("tt_precise.claims.evidence.runs.rough", lambda: "double")
    assert 8 < evidence.least("g_n", SHORT).digits < 18


def test_a_past_that_was_given_up_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    from scipy import integrate as scipy_integrate

    whole = scipy_integrate.solve_ivp

    def given_up(*arguments: Any, **keywords: Any) -> Any:
        found = whole(*arguments, **keywords)
        found.status = -1
        return found

    monkeypatch.setattr(scipy_integrate, "solve_ivp", given_up)
    with pytest.raises(ArithmeticError, match="gave up"):
        past(evidence.variant(until="0.31"))


def test_an_odeint_that_gave_up_is_no_run(monkeypatch: pytest.MonkeyPatch) -> None:
    from scipy import integrate as scipy_integrate

    whole = scipy_integrate.odeint

    def given_up(*arguments: Any, **keywords: Any) -> Any:
        rows, _ = whole(*arguments, **{**keywords, "full_output": True})
        told = {"message": "Excess work done on this call."}
        return (rows, told) if keywords.get("full_output") else rows

    monkeypatch.setattr(scipy_integrate, "odeint", given_up)
    with pytest.raises(ArithmeticError, match="up: Excess work"):
        paper_odeint(evidence.variant(until="0.05"))
