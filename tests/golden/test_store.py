"""Golden data: where they lie, what is whole, and how a folder is replaced."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import tt_precise as tt
from tests.conftest import Patch
from tests.golden.conftest import Small, rehash
from tests.golden.tables import edit_cell, edit_json, other_digit
from tt_precise.golden import store
from tt_precise.golden.store import MANIFEST, PROOF, SCENE, TRAJECTORY
from tt_precise.golden.verifying import inspect
from tt_precise.runtime.values import InputError

NAME = "contact-lost"  # few rows, and proved


@pytest.fixture
def proved(tmp_path: Path) -> Path:
    """A copy of shipped data with their proof."""
    return shutil.copytree(store.home() / NAME, tmp_path / NAME)


WITHOUT_PROOF = {
    "coulomb-flight", "coulomb-small-top", "coulomb-stick-slip", "elastic-hunt-crossley",
}  # fmt: skip


def test_manifests_list_the_proofs_that_ship() -> None:
    for name in store.scenes():
        stored = store.read_files(name)
        assert store.changes(stored) == []
        assert (PROOF in stored.manifest["files"]) == (name not in WITHOUT_PROOF)


def flip_last_digit(place: Path) -> None:
    edit_cell(place / TRAJECTORY, 41, "kx", lambda cell: other_digit(cell, 34))


def no_proof(place: Path) -> None:
    (place / PROOF).unlink()


def flipped_under_right_hashes(place: Path) -> None:
    flip_last_digit(place)
    rehash(place)


def proof_of_others(place: Path) -> None:
    shutil.copy(store.home() / "reference" / PROOF, place)


def problems(place: Path) -> list[str]:
    return inspect(NAME, place.parent)[1]


def edit_manifest(place: Path, change: Callable[[dict[str, Any]], object]) -> None:
    edit_json(place / MANIFEST, change, store.json_text)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (flip_last_digit, "trajectory.csv: changed since it was written"),
        (no_proof, "proof.json: missing, but manifest.json lists it"),
        (proof_of_others, "proof.json: changed since it was written"),
        (lambda place: (place / SCENE).write_text("title = 1\n"), "scene.toml"),
        (lambda place: (place / SCENE).write_text("no TOML ["), "scene.toml: not a TOML file"),
    ],
)
def test_what_got_changed_is_not_used(
    proved: Path, spoil: Callable[[Path], object], message: str
) -> None:
    spoil(proved)
    with pytest.raises(InputError, match=message):
        tt.golden.load(NAME, folder=proved.parent)
    if spoil is not proof_of_others:
        path = store.home() / NAME / TRAJECTORY
        with pytest.raises(InputError, match=message):
            tt.check.conservation(path, NAME, folder=proved.parent)
    assert problems(proved)


def test_right_hashes_do_not_get_past_the_proof(proved: Path) -> None:
    assert problems(proved) == []
    flipped_under_right_hashes(proved)
    assert "not the table that was proved" in problems(proved)[0]
    # without its proof nothing in the folder knows, but the manifest
    no_proof(proved)
    assert "missing, but manifest.json lists it" in problems(proved)[0]
    edit_manifest(proved, lambda manifest: manifest["files"].pop(PROOF))
    assert problems(proved) == []


def test_data_are_read_once_for_each_manifest(proved: Path) -> None:
    first = store.read_whole(NAME, proved.parent)
    assert store.read_whole(NAME, proved.parent) is first
    flipped_under_right_hashes(proved)
    assert store.read_whole(NAME, proved.parent).trajectory != first.trajectory


@pytest.mark.parametrize("file", [SCENE, TRAJECTORY])
@pytest.mark.parametrize("kind", ["link to a device", "link to a file", "pipe"])
def test_what_is_no_regular_file_is_refused(proved: Path, file: str, kind: str) -> None:
    (proved / file).rename(proved / "elsewhere")
    if kind == "pipe":
        os.mkfifo(proved / file)
    elif kind == "link to a file":
        (proved / file).symlink_to("elsewhere")
    else:
        (proved / file).symlink_to("/dev/zero")
    with pytest.raises(InputError, match=f"{file}: no regular file; expected golden data"):
        store.read_files(NAME, proved.parent)


def test_a_spoiled_proof_is_not_used(proved: Path) -> None:
    (proved / PROOF).write_text("no JSON")
    assert store.proof_sha256(proved) == ""
    with pytest.raises(InputError, match=r"proof\.json: changed since it was written"):
        store.read_whole(NAME, proved.parent)
    store.record_proof(proved)  # nothing to list
    with pytest.raises(InputError, match=r"proof\.json: not listed"):
        store.read_whole(NAME, proved.parent)


@pytest.mark.parametrize(
    ("change", "what"),
    [({"schema": "tt_precise.golden/1"}, "got schema"), ({"files": {}}, "missing required field"),
     ({"files": []}, "Expected `object`")],
)  # fmt: skip
def test_a_manifest_of_another_form_is_refused(
    proved: Path, change: dict[str, object], what: str
) -> None:
    edit_manifest(proved, lambda manifest: manifest.update(change))
    with pytest.raises(InputError, match=what):
        store.read_whole(NAME, proved.parent)


def test_one_way_to_name_golden_data(small: Small, tmp_path: Path, monkeypatch: Patch) -> None:
    own = tmp_path / "golden"
    shutil.copytree(small.folder / "reference", own / "mytop")
    edit_manifest(own / "mytop", lambda manifest: manifest.update(scene="mytop"))
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
    with pytest.raises(InputError, match="mytop in elsewhere"):
        tt.check.assert_matches_golden(path, toml, digits=30, folder="elsewhere")
    assert store.locate("reference").folder == store.home()


def test_a_folder_in_the_working_directory_does_not_beat_the_package(
    small: Small, tmp_path: Path, monkeypatch: Patch
) -> None:
    shutil.copytree(small.folder / "reference", tmp_path / "reference")
    monkeypatch.chdir(tmp_path)
    assert store.locate("reference").folder == store.home()
    assert len(tt.golden.load("reference")) == 801
    for by_path in ("./reference", Path("reference"), str(tmp_path / "reference")):
        assert len(tt.golden.load(by_path)) == 7


def test_a_folder_is_replaced_and_other_files_and_modes_stay(tmp_path: Path) -> None:
    target = tmp_path / "scene"
    store.replace_folder(target, {"a": "old\n", "proof": "of others\n"})
    (target / "a").chmod(0o600)
    target.chmod(0o700)
    store.replace_folder(target, {"a": "new\n", "b": "new\n"})
    found = {path.name: path.read_text() for path in target.iterdir()}
    assert found == {"a": "new\n", "b": "new\n", "proof": "of others\n"}
    assert [path.name for path in tmp_path.iterdir()] == ["scene"]
    assert (target / "a").stat().st_mode & 0o777 == 0o600
    assert target.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("at", ["new", "old"])
def test_an_interrupted_replacement_leaves_the_old_data(
    tmp_path: Path, monkeypatch: Patch, at: str
) -> None:
    """Interrupted at either renaming; or killed between the two, which the next one mends."""
    target = tmp_path / "scene"
    store.replace_folder(target, {"a": "old\n"})
    rename = Path.rename

    def interrupted(self: Path, to: Path) -> Path:
        if self.name.startswith(f".{at}") or (at == "old" and to.name.startswith(".old")):
            raise KeyboardInterrupt
        return rename(self, to)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "rename", interrupted)
        with pytest.raises(KeyboardInterrupt):
            store.replace_folder(target, {"a": "new\n"})
    assert (target / "a").read_text() == "old\n"
    assert [path.name for path in tmp_path.iterdir()] == ["scene"]
    target.rename(tmp_path / ".old-scene")
    with pytest.raises(InputError):
        store.replace_folder(target, {"no/such": "new\n"})
    assert (target / "a").read_text() == "old\n"
