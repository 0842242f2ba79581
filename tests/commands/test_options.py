"""Options that commands share: numbers, names, scenes, and where a document goes."""

from __future__ import annotations

import json
from pathlib import Path

import click
from click.testing import CliRunner

from tt_precise.commands import options
from tt_precise.scene.scene import Scene


@click.group()
def group() -> None:
    """A group with one command."""


@group.command("show")
@click.option("--size", type=options.POSITIVE)
@options.several(["a", "b"], "--names", "Only these")
@options.JSON
def show(size: float, names: tuple[str, ...], as_json: bool) -> None:
    """Print what was given."""
    options.emit(as_json, {"size": size, "names": list(names)}, [f"size {size}"])


def run(words: str) -> tuple[int, str]:
    result = CliRunner().invoke(group, words.split())
    return result.exit_code, result.output


def test_lines_or_one_json_object(tmp_path: Path) -> None:
    assert run("show --size 2") == (0, "size 2.0\n")
    status, text = run("show --size 2 --names a,b --json")
    assert (status, json.loads(text)) == (0, {"size": 2.0, "names": ["a", "b"]})
    file = tmp_path / "out.json"
    options.emit(False, {"size": 1}, [], file)
    assert json.loads(file.read_text("utf-8")) == {"size": 1}


def test_numbers_below_the_limit_and_wrong_names_are_refused() -> None:
    for size in ("0", "-1", "nan", "inf"):
        status, text = run(f"show --size {size}")
        assert status == 2
        assert f"got '{size}', expected a finite number above 0" in " ".join(text.split())
    result = CliRunner().invoke(group, ["show", "--names", "a,c"])
    assert str(result.exception) == "--names: got 'c', expected one of: a, b"


@group.command("end")
@options.scene(default="reference")
def end(scene: Scene) -> None:
    """Print the horizon of a scene."""
    click.echo(f"{scene.name} {scene.until}")


def test_a_command_receives_the_scene_with_its_horizon() -> None:
    assert run("end") == (0, "reference 8\n")
    assert run("end rolling --until 1/3") == (0, "rolling 1/3\n")
