"""What holds for all tests."""

import gc
import json
import os
import re
import shlex
import signal
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import click
import pytest

from tt_precise import cli
from tt_precise.integration import heyoka_backend
from tt_precise.scene.body import TippeTop
from tt_precise.scene.scene import load_scene
from tt_precise.taylor import machine

# Compiled equations of the tests, and of the commands that they start. Another name than the
# package's own, whose 64 MB the tests exceed.
os.environ["HEYOKA_CACHE_DIR"] = str(Path(__file__).parents[1] / "build" / "compiled")

# Code that is not optimised compiles in a tenth of the time in double, where it rounds otherwise,
# and in a third in several doubles. Users' code runs in sweeps and in commands that tests start.
heyoka_backend.OPTIMISATION.update(loop=0, compact=0)
machine.OPTIMISATION = 0

# Types of fixtures that many tests ask for.
Patch = pytest.MonkeyPatch
Captured = pytest.CaptureFixture[str]

# What a shell starts in the background ignores Ctrl-C, and hands that on to every process it
# starts; those of the tests are to be interrupted.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def no_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """No search for the cause of a failed check, which takes most of a check's time."""
    monkeypatch.setattr("tt_precise.check.causes.explain", lambda *_: [])


@pytest.fixture(scope="session")
def few_lanes() -> Iterator[None]:
    """Sweeps of four lanes: compiled in a quarter of the time of eight, for the same rows."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("heyoka.recommended_simd_size", lambda: 2)
        yield


# A case of a parametrised test whose other cases show its behaviour by default.
more = partial(pytest.param, marks=pytest.mark.evidence)

# One scene for each law of contact, and for each singular start or end.
OF_EACH_KIND = (
    "reference", "rolling", "contact-lost", "upright", "beside-the-pole", "coulomb-flight",
    "coulomb-stick-slip", "elastic-linear", "regularised-1e-2",
)  # fmt: skip


def of_each_kind(scenes: Iterable[str]) -> list[Any]:
    """Shipped scenes as parameters: one of each kind in the default run."""
    return [name if name in OF_EACH_KIND else more(name) for name in scenes]


Said = Callable[..., str]
Printed = Callable[..., Any]
SceneFile = Callable[..., Path]


@pytest.fixture
def said(capsys: pytest.CaptureFixture[str]) -> Said:
    """Return a function that runs a command and returns its output, or its refusal (status 2).

    Its words stand in texts, as in a shell; a path may stand alone.
    """

    def run(*words: str | Path, status: int = 0) -> str:
        capsys.readouterr()
        typed = (shlex.split(word) if isinstance(word, str) else [str(word)] for word in words)
        assert cli.main(list(chain.from_iterable(typed))) == status
        out, err = capsys.readouterr()
        told, silent = (err, out) if status == 2 else (out, err)
        assert silent == ""
        return told

    return run


@pytest.fixture
def printed(said: Said) -> Printed:
    """The JSON object that a command prints."""

    def run(*words: str | Path, status: int = 0) -> Any:
        text = said(*words, "--json", status=status)
        return json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))

    return run


@pytest.fixture
def scene_file(tmp_path: Path) -> SceneFile:
    """Write the reference scene with other values into a file."""

    def write(**changes: str) -> Path:
        text = load_scene("reference").text
        for name, value in changes.items():
            line = rf'^{name} = ".*"'
            text, count = re.subn(line, f'{name} = "{value}"', text, flags=re.MULTILINE)
            assert count == 1
        file = tmp_path / "mine.toml"
        file.write_text(text, "utf-8")
        return file

    return write


def every_command(command: Any = cli.group, words: str = "") -> Iterator[tuple[str, Any]]:
    """Yield each command with the words that call it."""
    if isinstance(command, click.Group):
        context = click.Context(command)
        for name in command.list_commands(context):
            yield from every_command(command.get_command(context, name), f"{words} {name}".strip())
    else:
        yield words, command


# the paper's top
RATIOS = {
    "m": "0.02", "R": "0.02", "alpha": "0.3", "I1": "131/350", "I3": "2/5", "g": "9.82",
    "mu": "0.3",
}  # fmt: skip


def top(**changes: Any) -> TippeTop:
    return TippeTop.from_ratios(**(RATIOS | changes))


def pytest_collection_finish() -> None:
    """Freeze the imported and collected objects: the collector need not look at them again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)
