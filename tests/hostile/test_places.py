"""Disks that are full, folders that cannot be written, builds side by side, millions of samples."""

import resource
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.hostile.conftest import Commands, arguments
from tt_precise.golden import load

OLD = "old\n"
LARGEST = 3000  # bytes that a file may have


def mostly_slow(first: str, *others: str) -> list[Any]:
    """All but the first are long evidence."""
    return [first, *(pytest.param(other, marks=pytest.mark.slow) for other in others)]


PRINTERS = mostly_slow(
    "events", "run reference --until 0.1", "golden list", "sweep --help", "claims EQ-8 --json"
)


def files_of(most: int) -> Callable[[], None]:
    """Let files have at most so many bytes, as on a full disk; setrlimit(2)."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


@pytest.mark.parametrize("writer", mostly_slow("run", "check", "sweep", "golden build"))
def test_a_full_disk_leaves_the_old_files_and_no_other(
    commands: Commands, tmp_path: Path, writer: str
) -> None:
    """Writing fails in the middle of a file."""
    olds = [tmp_path / "a.csv", tmp_path / "a.svg"]
    for old in olds:
        old.write_text(OLD)
    alone = ["--workers", "1"] if writer == "golden build" else []
    answer = commands.outside([*arguments(writer, tmp_path), *alone], before=files_of(LARGEST))
    assert answer.one_line, answer
    assert [old.read_text() for old in olds] == [OLD, OLD]
    assert sorted(tmp_path.glob("a.*")) == olds
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert [path.name for path in files if path.stat().st_size >= LARGEST] == []
    assert list(tmp_path.rglob(".*")) == []


@pytest.mark.parametrize("command", PRINTERS)
def test_a_full_disk_behind_stdout_is_one_line(commands: Commands, command: str) -> None:
    """What a pipeline into a file meets."""
    with open("/dev/full", "w") as sink:
        answer = commands.outside(command.split(), stdout=sink)
    assert answer.one_line, answer


@pytest.mark.slow
@pytest.mark.parametrize("builds", [1, 2])
def test_of_builds_of_one_scene_at_once_one_does_it(
    commands: Commands, tmp_path: Path, builds: int
) -> None:
    """The other is refused in one line (flock(2)), and waits for nobody; the data are whole."""
    folder = tmp_path / "golden"
    argv = ["golden", "build", "upright", "--workers", "1", "--folder", str(folder)]
    running = [commands.start(argv) for _ in range(builds)]
    errors = [process.communicate(timeout=200)[1] for process in running]
    assert sorted(process.returncode for process in running) == [0, 2][:builds]
    assert [len(error.strip().splitlines()) for error in errors if error] == [1][: builds - 1]
    assert len(load("upright", folder=folder)) > 100
