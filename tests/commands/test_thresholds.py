"""``tt-precise thresholds``: every number twice, and a status that says whether they agree."""

import json
from pathlib import Path
from typing import Any

import pytest

from tt_precise import cli
from tt_precise.mechanics import thresholds as formulas
from tt_precise.scene.scene import load_scene

NAMES = ["lambda", "lambda_thres", "lambda_up", "D0", "D1", "E0", "E1", "gamma", "sigma"]


def printed(capsys: pytest.CaptureFixture[str], *argv: str, status: int = 0) -> dict[str, Any]:
    assert cli.main(["thresholds", *argv, "--json"]) == status
    out, err = capsys.readouterr()
    assert err == ""
    found: dict[str, Any] = json.loads(out)
    return found


def test_what_a_person_reads(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["thresholds", "reference", "--digits", "20"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [*NAMES, "inverts"]
    assert lines[7].split()[:2] == ["gamma", "0.93571428571428571429"]
    assert all(line.endswith("20 digits agree") for line in lines[:-1])
    assert lines[-1].split()[1] == "yes:"


def test_digits_that_do_not_agree_fail(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    original = formulas.lambda_thres
    monkeypatch.setattr(
        formulas, "lambda_thres", lambda body, fn: original(body, fn) * (1 + fn.mpf("2e-48"))
    )
    found = printed(capsys, "reference", status=1)["quantities"]
    assert found["lambda_thres"]["digits_agreed"] == 47
    assert found["lambda_up"]["digits_agreed"] == 50
    assert cli.main(["thresholds", "reference"]) == 1
    assert "ONLY 47 digits agree" in capsys.readouterr().out
    assert cli.main(["thresholds", "reference", "--digits", "45"]) == 0


def test_a_threshold_that_does_not_exist_is_no_failure(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """gamma = 3/2 > 1 + alpha: the inverted spin is never stable, as both ways find."""
    file = tmp_path / "long.toml"
    text = load_scene("reference").text
    file.write_text(text.replace('I1 = "131/350"', 'I1 = "3/5"'), "utf-8")
    found = printed(capsys, str(file), "--digits", "10")
    absent = found["quantities"]["lambda_thres"]
    assert (absent["value"], absent["independent"], absent["digits_agreed"]) == (None, None, None)
    assert found["inverts"] is False
    assert cli.main(["thresholds", str(file), "--digits", "10"]) == 0
    assert "does not exist" in capsys.readouterr().out


def test_one_that_only_one_way_finds_is_a_failure(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from tt_precise.exact.stability import MarginalMomentum

    nothing = MarginalMomentum(False, reason="spoiled")
    monkeypatch.setattr("tt_precise.exact.thresholds.marginal_spin", lambda *_, **__: nothing)
    found = printed(capsys, "reference", "--digits", "10", status=1)["quantities"]
    assert found["lambda_thres"]["independent"] is None
    assert found["lambda_thres"]["digits_agreed"] == 0
