"""The section on proofs: what it says of whole, spoiled and missing ones."""

from __future__ import annotations

import shutil
from decimal import Decimal
from pathlib import Path

import pytest

from tests.report.conftest import figures, problems, tables
from tt_precise.golden import store
from tt_precise.golden.proofs import PROOF
from tt_precise.report.golden import _times, golden_section, proof_section


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of two scenes' golden data, which the section reads instead."""
    for name in ("reference", "upright"):
        shutil.copytree(store.home() / name, tmp_path / name)
    monkeypatch.setattr(store, "home", lambda: tmp_path)
    return tmp_path


def test_rows_hold_what_is_proved() -> None:
    whole = proof_section()
    digits, times, ends = tables(whole)
    assert [row[0] for row in digits.rows] == list(whole.results) == ["reference", "upright"]
    (row,) = (row for row in times.rows if row[:2] == ("reference", "B"))
    proved = whole.results["reference"]["inversion"]["B"]
    for cell, which in zip(row[2:4], ("t_init", "t_end"), strict=True):
        exact = Decimal(proved[which]["middle"])
        assert abs(Decimal(cell) - exact) <= Decimal("5e-25")
    assert int(row[4]) >= 25
    # the theorem for ever has its constants
    held, final = (row for row in ends.rows if row[0] == "reference")
    assert held[1] == final[1] == "pi"
    assert float(held[2]) < float(final[2]) == 8
    assert float(held[3]) > float(final[3]) > 0


def test_the_digits_of_a_row_are_those_of_its_worst_number() -> None:
    exact, loose = {"middle": "0", "radius": "0"}, {"middle": "7.8", "radius": "1e-10"}
    fine = {"middle": "3.1", "radius": "1e-20"}
    times = {
        "A": {"t_init": exact, "t_end": loose}, "B": {"t_init": fine, "t_end": loose}, "C": {},
    }  # fmt: skip
    rows = [tuple(row.values()) for row in _times("s", times)]
    assert [row[2:] for row in rows] == [("0, exactly", "7.8", "9"), ("3.1", "7.8", "9")]


def test_the_table_has_the_end_of_each_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()  # of the copy, which has no flight
    monkeypatch.setattr(store, "scenes", lambda: ["flight", "upright"])
    section = golden_section()
    (table,) = tables(section)
    assert [(row[0], row[2], row[3]) for row in table.rows] == [
        ("flight", "landed", "0.15298014628"), ("upright", "complete", "8")
    ]  # fmt: skip
    (figure,) = figures(section)
    assert (figure.name, problems(figure)) == ("golden-scenes", [])
    flight, upright = figure.panels
    assert flight.facts == "landed at 0.153 s"
    # upright: theta is 0 from the left end of the panel to its right end
    assert upright.path.startswith("M0.0 34.0L")
    assert upright.path.endswith("120.0 34.0")


def test_spoiled_and_missing_proofs_are_not_counted(place: Path) -> None:
    path = place / "reference" / PROOF
    path.write_text(path.read_text().replace('"rounded": 2', '"rounded": 3', 1))
    digits, times, ends = tables(proof_section())
    row, whole = digits.rows
    assert f"{PROOF}: not every number is proved" in row[1]
    assert row[2:] == ("-",) * 7
    assert "-" not in whole
    assert times.rows == ends.rows == []
    path.write_text("nonsense")
    assert "cannot be used" in tables(proof_section())[0].rows[0][1]
    path.unlink()
    assert tables(proof_section())[0].rows[0][1] == "none"
