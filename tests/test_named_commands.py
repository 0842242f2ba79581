"""Commands that are named outside the documentation's pages exist, with their options.

In messages and docstrings of the package, in tutorials' cells, in examples, in CONTRIBUTING and the
like, and in the tests that take too long to be run each time.
"""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from tests.test_documentation import check_words
from tests.test_schemas import OUTPUTS, SLOW

ROOT = Path(__file__).parents[1]
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


@pytest.mark.parametrize("text", ["as `tt-precise chek` says", "    tt-precise run --jsn | head\n"])
def test_a_command_that_does_not_exist_is_noticed(text: str) -> None:
    (command,) = named(text)
    with pytest.raises((click.ClickException, pytest.fail.Exception)):
        check_words(command, partly=True)


@pytest.mark.parametrize("name", [*OUTPUTS, *SLOW])
def test_commands_of_the_schemas_exist(name: str) -> None:
    for words, _ in {**OUTPUTS, **SLOW}[name]:
        check_words(shlex.join(["tt-precise", *words.split(), "--json"]))
