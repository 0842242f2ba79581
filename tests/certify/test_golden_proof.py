"""Printed tables compared with a proof, and the files that go beside them."""

import json
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.golden.tables import other_digit, with_cell
from tt_precise.certify.balls import NotProved
from tt_precise.certify.certificate import FILE, Accepted, Refused, TooWide
from tt_precise.certify.golden_proof import certify, check, checked, compared, proved
from tt_precise.certify.proof import Proof, prove
from tt_precise.commands.golden import certify_command as command
from tt_precise.golden import proofs, store
from tt_precise.golden.proofs import ENCLOSURE, PROOF
from tt_precise.golden.runs import exact_decimal
from tt_precise.golden.store import (
    EVENTS,
    MANIFEST,
    SCENE,
    TRAJECTORY,
    Stored,
    record_proof,
)
from tt_precise.golden.table import Table
from tt_precise.integration import catalogue
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import parse_scene

NAME = "short"


@pytest.fixture(scope="module")
def scene() -> tt.Scene:
    text = tt.load_scene("reference").text
    return parse_scene(text.replace('until = "8"', 'until = "0.05"'), NAME, NAME)


@pytest.fixture(scope="module")
def stored(scene: tt.Scene) -> Stored:
    """Tables as golden data have them, printed from heyoka's own numbers at 200 bits."""
    run = tt.integrate(scene, precision="mp", bits=200, events=catalogue("gliding"))
    trajectory = _printed(run.frame(numbers="exact"))
    times = map(exact_decimal, scene.sample_times)
    rows = [(str(t), *row[1:]) for t, row in zip(times, trajectory.rows, strict=True)]
    return Stored(
        NAME,
        scene.text,
        Table(trajectory.columns, tuple(rows)),
        _printed(run.events),
        store.read("reference").manifest,  # whose hashes are those of other tables
    )


@pytest.fixture(scope="module")
def proof(scene: tt.Scene) -> Proof:
    return prove(scene)


def _run(*arguments: str) -> int:
    status: int = command.main(args=list(arguments), standalone_mode=False)
    return status


def _printed(frame: pandas.DataFrame) -> Table:
    def cell(value: object) -> str:
        return "0" if abs(value) < 1e-40 else f"{Decimal(str(value)):.33e}"  # type: ignore[arg-type]

    texts = ("name", "direction")
    return Table.of_columns(
        {str(n): [str(x) if n in texts else cell(x) for x in frame[n]] for n in frame.columns}
    )


def changed(stored: Stored, file: str, table: Table) -> Stored:
    """The golden data with another table."""
    field = "events" if file == EVENTS else "trajectory"
    return replace(stored, **{field: table})  # type: ignore[arg-type]


def test_every_printed_digit_is_proved(stored: Stored, proof: Proof) -> None:
    certificate = compared(stored, proof)
    assert certificate.record.complete
    assert not certificate.complete  # the checker was not asked
    assert checked(stored, certificate).complete
    assert certificate.digits == 34
    assert certificate.content["rounded"] == certificate.content["entries"] > 100
    assert certificate.content["unproved"] == 0
    assert certificate.compared.count("wrong") == 0
    assert certificate.content["contact"]["g_n_positive"]
    assert certificate.content["contact"]["energy_never_grows"]


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_a_digit_spoiled_in_the_30th_place_is_proved_wrong(
    stored: Stored, proof: Proof, file: str
) -> None:
    spoiled = with_cell(stored.table(file), 2, "vy", lambda cell: other_digit(cell, 31))
    certificate = compared(changed(stored, file, spoiled), proof)
    assert not certificate.complete
    assert certificate.compared.count("wrong") == 1
    assert certificate.content[file]["columns"]["vy"]["wrong"] == 1
    assert "1 WRONG" in certificate.summary


def _emptied(table: Table) -> Table:
    return with_cell(table, 2, "phi_dot", lambda _: "")


def _renamed(table: Table) -> Table:
    return with_cell(table, 0, "name", lambda _: "eclipse")


def _later(table: Table) -> Table:
    return with_cell(table, 2, "t", lambda _: "0.0200001")


def _retold(table: Table) -> Table:
    """The same time, with another zero."""
    return with_cell(table, 2, "t", lambda time: f"{time}0")


def _widened(table: Table) -> Table:
    return Table((*table.columns, "luck"), tuple((*row, "7") for row in table.rows))


TAMPERINGS = {
    "an event of another name": (EVENTS, _renamed),
    "a wrong time": (TRAJECTORY, _later),
    "a time in other words": (TRAJECTORY, _retold),
    "the last rows cut off": (TRAJECTORY, lambda t: Table(t.columns, t.rows[:-2])),
    "the last events cut off": (EVENTS, lambda t: Table(t.columns, t.rows[:-1])),
    "an emptied cell": (TRAJECTORY, _emptied),
    "an emptied cell of an event": (EVENTS, _emptied),
    "an extra row": (TRAJECTORY, lambda t: Table(t.columns, (*t.rows, t.rows[-1]))),
    "an extra event": (EVENTS, lambda t: Table(t.columns, (*t.rows, t.rows[-1]))),
    "an extra column": (TRAJECTORY, _widened),
    "an extra column of events": (EVENTS, _widened),
    "events in another order": (EVENTS, lambda t: Table(t.columns, t.rows[::-1])),
}


@pytest.mark.parametrize("name", TAMPERINGS)
def test_what_was_tampered_with_is_not_certified(stored: Stored, proof: Proof, name: str) -> None:
    file, tampered = TAMPERINGS[name]
    table = tampered(stored.table(file))
    assert table != stored.table(file)
    certificate = compared(changed(stored, file, table), proof)
    assert not certificate.complete
    found = certificate.content["mismatches"]
    assert found
    if tampered is _later:
        assert found == [f"{TRAJECTORY}, line 4: got t = 0.0200001, expected 0.02"]


def test_events_that_do_not_exist_are_named_in_order(stored: Stored, proof: Proof) -> None:
    # a set's own order changes from process to process, and with it proof.json
    made_up = [f"eclipse{letter}" for letter in "hgfedcba"]
    rows = [(name, *row[1:]) for name, row in zip(made_up, stored.events.rows, strict=False)]
    events = Table(stored.events.columns, (*rows, *stored.events.rows))
    found = compared(replace(stored, events=events), proof).content["mismatches"]
    named = [one for one in found if "which does not exist" in one]
    assert len(named) == len(rows) > 3
    assert named == sorted(named)


def test_numbers_that_no_proof_reaches_are_counted(stored: Stored, proof: Proof) -> None:
    # the proof of the first 0.02 s, held against tables of 0.05 s
    shorter = prove(replace(stored.scene, until=Fraction(1, 50)))
    failed = replace(shorter.enclosure, failure=NotProved("S4", "as if"))
    certificate = compared(stored, replace(shorter, enclosure=failed))
    assert not certificate.complete
    whole = compared(stored, proof)
    assert certificate.content["entries"] == whole.content["entries"]
    assert 0 < certificate.content["rounded"] < whole.content["rounded"]
    assert certificate.content["unproved"] > 0
    kx = certificate.content[TRAJECTORY]["columns"]["kx"]
    assert (kx["entries"], kx["rounded"]) == (len(stored.trajectory.rows), 3)


def test_too_few_bits_prove_fewer_digits(stored: Stored) -> None:
    certificate = compared(stored, prove(stored.scene, bits=100))
    assert certificate.compared.count("wrong") == 0
    assert certificate.digits is not None
    assert 15 < certificate.digits < 30
    assert certificate.content["rounded"] < certificate.content["entries"]


def _write(stored: Stored, folder: Path) -> None:
    texts = {
        SCENE: stored.scene_text,
        TRAJECTORY: stored.trajectory.csv(),
        EVENTS: stored.events.csv(),
        MANIFEST: store.manifest_text(stored.manifest),
    }
    store.replace_folder(folder / NAME, texts)


def test_certify_writes_the_proof_and_verify_reads_it(stored: Stored, tmp_path: Path) -> None:
    _write(stored, tmp_path)
    assert _run(NAME, "--folder", str(tmp_path)) == 0
    content = json.loads((tmp_path / NAME / PROOF).read_text())
    assert content["failure"] is None
    assert content[TRAJECTORY]["columns"]["theta"]["digits"] == 34
    enclosure = Table.parse((tmp_path / NAME / ENCLOSURE).read_text())
    assert len(enclosure.rows) == 6
    record = proofs.read(NAME, tmp_path)
    assert record is not None
    assert (record.content, record.digits, record.complete) == (content, 34, True)
    assert proofs.complaints(store.read(NAME, tmp_path), record) == []
    proof_of_it, why = proofs.established(stored.scene, tmp_path)
    assert proof_of_it is not None, why
    for name in enclosure.columns[1:]:
        for (t, *_), printed in zip(
            stored.trajectory.rows, stored.trajectory.column(name), strict=True
        ):
            ball = proof_of_it.at(name, t)
            assert ball is not None
            if printed == "0":
                assert ball.high - ball.low < Fraction(1, 10**30)
            else:
                assert (ball.high - ball.low) / abs(ball.low) < Fraction(1, 10**35)
                assert abs(ball.low / Fraction(Decimal(printed)) - 1) < Fraction(1, 10**33)


def test_what_the_checker_refuses_is_not_written(
    stored: Stored, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _write(stored, tmp_path)

    def refused(*given: object) -> None:
        raise Refused("as if")

    monkeypatch.setattr("tt_precise.certify.golden_proof.check", refused)
    certificate = certify(NAME, folder=tmp_path)
    assert certificate.record.complete
    assert certificate.objection == "the checker: as if"
    assert not (tmp_path / NAME / PROOF).exists()
    assert _run(NAME, "--folder", str(tmp_path)) == 1


def test_bits_are_added_where_the_checker_needs_them(monkeypatch: pytest.MonkeyPatch) -> None:
    def narrow(stored: Stored, content: dict[str, Any], *_: object) -> Accepted:
        if content["bits"] < 264:
            raise TooWide("as if")
        return check(stored, content)

    monkeypatch.setattr("tt_precise.certify.golden_proof.check", narrow)
    made = proved("upright", None, 200)
    assert made.complete
    assert made.content["bits"] == 264


def test_a_wrong_scene_cannot_be_certified(stored: Stored, tmp_path: Path) -> None:
    # the tables of one friction, the equations of another that differs in the 30th digit
    text = stored.scene_text.replace('mu = "0.3"', 'mu = "0.300000000000000000000000000001"')
    assert text != stored.scene_text
    _write(replace(stored, scene_text=text), tmp_path)
    certificate = certify(NAME, folder=tmp_path)
    assert not (tmp_path / NAME / PROOF).exists()  # what is not whole is not written
    assert not (tmp_path / NAME / FILE).exists()
    assert certificate.compared.count("wrong") > 0
    assert _run(NAME, "--folder", str(tmp_path)) == 1


@pytest.mark.parametrize(
    ("cell", "file", "column"),
    [
        ("abc", TRAJECTORY, "kx"), ("nan", TRAJECTORY, "t"), ("inf", EVENTS, "t"),
        ("1/3", EVENTS, "nu_y"), ("1e999999999", TRAJECTORY, "kx"), ("0x1", EVENTS, "nu_y"),
    ],
)  # fmt: skip
def test_what_is_no_number_is_refused_before_anything_is_proved(
    stored: Stored, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cell: str, file: str,
    column: str,
) -> None:  # fmt: skip
    spoiled = with_cell(stored.table(file), 1, column, lambda _: cell)
    _write(changed(stored, file, spoiled), tmp_path)
    monkeypatch.setattr("tt_precise.certify.golden_proof.prove", None)
    with pytest.raises(
        InputError, match=rf"{file}, line 3, {column}: got '{cell}', expected a pri"
    ):
        certify(NAME, folder=tmp_path)


@pytest.mark.parametrize(
    ("kept", "message"),
    [
        (lambda _: {}, ": got schema"),
        # its own hash no longer fits
        (lambda content: content | {"title": "another"}, " has changed since it was built"),
    ],
)
def test_what_no_build_wrote_is_neither_proved_nor_sealed(
    stored: Stored, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    kept: Callable[[dict[str, Any]], dict[str, Any]], message: str,
) -> None:  # fmt: skip
    _write(stored, tmp_path)
    manifest = tmp_path / NAME / MANIFEST
    manifest.write_text(json.dumps(kept(json.loads(manifest.read_text()))))
    before = manifest.read_text()
    with pytest.raises(InputError, match=f"manifest.json{message}"):
        record_proof(tmp_path / NAME)
    monkeypatch.setattr("tt_precise.certify.golden_proof.prove", None)
    with pytest.raises(InputError, match=f"manifest.json{message}"):
        certify(NAME, folder=tmp_path)
    assert manifest.read_text() == before
    assert not (tmp_path / NAME / PROOF).exists()
