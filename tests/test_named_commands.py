"""Commands that are named outside the documentation's pages exist, with their options.

In messages and docstrings of the package, in tutorials' cells, in examples, in CONTRIBUTING and the
like, and in the tests that take too long to be run each time.
"""

import json
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from tests.test_documentation import check_words
from tests.test_schemas import OUTPUTS, SLOW
from tt_precise import cli
from tt_precise.integration import integrate

ROOT = Path(__file__).parents[1]
CI = ROOT / "examples/ci"
TUTORIALS = sorted((ROOT / "docs/tutorials").glob("*.md"))
TEXTS = [
    *(ROOT / name for name in ("CONTRIBUTING.md", "SECURITY.md", "reference_data/README.md")),
    *(ROOT / "tt_precise").rglob("*.py"),
    *(ROOT / "tt_precise").rglob("*.md"),
    *(path for path in (ROOT / "examples").rglob("*") if path.is_file()),
]
QUOTED = re.compile(r"`(tt-precise [a-z][^`\n]*)`")
TYPED = re.compile(
    r"^(?:.*&& | *)(tt-precise [a-z][^|>\n]*?)(?: \*/|')?(?= *(?:\||>|$))", re.MULTILINE
)


def named(text: str) -> Iterator[str]:
    """The commands of a text: in backquotes, or alone in a line, which may end in a backslash."""
    whole = text.replace("\\\n", " ")
    for found in (*QUOTED.finditer(whole), *TYPED.finditer(whole)):
        yield re.sub(r"\{[^}]*\}", "reference", found[1])


@pytest.mark.parametrize("paths", [TUTORIALS, TEXTS], ids=["tutorials", "others"])
def test_named_commands_exist(paths: list[Path]) -> None:
    for path in paths:
        for command in named(path.read_text("utf-8")):
            try:
                check_words(command, partly=True)
            except click.ClickException as error:
                pytest.fail(f"{path}: {command}: {error.format_message()}")


@pytest.mark.parametrize("name", [*OUTPUTS, *SLOW])
def test_commands_of_the_schemas_exist(name: str) -> None:
    for words, _ in {**OUTPUTS, **SLOW}[name]:
        check_words(shlex.join(["tt-precise", *words.split(), "--json"]))


@pytest.mark.parametrize("name", ["workflow.yml", "pre-commit-config.yaml"])
def test_commands_of_the_examples_exist(name: str) -> None:
    words = re.findall(r"tt-precise check [^'|>\n]+", (CI / name).read_text("utf-8"))
    assert words
    for command in words:
        check_words(command)


def test_an_annotation_for_each_check_that_failed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frame = integrate("reference", until="0.1").frame()
    frame.to_csv(tmp_path / "right.csv", index=False)
    frame["Lx"] *= 1.01
    frame.to_csv(tmp_path / "wrong.csv", index=False)
    for name, status in (("right", 0), ("wrong", 1)):
        argv = ["check", str(tmp_path / f"{name}.csv"), "--scene", "reference", "--json"]
        assert cli.main(argv) == status
        printed = capsys.readouterr().out
        (tmp_path / "check.json").write_text(printed, "utf-8")
        failed = [one["name"] for one in json.loads(printed)["checks"] if one["verdict"] == "fail"]
        annotations = [sys.executable, str(CI / "annotations.py"), str(tmp_path / "check.json")]
        lines = subprocess.run(annotations, capture_output=True, text=True, check=True).stdout
        titles = [line.split("::")[1].split()[1] for line in lines.splitlines()]
        assert titles == [f"title={one}" for one in failed]
        assert bool(failed) == (name == "wrong")
