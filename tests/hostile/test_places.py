"""Disks that are full, folders that cannot be written, builds side by side, millions of samples."""

from __future__ import annotations

import resource
import subprocess
import sys
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


MEMORY = """
import pandas, resource, sys
from dataclasses import replace
from fractions import Fraction
from tt_precise.integration.streaming import Stream
from tt_precise.scene.scene import load_scene
rows, peaks = 0, []
for samples in (10**5, int(sys.argv[1])):
    scene = replace(load_scene("reference"), sample_every=Fraction(8, samples))
    stream = Stream(scene, "theta", "g_n")
    rows = {counted}
    peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
print(rows, peaks[1] - peaks[0])
"""
STREAMED, COLLECTED = "sum(map(len, stream))", "len(pandas.concat(list(stream)))"
GROWTH_KB = 20_000


@pytest.mark.slow
@pytest.mark.parametrize(("counted", "bounded"), [(STREAMED, True), (COLLECTED, False)])
def test_ten_million_samples_stream_in_bounded_memory(counted: str, bounded: bool) -> None:
    """A block of 16,384 rows is in memory; 20 MB where one column of all would take 80."""
    done = subprocess.run(
        [sys.executable, "-c", MEMORY.format(counted=counted), str(10**7)],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    rows, growth = map(int, done.stdout.split())
    assert rows == 10**7 + 1
    assert (growth <= GROWTH_KB) == bounded
