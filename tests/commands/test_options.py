"""Options that commands share: numbers, options given twice, and where a document goes."""

from __future__ import annotations

import json
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from tt_precise.commands import options


@click.group(cls=options.Group)
def group() -> None:
    """A group with one command."""


@group.command("show")
@click.option("--size", type=options.POSITIVE)
@click.option("--name", "names", multiple=True)
@click.option("--flag", is_flag=True)
@options.JSON
def show(size: float, names: tuple[str, ...], flag: bool, as_json: bool) -> None:
    """Print what was given."""
    options.emit(as_json, {"size": size, "names": list(names)}, [f"size {size}"])


def run(words: str) -> tuple[int, str]:
    result = CliRunner().invoke(group, words.split())
    return result.exit_code, result.output


def test_lines_or_one_json_object(tmp_path: Path) -> None:
    assert run("show --size 2") == (0, "size 2.0\n")
    status, text = run("show --size 2 --name a --name b --json")
    assert (status, json.loads(text)) == (0, {"size": 2.0, "names": ["a", "b"]})
    file = tmp_path / "out.json"
    options.emit(False, {"size": 1}, [], file)
    assert json.loads(file.read_text("utf-8")) == {"size": 1}


@pytest.mark.parametrize("size", ["0", "-1", "nan", "inf", "2m"])
def test_a_number_that_is_none_is_refused(size: str) -> None:
    status, text = run(f"show --size {size}")
    assert status == 2
    assert f"got '{size}', expected a finite number above 0" in " ".join(text.split())


def test_an_option_given_twice_is_refused_unless_it_may_be() -> None:
    status, text = run("show --size 1 --size 2")
    assert status == 2
    assert "--size: got it 2 times, expected it once" in " ".join(text.split())
    assert run("show --size 1 --name a --name b --flag --flag")[0] == 0
