"""The command line: exit statuses, one line for what cannot be used, interruption."""

import errno
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import click
import pytest

import tt_precise
from tests.conftest import Said, SceneFile, every_command, more
from tt_precise import cli
from tt_precise.runtime.values import InputError

LONG = """
import os, signal, sys, threading
from tt_precise import cli

threading.Timer(4, os.kill, (os.getpid(), signal.SIGINT)).start()
sys.argv = ["tt-precise", "run", "frictionless", "--until", "100000", *sys.argv[1:]]
cli.entry()
"""


@pytest.fixture
def refused(said: Said) -> Said:
    """The one line that is printed about input which cannot be used."""

    def run(*words: str | Path) -> str:
        line = said(*words, status=2)
        assert line.startswith("tt-precise: ")
        assert line.count("\n") == 1 == len(line.splitlines())
        return line

    return run


def test_a_wrong_scene_is_named_with_its_file(refused: Said, scene_file: SceneFile) -> None:
    file = scene_file(R="0,1")
    assert f"tt-precise: {file}: R: got '0,1', expected" in refused("run", file)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("run nowhere", "scene: got 'nowhere', expected a path to a .toml file or one of: "),
        ("run reference --until -1", "until: got -1"),
        ("run reference --until 1h", "until: got '1h', expected a time"),
        ("run upright --formulation euler", "theta = 0, which is a pole"),
        ("run reference --out /proc/a.csv", "expected a place that can be written"),
        ("run reference --out .", "is a directory"),
        ("run reference --columns gn --out a.csv", "--columns: got 'gn', expected"),
        ("run reference --events theta_min,perigee", "event: got 'perigee'"),
        ("run reference --digits 9 --precision quad", "digits: got a precision"),
        ("run reference --out a.xlsx", "'.xlsx'"),
        ("run reference --plot a.jpg", "a.jpg"),
        ("run", "Missing argument 'SCENE'. See `tt-precise run --help`."),
        ("events reference --only perigee", "event: got 'perigee'"),
        ("events --until 1", "--until: got no SCENE"),
        ("golden list --folder nowhere", "golden data: got none in nowhere, expected"),
        ("invert", "command: got 'invert', expected one of: run, thresholds, scene, "),
        ("claims NUM-99", "NUM-99"),
        ("claims --verdict wrong", "--verdict: got 'wrong', expected one of"),
        ("sweep nothing --vary mu=1,2", "scene"),
        ("sweep reference --vary mu", "--vary"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(
    refused: Said, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in refused(words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("error", [KeyError("x"), OSError(errno.ENOENT, "No such file", "mine")])
def test_a_bug_is_neither_bad_input_nor_a_failed_check(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    monkeypatch.setattr(click.Group, "invoke", Mock(side_effect=error))
    assert cli.main(["columns"]) == 70
    *trace, line = capsys.readouterr().err.splitlines()
    assert trace[0].startswith("Traceback")
    assert f"a bug in tt-precise {tt_precise.__version__} ({type(error).__name__})" in line


def test_an_error_is_one_line(refused: Said, monkeypatch: pytest.MonkeyPatch) -> None:
    full = OSError(errno.ENOSPC, "no space")
    for error in (InputError("got this\nand that, expected other"), MemoryError(), full):
        monkeypatch.setattr(cli.group, "main", Mock(side_effect=error))
        refused()


def numeric_options() -> list[tuple[str, str]]:
    """(command, option) of each option that takes a number."""
    kinds = ("integer", "float", "integer range", "float range", "number")
    return [
        (words, option.opts[0])
        for words, command in every_command()
        for option in command.params
        if "--until" in option.opts
        or (option.type.name in kinds and isinstance(option, click.Option))
    ]


@pytest.mark.parametrize("value", ["nan", "ten", ""])
@pytest.mark.parametrize(("command", "option"), numeric_options())
def test_every_option_refuses_a_value_that_is_no_number(
    refused: Said, command: str, option: str, value: str
) -> None:
    needed = {
        "check": "- --scene reference", "sweep run": "reference --vary phi_dot=1,2 --workers 1",
        **dict.fromkeys(("events", "extremes", "run", "thresholds"), "reference"),
    }.get(command, "")  # fmt: skip
    refused(command, needed, option, f"'{value}'")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_command_explains_itself(said: Said, name: str) -> None:
    assert re.search(rf"^  {name} ", said("--help"), re.MULTILINE)
    assert f"Usage: tt-precise {name}" in said(name, "--help")


def test_no_command_shows_the_help_and_the_package_is_the_command(said: Said) -> None:
    assert said(status=2).startswith("Usage: tt-precise")
    module = [sys.executable, "-m", "tt_precise", "--version"]
    assert subprocess.check_output(module, text=True) == said("--version")


@pytest.mark.parametrize("precision", ["double", more("quad")])
def test_an_interruption_ends_a_long_run(precision: str) -> None:
    """A run that would take hours ends soon after Ctrl-C."""
    words = [sys.executable, "-c", LONG, "--precision", precision]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)
    assert (done.returncode, done.stdout) == (130, "")
    assert done.stderr.strip() == "tt-precise: interrupted"


def test_a_reader_that_leaves_early_is_no_error() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    words = [sys.executable, "-c", "from tt_precise.cli import entry; entry()", "events"]
    done = subprocess.run(words, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, "")
