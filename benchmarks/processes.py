"""Whole commands, from the start of Python to their exit, beside ``import numpy``."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from tt_precise.runtime.startup import THREADS
from tt_precise.tradeoff.timing import Turn, processor_time

ENTRY = "from tt_precise.cli import entry; entry()"


class Command(NamedTuple):
    """A call of the command line, and at most how many times ``import numpy`` it may take."""

    name: str
    argv: tuple[str, ...]
    limit: float | None


def commands(scratch: Path) -> Iterator[Command]:
    """What is measured; ``scratch`` takes what they write."""
    out = str(scratch / "reference.csv")
    run = ("run", "reference", "--out", out)
    yield Command("tt-precise run reference --out x.csv", run, 3.5)
    # after it, because it reads what the one before has written
    yield Command("tt-precise check x.csv", ("check", out, "--scene", "reference"), 2.2)
    yield Command("tt-precise events reference", ("events", "reference"), 4.0)
    yield Command("tt-precise thresholds reference", ("thresholds", "reference"), 4.0)
    yield Command("tt-precise claims NUM-22", ("claims", "NUM-22"), None)
    yield Command("tt-precise claims --verdict misprint", ("claims", "--verdict", "misprint"), None)
    yield Command("tt-precise run reference --out x.csv, first run ever", run, 7.0)


def turn(argv: Sequence[str], cache: Path, first: bool = False) -> Callable[[], Sequence[Turn]]:
    """A command as it is usually met, with warm caches; ``first``: as on a new machine.

    heyoka's ``cache`` is one of their own: where a machine's has grown beyond its limit, because
    thousands of integrators were compiled, looking into it takes most of a second.
    """

    def turns() -> Sequence[Turn]:
        if not first:
            action = partial(_call, ENTRY, *argv, HEYOKA_CACHE_DIR=str(cache))
            action()
            return [Turn(lambda: action, import_numpy, processor_time)]
        return [Turn(lambda: partial(_on_a_new_machine, argv), import_numpy, processor_time)]

    return turns


def import_numpy() -> None:
    """The yardstick."""
    _call("import numpy")


def _call(code: str, *argv: str, **environment: str) -> None:
    # modules are compiled once, as where a wheel was installed; and what this process set for its
    # own children is not what a shell has
    usual = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}
    usual.pop(THREADS, None)
    subprocess.run(
        [sys.executable, "-c", code, *argv],
        check=True, env={**usual, **environment},
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip


def _on_a_new_machine(argv: Sequence[str]) -> None:
    with tempfile.TemporaryDirectory() as cache:
        _call(ENTRY, *argv, XDG_CACHE_HOME=cache)
