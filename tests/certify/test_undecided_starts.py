"""Seeded starts whose signs at t = 0 are hard to decide: no proof that another run contradicts."""

from __future__ import annotations

import os
import random
from dataclasses import replace
from fractions import Fraction

import flint
import pytest
from flint import arb

import tt_precise as tt
from tt_precise.certify import NotProved, checker, prove
from tt_precise.certify.certificate import Refused, content_of
from tt_precise.golden.store import Stored
from tt_precise.golden.table import Table
from tt_precise.integration.events import catalogue
from tt_precise.scene.scene import Inclination, Scene

UNTIL = Fraction(1, 2000)
NEAR = 2.0**-70  # relative, of times
NOTHING = Table((), ())
RUN = int(os.environ.get("TT_PRECISE_STARTS", "100"))


def small(dice: random.Random) -> Fraction:
    """Zero, or of any size down to 1e-40, of either sign."""
    if dice.random() < 0.3:
        return Fraction(0)
    return dice.choice((-1, 1)) * Fraction(dice.randint(1, 9), 10 ** dice.randint(0, 40))


def start(seed: int) -> Scene:
    """A scene in which several functions vanish, or almost, at t = 0."""
    dice = random.Random(seed)
    scene = tt.load_scene(dice.choice(("reference", "tippetopsim", "frictionless")))
    theta = dice.choice(("0.1", "1.5", "1.5707963267948966", "3", "pi - 1e-3", "1e-6"))
    made = replace(
        scene.start, theta=Inclination.parse(theta), theta_dot=small(dice), phi_dot=small(dice),
        omega_3=dice.choice((Fraction(155), Fraction(20), small(dice))),
        nu_x=small(dice), nu_y=small(dice),
    )  # fmt: skip
    body = replace(scene.body, alpha=Fraction(dice.randint(5, 60), 100))
    return replace(scene, start=made, body=body, until=UNTIL)


def contradictions(seed: int) -> list[str]:
    """Events that the second checker encloses otherwise than a proof; [] if nothing is proved."""
    scene = start(seed)
    try:
        proof = prove(scene)
    except NotProved:
        return []
    if not proof.complete or proof.lost:
        return []
    stored = Stored(scene.name, scene.text, NOTHING, NOTHING, {})
    try:
        checked = checker.enclose(scene, content_of(stored, proof)).events
    except Refused as why:
        if "undecided" not in str(why):
            raise
        return []
    return [
        f"seed {seed}, {name}: proved {found}, the checker {checked[name]}"
        for name, found in proof.enclosed.events.items()
        if len(found) != len(checked[name])
        or any(
            a.direction != b.direction or not a.time.overlaps(b.time)
            for a, b in zip(found, checked[name], strict=True)
        )
    ]


@pytest.mark.parametrize("seed", [0, 1, 10])
def test_no_proof_is_contradicted(seed: int) -> None:
    assert contradictions(seed) == []


def test_events_are_those_that_a_run_sees() -> None:
    # heyoka at 240 bits
    scene = start(10)
    run = tt.integrate(scene, precision="mp", bits=240, events=catalogue(scene.model))
    proved = prove(scene).enclosed.events
    assert len(run.events) == sum(map(len, proved.values())) > 0
    for name, found in proved.items():
        rows = run.events[run.events["name"] == name]
        assert list(rows["direction"]) == [one.direction for one in found]
        for one, t in zip(found, rows["t"], strict=True):
            with flint.ctx.workprec(300):
                assert abs(one.time / arb(str(t)) - 1) < NEAR


@pytest.mark.proofs
def test_no_proof_of_many_is_contradicted() -> None:
    # TT_PRECISE_STARTS=10000 for all that have been promised; 100 take 20 s or more
    assert [line for seed in range(RUN) for line in contradictions(seed)] == []
