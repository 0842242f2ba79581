"""Signals at random moments of every command that writes: old files or new, never half a file."""

from __future__ import annotations

import csv
import gzip
import json
import os
import random
import shutil
import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.hostile.conftest import PROVED, arguments
from tt_precise.golden import load
from tt_precise.golden.proofs import read
from tt_precise.golden.store import home
from tt_precise.runtime.values import InputError

SIGNALS = {"SIGINT": 130, "SIGTERM": 143, "SIGKILL": -9}
MOMENTS, FIRST_S, LAST_S = 2, 0.5, 3.5
SEED = 20
OLD = "old\n"
WRITERS = (
    "run", "check", "golden build", "golden certify", "sweep", "sweep plot", "tradeoff", "extremes",
    "report",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", SIGNALS)
@pytest.mark.parametrize("writer", WRITERS)
def test_a_signal_leaves_whole_files_and_no_process(
    commands: Any, tmp_path: Path, writer: str, name: str
) -> None:
    """Each moment is drawn anew: within imports, work, writing.

    A file is replaced by renaming, which is atomic (POSIX rename).
    """
    drawn = random.Random(f"{SEED} {writer} {name}")
    for moment in range(MOMENTS):
        interrupted(commands, tmp_path / str(moment), writer, name, drawn)


def test_a_run_that_is_killed_leaves_whole_files(commands: Any, tmp_path: Path) -> None:
    interrupted(commands, tmp_path, "run", "SIGKILL", random.Random(SEED))


def test_half_a_file_would_be_noticed(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,half")
    assert torn(tmp_path) == ["a.csv"]


def interrupted(commands: Any, place: Path, writer: str, name: str, drawn: random.Random) -> None:
    """Start the command, send it the signal at a random moment, and look at what is left."""
    folder = place / "out"
    folder.mkdir(parents=True)
    for old in ("a.csv", "a.svg"):
        (folder / old).write_text(OLD)
    (folder / "rows.csv").write_text("a,b\n1,2\n3,4\n")
    if writer == "golden certify":
        for scene in PROVED:
            shutil.copytree(home() / scene, folder / scene)
    process = commands.start(arguments(writer, folder), before=heed_interrupts)
    time.sleep(drawn.uniform(FIRST_S, LAST_S))
    process.send_signal(getattr(signal, name))
    _, err = process.communicate(timeout=60)
    # 0: it had finished; negative: it had, and was about to leave
    assert process.returncode in (SIGNALS[name], 0, -getattr(signal, name)), err
    # after SIGKILL it is its workers, which lose their queues, that have the last word
    assert "Traceback" not in err or name == "SIGKILL", err
    assert torn(folder) == []
    assert not left_running(process.pid)


def heed_interrupts() -> None:
    """As at a terminal: what was started in the background has inherited to ignore SIGINT."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def torn(folder: Path) -> list[str]:
    """Files with visible names that are neither old nor whole."""
    whole: dict[str, Callable[[Path], bool]] = {
        ".csv": whole_csv,
        ".svg": lambda path: path.read_text().rstrip().endswith("</svg>"),
        ".json": lambda path: bool(json.loads(path.read_text())),
        ".html": lambda path: path.read_text().rstrip().endswith("</html>"),
        ".md": lambda path: path.read_text().endswith("\n"),
        ".gz": lambda path: bool(gzip.decompress(path.read_bytes())),
        ".toml": lambda path: path.read_text().endswith("\n"),
        ".parquet": lambda path: path.read_bytes()[-4:] == b"PAR1",
    }
    found = []
    for path in sorted(folder.rglob("*")):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if not path.is_file() or hidden or path.name == "rows.csv":
            continue
        try:
            if path.parent.name in PROVED:
                load(path.parent.name, folder=folder)
                read(path.parent.name, folder)
            elif path.read_bytes() != OLD.encode() and not whole[path.suffix](path):
                found.append(path.name)
        except (InputError, ValueError):
            found.append(path.name)
    return found


def whole_csv(path: Path) -> bool:
    """Whether all rows are there and as long as the header."""
    text = path.read_text()
    rows = list(csv.reader(text.splitlines()))
    rows_are_there = path.name != "a.csv" or len(rows) == 802
    return rows_are_there and text[-1:] == "\n" and len({len(row) for row in rows}) == 1


def left_running(group: int) -> bool:
    """Whether a process of the group still runs ten seconds later; and its end, if so."""
    until = time.monotonic() + 10
    while time.monotonic() < until:
        if not running(group):
            return False
        time.sleep(0.1)
    os.killpg(group, signal.SIGKILL)
    return True


def running(group: int) -> bool:
    """Whether a process of the group lives."""
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            state, _, its_group = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(its_group) == group and state != "Z":
            return True
    return False
