"""The command sweep."""

import json
from pathlib import Path

import pytest

from tt_precise.cli import main
from tt_precise.sweeps import spot_check

pytestmark = pytest.mark.usefixtures("few_lanes")

GRID = ["--until", "0.3", "--vary", "phi_dot=0:20:3", "--workers", "1", "--recheck", "0"]


def test_sweep_writes_rows_and_prints_a_summary(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "sweep"
    assert main(["sweep", "reference", *GRID, "--out", str(out), "--csv", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "tt_precise.sweep/1"
    assert printed["rows"] == 3
    assert json.loads((out / "summary.json").read_text("utf-8")) == printed
    header, *rows = (out / "rows.csv").read_text("utf-8").splitlines()
    assert header.startswith("index,phi_dot,outcome,t_init_A,t_init_B,t_init_C,t_end_A")
    assert len(rows) == 3
    for wanted in (["--y", "min_g_n"], ["--y", "steps", "--colour", "outcome"]):
        picture = tmp_path / "picture.svg"
        plot = ["sweep", "plot", str(out), "--x", "phi_dot", *wanted, "--out", str(picture)]
        assert main(plot) == 0
        assert picture.read_text("utf-8").startswith("<?xml")
    capsys.readouterr()
    assert main(["sweep", "plot", str(out), "--x", "phi_dot", "--y", "climb"]) == 2
    assert "none of 3 rows has a value" in capsys.readouterr().err


def test_sweep_reads_toml(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "small.toml"
    path.write_text('scene = "reference"\nuntil = "0.3"\n[vary]\nmu = "0.3,0.4"\n', "utf-8")
    assert main(["sweep", str(path), "--workers", "1", "--recheck", "0"]) == 0
    assert "2 of 2 rows" in capsys.readouterr().out


@pytest.mark.parametrize(
    "option",
    ["--vary mu=1,2", "--box mu=1:2", "--samples 4", "--sampler latin", "--seed 0", "--until 1",
     "--record climb_A", "--contact bilateral"],
)  # fmt: skip
def test_what_a_sweep_s_file_says_is_not_said_beside_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    path = tmp_path / "small.toml"
    path.write_text('scene = "reference"\nuntil = "0.3"\n[vary]\nmu = "0.3,0.4"\n', "utf-8")
    assert main(["sweep", str(path), *option.split()]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"tt-precise: {option.split()[0]}: got it with ")
    assert captured.out == ""


@pytest.mark.parametrize(
    ("again", "message"),
    [
        ({"outcome": "inverts"}, "1 other_outcome\n"),
        ({"t_init_A": 0.5}, "1 only_in_one\n"),
        ({}, ""),
    ],
)
def test_a_row_that_the_spot_check_contradicts_is_no_success(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    again: dict[str, object], message: str,
) -> None:  # fmt: skip
    right = spot_check.recomputed
    monkeypatch.setattr(
        spot_check, "recomputed", lambda scene, record: {**right(scene, record), **again}
    )
    asked = ["--until", "0.1", "--vary", "phi_dot=90", "--workers", "1", "--recheck", "1"]
    assert main(["sweep", "reference", *asked]) == (1 if message else 0)
    expected = f"tt-precise: THE SPOT CHECK CONTRADICTS ROWS OF THE SWEEP: {message}"
    assert capsys.readouterr().err == (expected if message else "")
