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
from tt_precise.commands.options import FINITE
from tt_precise.runtime.values import InputError

LONG = """
import os, signal, sys, threading
from tt_precise import cli
from tt_precise.integration import heyoka_backend

advance = heyoka_backend._advance

def interrupted_soon(*arguments):
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    return advance(*arguments)

heyoka_backend._advance = interrupted_soon
sys.argv = ["tt-precise", "run", "frictionless", "--until", "100000", *sys.argv[1:]]
cli.entry()
"""


@pytest.fixture
def refused(said: Said) -> Said:
    """The one line that is said about input which cannot be used."""

    def run(*words: str | Path) -> str:
        line = said(*words, status=2)
        assert line.startswith("tt-precise: ")
        assert line.count("\n") == 1 == len(line.splitlines())
        return line

    return run


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("R", "0,1", "R: got '0,1', expected"),
        ("mu", "1e999", "mu: got more than 1e300"),
        ("omega_3", "-1e301", "omega_3: got more than 1e300"),
        ("model", '"', "not a TOML file"),
    ],
)
def test_a_bad_scene(
    refused: Said, scene_file: SceneFile, name: str, value: str, message: str
) -> None:
    file = scene_file(**{name: value})
    line = refused("run", file)
    assert f"tt-precise: {file}: " in line
    assert message in line


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("run nowhere", "scene: got 'nowhere', expected a path to a .toml file or one of: "),
        ("run nowhere.toml", "nowhere.toml: No such file or directory"),
        ("run reference --until -1", "until: got -1"),
        ("run reference --until 1e-999", "until: got less than 1e-300 s"),
        ("run upright --formulation euler", "theta = 0 is a pole"),
        ("run reference --formulation lagrange", "expected one of: newton, euler"),
        ("run reference --out no/such/folder/a.csv", "expected a file in a folder"),
        ("run reference --until 0 --out /proc/a.csv", "expected a place that can"),
        ("run reference --out .", "is a directory"),
        (
            "run reference --columns g_n",
            "without --out, --plot or --events with --json, expected one",
        ),
        ("run reference --columns gn --out a.csv", "--columns: got 'gn', expected"),
        ("run reference --events theta_min,perigee", "event: got 'perigee'"),
        ("run reference --record theta", "expected one of: phi, psi, x, y"),
        ("run reference --digits 0", "digits: got 0, expected a whole number"),
        ("run reference --digits 9 --precision quad", "digits: got a precision too"),
        ("run reference --bits 200", "expected bits only with mp"),
        ("run", "Missing argument 'SCENE'"),
        ("run reference again", "unexpected extra argument"),
        ("run reference --fast", "No such option"),
        ("events reference --only perigee", "event: got 'perigee'"),
        ("events --only equator", "expected the SCENE too"),
        ("events reference --only ''", "--only: got '', expected names"),
        ("golden list --folder nowhere", "golden data: got none in nowhere, expected"),
        ("thresholds reference --digits 0", "expected a whole number between 1 and"),
        ("invert", "command: got 'invert', expected one of: run, thresholds, scene, "),
        ("run reference --until 0 --out -", "-: got a dash, expected a file"),
        ("run reference --plot a.svg --out ./a.svg", "which is --out too"),
        ("run reference --out a.xlsx", "'.xlsx'"),
        ("run reference --plot a.jpg", "a.jpg"),
        ("run reference --plot none/a.svg", "--plot: got"),
        ("run reference --animate a.svg", "animate: got"),
        ("claims NUM-99", "NUM-99"),
        ("claims NUM-23 é", "é"),
        ("claims --verdict wrong", "wrong"),
        ("claims --kind x", "x"),
        ("claims --workers 0", "0"),
        ("extremes --topic weather", "weather"),
        ("sweep nothing --vary mu=1,2", "scene"),
        ("sweep reference --vary mu", "--vary"),
        ("sweep reference --vary mu=1,2 --csv", "--csv"),
        ("sweep plot nowhere --x mu --y t_init", "no rows"),
        ("sweep plot a --x b --y c --colour d --map e", "--map"),
    ],
)
def test_bad_arguments(
    refused: Said, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in refused(words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "error", [KeyError("x"), OSError(errno.ENOENT, "No such file or directory", "internal")]
)
def test_a_bug_is_neither_bad_input_nor_a_failed_check(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    monkeypatch.setattr(click.Group, "invoke", Mock(side_effect=error))
    assert cli.main(["columns"]) == 70
    *trace, line = capsys.readouterr().err.splitlines()
    assert trace[0].startswith("Traceback")
    assert f"this is a bug in tt-precise {tt_precise.__version__}" in line
    assert type(error).__name__ in line


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (InputError("got this\nand that"), "tt-precise: got this and that\n"),
        (MemoryError(), "expected "),
        (OSError(errno.ENOSPC, "No space left on device"), "expected "),
        (OSError(errno.EMFILE, "Too many open files"), "expected "),
    ],
)
def test_what_is_reported_is_always_one_line(
    refused: Said, monkeypatch: pytest.MonkeyPatch, error: Exception, message: str
) -> None:
    monkeypatch.setattr(cli.group, "main", Mock(side_effect=error))
    assert message in refused()


# what is no number, or none that anybody means
NO_NUMBERS = ("nan", "inf", "-inf", "1e999", "-1e999", "1j", "", " ", "ten", "0x10", "1_0e", "--")


def numeric_options() -> list[tuple[str, str]]:
    """(command, option) of everything that takes a number."""
    found = []
    for words, command in every_command():
        for one in command.params:
            number = one.type.name in ("integer", "float", "integer range", "float range", "number")
            if "--until" in one.opts or (number and isinstance(one, click.Option)):
                found += [(words, spelling) for spelling in one.opts]
    return sorted(found)


@pytest.mark.parametrize("value", NO_NUMBERS)
def test_what_is_no_number_is_refused(value: str) -> None:
    with pytest.raises(click.ClickException):
        FINITE.convert(value, None, None)


@pytest.mark.parametrize(("command", "option"), numeric_options())
def test_every_option_refuses_what_is_no_number(refused: Said, command: str, option: str) -> None:
    needed = {
        "check": "- --scene reference",
        "run": "reference",
        "sweep run": "reference --vary phi_dot=1,2 --workers 1",
        "thresholds": "reference",
    }.get(command, "")
    refused(command, needed, option, "ten")


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_every_command_explains_itself(said: Said, name: str) -> None:
    assert re.search(rf"^  {name} ", said("--help"), re.MULTILINE)
    assert f"Usage: tt-precise {name}" in said(name, "--help")


def test_no_command_shows_the_help_and_fails_and_the_package_is_the_command(said: Said) -> None:
    assert said(status=2).startswith("Usage: tt-precise")
    assert said("--version").split()[-1] == tt_precise.__version__
    module = [sys.executable, "-m", "tt_precise", "--version"]
    assert subprocess.check_output(module, text=True) == said("--version")


@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("run {scene} --until 0.1 --out {scene}", "--out"),
        ("check {mine} --scene {scene} --markdown {link}", "--markdown"),
        ("check {mine} --scene {scene} --junit {scene}", "--junit"),
    ],
)
def test_what_is_read_is_not_written_over(
    said: Said, refused: Said, scene_file: SceneFile, tmp_path: Path, words: str, option: str
) -> None:
    scene, mine, link = scene_file(), tmp_path / "mine.csv", tmp_path / "link"
    said("run", scene, "--until 0.05 --out", mine)
    link.symlink_to(mine)
    before = scene.read_bytes(), mine.read_bytes()
    message = refused(words.format(scene=scene, mine=mine, link=link))
    assert f"{option}: got " in message
    assert "which is read; expected another file" in message
    assert (scene.read_bytes(), mine.read_bytes()) == before


@pytest.mark.parametrize("precision", ["double", more("quad")])
def test_an_interruption_ends_a_long_run(precision: str) -> None:
    """A run that would take hours ends within a piece of it after Ctrl-C."""
    done = subprocess.run(
        [sys.executable, "-c", LONG, "--precision", precision],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 130
    assert done.stderr.strip() == "tt-precise: interrupted"
    assert done.stdout == ""


def test_a_reader_that_leaves_early_is_no_error() -> None:
    code = "from tt_precise.cli import entry; entry()"
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-c", code, "events"],
        stdout=writing, stderr=subprocess.PIPE, text=True, timeout=60, check=False,
    )  # fmt: skip
    os.close(writing)
    assert done.returncode == 128 + signal.SIGPIPE
    assert done.stderr == ""


@pytest.mark.usefixtures("few_lanes")
def test_options_that_are_lists_are_given_several_times(said: Said) -> None:
    said("sweep reference --vary mu=0.3 --vary omega_3=155 --until 0.01 --workers 1 --recheck 0")


def test_sweep_h_shows_the_options_of_a_sweep(said: Said) -> None:
    assert "--vary" in said("sweep -h")


@pytest.mark.parametrize(("word", "meant"), cli.MEANT.items())
def test_a_command_that_people_try_names_the_one_that_does_it(
    refused: Said, word: str, meant: str
) -> None:
    assert refused(word, "reference") == f"tt-precise: command: got {word!r}, expected {meant}\n"
    command = meant.partition(" ")[0]
    assert command in {*cli.COMMANDS, "COMMAND", "in"}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("run", "reference", "--mu", "0.2"), "'--mu'. It stands in the scene's file: `tt-precise "
         "scene new top.toml`."),
        (("run", "reference", "--csv", "a"), "See `tt-precise run --help`."),
        (("run", "reference", "theta"), ": lists are written with commas, without spaces. See"),
        (("run", "reference", "--until", "1h"), "until: got '1h', expected a time, such as"),
        (("run", "reference", "--set", "mu=2"), "option '--set'. It stands in the scene's file"),
        (("sweep", "reference", "--plot", "a.png"), "`tt-precise sweep plot RESULT` and"),
        (("sweep", "reference", "mu=1:2:3"), "--vary NAME=FIRST:LAST:COUNT"),
        (("check", "a.csv"), "Missing option '--scene'. A shipped name or a TOML file."),
    ],
)  # fmt: skip
def test_a_wrong_option_says_what_is_expected(
    refused: Said, words: tuple[str, ...], told: str
) -> None:
    assert told in refused(*words)
