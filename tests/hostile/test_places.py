"""Disks that are full, folders that cannot be written, builds side by side, millions of samples."""

from __future__ import annotations

import resource
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.hostile.conftest import arguments
from tt_precise.golden import load

OLD = "old\n"
LARGEST = 3000  # bytes that a file may have
WRITERS = ("run", "check", "sweep", "golden build")
FAST = "run"  # the one that belongs to the default tests
SLOW_WRITERS = [
    one if one == FAST else pytest.param(one, marks=pytest.mark.slow) for one in WRITERS
]
PRINTERS = (
    "events",
    *(
        pytest.param(command, marks=pytest.mark.slow)
        for command in (
            "run reference --until 0.1",
            "golden list",
            "sweep --help",
            "claims EQ-8 --json",
        )
    ),
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with old results in it."""
    out = tmp_path / "out"
    out.mkdir()
    for old in ("a.csv", "a.svg"):
        (out / old).write_text(OLD)
    return out


def files_of(most: int) -> Callable[[], None]:
    """Let files have at most so many bytes, as on a full disk; setrlimit(2)."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


@pytest.mark.parametrize("writer", SLOW_WRITERS)
def test_a_full_disk_leaves_the_old_files_and_no_other(
    commands: Any, folder: Path, writer: str
) -> None:
    """Writing fails in the middle of a file."""
    alone = ["--workers", "1"] if writer == "golden build" else []
    argv = [*arguments(writer, folder), *alone]
    answer = commands.outside(argv, before=files_of(LARGEST))
    assert answer.one_line, answer
    assert {path.name: path.read_text() for path in folder.glob("a.*")} == {
        "a.csv": OLD, "a.svg": OLD,
    }  # fmt: skip
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert [path.name for path in files if path.stat().st_size >= LARGEST] == []
    assert list(folder.rglob(".*")) == []


@pytest.mark.parametrize("command", PRINTERS)
def test_a_full_disk_behind_stdout_is_one_line(commands: Any, command: str) -> None:
    """What a pipeline into a file meets."""
    with open("/dev/full", "w") as sink:
        answer = commands.outside(command.split(), stdout=sink)
    assert answer.one_line, answer


@pytest.mark.slow
@pytest.mark.parametrize("builds", [1, 2])
def test_of_builds_of_one_scene_at_once_one_does_it(
    commands: Any, tmp_path: Path, builds: int
) -> None:
    """The other is refused in one line (flock(2)), and waits for nobody; the data are whole."""
    folder = tmp_path / "golden"
    argv = ["golden", "build", "upright", "--workers", "1", "--folder", str(folder)]
    running = [commands.start(argv) for _ in range(builds)]
    errors = [process.communicate(timeout=200)[1] for process in running]
    assert sorted(process.returncode for process in running) == [0, 2][:builds]
    assert [len(error.strip().splitlines()) for error in errors if error] == [1][: builds - 1]
    assert len(load("upright", folder=folder)) > 100
