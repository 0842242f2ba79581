"""Steps prepared by other processes: the same proof, bit for bit."""

from __future__ import annotations

import pickle
import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

import flint
from flint import arb, arb_poly

import tt_precise as tt
from tt_precise.certify import NotProved, Proof, balls, prove
from tt_precise.certify.ahead import Ahead, Made, Pace


def bits_of(proof: Proof) -> list[Any]:
    """All numbers of a proof, as integers."""
    return [
        [pickle.dumps(one) for one in (stretch.begin, stretch.piece, stretch.radius)]
        + [pickle.dumps(band.polynomial) for band in (*stretch.tube, *stretch.rates)]
        for stretch in proof.enclosure.stretches
    ]


def test_a_proof_does_not_depend_on_the_number_of_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    # 7 stretches, and steps that fail among them: what was made ahead is made again
    failed, again = [], Ahead.again

    def noted(ahead: Ahead, made: Made) -> None:
        failed.append(made)
        again(ahead, made)

    monkeypatch.setattr(Ahead, "again", noted)
    scene = replace(tt.load_scene("regularised-1e-4"), until=Fraction(1, 50))
    alone = bits_of(prove(scene))
    assert failed
    assert bits_of(prove(scene, workers=2)) == alone
    assert len(failed) % 2 == 0
    # the negative control: the last bits of a start count
    start = replace(scene.start, nu_y=scene.start.nu_y + Fraction(1, 10**59))
    assert bits_of(prove(replace(scene, start=start))) != alone


def test_balls_are_the_same_in_another_process() -> None:
    dice = random.Random(1)
    with flint.ctx.workprec(216):
        numbers = [
            (arb(dice.uniform(-9, 9)).sin() / 3 + arb(0, 2.0 ** -dice.randint(0, 900)))
            * (1 - dice.random() * arb(0, 2.0 ** -dice.randint(1, 200)))
            for _ in range(300)
        ]
        numbers += [arb(0), arb(-2), arb(1) / 3, arb(0, 1), arb(1, 2)]
    # whatever the precision is there
    for number in numbers:
        found = pickle.loads(pickle.dumps(number))
        assert balls._written(found) == balls._written(number)
    polynomial = arb_poly(numbers)
    coefficients = pickle.loads(pickle.dumps(polynomial)).coeffs()
    assert [*map(balls._written, coefficients)] == [*map(balls._written, polynomial.coeffs())]
    # the negative control: a radius that no ball has, of 31 bits
    with pytest.raises(NotProved, match="not the same"):
        balls._read(1, 0, 2**30 + 1, -40)


def test_a_reason_is_the_same_in_another_process() -> None:
    why = pickle.loads(pickle.dumps(NotProved("S4", "too wide")))
    assert (str(why), why.hypothesis) == ("not proved (S4): too wide", "S4")


def test_the_pace_after_failures() -> None:
    pace = Pace(arb(1), arb(1), arb(1))
    shorter = pace.back(arb(1) / 2)
    assert shorter.limit == 0.25
    assert abs(shorter.ceiling - 0.45) < 1e-15
    # it grows again, no faster than the ceiling allows
    for _ in range(5):
        shorter = shorter.on()
    assert abs(shorter.limit - 0.45 * arb("1.01") ** 5) < 1e-12
