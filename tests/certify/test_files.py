"""Printed tables compared with a proof, and the file that goes beside them."""

import json
import random
import re
import shutil
from contextlib import nullcontext
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from functools import cache
from itertools import cycle
from pathlib import Path
from typing import Any

import pytest

import tt_precise as tt
from tests.certify.conftest import altered
from tests.certify.forged import OF_TABLES, altered_table
from tests.conftest import Patch, more
from tests.golden.tables import edit_json, other_digit, with_cell
from tt_precise.certify import NotProved, Proof, prove
from tt_precise.certify.balls import fraction
from tt_precise.certify.compare import Enclosed, TableComparison, compare
from tt_precise.certify.files import certificate_of, certify
from tt_precise.commands.golden import certify_command as command
from tt_precise.golden import proofs, store
from tt_precise.golden.runs import exact_decimal
from tt_precise.golden.store import EVENTS, MANIFEST, PROOF, SCENE, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.verifying import verify_scene
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import parse_scene

NAME = "short"


@pytest.fixture(scope="module")
def scene() -> tt.Scene:
    text = tt.load_scene("reference").text
    return parse_scene(text.replace('until = "8"', 'until = "0.05"'), NAME, NAME)


@pytest.fixture(scope="module")
def stored(scene: tt.Scene) -> Stored:
    """The first rows of golden data, with the manifest of the whole tables."""
    whole = store.read_files("reference")
    tables = {
        file: Table(table.columns, tuple(row for row in table.rows if in_time(table, row, scene)))
        for file, table in whole.tables.items()
    }
    return Stored(Path(NAME), scene.text, tables, whole.manifest)


def in_time(table: Table, row: tuple[str, ...], scene: tt.Scene) -> bool:
    return Decimal(row[table.columns.index("t")]) <= scene.until


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
    assert certificate.objection == ""
    content = certificate.content
    assert content["rounded"] == content["entries"] > 100
    assert content["contact"]["g_n_positive"] is content["contact"]["energy_never_grows"] is True
    assert content["proved_events"]["theta_max"] == 1
    assert proofs.stale(content) == ""
    other = {"code": content["code"] | {"scene": "0"}}
    assert proofs.stale(other) == ", before the last change of scene"
    assert proofs.stale({}) == ", by earlier code"


def test_the_code_of_a_proof_is_what_a_reader_has_to_trust() -> None:
    text = (store.home().parent / "docs/explanation/proof.md").read_text("utf-8")
    named = {*re.findall(r"`([^`]+)`", text.partition("| files |")[2].partition("\n\n")[0])}
    folders = {path.removeprefix("certify/").removesuffix(".py") for path in proofs.CODE}
    assert named ^ folders == {"trajectory.csv", "events.csv", "Frame.near"}


def test_times_that_are_no_decimals_are_rounded(scene: tt.Scene) -> None:
    (row,) = Enclosed([(Fraction(1, 30), {})], {}).tables(scene)[TRAJECTORY].rows
    assert row[0] == f"3.{'3' * 33}e-2"


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_a_digit_spoiled_in_the_30th_place_is_proved_wrong(
    stored: Stored, proof: Proof, file: str
) -> None:
    spoiled = with_cell(stored.tables[file], 2, "vy", lambda cell: other_digit(cell, 31))
    comparison = compared(altered(stored, file, spoiled), proof)
    assert comparison.wrong == [f"{file}, line 4, vy: {spoiled.column('vy')[2]} is proved wrong"]
    assert comparison.objection == comparison.wrong[0]
    assert comparison.rounded == comparison.numbers - 1


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


@pytest.mark.parametrize(
    ("file", "row", "column", "text", "named"),
    [
        (EVENTS, 0, "name", "eclipse", "line 2, name: got 'eclipse', expected theta_min"),
        (EVENTS, 0, "name", "stick", "line 2, name: got 'stick', expected theta_min"),
        (EVENTS, 0, "direction", "0", "line 2, direction: got '0', expected -1"),
        (EVENTS, 2, "phi_dot", "", "line 4, phi_dot: got '', expected 0 or 34 digits"),
        (TRAJECTORY, 2, "t", "0.0200001", "line 4, t: got '0.0200001', expected 0.02"),
        (TRAJECTORY, 2, "t", "0.020", "line 4, t: got '0.020', expected 0.02"),
    ],
)
def test_a_cell_with_another_text_is_named(
    stored: Stored, proof: Proof, file: str, row: int, column: str, text: str, named: str
) -> None:
    table = with_cell(stored.tables[file], row, column, lambda _: text)
    comparison = compared(altered(stored, file, table), proof)
    assert (comparison.objection, comparison.undecided) == (f"{file}, {named}", False)


@pytest.mark.parametrize("file", [TRAJECTORY, EVENTS])
def test_columns_and_rows_are_those_of_the_motion(stored: Stored, proof: Proof, file: str) -> None:
    columns, rows = stored.tables[file].columns, stored.tables[file].rows
    wider = Table((*columns, "luck"), tuple((*row, "7") for row in rows))
    assert "luck" in compared(altered(stored, file, wider), proof).objection
    for name in ("contact_lost", "landed", "stick"):  # ends that are not proved
        longer = Table(columns, (*rows, (name, *rows[-1][1:])))
        counts = f"{file}: {len(rows) + 1} rows, expected {len(rows)}"
        assert compared(altered(stored, file, longer), proof).mismatches == [counts]


def test_bits_are_added_where_they_are_needed(stored: Stored) -> None:
    coarse = compared(stored, prove(stored.scene, bits=100))
    assert coarse.undecided
    assert coarse.wrong == []
    assert coarse.objection == "174 of 174 numbers are not proved"
    certificate = certificate_of(stored, 100)
    assert (certificate.objection, certificate.content["bits"]) == ("", 164)


def written(stored: Stored, folder: Path) -> Path:
    texts = {file: table.csv() for file, table in stored.tables.items()}
    texts |= {SCENE: stored.scene_text, MANIFEST: store.json_text(stored.manifest)}
    (folder / NAME).mkdir()
    for file, text in texts.items():
        (folder / NAME / file).write_text(text, "utf-8")
    return folder / NAME


@pytest.fixture(scope="module")
def proved(stored: Stored, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = written(stored, tmp_path_factory.mktemp("proved"))
    certify(NAME, folder=place.parent)
    return place


once = cache(prove)


@pytest.fixture
def copied(proved: Path, tmp_path: Path, monkeypatch: Patch) -> Path:
    """Tables and their proof, whose statements are compared with what is proved once."""
    monkeypatch.setattr("tt_precise.certify.files.prove", once)
    return Path(shutil.copytree(proved, tmp_path / NAME))


def assert_compared(copied: Path, difference: str, **statements: Any) -> None:
    """Let a proof state something else, and assert that this is no ``difference``, or one."""
    edit_json(copied / PROOF, lambda content: content.update(statements), json.dumps)
    failure = f"states another {difference}"
    with pytest.raises(NotProved, match=failure) if difference else nullcontext():
        certify(NAME, folder=copied.parent, again=True)


def test_certify_writes_the_proof_and_verify_reads_it(stored: Stored, tmp_path: Path) -> None:
    place = written(stored, tmp_path)
    assert _run(NAME, "--folder", str(tmp_path)) == 0
    content, manifest = (json.loads((place / file).read_text()) for file in (PROOF, MANIFEST))
    assert manifest["files"][PROOF] == {"sha256": store.proof_sha256(place)}
    assert proofs.read_proof(store.read_files(NAME, tmp_path)) == content
    established = proofs.established(stored.scene, tmp_path)
    for t, state in prove(stored.scene).observations.rows:
        for name, exact in state.items():
            printed: Any = established.at(name, str(exact_decimal(t)))
            middle: Any = fraction(exact.mid())  # type: ignore[union-attr]
            assert printed.low <= middle <= printed.high
    assert _run(NAME, "--folder", str(tmp_path), "--check") == 0
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
    copied: Path, name: str, change: Any
) -> None:
    assert_compared(copied, name, **{name: change})
    assert _run(NAME, "--folder", str(copied.parent), "--check") == 1
    # a hash shows the edit too, unless somebody adapts it
    stored = store.read_files(NAME, copied.parent)
    assert [line for line in store.changes(stored) if line.startswith(PROOF)]


def test_a_bound_is_confirmed_up_to_what_is_proved(copied: Path) -> None:
    contact = json.loads((copied / PROOF).read_text())["contact"]
    proved = Decimal(contact["g_n_at_least_mg"])
    unit = Decimal(1).scaleb(proved.adjusted() - 5)
    for bound, difference in ((proved - unit, ""), (proved, ""), (proved + unit, "contact")):
        assert_compared(copied, difference, contact={**contact, "g_n_at_least_mg": f"{bound:.5e}"})


def test_a_wrong_scene_cannot_be_certified(stored: Stored, tmp_path: Path) -> None:
    # the tables of one friction, the equations of another that differs in the 30th digit
    text = stored.scene_text.replace('mu = "0.3"', 'mu = "0.300000000000000000000000000001"')
    assert text != stored.scene_text
    place = written(replace(stored, scene_text=text), tmp_path)
    assert certify(NAME, folder=tmp_path).compared.wrong
    assert not (place / PROOF).exists()  # what is not whole is not written
    assert _run(NAME, "--folder", str(tmp_path)) == 1


@pytest.mark.parametrize(
    ("cell", "file", "column"),
    [("nan", TRAJECTORY, "t"), ("inf", EVENTS, "t"), ("1e999999999", TRAJECTORY, "kx")],
)
def test_what_is_no_number_is_refused_before_anything_is_proved(
    stored: Stored, tmp_path: Path, monkeypatch: Patch, cell: str, file: str, column: str
) -> None:
    table = with_cell(stored.tables[file], 1, column, lambda _: cell)
    written(altered(stored, file, table), tmp_path)
    monkeypatch.setattr("tt_precise.certify.files.prove", None)
    place = rf"{file}, line 3, {column}: got '{cell}', expected a pri"
    with pytest.raises(InputError, match=place):
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
    assert certify(name, again=True).objection == ""


def test_a_failure_is_the_hypothesis_that_fails_in_any_words(
    copied: Path, monkeypatch: Patch
) -> None:
    why = "the contact force, or the spin, may vanish"
    failure = {"failure": f"not proved (W2): {why}"}
    monkeypatch.setattr("tt_precise.certify.files._forever", lambda proof: failure)
    assert_compared(copied, "", forever={"failure": "not proved (W2): in older words (of 2026)"})
    assert_compared(copied, "forever", forever={"failure": f"not proved (W3): {why}"})
    # a failure does not confirm a statement
    held = json.loads((store.home() / "reference" / PROOF).read_text("utf-8"))["forever"]
    assert_compared(copied, "forever", forever=held)
