"""Building: byte-identical again, refusing changes, whole after an interruption."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tt_precise.golden import building, store
from tt_precise.golden.building import REFUSED, RENEWED, REPLACED, UNCHANGED
from tt_precise.golden.hashes import PROOF, PROOF_KEY
from tt_precise.golden.manifest import derive
from tt_precise.golden.runs import LADDER, tasks
from tt_precise.golden.seal import read_whole
from tt_precise.golden.store import FILES, MANIFEST, TRAJECTORY
from tt_precise.golden.table import Table
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import locked

if TYPE_CHECKING:
    from tests.golden.conftest import Small


def again(small: Small, reason: str = "") -> building.Built:
    built = building.build(
        [small.scene], folder=small.folder, replace=reason, workers=1, cache=small.shelf
    )
    return built[0]


def contents(small: Small) -> dict[str, bytes]:
    place = small.folder / small.scene.name
    return {path.name: path.read_bytes() for path in place.iterdir()}


def flip_first_theta(small: Small) -> None:
    path = small.folder / small.scene.name / TRAJECTORY
    path.write_text(path.read_text().replace("1.000", "1.001", 1))


def test_new_data_are_whole_and_claim_34_digits(small: Small) -> None:
    assert small.built.outcome == building.NEW
    assert small.built.digits == 34
    assert small.built.bits == LADDER[0]
    assert sorted(contents(small)) == sorted(FILES)
    assert [path.name for path in small.folder.iterdir()] == [small.scene.name]


def test_manifest_names_no_time_or_place(small: Small) -> None:
    manifest = json.loads(contents(small)[MANIFEST])
    assert set(manifest["versions"]) == {"tt-precise", "heyoka", "mpmath", "python"}
    assert "second" not in "".join(manifest["evidence"])


def test_the_same_again_is_unchanged_to_the_byte(small: Small) -> None:
    before = contents(small)
    assert again(small).outcome == UNCHANGED
    assert contents(small) == before


def test_a_change_of_a_digit_is_refused(small: Small) -> None:
    flip_first_theta(small)
    before = contents(small)
    built = again(small)
    assert built.outcome == REFUSED
    assert not built.good
    assert "1.001" in built.note
    assert "--replace" in built.note
    assert contents(small) == before


def test_a_change_with_a_reason_is_recorded_for_good(small: Small) -> None:
    flip_first_theta(small)
    assert again(small, "the old ones were spoiled").outcome == REPLACED
    manifest = json.loads(contents(small)[MANIFEST])
    assert [entry["reason"] for entry in manifest["history"]] == ["the old ones were spoiled"]
    assert "1.001" in manifest["history"][0]["first_change"]
    assert again(small).outcome == UNCHANGED


def test_a_damaged_folder_is_not_replaced_silently(small: Small) -> None:
    (small.folder / small.scene.name / TRAJECTORY).write_text("t,kx\n0\n")
    assert again(small).outcome == REFUSED


def test_another_manifest_with_the_same_digits_is_renewed(small: Small) -> None:
    before = contents(small)
    path = small.folder / small.scene.name / MANIFEST
    path.write_text(path.read_text().replace('"heyoka": "', '"heyoka": "0.'))
    assert again(small).outcome == RENEWED
    assert contents(small) == before


def test_a_contradiction_between_runs_leaves_the_data(small: Small) -> None:
    before = contents(small)
    task = tasks(small.scene, LADDER[0])[1]
    small.shelf.keep(task, replace(small.runs[1], status="contact_lost"))
    try:
        built = again(small)
    finally:
        small.shelf.keep(task, small.runs[1])
    assert built.outcome == building.FAILED
    assert "contact_lost" in built.note
    assert contents(small) == before


def test_an_interrupted_replacement_leaves_the_old_data(
    small: Small, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(small)

    def interrupt(fresh: Path, target: Path) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(store, "_exchange", interrupt)
        with pytest.raises(KeyboardInterrupt):
            store.replace_folder(small.folder / small.scene.name, {TRAJECTORY: "t\n"})
    assert contents(small) == before
    assert store.scenes(small.folder) == [small.scene.name]
    # what the interruption left behind is in nobody's way
    assert again(small).outcome == UNCHANGED
    store.replace_folder(small.folder / small.scene.name, {TRAJECTORY: "t\n"})
    assert contents(small) == {**before, TRAJECTORY: b"t\n"}
    assert [path.name for path in small.folder.iterdir()] == [small.scene.name]


@pytest.mark.parametrize("without", ["renameat2", ""])
def test_a_folder_is_replaced_with_and_without_exchange(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, without: str
) -> None:
    if without:
        monkeypatch.setattr(store.ctypes, "CDLL", lambda *args, **kwargs: object())
    target = tmp_path / "scene"
    store.replace_folder(target, {"a": "old\n", "proof": "of others\n"})
    store.replace_folder(target, {"a": "new\n", "b": "new\n"})
    found = {path.name: path.read_text() for path in target.iterdir()}
    assert found == {"a": "new\n", "b": "new\n", "proof": "of others\n"}
    assert [path.name for path in tmp_path.iterdir()] == ["scene"]


def test_two_builds_do_not_share_a_folder(small: Small) -> None:
    with locked(small.folder, store.WORK), pytest.raises(InputError, match="another golden build"):
        again(small)


def test_cached_runs_come_back_and_damaged_ones_do_not(small: Small) -> None:
    task = tasks(small.scene, LADDER[0])[2]
    assert small.shelf.find(task) == small.runs[2]
    path = small.shelf.records.path(task.name, asdict(task))
    content = path.read_bytes()
    try:
        path.write_bytes(content[: len(content) // 2])
        assert small.shelf.find(task) is None
    finally:
        path.write_bytes(content)
    assert small.shelf.find(replace(task, bits=168)) is None


def test_a_spoiled_proof_is_not_recorded(small: Small) -> None:
    place = small.folder / "reference"
    (place / PROOF).write_text("{}")
    building.build([small.scene], folder=small.folder, workers=1, cache=small.shelf)
    assert PROOF_KEY not in json.loads((place / MANIFEST).read_text())
    with pytest.raises(InputError, match=r"proof\.json: spoiled"):
        read_whole("reference", small.folder)


def test_tables_that_claim_nothing_claim_no_digits(small: Small) -> None:
    nothing = Table(("t", "kx"), (("0", "0"), ("0.01", "")))
    assert derive(small.scene, nothing, Table(("name", "t", "kx"), ()))["digits"] == 0
