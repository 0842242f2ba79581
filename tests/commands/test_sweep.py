"""The command sweep."""

import sys
from pathlib import Path
from typing import Any

import pandas
import pytest

from tests.conftest import Printed, Said
from tt_precise.cli import main
from tt_precise.sweeps import run
from tt_precise.sweeps.columns import DERIVED, FIXED, OUTCOMES

pytestmark = pytest.mark.usefixtures("few_lanes")


@pytest.mark.parametrize("name", ["rows.csv", "rows"])
def test_sweep_writes_rows_and_plot_reads_them(
    name: str, tmp_path: Path, said: Said, printed: Printed
) -> None:
    out, picture = tmp_path / name, tmp_path / "picture.svg"
    grid = "--until 0.3 --vary phi_dot=0:20:3 --workers 1 --recheck 1"
    summary = printed("sweep reference", grid, "--out", out)
    assert (summary["schema"], summary["rows"]) == ("tt_precise.sweep/2", 3)
    assert summary["recheck"]["contradictions"] == []
    said("sweep plot", out, "--y steps --colour outcome --out", picture)
    assert picture.read_text("utf-8").startswith("<?xml")
    assert "none of 3 rows has a value" in said("sweep plot", out, "--y climb", status=2)


def test_a_csv_file_needs_no_extra(
    tmp_path: Path, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("pyarrow.parquet", "fsspec"):
        monkeypatch.setitem(sys.modules, module, None)
    words = "sweep reference --until 0.1 --vary mu=0.1,0.3 --vary omega_3=1,155 --workers 1 --out"
    file, picture = tmp_path / "map.csv", tmp_path / "map.svg"
    said(words, file)
    assert pandas.read_csv(file)["outcome"].tolist() == ["does_not_invert", "undecided"] * 2
    assert "--record lambda_ratio" in said("sweep plot", file, "--out", picture)
    assert "tt-precise[parquet]" in said(words, tmp_path / "map", status=2)
    assert "tt-precise[parquet]" in said("sweep plot", tmp_path / "map", status=2)


def test_two_varied_numbers_make_a_map_of_the_outcomes(tmp_path: Path, said: Said) -> None:
    out, plain, same, other = (tmp_path / name for name in ("a.csv", "b.svg", "c.svg", "d.svg"))
    grid = "--vary mu=0.1,0.3 --vary omega_3=1,155 --recheck 0"
    said("sweep reference --until 0.1 --workers 1", grid, "--out", out)
    said("sweep plot", out, "--out", plain)
    said("sweep plot", out, "--x omega_3 --y mu --map outcome --out", same)
    said("sweep plot", out, "--colour steps --out", other)
    assert plain.read_text("utf-8") == same.read_text("utf-8") != other.read_text("utf-8")


def test_the_summary_has_units_and_missing_times(said: Said) -> None:
    words = "--vary theta=1deg:9deg:2 --vary omega_3=600rpm --until 0.05 --workers 1 --recheck 0"
    text = said("sweep reference", words)
    assert "2 of 2 rows in " in text
    assert "          theta: 0.0174533 to 0.15708 rad (1 to 9 deg)\n" in text
    assert "        omega_3: 62.8319 to 62.8319 rad/s\n" in text
    words = "--vary mu=0.05,0.3 --until 6 --workers 1 --recheck 1"
    text = said("sweep reference", words)
    assert "             mu: 0.05 to 0.3 s/m\n" in text
    assert "3.18597 to 3.18597 s (none in 1 of 2 rows)\n" in text
    assert "again in a finer arithmetic, rows: 2" in text


@pytest.mark.parametrize(
    ("changes", "text"),
    [({"outcome": "inverts"}, "row 0, outcome"), ({"t_init_A": 0.5}, "row 0, t_init_A"), ({}, "")],
)
def test_a_row_that_a_finer_arithmetic_contradicts_is_no_success(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
    changes: dict[str, Any], text: str,
) -> None:  # fmt: skip
    right = run.fine_row_of
    monkeypatch.setattr(run, "fine_row_of", lambda *given: {**right(*given), **changes})
    words = "sweep reference --until 0.1 --vary phi_dot=90 --workers 1 --recheck 1"
    assert main(words.split()) == (1 if text else 0)
    printed = capsys.readouterr()
    assert ("CONTRADICTS" in printed.err, text in printed.out) == (bool(text), True)


def test_the_help_names_every_column(said: Said) -> None:
    text = said("sweep -h")
    for name in (*FIXED, *DERIVED, *OUTCOMES):
        stem, _, definition = name.rpartition("_")
        assert (stem if definition in ("A", "B", "C") else name) in text


def test_find_prints_the_threshold(said: Said, printed: Printed) -> None:
    words = "sweep find reference omega_3=1:5 --until 0.1 --points 2"
    assert "none: the answer is no at all of 2 values" in said(words, status=1)
    document = printed(words, status=1)
    assert (document["value"], document["changes"], document["confirmed"]) == (None, [], False)
    assert "got 'omega_3', expected NAME=LOW:HIGH" in said("sweep find reference omega_3", status=2)
