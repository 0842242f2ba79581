"""Proofs beside golden data: damage to them is found and named, and ends what they prove."""

import json
import shutil
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import product
from operator import sub, truediv
from pathlib import Path

import pytest

from tests.golden.tables import edit_cell, edit_json
from tt_precise.golden import proofs, store
from tt_precise.golden.proofs import PROOF, Interval, established
from tt_precise.golden.store import EVENTS, SCENE, TRAJECTORY
from tt_precise.golden.table import EXACTLY, last_digit_exponent
from tt_precise.golden.verifying import inspect
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

NAME = "from-initiation"  # the shortest with all times of the climb


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the committed golden data of one scene, with their proof, to spoil."""
    shutil.copytree(store.home() / NAME, tmp_path / NAME)
    return tmp_path


@pytest.fixture
def scene() -> Scene:
    return load_scene(NAME)


def added(folder: Path, file: str, line: int, column: str, count: int) -> None:
    """Add ``count`` units in the last place to one cell of a table."""

    def change(cell: str) -> str:
        return str(EXACTLY.add(Decimal(cell), count * Decimal(f"1e{last_digit_exponent(cell)}")))

    edit_cell(folder / NAME / file, line, column, change)


def problem(folder: Path) -> str:
    """Why the proof is not valid."""
    with pytest.raises(InputError) as refusal:
        proofs.read_proof(store.read_files(NAME, folder))
    return str(refusal.value)


def refused(scene: Scene, folder: Path) -> str:
    """Why the proof establishes nothing."""
    proof = established(scene, folder)
    assert proof.stored is None
    return proof.why


def test_the_committed_proof_establishes_its_scene(scene: Scene) -> None:
    proof = established(scene)
    assert proof.why == ""
    assert proof.g_n_positive
    for definition, which in product("ABC", ("t_init", "t_end")):
        moment = proof.moment(definition, which)
        assert moment is not None
        assert moment.high - moment.low < Fraction(1, 10**25)
        # the scene begins where the climb does: that time is known exactly
        begins = which == "t_init" and moment.low == moment.high == 0
        assert begins or 0 < moment.low < moment.high
    assert proof.moment("D", "t_init") is None


def test_enclosures_hold_what_is_exact(scene: Scene) -> None:
    proof = established(scene)
    found = proof.events("equator")
    assert proof.stored is not None
    assert found is not None
    rows = [row for row in proof.stored.events.rows if row[0] == "equator"]
    assert len(found) == len(rows) > 0
    for event, row in zip(found, rows, strict=True):
        # half a unit of the last digit, either way
        half = Fraction(10) ** last_digit_exponent(row[1]) / 2
        assert event["t"].low == Fraction(row[1]) - half
        assert event["t"].high == Fraction(row[1]) + half
        assert event["direction"].low == event["direction"].high == int(row[2])
        # cos theta is zero there
        assert Fraction(-1, 10**33) < event["kz"].low <= 0 <= event["kz"].high
    assert proof.events("eclipse") is None
    # omega_3 of the start is exact: L.k = I3 omega_3
    kx, kz, Lx, Lz = (ball.low for n in ("kx", "kz", "Lx", "Lz") if (ball := proof.at(n, "0")))
    spin = scene.body.I3 * scene.start.omega_3
    assert abs((kx * Lx + kz * Lz) / spin - 1) < Fraction(1, 10**30)
    assert proof.at("kx", "0.0001") is None
    for name, exact in (("theta", scene.start.theta.offset), ("omega_3", scene.start.omega_3)):
        ball = proof.at(name, "0")
        assert ball is not None
        assert ball.low <= exact <= ball.high < ball.low + Fraction(1, 10**30)


@pytest.mark.parametrize(
    ("file", "column", "count"),
    [(TRAJECTORY, "theta", 1), (TRAJECTORY, "nu_y", -1), (EVENTS, "t", 1), (EVENTS, "kz", -1)],
)
def test_another_table_than_the_proved_one_establishes_nothing(
    folder: Path, file: str, column: str, count: int
) -> None:
    added(folder, file, 12, column, count)
    assert f"{file}: not the table that was proved" in problem(folder)
    assert refused(load_scene(NAME), folder)


def test_a_proof_of_some_numbers_is_none(folder: Path) -> None:
    edit_json(folder / NAME / PROOF, lambda content: content.update(rounded=7), json.dumps)
    store.record_proof(folder / NAME)
    assert "not every number is proved" in problem(folder)
    listed = proofs.summary(store.read_files(NAME, folder))
    assert listed == {"problem": problem(folder)}


def test_other_events_and_another_scene_are_not_those_that_were_proved(
    folder: Path, scene: Scene
) -> None:
    body = replace(scene.body, mu=scene.body.mu + Fraction(1, 10**45))
    assert "another start, body or horizon" in refused(replace(scene, body=body), folder)
    path = folder / NAME / EVENTS
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:5] + lines[6:]))
    assert "not the table that was proved" in problem(folder)
    assert refused(scene, folder)
    path.write_text("".join(lines))
    path = folder / NAME / SCENE
    path.write_text(path.read_text().replace('mu = "0.3"', 'mu = "0.30001"'))
    assert f"{PROOF}: about another scene than {SCENE} says" in problem(folder)


def test_a_missing_proof_says_what_to_do(folder: Path, scene: Scene) -> None:
    (folder / NAME / PROOF).unlink()
    assert proofs.summary(store.read_files(NAME, folder)) is None
    assert "golden certify" in refused(scene, folder)
    assert f"{PROOF}: missing, but manifest.json lists it" in "".join(inspect(NAME, folder)[1])


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"schema": "tt_precise.proof/4"}', '{"schema": 7}']
)
def test_a_proof_that_is_none_is_refused(folder: Path, scene: Scene, text: str) -> None:
    (folder / NAME / PROOF).write_text(text)
    assert "the proof cannot be used" in problem(folder) == refused(scene, folder)


def test_intervals_reach_from_the_least_corner_to_the_largest() -> None:
    ends = [Fraction(x) for x in ("-3", "-0.5", "0", "0.25", "2")]
    intervals = [Interval(a, b) for a, b in product(ends, ends) if a <= b]
    for one, other, operation in product(intervals, intervals, (sub, truediv)):
        assert (one < other) == (one.high < other.low) == (other > one)
        if operation is truediv and other.low <= 0 <= other.high:
            with pytest.raises(ZeroDivisionError):
                one / other
        else:
            corners = [operation(a, b) for a, b in product(one, other)]
            assert [*operation(one, other)] == [min(corners), max(corners)]


def test_what_is_no_ball_is_refused() -> None:
    for ball in (("nan", "1"), ("1", "inf"), ("1", "-1")):
        with pytest.raises(ArithmeticError, match="expected a middle and a radius"):
            Interval.around(*ball)
    low, high = Fraction(3, 20) - Fraction(2, 10**40), Fraction(3, 20) + Fraction(2, 10**40)
    assert [*Interval.around("1.5e-1", "2e-40")] == [low, high]


def test_a_printed_number_encloses_the_exact_one() -> None:
    for text, low, high in (("-2e-3", "-2.5e-3", "-1.5e-3"), ("0", "-5e-35", "5e-35")):
        assert [*Interval.of_printed(text, Decimal("0.5"))] == [Fraction(low), Fraction(high)]
