"""README.md: its examples run, in order, in one folder, and print what it says they print.

In a ``python`` block a comment behind a ``print`` may give the beginning of what is printed, as in
``# rad at 8 s: 3.1340...``. A block that defines tests is handed to pytest. In a ``console`` block
lines after ``$ `` are commands; lines below a command are what it prints, ``...`` for anything.
"""

import contextlib
import doctest
import io
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import click
import pytest

from tt_precise import cli

README = Path(__file__).parents[1] / "README.md"
MAKEFILE = README.with_name("Makefile")
# From ten seconds to minutes: their words are checked, but they run under the marker slow only.
LONG = ("claims", "report", "golden build", "golden verify", "sweep", "tradeoff", "extremes")
BEGINNING = re.compile(r"#.*?(-?\d+\.\d+)\.\.\.")
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


class Block(NamedTuple):
    """A fenced block: its language, its text, and the line of the file on which it starts."""

    language: str
    text: str
    line: int


def blocks(text: str) -> list[Block]:
    return [
        Block(found[1], found[2], text[: found.start()].count("\n") + 2)
        for found in FENCE.finditer(text)
    ]


def commands(block: Block) -> list[tuple[str, str]]:
    """Each command of a console block, with what it is said to print."""
    pieces = re.split(r"^\$ ", block.text, flags=re.MULTILINE)
    assert not pieces[0], f"line {block.line}: expected a line that starts with '$ '"
    told = [piece.partition("\n") for piece in pieces[1:]]
    return [(command, output) for command, _, output in told]


def run_python(text: str) -> None:
    """Run a block and hold the comments behind its ``print`` to what they say."""
    if re.search(r"^def test_", text, re.MULTILINE):
        return run_tests(text)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(text, "README.md", "exec"), {})
    prints = [line for line in text.splitlines() if line.startswith("print(")]
    outputs = printed.getvalue().splitlines()
    assert len(prints) == len(outputs)
    for line, output in zip(prints, outputs, strict=True):
        beginning = BEGINNING.search(line)
        if beginning:
            assert output.startswith(beginning[1]), line
    return None


def run_tests(text: str) -> None:
    Path("test_readme_block.py").write_text(text, "utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_readme_block.py"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr


def run_command(command: str, expected: str) -> None:
    """Run a command with ``tt-precise``, which must succeed and print what is said."""
    program, *arguments = shlex.split(command, comments=True)
    assert program == "tt-precise", command
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        status = cli.main(arguments)
    assert status == 0, command
    checker = doctest.OutputChecker()
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    if expected.strip():
        assert checker.check_output(expected, printed.getvalue(), flags), printed.getvalue()


def check_words(command: str) -> None:
    """Parse a command without running it: it and its options exist."""
    _, *arguments = shlex.split(command, comments=True)
    found: click.Command = cli.group
    while isinstance(found, click.Group):
        name, *arguments = arguments
        context = click.Context(found)
        found = found.get_command(context, name) or pytest.fail(f"{command}: no such command")
    found.make_context(found.name, list(arguments))


def is_long(command: str) -> bool:
    return any(f"tt-precise {words}" in command for words in LONG)


def run_all(text: str, *, long: bool) -> int:
    """Run all blocks in the present folder; how many examples there were."""
    count = 0
    for block in blocks(text):
        if block.language == "python":
            run_python(block.text)
            count += 1
        elif block.language == "console":
            for command, expected in commands(block):
                if is_long(command) and not long:
                    check_words(command)
                else:
                    run_command(command, expected)
                count += 1
    return count


@pytest.fixture
def readme() -> str:
    if not README.exists():
        pytest.skip("there is no README.md yet")
    return README.read_text("utf-8")


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_the_examples_run(readme: str) -> None:
    assert run_all(readme, long=False) >= 5


@pytest.mark.slow
def test_the_long_examples_run_too(readme: str) -> None:
    assert run_all(readme, long=True) >= 5


def test_make_targets_exist(readme: str) -> None:
    targets = re.findall(r"^([a-z]+):", MAKEFILE.read_text("utf-8"), re.MULTILINE)
    named = re.findall(r"\bmake ([a-z]+)\b", readme)
    used = [name for name in named if f"make {name}" in readme and name not in ("each", "it")]
    assert {"report", "test"} <= set(used) <= set(targets)


def test_links_lead_somewhere(readme: str) -> None:
    links = re.findall(r"\]\(([^)#]+)\)", readme)
    inside = [link for link in links if "://" not in link]
    assert len(inside) > 3
    missing = [link for link in inside if not (README.parent / link).exists()]
    assert [link for link in missing if not link.startswith("reports/")] == []
    if missing:
        pytest.skip(f"the report is not committed yet: {', '.join(missing)}")


@pytest.mark.parametrize(
    "spoiled",
    [
        "```python\nassert 1 + 1 == 3\n```\n",
        "```python\nprint(3.14159)  # pi: 3.1417...\n```\n",
        "```python\nimport tt_precise as tt\ntt.no_such_name\n```\n",
        "```python\ndef test_mine(no_such_fixture):\n    pass\n```\n",
        "```console\n$ tt-precise run nowhere\n```\n",
        "```console\n$ tt-precise events\nno such event\n```\n",
        "```console\n$ tt-precise report --no-such-option\n```\n",
        "```console\n$ tt-precise golden burn\n```\n",
        "```console\n$ rm -r /\n```\n",
    ],
)
def test_a_wrong_example_is_found(spoiled: str) -> None:
    with pytest.raises(
        (AssertionError, AttributeError, click.ClickException, pytest.fail.Exception)
    ):
        run_all(spoiled, long=False)


def test_a_right_example_passes() -> None:
    right = (
        "```console\n$ tt-precise events\ntheta_min  turning point: ...\n```\n"
        "```python\nprint(3.14159)  # pi: 3.1415...\n```\n"
        "```toml\nanything = 'else'\n```\n"
    )
    assert run_all(right, long=False) == 2
