"""How functions begin: exact orders and signs, against series in mpmath, and the false proof."""

from dataclasses import replace
from fractions import Fraction
from typing import Any

import flint
import mpmath
import pytest

import tt_precise as tt
from tt_precise.certify import NotProved, prove
from tt_precise.certify.onset import Exact, Onset, onset
from tt_precise.certify.problem import FUNCTIONS, form_of, problem_of
from tt_precise.integration.events import catalogue, event_named
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import formulation
from tt_precise.scene.scene import Inclination, Scene
from tt_precise.taylor.series import solution

SINE, COSINE = Exact.sine_cosine()


def begins(scene: Scene, name: str) -> Onset | None:
    return onset(scene, event_named(name, scene.model).function)


def test_the_field_of_sine_and_cosine() -> None:
    assert (SINE * SINE + COSINE * COSINE - 1).is_zero
    assert not (SINE - COSINE).is_zero
    element = (2 * SINE + Fraction(1, 3)) / (COSINE - 5)
    assert (element * (COSINE - 5) - 2 * SINE - Fraction(1, 3)).is_zero
    assert (1 / element * element - 1).is_zero
    with pytest.raises(NotProved, match="by zero"):
        element / (SINE * SINE + COSINE * COSINE - 1)


def test_roots_of_rational_numbers() -> None:
    root = Exact.of(Fraction(73, 1000)).sqrt()
    assert (root * root - Fraction(73, 1000)).is_zero
    assert (1 / root * root - 1).is_zero
    assert ((COSINE + root) / (SINE - root) * (SINE - root) - COSINE - root).is_zero
    # the negative controls: near it, and not it
    assert not (root - Fraction(27018512, 10**8)).is_zero
    assert not (root - SINE).is_zero
    assert (root - Fraction(27018512, 10**8)).sign(Inclination.parse("1")) == 1
    assert (root - Fraction(27018513, 10**8)).sign(Inclination.parse("1")) == -1
    assert (Exact.of(Fraction(9, 4)).sqrt() - Fraction(3, 2)).is_zero
    for other in (SINE, root, Exact.of(-1)):
        with pytest.raises(NotProved, match="not that of a rational"):
            other.sqrt()


def test_signs_however_small() -> None:
    # pi - 1e-300 has the sine 1e-300
    theta = Inclination.parse("pi - 1e-300")
    assert SINE.sign(theta) == 1
    assert COSINE.sign(theta) == -1
    assert (SINE - Fraction(1, 10**300)).sign(theta) == -1
    nought = Inclination.parse("1e-300")
    assert (1 - COSINE - SINE * SINE / 2).sign(nought) == 1  # theta^4/8


def test_the_reference_scene() -> None:
    # from rest: phi_dot begins as -t^2, nu_y as -t^2, theta is a maximum of cos theta's minimum
    scene = tt.load_scene("reference")
    assert begins(scene, "phi_dot_zero") == Onset(2, -1)
    assert begins(scene, "nu_y_zero") == Onset(2, -1)
    assert begins(scene, "theta_max") == Onset(1, 1)
    assert begins(scene, "equator") == Onset(0, 1)


@pytest.mark.parametrize("name", ["upright", "rocking"])
def test_what_vanishes_identically_has_no_order(name: str) -> None:
    assert begins(tt.load_scene(name), "phi_dot_zero") is None


@pytest.mark.parametrize("name", ["reference", "kicked", "tippetopsim", "rolling"])
def test_leading_coefficients_are_those_of_mpmath(name: str) -> None:
    scene = tt.load_scene(name)
    form = formulation(scene.model, "newton")
    with mpmath.workdps(60):

        def number(value: Fraction) -> Any:
            return mpmath.mpf(value.numerator) / value.denominator

        body = scene.body.numbers(number)
        start = [number(getattr(scene.start, one)) for one in EulerState._fields[1:]]
        sine_cosine = scene.start.theta.sine_cosine(mpmath.mp, number)
        euler = EulerState(None, *start)
        vectors = vectors_from_euler(body, euler, mpmath.mp, sine_cosine=sine_cosine)
        state = [mpmath.mpf(value) for value in vectors[: len(form.columns)]]
        series = solution(lambda y: form.rates(body, form.State(*y), mpmath.mp), state)
        motion = form.motion(body, form.State(*series), mpmath.mp)
        for event in catalogue(scene.model):
            found = event_named(event, scene.model).function(motion).upto(3)
            exact = begins(scene, event)
            assert exact is not None
            size = max(abs(one) for one in found)
            assert all(abs(one) < size * mpmath.mpf(10) ** -50 for one in found[: exact.order])
            assert mpmath.sign(found[exact.order]) == exact.sign


@pytest.mark.parametrize("name", ["regularised-1e-2", "coulomb-gliding"])
def test_leading_coefficients_with_dry_friction_are_those_of_balls(name: str) -> None:
    scene = tt.load_scene(name)
    form = form_of(scene)
    with flint.ctx.workprec(200):
        body = form_of(scene).body(problem_of(scene).parameters())
        start = list(problem_of(scene).start())
        series = solution(lambda y: form.rates(body, form.State(*y), FUNCTIONS), start)
        motion = form.motion(body, form.State(*series), FUNCTIONS)
        orders = set()
        for event in catalogue(scene.model):
            found = event_named(event, scene.model).function(motion).upto(2)
            exact = begins(scene, event)
            assert exact is not None
            orders.add(exact.order)
            assert all(one.contains(0) for one in found[: exact.order])
            assert found[exact.order] * exact.sign > 0
        assert orders == {0, 1}


def test_a_sign_that_changes_at_once_is_found() -> None:
    """A gliding velocity of -1e-9 m/s turns phi_dot negative, for 1e-11 s only."""
    scene = tt.load_scene("tippetopsim")
    start = replace(
        scene.start, theta=Inclination.parse("1.5"), nu_x=Fraction(1, 5),
        nu_y=Fraction(-1, 10**9), omega_3=Fraction(20),
    )  # fmt: skip
    body = replace(scene.body, alpha=Fraction(1, 20))
    proof = prove(replace(scene, start=start, body=body, until=Fraction(1, 50)))
    found = proof.inversion.C.t_init
    with flint.ctx.workprec(300):
        assert found.overlaps(flint.arb("1.04929346828931e-11", "1e-24"))
        assert not found.contains(0)


def test_what_begins_at_zero_and_rises_has_no_event_there() -> None:
    proof = prove(replace(tt.load_scene("tippetopsim"), until=Fraction(1, 500)))
    assert begins(proof.scene, "phi_dot_zero") == Onset(1, 1)
    assert proof.all_events["phi_dot_zero"].zeros == []
    assert proof.all_events["phi_dot_zero"].failure is None


def test_phi_dot_that_only_touches_zero_changes_no_sign() -> None:
    # it comes back to zero with each nutation, without friction
    proof = prove(replace(tt.load_scene("frictionless"), until=Fraction(1, 10)))
    assert len(proof.all_events["theta_max"].zeros) >= 2
    found = proof.all_events["phi_dot_zero"]
    assert (found.zeros, found.failure) == ([], None)
    # with the smallest friction nothing of the kind is known, and it is no longer so
    body = replace(proof.scene.body, mu=Fraction(1, 1000))
    rubbed = prove(replace(proof.scene, body=body))
    assert rubbed.all_events["phi_dot_zero"].failure is None
    assert len(rubbed.all_events["phi_dot_zero"].zeros) > 0
