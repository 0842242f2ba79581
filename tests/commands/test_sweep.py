"""The command sweep."""

import json
import re
import sys
from pathlib import Path

import pandas
import pytest

from tests.conftest import Printed, Said
from tt_precise.cli import main
from tt_precise.sweeps import spot_check
from tt_precise.sweeps.columns import DERIVED, FIXED, OUTCOMES

pytestmark = pytest.mark.usefixtures("few_lanes")


def test_sweep_writes_rows_and_prints_a_summary(
    tmp_path: Path, said: Said, printed: Printed
) -> None:
    out, picture = tmp_path / "sweep", tmp_path / "picture.svg"
    grid = "--until 0.3 --vary phi_dot=0:20:3 --workers 1 --recheck 0"
    summary = printed("sweep reference", grid, "--csv --out", out)
    assert (summary["schema"], summary["rows"]) == ("tt_precise.sweep/1", 3)
    assert json.loads((out / "summary.json").read_text("utf-8")) == summary
    header, *rows = (out / "rows.csv").read_text("utf-8").splitlines()
    assert header.startswith("index,phi_dot,outcome,t_init_A,t_init_B,t_init_C,t_end_A")
    assert len(rows) == 3
    for wanted in ("--y min_g_n", "--y steps --colour outcome"):
        said("sweep plot", out, "--x phi_dot", wanted, "--out", picture)
        assert picture.read_text("utf-8").startswith("<?xml")
    refused = said("sweep plot", out, "--x phi_dot --y climb", status=2)
    assert "none of 3 rows has a value" in refused


def test_two_varied_numbers_make_a_map_of_the_outcomes(tmp_path: Path, said: Said) -> None:
    out, plain, asked = (tmp_path / name for name in ("a.csv", "plain.svg", "asked.svg"))
    said(
        "sweep reference --until 0.1 --vary mu=0.1,0.3 --vary omega_3=1,155 --workers 1 --out", out
    )
    said("sweep plot", out, "--x omega_3 --y mu --out", plain)
    said("sweep plot", out, "--x omega_3 --y mu --map outcome --out", asked)
    assert plain.read_text("utf-8") == asked.read_text("utf-8")
    assert "--record lambda_ratio" in said("sweep plot", out, "--out", asked)
    assert plain.read_text("utf-8") == asked.read_text("utf-8")
    said("sweep plot", out, "--x omega_3 --y mu --colour steps --out", asked)
    assert plain.read_text("utf-8") != asked.read_text("utf-8")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text('scene = "reference"\nuntil = "0.3"\n[vary]\nmu = "0.3,0.4"\n', "utf-8")
    return path


def test_sweep_reads_toml(file: Path, said: Said) -> None:
    text = said("sweep", file, "--workers 1 --recheck 0")
    assert "2 of 2 rows" in text
    assert "             mu: 0.3 to 0.4 s/m\n" in text


def test_the_summary_says_the_units_of_the_rows(said: Said) -> None:
    words = "--vary theta=1deg:9deg:2 --vary omega_3=600rpm --until 0.05 --workers 1 --recheck 0"
    text = said("sweep reference", words)
    assert "          theta: 0.0174533 to 0.15708 rad (1 to 9 deg)\n" in text
    assert "        omega_3: 62.8319 to 62.8319 rad/s\n" in text
    assert re.search(r"^        min_g_n: [\d.]+ to [\d.]+ N$", text, re.MULTILINE)
    words = "--vary mu=0.05,0.3 --until 6 --workers 1 --recheck 0"
    assert "3.18597 to 3.18597 s (none in 1 of 2 rows)\n" in said("sweep reference", words)


@pytest.mark.parametrize(
    "option",
    ["--vary mu=1,2", "--box mu=1:2", "--samples 4", "--seed 0", "--until 1",
     "--record climb_A", "--contact bilateral"],
)  # fmt: skip
def test_a_key_of_the_file_of_a_sweep_is_refused_as_an_option(
    file: Path, said: Said, option: str
) -> None:
    refused = said("sweep", file, option, status=2)
    assert refused.startswith(f"tt-precise: {option.split()[0]}: got this option with ")
    assert refused.rstrip().endswith(" in that file")


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
    asked = "sweep reference --until 0.1 --vary phi_dot=90 --workers 1 --recheck 1"
    assert main(asked.split()) == (1 if message else 0)
    expected = f"tt-precise: THE SPOT CHECK CONTRADICTS ROWS OF THE SWEEP: {message}"
    assert capsys.readouterr().err == (expected if message else "")


def test_the_help_names_every_column(said: Said) -> None:
    text = said("sweep -h")
    for name in (*FIXED, *DERIVED, *OUTCOMES):
        stem, _, definition = name.rpartition("_")
        assert (f"{stem}_A, _B, _C" if definition in ("A", "B", "C") else name) in text


def test_rows_in_csv_need_no_parquet(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, said: Said
) -> None:
    """A file, or rows.csv in a folder, which holds nothing else then."""
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    words = "sweep reference --until 0.1 --vary phi_dot=0,1 --workers 1 --recheck 0 --out"
    file, folder = tmp_path / "rows.csv", tmp_path / "sweep"
    said(words, file)
    said(words, folder, "--csv")
    assert file.read_text("utf-8") == (folder / "rows.csv").read_text("utf-8")
    assert [one.name for one in folder.iterdir()] == ["rows.csv"]
    assert pandas.read_csv(file)["outcome"].tolist() == ["undecided"] * 2
    assert "parquet: not installed" in said(words, folder, status=2)
    assert "--csv: got the URL" in said(words, "file:///tmp/x --csv", status=2)
