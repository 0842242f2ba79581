"""Golden data that are no longer what was built are neither loaded nor compared with."""

from __future__ import annotations

import json
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import tt_precise as tt
from tt_precise.golden import manifest as manifests
from tt_precise.golden import places, proofs, seal, store
from tt_precise.golden.integrity import inspect
from tt_precise.golden.proved import PROVED
from tt_precise.golden.store import EVENTS, MANIFEST, SCENE, TRAJECTORY
from tt_precise.runtime.errors import InputError

if TYPE_CHECKING:
    from tests.golden.conftest import Small

NAME = "contact-lost"  # few rows, and proved


@pytest.fixture
def proved(tmp_path: Path) -> Path:
    """A copy of shipped data with their proof."""
    return shutil.copytree(store.home() / NAME, tmp_path / NAME)


def test_the_package_knows_the_proofs_that_ship() -> None:
    there = {name for name in store.scenes() if proofs.read(name)}
    assert there == PROVED, "golden/proved.py: list the scenes that have a proof.json"
    for name in PROVED:
        stored = store.read(name)
        assert stored.manifest[manifests.PROOF_KEY] == seal.proof_hash(store.home() / name)


def test_the_hash_of_a_proof_is_put_in_and_taken_out() -> None:
    known = {"schema": "s", manifests.SELF_HASH: "old"}
    sealed = manifests.with_proof(known, "ab")
    assert sealed == {"schema": "s", manifests.PROOF_KEY: "ab"}
    assert manifests.with_proof(sealed, None) == {"schema": "s"}


def reseal(place: Path) -> None:
    """What somebody does who edits golden data and makes the manifest agree with them."""
    stored = store.read(place.name, place.parent)
    derived = manifests.derive(stored.scene, stored.trajectory, stored.events)
    old = stored.manifest
    for file, entry in derived["files"].items():
        for name, column in entry.get("columns", {}).items():
            column |= {
                k: v for k, v in old["files"][file]["columns"][name].items() if k == "agreement"
            }
    marks = {TRAJECTORY: stored.trajectory.row_marks, EVENTS: stored.events.row_marks}
    content = {k: v for k, v in old.items() if k != manifests.SELF_HASH}
    (place / MANIFEST).write_text(manifests.dump({**content, **derived, "row_marks": marks}))


def agreements(manifest: dict[str, Any], file: str, column: str) -> Any:
    return manifest["files"][file]["columns"][column].get("agreement")


def flip_last_digit(place: Path) -> None:
    lines = (place / TRAJECTORY).read_text().splitlines()
    cells = lines[40].split(",")
    mantissa, exponent = cells[1].split("e")
    cells[1] = f"{mantissa[:-1]}{(int(mantissa[-1]) + 1) % 10}e{exponent}"
    lines[40] = ",".join(cells)
    (place / TRAJECTORY).write_text("\n".join(lines) + "\n")


def no_proof(place: Path) -> None:
    (place / proofs.PROOF).unlink()
    (place / proofs.ENCLOSURE).unlink()
    (place / proofs.EVENTS_ENCLOSURE).unlink()


def flipped_and_resealed(place: Path) -> None:
    flip_last_digit(place)
    reseal(place)


def proof_of_others(place: Path) -> None:
    shutil.copy(store.home() / "steep" / proofs.PROOF, place)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (flip_last_digit, "trajectory.csv got changed since it was built"),
        (no_proof, "proof.json: missing, but manifest.json records a proof"),
        (proof_of_others, "proof.json: not the one that manifest.json records"),
        (lambda place: (place / SCENE).write_text("title = 1\n"), "scene.toml"),
    ],
)
def test_what_got_changed_is_not_used(
    proved: Path, spoil: Callable[[Path], object], message: str
) -> None:
    tt.golden.load(NAME, folder=proved.parent)
    spoil(proved)
    with pytest.raises(InputError, match=message):
        tt.golden.load(NAME, folder=proved.parent)
    if spoil is not proof_of_others:
        path = store.home() / NAME / TRAJECTORY
        with pytest.raises(InputError, match=message):
            tt.check.conservation(path, NAME, folder=proved.parent)
    assert inspect(NAME, proved.parent)[1]


def test_resealing_does_not_get_past_the_proof(proved: Path) -> None:
    assert inspect(NAME, proved.parent)[1] == []
    flipped_and_resealed(proved)
    stored, problems = inspect(NAME, proved.parent)
    assert stored is not None
    assert "not the table that was proved" in problems[0]
    # without its proof nothing in the folder knows, but the manifest, and for shipped data the code
    no_proof(proved)
    assert "missing, but manifest.json records" in inspect(NAME, proved.parent)[1][0]
    manifest = json.loads((proved / MANIFEST).read_text())
    (proved / MANIFEST).write_text(manifests.dump(manifests.with_proof(manifest, None)))
    assert inspect(NAME, proved.parent)[1] == []


def test_the_package_misses_a_shipped_proof(proved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flipped_and_resealed(proved)
    no_proof(proved)
    manifest = json.loads((proved / MANIFEST).read_text())
    (proved / MANIFEST).write_text(manifests.dump(manifests.with_proof(manifest, None)))
    monkeypatch.setattr(seal, "home", lambda: proved.parent)
    assert "the package knows of a proof" in inspect(NAME, proved.parent)[1][0]


def test_files_are_read_once_while_they_stay_the_same(
    small: Small, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = small.folder / "reference"
    for file in place.iterdir():
        _age(file)
    first = store.read("reference", small.folder)
    assert store.read("reference", small.folder).trajectory is first.trajectory
    _age(place / TRAJECTORY, 50)
    assert store.read("reference", small.folder).trajectory is not first.trajectory
    # a file written just now may be written again within the same tick of its clock
    (place / TRAJECTORY).write_text(first.trajectory.csv())
    assert store.stamp(place / TRAJECTORY) is None


def _age(path: Path, seconds: int = 60) -> None:
    then = time.time() - seconds
    os.utime(path, (then, then))


def test_one_way_to_name_golden_data(
    small: Small, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "golden"
    shutil.copytree(small.folder / "reference", own / "mytop")
    manifest = json.loads((own / "mytop" / MANIFEST).read_text()) | {"scene": "mytop"}
    (own / "mytop" / MANIFEST).write_text(manifests.dump(manifest))
    toml = tmp_path / "mytop.toml"
    toml.write_text(small.scene.text)
    expected = tt.golden.load("reference", folder=small.folder)
    monkeypatch.chdir(tmp_path)
    for scene, folder in (
        ("mytop", None), (toml, None), (str(toml), None), (own / "mytop", None),
        ("mytop", "golden"), ("mytop", own), (toml, str(own)),
    ):  # fmt: skip
        assert tt.golden.load(scene, folder=folder).equals(expected)
    # every row is compared, to the last digit
    path = own / "mytop" / TRAJECTORY
    found = tt.check.conservation(path, toml)["golden"]
    assert found.value == 34
    assert tt.check.assert_matches_golden(path, toml, digits=30, folder=own).passed
    with pytest.raises(InputError, match="no golden data of a scene mytop in elsewhere"):
        tt.check.assert_matches_golden(path, toml, digits=30, folder="elsewhere")
    assert places.locate("reference").folder == store.home()


def test_a_folder_in_the_working_directory_does_not_beat_the_package(
    small: Small, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(small.folder / "reference", tmp_path / "reference")
    monkeypatch.chdir(tmp_path)
    assert places.locate("reference").folder == store.home()
    assert len(tt.golden.load("reference")) == 801
    for by_path in ("./reference", Path("reference"), str(tmp_path / "reference")):
        assert len(tt.golden.load(by_path)) == 7


def test_a_spoiled_proof_never_counts_as_the_recorded_one(proved: Path) -> None:
    """A build records the proof that lies there; a spoiled one has no hash to record."""
    content = json.loads((proved / proofs.PROOF).read_text())
    (proved / proofs.PROOF).write_text(json.dumps(content | {"digits": 35}))
    assert seal.proof_hash(proved) == ""
    stored = store.read(NAME, proved.parent)
    for recorded in ("", None):
        text = manifests.dump(manifests.with_proof(stored.manifest, recorded))
        (proved / MANIFEST).write_text(text)
        with pytest.raises(InputError, match=r"proof\.json: spoiled, its own hash does not fit"):
            seal.read_whole(NAME, proved.parent)
