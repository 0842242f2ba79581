"""Printed tables compared with a proof, and the files that go beside them."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec
import pandas
import pytest

import tt_precise as tt
from tests.certify.conftest import altered
from tests.conftest import Patch
from tests.golden.tables import other_digit, with_cell
from tt_precise.certify.balls import NotProved
from tt_precise.certify.certificate import FILE, Accepted, Refused, TooWide
from tt_precise.certify.golden_proof import certify, check, checked, compared, proved
from tt_precise.certify.proof import Proof, prove
from tt_precise.commands.golden import certify_command as command
from tt_precise.golden import proofs, store
from tt_precise.golden.documents import Attempt
from tt_precise.golden.proofs import ENCLOSURE, PROOF
from tt_precise.golden.runs import exact_decimal
from tt_precise.golden.store import EVENTS, MANIFEST, SCENE, TRAJECTORY, Stored, record_proof
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import verify_scene
from tt_precise.integration import catalogue
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import parse_scene

NAME = "short"


@pytest.fixture(scope="module")
def scene() -> tt.Scene:
    text = tt.load_scene("reference").text
    return parse_scene(text.replace('until = "8"', 'until = "0.05"'), NAME, NAME)


def stored_of(scene: tt.Scene) -> Stored:
    """Tables as golden data have them, printed from heyoka's own numbers at 200 bits."""
    run = tt.integrate(scene, precision="mp", bits=200, events=catalogue("gliding"))

    def cell(value: object) -> str:
        return "0" if abs(value) < 1e-40 else f"{Decimal(str(value)):.33e}"  # type: ignore[arg-type]

    def printed(frame: pandas.DataFrame) -> dict[str, list[str]]:
        texts = ("name", "direction")
        return {str(n): [str(x) if n in texts else cell(x) for x in frame[n]] for n in frame}

    trajectory = printed(run.frame(numbers="exact"))
    times = zip(scene.sample_times, trajectory["t"], strict=True)
    trajectory["t"] = [exact_decimal(exact) or cell for exact, cell in times]
    tables = Table.of_columns(trajectory), Table.of_columns(printed(run.events))
    # a manifest whose hashes are those of other tables
    return Stored(NAME, scene.text, *tables, store.read("reference").manifest)


@pytest.fixture(scope="module")
def stored(scene: tt.Scene) -> Stored:
    return stored_of(scene)


@pytest.fixture(scope="module")
def proof(scene: tt.Scene) -> Proof:
    return prove(scene)


def _run(*arguments: str) -> int:
    status: int = command.main(args=list(arguments), standalone_mode=False)
    return status


def test_every_printed_digit_is_proved(stored: Stored, proof: Proof) -> None:
    certificate = compared(stored, proof)
    assert certificate.record.complete
    assert not certificate.complete  # the checker was not asked
    assert checked(stored, certificate).complete
    assert certificate.digits == 34
    content = certificate.content
    assert content["rounded"] == content["entries"] > 100
    assert (content["unproved"], certificate.compared.count("wrong")) == (0, 0)
    assert content["contact"]["g_n_positive"]
    assert content["contact"]["energy_never_grows"]


def test_times_that_are_no_decimals_are_printed_rounded(scene: tt.Scene) -> None:
    text = scene.text.replace('sample_every = "0.01"', 'sample_every = "1/30"')
    thirds = parse_scene(text, NAME, NAME)
    table, proof = stored_of(thirds), prove(thirds)
    assert table.trajectory.column("t")[1] == f"3.{'3' * 33}e-2"
    assert compared(table, proof).record.complete
    other = with_cell(table.trajectory, 1, "t", lambda cell: other_digit(cell, 34))
    assert "expected 3.33" in compared(altered(table, TRAJECTORY, other), proof).objection


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_a_digit_spoiled_in_the_30th_place_is_proved_wrong(
    stored: Stored, proof: Proof, file: str
) -> None:
    spoiled = with_cell(stored.table(file), 2, "vy", lambda cell: other_digit(cell, 31))
    certificate = compared(altered(stored, file, spoiled), proof)
    assert not certificate.complete
    assert certificate.compared.count("wrong") == 1
    assert certificate.content[file]["columns"]["vy"]["wrong"] == 1
    assert "1 WRONG" in certificate.summary


Tampered = Callable[[Table], Table]


def cell_of(row: int, column: str, text: str) -> Tampered:
    return lambda table: with_cell(table, row, column, lambda cell: text.format(cell))


def rows_of(change: Callable[[tuple[Any, ...]], tuple[Any, ...]]) -> Tampered:
    return lambda table: Table(table.columns, change(table.rows))


def widened(table: Table) -> Table:
    return Table((*table.columns, "luck"), tuple((*row, "7") for row in table.rows))


TAMPERINGS: dict[str, tuple[str, Tampered]] = {
    "an event of another name": (EVENTS, cell_of(0, "name", "eclipse")),
    "a wrong time": (TRAJECTORY, cell_of(2, "t", "0.0200001")),
    "a time in other words": (TRAJECTORY, cell_of(2, "t", "{}0")),
    "the last rows cut off": (TRAJECTORY, rows_of(lambda rows: rows[:-2])),
    "the last events cut off": (EVENTS, rows_of(lambda rows: rows[:-1])),
    "an emptied cell": (TRAJECTORY, cell_of(2, "phi_dot", "")),
    "an emptied cell of an event": (EVENTS, cell_of(2, "phi_dot", "")),
    "a cell of one digit": (TRAJECTORY, cell_of(2, "kx", "9e-2")),
    "a cell of an event in another form": (EVENTS, cell_of(2, "kx", "0e9")),
    "an extra row": (TRAJECTORY, rows_of(lambda rows: (*rows, rows[-1]))),
    "an extra event": (EVENTS, rows_of(lambda rows: (*rows, rows[-1]))),
    "an extra column": (TRAJECTORY, widened),
    "an extra column of events": (EVENTS, widened),
    "events in another order": (EVENTS, rows_of(lambda rows: rows[::-1])),
}


@pytest.mark.parametrize("name", TAMPERINGS)
def test_what_was_tampered_with_is_not_certified(stored: Stored, proof: Proof, name: str) -> None:
    file, tampered = TAMPERINGS[name]
    table = tampered(stored.table(file))
    assert table != stored.table(file)
    certificate = compared(altered(stored, file, table), proof)
    assert not certificate.complete
    found = certificate.content["mismatches"]
    assert found
    if name == "a wrong time":
        assert found == [f"{TRAJECTORY}, line 4: got t = 0.0200001, expected 0.02"]
    if name == "an emptied cell of an event":
        assert f"{EVENTS}, line 4, phi_dot: empty, where there is a number" in found


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
    content, whole = certificate.content, compared(stored, proof).content
    assert content["entries"] == whole["entries"]
    assert 0 < content["rounded"] < whole["rounded"]
    assert content["unproved"] > 0
    kx = content[TRAJECTORY]["columns"]["kx"]
    assert (kx["entries"], kx["rounded"]) == (len(stored.trajectory.rows), 3)
    assert msgspec.convert({**content, "complete": False, "digits": None}, Attempt).failure


def test_too_few_bits_prove_fewer_digits(stored: Stored) -> None:
    certificate = compared(stored, prove(stored.scene, bits=100))
    assert certificate.compared.count("wrong") == 0
    assert 15 < (certificate.digits or 0) < 30
    assert certificate.content["rounded"] < certificate.content["entries"]


@pytest.fixture
def place(stored: Stored, tmp_path: Path) -> Path:
    return written(stored, tmp_path)


def written(stored: Stored, folder: Path) -> Path:
    texts = {
        SCENE: stored.scene_text,
        TRAJECTORY: stored.trajectory.csv(),
        EVENTS: stored.events.csv(),
        MANIFEST: store.manifest_text(stored.manifest),
    }
    store.replace_folder(folder / NAME, texts)
    return folder / NAME


def test_certify_writes_the_proof_and_verify_reads_it(stored: Stored, place: Path) -> None:
    folder = place.parent
    assert _run(NAME, "--folder", str(folder)) == 0
    content = json.loads((place / PROOF).read_text())
    assert content["failure"] is None
    assert content[TRAJECTORY]["columns"]["theta"]["digits"] == 34
    enclosure = Table.parse((place / ENCLOSURE).read_text())
    assert len(enclosure.rows) == 6
    record = proofs.read(NAME, folder)
    assert record is not None
    assert (record.content, record.digits, record.complete) == (content, 34, True)
    assert proofs.complaints(store.read(NAME, folder), record) == []
    found = proofs.established(stored.scene, folder)
    assert found.record is not None, found.why
    times = [t for t, *_ in stored.trajectory.rows]
    for name in enclosure.columns[1:]:
        for t, printed in zip(times, stored.trajectory.column(name), strict=True):
            ball = found.at(name, t)
            assert ball is not None
            if printed == "0":
                assert ball.high - ball.low < Fraction(1, 10**30)
            else:
                assert (ball.high - ball.low) / abs(ball.low) < Fraction(1, 10**35)
                assert abs(ball.low / Fraction(printed) - 1) < Fraction(1, 10**33)
    path = place / SCENE
    path.write_text(path.read_text().replace('"155"', '"154"'))
    other = verify_scene(NAME, folder)
    assert (other.verdict, other.digits_proved) == ("fail", None)  # proved of another scene


def test_what_the_checker_refuses_is_not_written(place: Path, monkeypatch: Patch) -> None:
    def refused(*given: object) -> None:
        raise Refused("as if")

    monkeypatch.setattr("tt_precise.certify.golden_proof.check", refused)
    certificate = certify(NAME, folder=place.parent)
    assert certificate.record.complete
    assert certificate.objection == "the checker: as if"
    assert not (place / PROOF).exists()
    assert _run(NAME, "--folder", str(place.parent)) == 1


def test_bits_are_added_where_the_checker_needs_them(monkeypatch: Patch) -> None:
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
    place = written(replace(stored, scene_text=text), tmp_path)
    assert certify(NAME, folder=tmp_path).compared.count("wrong") > 0
    assert not (place / PROOF).exists()  # what is not whole is not written
    assert not (place / FILE).exists()
    assert _run(NAME, "--folder", str(tmp_path)) == 1


@pytest.mark.parametrize(
    ("cell", "file", "column"),
    [
        ("abc", TRAJECTORY, "kx"), ("nan", TRAJECTORY, "t"), ("inf", EVENTS, "t"),
        ("1/3", EVENTS, "nu_y"), ("1e999999999", TRAJECTORY, "kx"), ("0x1", EVENTS, "nu_y"),
    ],
)  # fmt: skip
def test_what_is_no_number_is_refused_before_anything_is_proved(
    stored: Stored,
    tmp_path: Path,
    monkeypatch: Patch,
    cell: str,
    file: str,
    column: str,
) -> None:
    written(altered(stored, file, cell_of(1, column, cell)(stored.table(file))), tmp_path)
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
    place: Path,
    monkeypatch: Patch,
    kept: Callable[[dict[str, Any]], dict[str, Any]],
    message: str,
) -> None:
    manifest = place / MANIFEST
    manifest.write_text(json.dumps(kept(json.loads(manifest.read_text()))))
    before = manifest.read_text()
    monkeypatch.setattr("tt_precise.certify.golden_proof.prove", None)
    for refused in (lambda: record_proof(place), lambda: certify(NAME, folder=place.parent)):
        with pytest.raises(InputError, match=f"manifest.json{message}"):
            refused()
    assert manifest.read_text() == before
    assert not (place / PROOF).exists()


@pytest.mark.proofs
@pytest.mark.parametrize("name", [name for name in store.scenes() if proofs.read(name)])
def test_committed_proofs_come_out_again(name: str, tmp_path: Path) -> None:
    shutil.copytree(store.home() / name, tmp_path / name)
    certificate = certify(name, folder=tmp_path)
    assert certificate.complete, certificate.summary
    for file in (ENCLOSURE, proofs.EVENTS_ENCLOSURE):
        assert (tmp_path / name / file).read_bytes() == (store.home() / name / file).read_bytes()
    made, committed = (proofs.read(name, place) for place in (tmp_path, store.home()))
    assert made is not None
    assert committed is not None
    # sources and libraries may be others
    for key in made.content.keys() - {"prover", "versions", store.PROOF_HASH}:
        assert made.content[key] == committed.content[key], key
