"""Commands that are named outside the documentation's pages exist, with their options.

In messages and docstrings of the package, in tutorials' cells, in examples, in CONTRIBUTING and the
like, and in the tests that take too long to be run each time.
"""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from tests.conftest import Said
from tests.test_documentation import check_words
from tests.test_schemas import SLOW
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


def test_commands_of_the_slow_schemas_and_of_the_examples_exist() -> None:
    for (words, _), *_ in SLOW.values():
        check_words(f"tt-precise {words} --json")
    for name in ("workflow.yml", "pre-commit-config.yaml"):
        commands = re.findall(r"tt-precise check [^'|>\n]+", (CI / name).read_text("utf-8"))
        assert commands
        for command in commands:
            check_words(command)


def test_an_annotation_for_each_check_that_failed(tmp_path: Path, said: Said) -> None:
    frame = integrate("reference", until="0.1").frame()
    frame.to_csv(tmp_path / "right.csv", index=False)
    frame["Lx"] *= 1.01
    frame.to_csv(tmp_path / "wrong.csv", index=False)
    for name, status in (("right", 0), ("wrong", 1)):
        file = tmp_path / "check.json"
        file.write_text(said("check", tmp_path / f"{name}.csv", "--scene reference --json",
                             status=status), "utf-8")  # fmt: skip
        checks = json.loads(file.read_text("utf-8"))["checks"]
        failed = [one["name"] for one in checks if one["verdict"] == "fail"]
        annotations = [sys.executable, str(CI / "annotations.py"), str(file)]
        lines = subprocess.run(annotations, capture_output=True, text=True, check=True).stdout
        titles = [line.split("::")[1].split()[1] for line in lines.splitlines()]
        assert titles == [f"title={one}" for one in failed]
        assert bool(failed) == (name == "wrong")
