"""``tt-precise columns``: names, units, frames."""

import json

import pytest

from tt_precise import cli
from tt_precise.check.columns import COLUMN_SETS


def test_a_person_reads_every_column(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["columns"]) == 0
    printed = capsys.readouterr().out
    for found in COLUMN_SETS.values():
        assert f"\n{found.name}\n" in printed
        for name in found.names:
            assert f"\n  {name} " in printed


def test_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["columns", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == "tt_precise.columns/1"
    rigid = printed["sets"]["rigid body"]
    assert rigid["t"]["required"]
    assert rigid["qw"]["required"]
    assert not rigid["vcx"]["required"]
    assert rigid["wx"]["unit"] == "rad/s"
