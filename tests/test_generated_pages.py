"""Tables that the documentation makes of the package: they hold all that the commands print."""

import json
import runpy
from pathlib import Path
from typing import Any

import pytest

from tt_precise import cli

FILE = Path(__file__).parents[1] / "docs/_ext/generated.py"


def test_every_column_and_event_stands_in_its_table(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("docutils", reason="needs the extra docs")
    generated = runpy.run_path(str(FILE))

    def printed(command: str) -> Any:
        assert cli.main([command, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    sets = printed("columns")["sets"].values()
    lines = [line for line in generated["columns"]("") if line.startswith("| `")]
    assert [line.split("`")[1] for line in lines] == [name for columns in sets for name in columns]
    optional = [one for columns in sets for one in columns.values() if not one["required"]]
    assert sum("(if known)" in line for line in lines) == len(optional) > 8
    known, text = printed("events"), "\n".join(generated["events"](""))
    for name in (*known["events"], *known["joining"], *known["terminal"], "zero:NAME"):
        assert f"| `{name}`" in text, name
