"""Seeded random tops and starts; some lose contact and some begin near a pole."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from tt_precise.integration import integrate
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import require_contact
from tt_precise.runtime.values import InputError
from tt_precise.scene.body import TippeTop
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Inclination, Scene, Start


def gliding_scenes(until_s: Fraction | int) -> Iterator[Scene]:
    """Gliding tops on a table that has to push all the way to ``until_s``; the same every time."""
    seed = 0
    while True:
        scene = random_scene(random.Random(seed), f"scene-{seed}")
        seed += 1
        scene = replace(scene, until=Fraction(until_s), sample_every=Fraction(1, 100))
        if scene.model != "gliding" or not stands(scene):
            continue
        if integrate(scene, events=(), record=()).status == "complete":
            yield scene


def random_scene(draws: random.Random, name: str) -> Scene:
    """A top and a start, gliding or rolling, for 0.05 to 0.6 s."""

    def number(low: float, high: float) -> Fraction:
        return Fraction(round(1e6 * draws.uniform(low, high)), 10**6)

    I1 = number(0.2, 0.6)
    body = TippeTop.from_ratios(
        m=number(0.01, 0.03), R=number(0.01, 0.03), alpha=number(0.02, 0.6), I1=I1,
        I3=min(number(0.2, 0.6), 2 * I1), g="9.82", mu=number(0, 1),
    )  # fmt: skip
    rolling = draws.random() < 0.15
    tilt = number(0.02, 3.1)
    if draws.random() < 0.1:  # near a pole, where the Euler rates are ill conditioned
        tilt /= 10 ** draws.randint(2, 6)
    gliding = {} if rolling else {"nu_x": number(-0.2, 0.2), "nu_y": number(-0.2, 0.2)}
    start = Start(
        Inclination.parse(str(tilt)), theta_dot=number(-5, 5), phi_dot=number(-5, 5),
        omega_3=number(-200, 200), **gliding,
    )  # fmt: skip
    until = number(0.05, 0.6)
    return Scene(
        name=name, model="rolling" if rolling else "gliding", body=body, start=start,
        until=until, sample_every=until,
    )  # fmt: skip


def stands(scene: Scene) -> bool:
    """Test that the table has to push at the start."""
    double = precision_named("double")
    start = InitialState.of(scene, double.arithmetic)
    try:
        require_contact(scene.name, start, double.context, "unilateral")
    except InputError:
        return False
    return True
