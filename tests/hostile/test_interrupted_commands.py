"""Signals at random moments of every command that writes: old files or new, never half a file."""

import csv
import gzip
import json
import os
import random
import shutil
import signal
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from tests.hostile.conftest import PROVED, Commands, arguments
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
    commands: Commands, tmp_path: Path, writer: str, name: str
) -> None:
    """Each moment is drawn anew: within imports, work, writing.

    A file is replaced by renaming, which is atomic (POSIX rename).
    """
    drawn = random.Random(f"{SEED} {writer} {name}")
    for moment in range(MOMENTS):
        interrupted(commands, tmp_path / str(moment), writer, name, drawn)


def test_a_run_that_is_killed_leaves_whole_files(commands: Commands, tmp_path: Path) -> None:
    interrupted(commands, tmp_path, "run", "SIGKILL", random.Random(SEED))
    # half a file would be noticed
    (tmp_path / "out" / "a.csv").write_text("t,half")
    assert torn(tmp_path / "out") == ["a.csv"]


def interrupted(
    commands: Commands, place: Path, writer: str, name: str, drawn: random.Random
) -> None:
    """Start the command, send it the signal at a random moment, and look at what is left."""
    folder = place / "out"
    folder.mkdir(parents=True)
    for old in ("a.csv", "a.svg"):
        (folder / old).write_text(OLD)
    (folder / "rows.csv").write_text("a,b\n1,2\n3,4\n")
    if writer == "golden certify":
        for scene in PROVED:
            shutil.copytree(home() / scene, folder / scene)
    # as at a terminal: what was started in the background has inherited to ignore SIGINT
    process = commands.start(
        arguments(writer, folder), before=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)
    )
    time.sleep(drawn.uniform(FIRST_S, LAST_S))
    process.send_signal(getattr(signal, name))
    _, err = process.communicate(timeout=60)
    # 0: it had finished; negative: it had, and was about to leave
    assert process.returncode in (SIGNALS[name], 0, -getattr(signal, name)), err
    # after SIGKILL it is its workers, which lose their queues, that have the last word
    assert "Traceback" not in err or name == "SIGKILL", err
    assert torn(folder) == []
    assert not left_running(process.pid)


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
    for path in (folder / name for name in visible(folder) if name != "rows.csv"):
        try:
            if path.parent.name in PROVED:
                load(path.parent.name, folder=folder)
                read(path.parent.name, folder)
            elif path.read_bytes() != OLD.encode() and not whole[path.suffix](path):
                found.append(path.name)
        except (InputError, ValueError):
            found.append(path.name)
    return found


def files(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def visible(folder: Path) -> list[str]:
    """All but what SIGKILL has left half done, which is hidden."""
    return [n for n in files(folder) if not any(part[0] == "." for part in Path(n).parts)]


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
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, its_group = stat.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                return True
    return False


# Killed at twenty moments one after the other in the same place, then repeated: what is left is,
# byte for byte, what an undisturbed run leaves.


def certify(folder: Path) -> list[str]:
    """Of a scene that takes 2 s, without the proof that ships."""
    place = folder / "upright"
    if not place.exists():
        shutil.copytree(home() / "upright", place)
        for name in ("proof.json", "enclosure.csv", "events-enclosure.csv"):
            (place / name).unlink()
    return ["golden", "certify", "upright", "--folder", str(folder)]


def extremes(folder: Path) -> list[str]:
    return ["extremes", "--quick", "--topic", "geometry", "--out", str(folder / "a.json")]


def run(folder: Path) -> list[str]:
    folder.mkdir(exist_ok=True)
    return ["run", "reference", "--digits", "6", "--out", str(folder / "a.csv")]


@pytest.mark.slow
@pytest.mark.parametrize("words", [run, certify, extremes], ids=lambda words: words.__name__)
def test_what_was_killed_and_repeated_is_what_was_not(
    commands: Commands, tmp_path: Path, words: Callable[[Path], list[str]]
) -> None:
    folder, undisturbed = tmp_path / "killed", tmp_path / "undisturbed"
    for place in (tmp_path / "compiling", undisturbed):  # the second with compiled integrators
        begin = time.monotonic()
        assert commands.outside(words(place)).status == 0
        took = time.monotonic() - begin
    drawn = random.Random(SEED)
    for _ in range(20):
        process = commands.start(words(folder))
        time.sleep(drawn.uniform(0.1, 1.0) * took)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
    answer = commands.outside(words(folder))
    assert answer.status == 0, answer
    names = visible(folder)
    assert names == files(undisturbed)
    for name in names:
        assert (folder / name).read_bytes() == (undisturbed / name).read_bytes(), name
