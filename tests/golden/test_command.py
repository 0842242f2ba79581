"""The command: what it prints, its JSON, and its exit status."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.golden.conftest import Small
from tests.golden.tables import edit_cell
from tt_precise.cli import main
from tt_precise.golden.store import MANIFEST, TRAJECTORY
from tt_precise.runtime import files
from tt_precise.runtime.values import InputError


def test_list_names_what_is_there_and_what_is_missing(
    small: Small, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["golden", "list", "--folder", str(small.folder)]) == 0
    out = capsys.readouterr().out
    assert "reference              34 digits, none proved          7 rows" in out
    assert "without golden data: " in out
    assert main(["golden", "list", "--folder", str(small.folder), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "tt_precise.golden.list/1"
    assert [(one["scene"], one["proof"]) for one in printed["scenes"]] == [("reference", None)]


def test_list_says_what_is_proved(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["golden", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    (line,) = (line for line in lines if line.startswith("reference "))
    assert "34 digits, 34 proved " in line
    assert main(["golden", "list", "--json"]) == 0
    (proof,) = (
        one["proof"]
        for one in json.loads(capsys.readouterr().out)["scenes"]
        if one["scene"] == "reference"
    )
    assert proof["complete"]
    assert proof["rounded"] == proof["entries"] > 20_000


def test_verify_fails_with_status_1_and_names_the_damage(
    small: Small, capsys: pytest.CaptureFixture[str]
) -> None:
    path = small.folder / "reference" / TRAJECTORY
    path.write_text(path.read_text().replace("0.02,", "0.02,-", 1))
    asked = ["golden", "verify", "reference", "--folder", str(small.folder), "--json"]
    assert main([*asked, "--workers", "1"]) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "tt_precise.golden.verify/1"
    (one,) = printed["scenes"]
    assert (one["scene"], one["verdict"], one["digits_claimed"]) == ("reference", "fail", 34)
    assert "trajectory.csv: changed since it was built" in one["problems"][0]
    assert "trajectory.csv, line 4, kx: newton triple-double agrees to 0.0" in one["problems"][1]


@pytest.mark.parametrize("what", ["build", "verify"])
def test_unknown_scenes_have_status_2(
    small: Small, capsys: pytest.CaptureFixture[str], what: str
) -> None:
    assert main(["golden", what, "nowhere", "--folder", str(small.folder)]) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert "nowhere" in captured.err


@pytest.mark.parametrize("wrong", ["no such scene", "a place that cannot be written"])
def test_what_cannot_be_certified_is_found_out_before_the_work(
    small: Small, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, wrong: str
) -> None:
    pytest.importorskip("flint", reason="needs the extra certify")
    from tt_precise.certify import golden_proof

    def unwritable(path: Path) -> None:
        raise InputError(f"{path}: Permission denied")

    monkeypatch.setattr(golden_proof, "attempted", lambda *_: pytest.fail("minutes of work"))
    scenes = ["reference"]
    if wrong == "no such scene":
        scenes.append("nowhere")
    else:
        monkeypatch.setattr(files, "require_writable", unwritable)
    argv = ["golden", "certify", *scenes, "--folder", str(small.folder), "--workers", "1"]
    assert main(argv) == 2
    said = "got 'nowhere'" if wrong == "no such scene" else "proof.json: Permission denied"
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("cell", ["nan", "inf", "1e9z"])
def test_a_cell_that_is_no_number_is_a_problem_and_no_bug(
    small: Small, capsys: pytest.CaptureFixture[str], cell: str
) -> None:
    edit_cell(small.folder / "reference" / TRAJECTORY, 2, "kx", lambda _: cell)
    problem = f"trajectory.csv, line 2, kx: got {cell!r}, expected a printed number"
    assert main(["golden", "verify", "--folder", str(small.folder), "--workers", "1"]) == 1
    assert problem in capsys.readouterr().out
    assert main(["golden", "list", "--folder", str(small.folder)]) == 0


def test_a_manifest_that_lacks_what_is_listed_is_one_line(
    small: Small, capsys: pytest.CaptureFixture[str]
) -> None:
    (small.folder / "reference" / MANIFEST).write_text("{}")
    assert main(["golden", "list", "--folder", str(small.folder)]) == 2
    captured = capsys.readouterr()
    assert "manifest.json: got schema 'None'" in captured.err
    assert captured.err.count("\n") == 1


def test_certificates_are_checked_or_written(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("flint", reason="needs the extra certify")
    assert main(["golden", "certify", "upright", "--check", "--certificate"]) == 2
    assert "--check: got --certificate too" in capsys.readouterr().err


def test_certificates_of_ones_own_data_are_found(
    small: Small,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("flint", reason="needs the extra certify")
    from tt_precise.certify import certificate

    mine = shutil.copytree(small.folder / "reference", tmp_path / "golden" / "mytop")
    (mine / certificate.FILE).write_bytes(b"nothing that anybody wrote")
    monkeypatch.chdir(tmp_path)
    assert main(["golden", "certify", "mytop", "--check"]) == 1
    assert "mytop: refused: the certificate cannot be read" in capsys.readouterr().out


@pytest.mark.parametrize("place", ["empty", "missing"])
@pytest.mark.parametrize(
    "what", ["verify", "verify --json", "certify", "certify --check", "certify --check --json"]
)
def test_nothing_to_look_at_is_no_pass(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], what: str, place: str
) -> None:
    pytest.importorskip("flint", reason="needs the extra certify")
    (tmp_path / "empty").mkdir()
    assert main(["golden", *what.split(), "--folder", str(tmp_path / place)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert f"golden data: got none in {tmp_path / place}, expected" in captured.err
    assert captured.err.count("\n") == 1
