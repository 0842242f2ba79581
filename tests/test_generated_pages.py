"""Tables that the documentation makes of the package: they hold all that the commands print."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest

from tt_precise import cli

FILE = Path(__file__).parents[1] / "docs/_ext/generated.py"


@pytest.fixture(scope="module")
def generated() -> Any:
    pytest.importorskip("docutils", reason="needs the extra docs")
    spec = importlib.util.spec_from_file_location("generated", FILE)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def printed(capsys: pytest.CaptureFixture[str], command: str) -> Any:
    assert cli.main([command, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_every_column_stands_in_its_table(
    generated: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    sets = printed(capsys, "columns")["sets"]
    lines = [line for line in generated.columns("") if line.startswith("| `")]
    names = [name for columns in sets.values() for name in columns]
    assert [line.split("`")[1] for line in lines] == names
    optional = [one for columns in sets.values() for one in columns.values() if not one["required"]]
    assert sum("(if known)" in line for line in lines) == len(optional) > 8


def test_every_event_stands_in_its_table(
    generated: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    known = printed(capsys, "events")
    text = "\n".join(generated.events(""))
    for name in (*known["events"], *known["joining"], *known["terminal"]):
        assert f"| `{name}`" in text, name
    assert "| `zero:NAME`" in text
