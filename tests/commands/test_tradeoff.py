"""The command tradeoff: its JSON and its table."""

import json

import pytest

from tests.conftest import Said
from tt_precise import cli
from tt_precise.tradeoff import measure

KEYS = {"method", "setting", "precision", "error", "seconds", "steps", "jellett_drift"}


UNLIMITED = "--seconds=1e6"  # However busy the machine is.


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure, "ASKED", (6, 12))
    monkeypatch.setattr(measure, "TOLERANCES", (1e-6,))


def test_json_has_the_rows_and_the_ratios(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["tradeoff", "rolling", UNLIMITED, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["schema"], document["scene"]) == ("tt_precise.tradeoff/3", "rolling")
    rows = document["rows"]
    methods = ["tt_precise", "tt_precise", "SciPy DOP853", "SciPy LSODA"]
    assert [row["method"] for row in rows] == methods
    assert [row["setting"] for row in rows[:2]] == ["digits=6", "digits=12"]
    assert all(row.keys() >= KEYS for row in rows)
    assert rows[0]["error"] < 1e-6
    assert rows[1]["error"] < 1e-12
    assert {name.partition(",")[0] for name in document["ratios"]} <= set(methods)


def test_a_table_for_a_screen(said: Said) -> None:
    text = said(f"tradeoff contact-lost {UNLIMITED}")
    head, _, titles, first, *_ = text.splitlines()
    assert head.startswith("contact-lost, 0 to 1.33 s")
    assert titles.split() == [
        "method", "setting", "arithmetic", "digits", "seconds", "first", "drift"
    ]  # fmt: skip
    assert first.split()[:3] == ["tt_precise", "digits=6", "double"]
    assert all(len(line) <= 88 for line in text.splitlines()[1:])
    assert "atol: in SI for each entry: 1 for k, kg m^2/s for L" in text
    assert "none" not in text
    assert "until: got -1, expected seconds" in said("tradeoff reference --until -1", status=2)
    assert "--seconds: got 0, expected" in said("tradeoff reference --seconds 0", status=2)
    assert "got 'nowhere'" in said("tradeoff nowhere", status=2)


def test_a_limit_and_a_row_without_a_digit_are_explained(
    said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(measure, "TOLERANCES", (10.0,))
    text = said(f"tradeoff reference --until 0.5 {UNLIMITED}")
    assert text.startswith("reference, 0 to 0.5 s")
    assert "  none " in text
    assert "\nnone: at the worst sample no digit is right." in text
    short = said("tradeoff reference --until 0.5 --seconds 1e-9")
    assert "left out: SciPy LSODA from 10 on: beyond 1e-08 s; --seconds S allows more" in short
