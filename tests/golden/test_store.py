"""Golden data: where they lie, and what is whole."""

import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

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


def flip_last_digit(path: Path) -> None:
    edit_cell(path / TRAJECTORY, 41, "kx", lambda cell: other_digit(cell, 34))


def problems(path: Path) -> list[str]:
    return inspect(NAME, path.parent)[1]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (flip_last_digit, "trajectory.csv: changed since it was written"),
        (lambda path: (path / PROOF).unlink(), "proof.json: missing, but manifest.json lists it"),
        (lambda path: (path / PROOF).write_text("no JSON"), "proof.json: changed since it was"),
        (lambda path: (path / SCENE).write_text("no TOML ["), "scene.toml: not a TOML file"),
    ],
)
def test_changed_data_are_not_used(
    proved: Path, spoil: Callable[[Path], object], message: str
) -> None:
    spoil(proved)
    with pytest.raises(InputError, match=message):
        tt.golden.load(NAME, folder=proved.parent)
    assert problems(proved)


def test_right_hashes_do_not_get_past_the_proof(proved: Path) -> None:
    assert problems(proved) == []
    flip_last_digit(proved)
    rehash(proved)
    assert "not the table that was proved" in problems(proved)[0]
    # without its proof nothing in the folder knows, but the manifest
    (proved / PROOF).unlink()
    assert "missing, but manifest.json lists it" in problems(proved)[0]
    edit_json(proved / MANIFEST, lambda manifest: manifest["files"].pop(PROOF), store.json_text)
    assert problems(proved) == []


@pytest.mark.parametrize("file", [SCENE, TRAJECTORY])
@pytest.mark.parametrize("kind", ["link", "pipe"])
def test_files_that_are_not_regular_are_refused(proved: Path, file: str, kind: str) -> None:
    (proved / file).rename(proved / "elsewhere")
    if kind == "pipe":
        os.mkfifo(proved / file)
    else:
        (proved / file).symlink_to("elsewhere")
    with pytest.raises(InputError, match=f"{file}: no regular file; expected golden data"):
        store.read_files(NAME, proved.parent)


def test_data_are_named_by_name_file_or_folder(
    small: Small, tmp_path: Path, monkeypatch: Patch
) -> None:
    own = tmp_path / "golden"
    shutil.copytree(small.path, own / "mytop")
    named = partial(dict.update, scene="mytop")
    edit_json(own / "mytop" / MANIFEST, named, store.json_text)
    toml = tmp_path / "mytop.toml"
    toml.write_text(small.scene.text)
    expected = tt.golden.load("reference", folder=small.folder)
    monkeypatch.chdir(tmp_path)
    for scene, folder in (
        *((each, None) for each in ("mytop", toml, str(toml), own / "mytop", "golden/mytop")),
        *(("mytop", each) for each in ("golden", own)),
        (toml, str(own)),
    ):
        assert tt.golden.load(scene, folder=folder).equals(expected)
    table = own / "mytop" / TRAJECTORY
    tt.check.assert_matches_golden(table, toml, digits=30, folder=own)
    with pytest.raises(InputError, match="mytop in elsewhere"):
        tt.check.assert_matches_golden(table, toml, digits=30, folder="elsewhere")
    for name in (".hidden", "a/b.c", "x" * 101):
        with pytest.raises(InputError, match="expected letters, digits"):
            store.locate(name, own)


def test_the_package_precedes_a_folder_in_the_working_directory(
    small: Small, tmp_path: Path, monkeypatch: Patch
) -> None:
    for place in (tmp_path, tmp_path / "golden"):
        shutil.copytree(small.path, place / "reference")
    monkeypatch.chdir(tmp_path)
    assert store.locate("reference") == store.home() / "reference"
    assert len(tt.golden.load("reference")) == 801
    for by_path in ("./reference", Path("reference"), str(tmp_path / "reference")):
        assert len(tt.golden.load(by_path)) == 7
