"""The momentum about the lowest point: proved for any force, and seen in solutions."""

from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.conftest import more
from tests.exact.conftest import Spoil, wrong
from tt_precise.exact.identities import prove
from tt_precise.mechanics import contact_momentum as about_the_contact
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross

IDENTITY = "momentum about the lowest point under any contact force"


def off(value: Any) -> Any:
    return value + (0 * value + 1) / 10**40


@pytest.mark.parametrize(
    "spoil",
    [
        wrong(about_the_contact, "contact_momentum", 0, change=off),
        wrong(about_the_contact, "contact_momentum_rate", 2, change=off),
        more(wrong(about_the_contact, "contact_lift", change=off)),
        more(wrong(about_the_contact, "normal_force_along", change=off)),
    ],
)
def test_the_proof_needs_every_function(spoil: Spoil, monkeypatch: pytest.MonkeyPatch) -> None:
    assert prove(IDENTITY).holds
    spoil(monkeypatch)
    assert not prove(IDENTITY).holds


@pytest.mark.parametrize("name", ["reference", "rolling", "frictionless"])
def test_the_rate_is_that_of_solutions(name: str) -> None:
    """dQ/dt by finite differences, to every force law."""
    scene, step = tt.load_scene(name), 1e-4
    times = [1.0 - step, 1.0, 1.0 + step]
    frame = tt.integrate(scene, digits=13).frame(*NewtonState._fields, times=times, numbers="float")
    body = scene.body.numbers(float)
    state = NewtonState(*(frame[n].to_numpy() for n in NewtonState._fields))
    q = Motion(body, state, numpy, scene.model)
    k_dot = cross(q.omega, q.k)
    Q = numpy.array(about_the_contact.contact_momentum(body, q.a, q.state.L, q.s_dot))
    rate = numpy.array(about_the_contact.contact_momentum_rate(body, q.a, k_dot, q.s_dot))
    slope = (Q[:, 2] - Q[:, 0]) / (2 * step)
    unit = body.m * body.g * body.R * body.alpha
    assert abs(slope - rate[:, 1]).max() < 1e-4 * unit
    assert abs(rate[:, 1]).max() > 1e-2 * unit
