"""Proofs beside golden data: every damage to them is found and named, and ends what they prove."""

import json
import random
import shutil
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import product
from operator import add, mul, sub, truediv
from pathlib import Path
from typing import Any

import mpmath
import pytest

from tests.golden.tables import edit_cell, edit_json
from tt_precise.golden import proofs, store
from tt_precise.golden.digits import EXACT, last_place
from tt_precise.golden.proofs import ENCLOSURE, EVENTS_ENCLOSURE, PROOF, Interval, established
from tt_precise.golden.store import EVENTS, SCENE, TRAJECTORY
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import inspect, verify_scene
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


def edit_proof(folder: Path, change: Callable[[dict[str, Any]], object], *, seal: bool) -> None:
    edit_json(folder / NAME / PROOF, change, store.proof_text if seal else json.dumps)


def added(folder: Path, file: str, line: int, column: str, count: int) -> None:
    """Add ``count`` units in the last place to one cell of a table."""

    def change(cell: str) -> str:
        return str(EXACT.add(Decimal(cell), count * Decimal(f"1e{last_place(cell)}")))

    edit_cell(folder / NAME / file, line, column, change)


def problems(folder: Path) -> list[str]:
    record = proofs.read(NAME, folder)
    assert record is not None
    return proofs.complaints(store.read(NAME, folder), record)


def refused(scene: Scene, folder: Path) -> str:
    """Why the proof establishes nothing."""
    proof = established(scene, folder)
    assert proof.record is None
    return proof.why


def test_the_committed_proof_establishes_its_scene(scene: Scene) -> None:
    proof = established(scene)
    assert proof.record is not None, proof.why
    assert (proof.record.complete, proof.record.digits) == (True, 34)
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
        # closer to the exact time than what is printed is
        half = Fraction(5, 10**34)
        assert event["t"].low - half <= Fraction(row[1]) <= event["t"].high + half
        assert event["t"].high - event["t"].low < half / 100
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


def test_an_edited_proof_or_enclosure_is_found_and_named(folder: Path, scene: Scene) -> None:
    added(folder, ENCLOSURE, 7, "Ly", 5000)
    assert problems(folder) == [f"{ENCLOSURE}: changed since it was written"]
    assert refused(scene, folder)
    edit_proof(folder, lambda stated: stated["contact"].update(g_n_positive=False), seal=False)
    found = problems(folder)
    assert found[0] == f"{PROOF}: edited after it was written"
    assert refused(scene, folder) == found[0]
    assert inspect(NAME, folder)[1] == found


@pytest.mark.parametrize(
    ("file", "column", "count"),
    [
        (TRAJECTORY, "theta", 1),
        (TRAJECTORY, "phi_dot", 1),
        (TRAJECTORY, "nu_y", -1),
        (EVENTS, "t", 4_999_999_999_999),
        (EVENTS, "Lx", 999_999),
        (EVENTS, "t", 1),
        (EVENTS, "kz", -1),
        (EVENTS, "theta", 1),
        (EVENTS, "omega_3", 1),
    ],
)
def test_every_printed_number_is_held_against_its_enclosure(
    folder: Path, file: str, column: str, count: int
) -> None:
    """Also where the hashes of the table and of the proof are made to fit."""
    excluded = f"{file}, line 12, {column}: excluded by its enclosure"
    added(folder, file, 12, column, count)
    assert excluded in problems(folder)
    assert any("not the table that was proved" in one for one in problems(folder))
    assert refused(load_scene(NAME), folder)
    sha256 = store.read(NAME, folder).table(file).sha256
    edit_proof(folder, lambda content: content[file].update(sha256=sha256), seal=True)
    assert problems(folder) == [excluded]


def _moved(content: dict[str, Any]) -> None:
    ball = content["inversion"]["A"]["t_init"]
    ball["middle"] = str(Decimal(ball["middle"]) + Decimal("1e-32"))


KX, T = (lambda c: c[TRAJECTORY]["columns"]["kx"]), (lambda c: c[EVENTS]["columns"]["t"])
EDITS: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "contact": (lambda c: c["contact"].update(g_n_at_least_mg="0.9"), "contact force"),
    "energy": (lambda c: c["contact"].update(energy_never_grows=False), "energy may grow"),
    "lost": (
        lambda c: c.update(contact={"g_n_positive": "x", "lost_at_s": c["inversion"]["equator"]}),
        "contact is lost at another time",
    ),
    "times": (_moved, "A, t_init is not where"),
    "no times": (lambda c: c["inversion"]["B"].update(t_end=None), "B, t_end is none"),
    "event counts": (lambda c: c["proved_events"].update(theta_min=999), "999 events theta_min"),
    "kinds of events": (lambda c: c["proved_events"].pop("equator"), "kinds of events"),
    "digits": (lambda c: c.update(digits=99), "digits is not the least"),
    "digits of a column": (lambda c: KX(c).update(digits=35), "35 digits"),
    "entries": (lambda c: T(c).update(entries=7), "other entries of t"),
    "rounded ones": (lambda c: T(c).update(rounded=-1), "other entries of t"),
    "wrong ones": (lambda c: T(c).update(wrong=1), "1 entries of t are"),
    "rounded": (lambda c: c.update(rounded=7), "rounded is not the sum"),
}


@pytest.mark.parametrize("name", EDITS)
def test_a_proof_edited_with_its_seal_renewed_is_found(folder: Path, name: str) -> None:
    change, complaint = EDITS[name]
    edit_proof(folder, change, seal=True)
    assert any(complaint in one for one in problems(folder))
    if name == "digits":  # the list of scenes checks what it says
        listed = proofs.summary(store.read(NAME, folder), folder)
        assert listed == {"problem": f"{PROOF}: digits is not the least over the columns"}


def test_other_events_and_another_scene_are_not_those_that_were_proved(
    folder: Path, scene: Scene
) -> None:
    body = replace(scene.body, mu=scene.body.mu + Fraction(1, 10**45))
    assert "another start, body or horizon" in refused(replace(scene, body=body), folder)
    path = folder / NAME / EVENTS
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:5] + lines[6:]))
    assert any("not the table that was proved" in one for one in problems(folder))
    assert refused(scene, folder)
    path.write_text("".join(lines))
    path = folder / NAME / SCENE
    path.write_text(path.read_text().replace('mu = "0.3"', 'mu = "0.30001"'))
    assert problems(folder) == [f"{PROOF}: about another scene than {SCENE} says"]


def test_a_missing_proof_says_what_to_do(folder: Path, scene: Scene) -> None:
    (folder / NAME / PROOF).unlink()
    with pytest.raises(InputError, match="golden certify"):
        proofs.read(NAME, folder)
    (folder / NAME / ENCLOSURE).unlink()
    (folder / NAME / EVENTS_ENCLOSURE).unlink()
    assert proofs.read(NAME, folder) is None
    assert "golden certify" in refused(scene, folder)


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"schema": "tt_precise.proof/4"}', '{"schema": 7}']
)
def test_a_proof_that_is_none_is_refused(folder: Path, scene: Scene, text: str) -> None:
    (folder / NAME / PROOF).write_text(text)
    with pytest.raises(InputError):
        proofs.read(NAME, folder)
    assert refused(scene, folder)


def test_a_proof_that_ends_early_establishes_nothing(folder: Path, scene: Scene) -> None:
    why = "not proved (S4): far"
    edit_proof(folder, lambda c: c.update(failure=why, inversion={"failure": why}), seal=True)
    assert problems(folder) == []
    assert "S4" in refused(scene, folder)
    none = {"t_init": None, "t_end": None}
    no_climb = {"equator": None, "A": none, "B": none, "C": none}
    edit_proof(folder, lambda c: c.update(inversion=no_climb), seal=True)
    assert problems(folder) == [f"{PROOF}: no climb, by a proof that ends early"]


@pytest.mark.parametrize("version", [0, 10**6, "1", None, 1.5])
def test_a_proof_by_another_prover_is_refused(folder: Path, scene: Scene, version: object) -> None:
    """One older than the last change that mattered to soundness, or one that nobody knows."""
    edit_proof(folder, lambda content: content["prover"].update(version=version), seal=True)
    with pytest.raises(InputError, match="version"):
        proofs.read(NAME, folder)
    assert refused(scene, folder)
    assert verify_scene(NAME, folder).verdict == "fail"


def test_intervals_reach_from_the_least_corner_to_the_largest() -> None:
    ends = [Fraction(x) for x in ("-3", "-0.5", "0", "0.25", "2")]
    intervals = [(a, b) for a, b in product(ends, ends) if a <= b]
    for one, other, operation in product(intervals, intervals, (add, sub, mul, truediv)):
        if operation is truediv and other[0] <= 0 <= other[1]:
            with pytest.raises(ZeroDivisionError):
                Interval(*one) / Interval(*other)
            continue
        corners = [operation(a, b) for a, b in product(one, other)]
        found = operation(Interval(*one), Interval(*other))
        assert (found.low, found.high) == (min(corners), max(corners))
    for one, other in product(intervals, intervals):
        below = one[1] < other[0]
        assert (Interval(*one) < Interval(*other)) == below == (Interval(*other) > Interval(*one))


def test_pi_is_enclosed() -> None:
    with mpmath.workdps(80):
        truth = Fraction(mpmath.nstr(+mpmath.pi, 78))
    assert proofs.PI.low < truth < proofs.PI.high
    assert proofs.PI.high - proofs.PI.low < Fraction(1, 10**58)


@pytest.mark.parametrize("ball", [("nan", "1"), ("1", "inf"), ("1", "-1"), ("-inf", "0")])
def test_what_is_no_ball_is_refused(ball: tuple[str, str]) -> None:
    with pytest.raises(ArithmeticError, match="expected a middle and a radius"):
        Interval.around(*ball)
    third = Interval.around("1.5e-1", "2e-40")
    assert third.low == Fraction(3, 20) - Fraction(2, 10**40)
    assert third.high - third.low == Fraction(4, 10**40)


SCALE = Decimal("0.5")


def printed(rng: random.Random) -> str:
    """A number as golden tables have it, of 1 to 34 digits."""
    places = rng.choice([0, 1, 5, 20, 33])
    digits = f"{rng.randint(1, 9)}.{rng.randint(0, 10**places - 1):0{places}d}"
    return rng.choice(["", "-"]) + (digits if places else digits[0]) + f"e{rng.randint(-9, 2):+03d}"


@pytest.mark.parametrize("seed", range(5))
def test_a_ball_comes_back_from_its_last_digits(seed: int) -> None:
    """It holds the interval, and is as narrow as three more digits than are printed, or as it.

    What it excludes by a comparison of integers is what fractions say.
    """
    rng = random.Random(seed)
    for _ in range(100):
        text = rng.choice([printed(rng), "0"])
        place = SCALE.adjusted() - 34 if text == "0" else last_place(text)
        unit = Fraction(10) ** (place - proofs.BEYOND)
        middle = Fraction(text) + rng.randint(-600, 600) * unit + unit * Fraction(rng.random())
        reach = unit * Fraction(rng.random()) * Fraction(10) ** rng.randint(-6, 6)
        ball = proofs.ball_text(text, middle - reach, middle + reach, SCALE)
        found = Interval.of_ball(text, ball, SCALE)
        assert found.low <= middle - reach < middle + reach <= found.high
        assert found.high - found.low <= max(2 * unit, 40 * reach)
    for _ in range(100):
        text = printed(rng)
        unit = Fraction(10) ** last_place(text)
        middle = Fraction(text) + unit * Fraction(rng.randint(-120, 120), 100)
        reach = unit * Fraction(10) ** rng.randint(-5, 1)
        ball = proofs.ball_text(text, middle - reach, middle + reach, SCALE)
        found = Interval.of_ball(text, ball, SCALE)
        apart = max(found.low - Fraction(text), Fraction(text) - found.high)
        assert proofs.excludes(text, ball, SCALE) == (apart > unit / 2), (text, ball)


@pytest.mark.parametrize(
    ("text", "ball", "excluded"),
    [
        ("0", "1001", False),
        ("0", "-1002", True),  # 0 is at most 1e-34 of the scale
        ("", "", False),
        ("", "1000", True),
        ("1.0e+0", "", True),
    ],
)
def test_zeros_and_empty_cells(text: str, ball: str, excluded: bool) -> None:
    assert proofs.excludes(text, ball, Decimal(1)) is excluded


@pytest.mark.parametrize("ball", ["nan", "1e999999", "1.5", "1e-3", "e3"])
def test_a_cell_that_is_no_ball_is_a_complaint(folder: Path, ball: str) -> None:
    path = folder / NAME / ENCLOSURE
    edit_cell(path, 5, Table.parse(path.read_text()).columns[3], lambda _: ball)
    sha256 = Table.parse(path.read_text()).sha256
    edit_proof(folder, lambda content: content[ENCLOSURE].update(sha256=sha256), seal=True)
    found = problems(folder)
    assert found
    assert all("cannot be checked" in one or "excluded" in one for one in found)
