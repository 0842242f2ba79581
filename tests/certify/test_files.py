"""Printed tables compared with a proof, and the file that goes beside them."""

import json
import random
import shutil
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import cache, partial
from itertools import cycle
from pathlib import Path
from typing import Any

import pandas
import pytest

import tt_precise as tt
from tests.certify.conftest import altered
from tests.certify.forged import OF_TABLES, altered_table
from tests.conftest import Patch, more
from tests.golden.tables import edit_json, other_digit, with_cell
from tt_precise.certify import NotProved, Proof, prove
from tt_precise.certify.compare import TableComparison, compare
from tt_precise.certify.files import certificate_of, certify, check
from tt_precise.commands.golden import certify_command as command
from tt_precise.golden import proofs, store
from tt_precise.golden.runs import exact_decimal
from tt_precise.golden.store import EVENTS, MANIFEST, PROOF, SCENE, TRAJECTORY, Stored
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
    columns = {TRAJECTORY: trajectory, EVENTS: printed(run.events)}
    tables = {file: Table.of_columns(column) for file, column in columns.items()}
    # a manifest whose hashes are those of other tables
    return Stored(Path(NAME), scene.text, tables, store.read_files("reference").manifest)


@pytest.fixture(scope="module")
def stored(scene: tt.Scene) -> Stored:
    return stored_of(scene)


@pytest.fixture(scope="module")
def proof(scene: tt.Scene) -> Proof:
    return prove(scene)


def _run(*arguments: str) -> int:
    status: int = command.main(args=list(arguments), standalone_mode=False)
    return status


def compared(stored: Stored, proof: Proof) -> TableComparison:
    return compare(stored, proof.observations)


def test_every_printed_digit_is_proved(stored: Stored) -> None:
    certificate = certificate_of(stored)
    assert certificate.complete
    content = certificate.content
    assert content["rounded"] == content["entries"] > 100
    assert content["contact"]["g_n_positive"]
    assert content["contact"]["energy_never_grows"]
    assert content["proved_events"]["theta_max"] == 1


def test_times_that_are_no_decimals_are_printed_rounded(scene: tt.Scene) -> None:
    text = scene.text.replace('sample_every = "0.01"', 'sample_every = "1/30"')
    thirds = parse_scene(text, NAME, NAME)
    table, proof = stored_of(thirds), prove(thirds)
    assert table.trajectory.column("t")[1] == f"3.{'3' * 33}e-2"
    assert compared(table, proof).objection == ""
    other = with_cell(table.trajectory, 1, "t", lambda cell: other_digit(cell, 34))
    assert "expected 3.33" in compared(altered(table, TRAJECTORY, other), proof).objection


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_a_digit_spoiled_in_the_30th_place_is_proved_wrong(
    stored: Stored, proof: Proof, file: str
) -> None:
    spoiled = with_cell(stored.tables[file], 2, "vy", lambda cell: other_digit(cell, 31))
    found = compared(altered(stored, file, spoiled), proof)
    assert found.total.wrong == found.tallies[file]["vy"].wrong == 1
    assert found.objection == f"{file}: 1 entries of vy are proved wrong"


@pytest.mark.parametrize(
    "seeds", [range(60), pytest.param(range(60, 200), marks=pytest.mark.slow)], ids=len
)
def test_changed_tables_are_refused(stored: Stored, proof: Proof, seeds: range) -> None:
    assert compared(stored, proof).objection == ""
    for seed, kind in zip(seeds, cycle(OF_TABLES), strict=False):
        dice = random.Random(seed)
        file = dice.choice((TRAJECTORY, EVENTS))
        forged = altered(stored, file, altered_table(dice, stored.tables[file], kind))
        assert compared(forged, proof).objection, f"seed {seed}"


Tampered = Callable[[Table], Table]


def cell_of(row: int, column: str, text: str) -> Tampered:
    return lambda table: with_cell(table, row, column, lambda cell: text.format(cell))


def widened(table: Table) -> Table:
    return Table((*table.columns, "luck"), tuple((*row, "7") for row in table.rows))


# What the forgeries do not do.
TAMPERINGS: dict[str, tuple[str, Tampered]] = {
    "an event of another name": (EVENTS, cell_of(0, "name", "eclipse")),
    "a wrong time": (TRAJECTORY, cell_of(2, "t", "0.0200001")),
    "a time in other words": (TRAJECTORY, cell_of(2, "t", "{}0")),
    "an emptied cell of an event": (EVENTS, cell_of(2, "phi_dot", "")),
    "an extra column": (TRAJECTORY, widened),
    "an extra column of events": (EVENTS, widened),
}


@pytest.mark.parametrize("name", TAMPERINGS)
def test_what_was_tampered_with_is_not_certified(stored: Stored, proof: Proof, name: str) -> None:
    file, tampered = TAMPERINGS[name]
    table = tampered(stored.tables[file])
    assert table != stored.tables[file]
    found = compared(altered(stored, file, table), proof).mismatches
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
    found = compared(altered(stored, EVENTS, events), proof).mismatches
    named = [one for one in found if "which does not exist" in one]
    assert len(named) == len(rows) > 3
    assert named == sorted(named)


@pytest.mark.parametrize("name", ["contact_lost", "landed", "stick"])
def test_an_end_that_is_not_proved_is_named(stored: Stored, proof: Proof, name: str) -> None:
    events = stored.events
    forged = Table(events.columns, (*events.rows, (name, *events.rows[-1][1:])))
    line = f"{EVENTS}: {name}, which is not proved to happen"
    assert line in compared(altered(stored, EVENTS, forged), proof).mismatches


def test_numbers_that_no_proof_reaches_are_counted(stored: Stored, proof: Proof) -> None:
    # the proof of the first 0.02 s, held against tables of 0.05 s
    shorter = prove(replace(stored.scene, until=Fraction(1, 50)))
    found, whole = compared(stored, shorter), compared(stored, proof)
    assert found.total.numbers == whole.total.numbers
    assert 0 < found.total.rounded < whole.total.rounded
    assert "6 rows, expected 3" in found.objection
    kx = found.tallies[TRAJECTORY]["kx"]
    assert (kx.numbers, kx.rounded) == (len(stored.trajectory.rows), 3)


def test_too_few_bits_prove_fewer_numbers(stored: Stored) -> None:
    found = compared(stored, prove(stored.scene, bits=100))
    assert found.total.wrong == 0
    assert found.undecided
    assert found.total.rounded < found.total.numbers


def test_bits_are_added_where_they_are_needed(stored: Stored) -> None:
    made = certificate_of(stored, 100)
    assert made.complete
    assert made.content["bits"] == 164


@pytest.fixture
def place(stored: Stored, tmp_path: Path) -> Path:
    return written(stored, tmp_path)


def written(stored: Stored, folder: Path) -> Path:
    texts = {file: table.csv() for file, table in stored.tables.items()}
    texts |= {SCENE: stored.scene_text, MANIFEST: store.json_text(stored.manifest)}
    (folder / NAME).mkdir()
    for file, text in texts.items():
        (folder / NAME / file).write_text(text, "utf-8")
    return folder / NAME


@pytest.fixture(scope="module")
def proved(stored: Stored, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Tables and their proof, which comes out again."""
    folder = tmp_path_factory.mktemp("proved")
    whole = written(stored, folder)
    certify(NAME, folder=folder)
    assert check(NAME, folder=folder).complete
    return whole


@pytest.fixture
def copied(proved: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(proved, tmp_path / NAME))


once = cache(prove)


@pytest.fixture
def proved_once(monkeypatch: Patch) -> None:
    """Statements are compared again; what they are compared with is proved once."""
    monkeypatch.setattr("tt_precise.certify.files.prove", once)


def test_certify_writes_the_proof_and_verify_reads_it(stored: Stored, place: Path) -> None:
    folder = place.parent
    assert _run(NAME, "--folder", str(folder)) == 0
    content = json.loads((place / PROOF).read_text())
    manifest = json.loads((place / MANIFEST).read_text())
    assert manifest["files"][PROOF] == {"sha256": store.proof_sha256(place)}
    record = proofs.read_proof(NAME, folder)
    assert record is not None
    assert (record.content, record.digits) == (content, 34)
    assert proofs.complaints(store.read_files(NAME, folder), record) == []
    found = proofs.established(stored.scene, folder)
    assert found.record is not None, found.why
    proof = prove(stored.scene).observations
    for t, state in proof.rows:
        for name, exact in state.items():
            ball = found.at(name, str(exact_decimal(t)))
            assert ball is not None
            assert exact is not None
            # the exact number is within half a unit of the last digit
            middle = Fraction(*map(int, (exact.mid().fmpq().p, exact.mid().fmpq().q)))
            assert ball.low <= middle <= ball.high
    # proved again it is the same; another statement is refused
    assert _run(NAME, "--folder", str(folder), "--check") == 0
    path = place / SCENE
    path.write_text(path.read_text().replace('"155"', '"154"'))
    other = verify_scene(place)
    assert (other.verdict, other.digits_proved) == ("fail", None)  # proved of another scene


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("contact", {"g_n_positive": True, "g_n_at_least_mg": "2e+0", "energy_never_grows": True}),
        ("contact", {"g_n_positive": True, "g_n_at_least_mg": "nan", "energy_never_grows": True}),
        ("contact", {"g_n_positive": False, "g_n_at_least_mg": "1e-1", "energy_never_grows": True}),
        ("contact", {"g_n_positive": "until contact is lost"}),
        ("proved_events", {"theta_max": 2}),
        ("rounded", 7),
        more("inversion", {"equator": None}),
    ],
)
def test_statements_that_are_not_proved_again_are_refused(
    proved_once: None, copied: Path, name: str, change: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    edit_json(copied / PROOF, lambda content: content.update({name: change}), json.dumps)
    assert _run(NAME, "--folder", str(copied.parent), "--check") == 1
    assert f"states another {name}" in capsys.readouterr().out
    # a hash shows the edit too, unless somebody adapts it
    stored = store.read_files(NAME, copied.parent)
    assert [line for line in store.changes(stored) if line.startswith(PROOF)]


def _with_contact(contact: dict[str, Any], proof: dict[str, Any]) -> None:
    proof["contact"] = contact


def test_a_bound_is_confirmed_up_to_what_is_proved(proved_once: None, copied: Path) -> None:
    content = json.loads((copied / PROOF).read_text())["contact"]
    proved = Decimal(content["g_n_at_least_mg"])
    unit = Decimal(1).scaleb(proved.adjusted() - 5)
    for bound, holds in ((proved - unit, True), (proved, True), (proved + unit, False)):
        stated = {**content, "g_n_at_least_mg": f"{bound:.5e}"}
        edit_json(copied / PROOF, partial(_with_contact, stated), json.dumps)
        with nullcontext() if holds else pytest.raises(NotProved, match="another contact"):
            check(NAME, folder=copied.parent)


def test_a_wrong_scene_cannot_be_certified(stored: Stored, tmp_path: Path) -> None:
    # the tables of one friction, the equations of another that differs in the 30th digit
    text = stored.scene_text.replace('mu = "0.3"', 'mu = "0.300000000000000000000000000001"')
    assert text != stored.scene_text
    place = written(replace(stored, scene_text=text), tmp_path)
    assert certify(NAME, folder=tmp_path).compared.total.wrong > 0
    assert not (place / PROOF).exists()  # what is not whole is not written
    assert _run(NAME, "--folder", str(tmp_path)) == 1


def test_what_cannot_be_proved_says_why(capsys: pytest.CaptureFixture[str]) -> None:
    assert _run("elastic-hunt-crossley") == 1
    out = capsys.readouterr().out
    assert "refused: not proved (equations): a hunt-crossley table changes them" in out


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
    written(altered(stored, file, cell_of(1, column, cell)(stored.tables[file])), tmp_path)
    monkeypatch.setattr("tt_precise.certify.files.prove", None)
    with pytest.raises(
        InputError, match=rf"{file}, line 3, {column}: got '{cell}', expected a pri"
    ):
        certify(NAME, folder=tmp_path)


QUICK = ("upright", "inverted", "flight")  # Two or three seconds each.
PROVED = [name for name in store.scenes() if (store.home() / name / PROOF).is_file()]


@pytest.mark.parametrize(
    "name",
    [
        *QUICK,
        more("coulomb-gliding"),
        *(
            pytest.param(name, marks=pytest.mark.proofs)
            for name in PROVED
            if name not in (*QUICK, "coulomb-gliding")
        ),
    ],
)
def test_committed_proofs_come_out_again(name: str) -> None:
    assert check(name).complete


@pytest.mark.parametrize(
    ("stated", "same"),
    [
        ("not proved (W2): in older words (of 2026)", True),
        ("not proved (W3): the contact force, or the spin, may vanish", False),
    ],
)
def test_a_failure_is_the_hypothesis_that_fails_in_any_words(
    proved_once: None, copied: Path, monkeypatch: Patch, stated: str, same: bool
) -> None:
    failure = {"failure": "not proved (W2): the contact force, or the spin, may vanish"}
    monkeypatch.setattr("tt_precise.certify.files._forever", lambda proof: failure)
    edit_json(copied / PROOF, lambda content: content.update(forever={"failure": stated}))
    with nullcontext() if same else pytest.raises(NotProved, match="another forever"):
        check(NAME, folder=copied.parent)
    # a failure does not confirm a statement
    held = json.loads((store.home() / "reference" / PROOF).read_text("utf-8"))["forever"]
    edit_json(copied / PROOF, lambda content: content.update(forever=held))
    with pytest.raises(NotProved, match="another forever"):
        check(NAME, folder=copied.parent)
