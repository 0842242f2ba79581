"""The command: what it prints, its JSON, and its exit status."""

import json
import shutil
from pathlib import Path

import pytest

from tests.conftest import Patch, Said
from tests.golden.conftest import Small
from tt_precise.golden.store import MANIFEST, TRAJECTORY
from tt_precise.runtime import files
from tt_precise.runtime.values import InputError


@pytest.fixture
def golden(small: Small, said: Said) -> Said:
    """``golden("list")``: what the command prints of the small data."""

    def run(words: str, status: int = 0, folder: Path | None = small.folder) -> str:
        text = said("golden", words, *(["--folder", folder] if folder else []), status=status)
        assert status < 2 or text.count("\n") == 1
        return text

    return run


def test_list_names_what_is_there_what_is_missing_and_what_is_proved(golden: Said) -> None:
    assert "reference              34 digits, none proved: not proved yet" in golden("list")
    listed = golden("list", folder=None)
    assert "reference              34 digits, 34 proved" in listed
    assert "coulomb-stick-slip     34 digits, none proved: the contact sticks " in listed
    scenes = json.loads(golden("list --json", folder=None))["scenes"]
    (proof,) = (one["proof"] for one in scenes if one["scene"] == "reference")
    assert proof["rounded"] == proof["entries"] > 20_000


def test_verify_fails_with_status_1_and_names_the_damage(small: Small, golden: Said) -> None:
    path = small.folder / "reference" / TRAJECTORY
    path.write_text(path.read_text().replace("0.02,", "0.02,-", 1))
    printed = json.loads(golden("verify reference --json --workers 1", status=1))
    assert printed["schema"] == "tt_precise.golden.verify/1"
    (one,) = printed["scenes"]
    assert (one["scene"], one["verdict"], one["digits_claimed"]) == ("reference", "fail", 34)
    assert "trajectory.csv: changed since it was written" in one["problems"][0]
    assert "trajectory.csv, line 4, kx: newton 160 agrees to 0.7" in "".join(one["problems"])


def test_what_cannot_be_certified_is_found_out_before_the_work(
    golden: Said, monkeypatch: Patch
) -> None:
    def unwritable(path: Path) -> None:
        raise InputError(f"{path}: Permission denied")

    monkeypatch.setattr("tt_precise.certify.files.attempted", lambda *_: pytest.fail("minutes"))
    assert "got 'nowhere'" in golden("certify reference nowhere --workers 1", status=2)
    monkeypatch.setattr(files, "require_writable", unwritable)
    assert "proof.json: Permission denied" in golden("certify reference --workers 1", status=2)


def test_damaged_data_are_named_and_the_others_are_listed(small: Small, golden: Said) -> None:
    shutil.copytree(small.folder / "reference", small.folder / "second")
    (small.folder / "reference" / MANIFEST).write_text("{}")
    lines = golden("list", status=1).splitlines()
    assert lines[0].startswith("second                 34 digits")
    assert "manifest.json: got " in lines[1]
    (one,) = json.loads(golden("list --json", status=1))["damaged"]
    assert one["scene"] == "reference"


@pytest.mark.parametrize("place", ["empty", "missing"])
@pytest.mark.parametrize("what", ["verify", "certify", "certify --check --json"])
def test_nothing_to_look_at_is_no_pass(golden: Said, tmp_path: Path, what: str, place: str) -> None:
    (tmp_path / "empty").mkdir()
    found = golden(what, folder=tmp_path / place, status=2)
    assert f"golden data: got none in {tmp_path / place}, expected" in found
