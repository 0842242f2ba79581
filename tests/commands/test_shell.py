"""What a user of a shell meets: a full disk, a read-only folder, a run that is killed."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.conftest import more
from tt_precise.golden.store import home

OLD = "old\n"
LARGEST = 3000  # bytes that a file may have
ENTRY = "from tt_precise.cli import entry; entry()"
# linux/prctl.h, linux/capability.h
PR_CAPBSET_DROP, CAP_DAC_OVERRIDE = 24, 1
WRITERS = {
    "run": "run reference --out {folder}/a.csv",
    "check": "check {golden} --scene reference --plot {folder}/a.svg",
    "sweep": "sweep reference --vary mu=0.2:0.3:40 --until 0.1 --workers 1 --out {folder}/rows.csv",
    "golden build": "golden build upright --workers 1 --folder {folder}",
}


class Answer(NamedTuple):
    """The exit status of a command (negative: the signal that killed it), stdout, stderr."""

    status: int
    out: str
    err: str

    @property
    def refused(self) -> bool:
        """Status 2, one line on stderr, nothing else."""
        return (self.status, self.out, self.err.count("\n")) == (2, "", 1)


Shell = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Start a command in a process of its own, with an empty cache folder."""
    # Python does not notice when a full disk cuts off a compiled module, and every later process
    # would stumble over it
    own = {"XDG_CACHE_HOME": str(tmp_path_factory.mktemp("cache")), "PYTHONDONTWRITEBYTECODE": "1"}
    started: list[subprocess.Popen[str]] = []

    def run(
        words: str, before: Callable[[], Any] | None = None, stdout: Any = subprocess.PIPE
    ) -> Any:
        process = subprocess.Popen(
            [sys.executable, "-c", ENTRY, *words.split()],
            env={**os.environ, **own}, stdout=stdout, stderr=subprocess.PIPE, text=True,
            start_new_session=True, preexec_fn=before,
        )  # fmt: skip
        started.append(process)
        return process

    yield run
    for process in started:
        if process.poll() is None:  # a test has failed
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()


def answer(process: subprocess.Popen[str]) -> Answer:
    out, err = process.communicate(timeout=240)
    return Answer(process.returncode, out or "", err)


def files_of(most: int) -> Callable[[], None]:
    """Let files have at most so many bytes, as on a full disk; setrlimit(2)."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


def obey_permissions() -> None:
    """Let file permissions bind the superuser too, from the next program on."""
    # fails, without effect, for everybody else, whom they bind anyway
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)


def typed(writer: str, folder: Path) -> str:
    return WRITERS[writer].format(folder=folder, golden=home() / "reference/trajectory.csv")


@pytest.mark.parametrize(
    "writer", [w if w == "run" else pytest.param(w, marks=pytest.mark.slow) for w in WRITERS]
)
def test_a_full_disk_leaves_the_old_files_and_no_other(
    start: Shell, tmp_path: Path, writer: str
) -> None:
    """Writing fails in the middle of a file."""
    olds = [tmp_path / "a.csv", tmp_path / "a.svg"]
    for old in olds:
        old.write_text(OLD)
    found = answer(start(typed(writer, tmp_path), files_of(LARGEST)))
    assert found.refused, found
    assert [old.read_text() for old in olds] == [OLD, OLD]
    assert sorted(tmp_path.glob("a.*")) == olds
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    cut = [path.suffix for path in files if path.stat().st_size >= LARGEST]
    assert cut in ([], [".part"])  # the rows of a sweep that are there stay for the next command
    assert list(tmp_path.rglob(".*")) == []


@pytest.mark.parametrize("ending", [more(".h5"), more(".parquet"), more(".arrow"), ".json"])
def test_a_disk_that_fills_up_while_a_library_writes_leaves_nothing(
    start: Shell, tmp_path: Path, ending: str
) -> None:
    """The limit lets the check before the work pass; HDF5 would end in a segmentation fault."""
    words = f"run reference --until 2 --out {tmp_path}/a{ending}"
    found = answer(start(words, files_of(8192)))
    assert found.refused, found
    assert list(tmp_path.rglob("*")) == []


def test_a_full_disk_behind_a_pipe_is_one_line(start: Shell) -> None:
    with open("/dev/full", "w") as sink:
        found = answer(start("events", stdout=sink))
    assert found.refused, found


def test_a_folder_that_cannot_be_written_is_one_line_before_the_work(
    start: Shell, tmp_path: Path
) -> None:
    tmp_path.chmod(0o555)
    words = f"run reference --until 100000 --out {tmp_path}/a.csv"
    found = answer(start(words, obey_permissions))
    tmp_path.chmod(0o755)
    assert found.refused, found
    assert "Permission denied" in found.err


@pytest.mark.parametrize("after_s", [0.5, 1.5])
def test_a_run_that_is_killed_leaves_the_old_file_or_a_whole_one(
    start: Shell, tmp_path: Path, after_s: float
) -> None:
    """At any moment: a file is written elsewhere and renamed, which is atomic (rename(2))."""
    file = tmp_path / "a.csv"
    file.write_text(OLD)
    process = start(f"run reference --out {file}")
    time.sleep(after_s)
    process.send_signal(signal.SIGKILL)
    assert answer(process).status in (-signal.SIGKILL, 0)
    assert file.read_text() == OLD or len(file.read_text().splitlines()) == 802
