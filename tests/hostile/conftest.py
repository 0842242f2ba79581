"""Running the command line where it is to be mistreated: here, or in a process of its own."""

import ctypes
import io
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tt_precise.golden.store import home

FONTS = Path.home() / ".cache" / "matplotlib"
ENTRY = "from tt_precise.cli import entry; entry()"
# linux/prctl.h, linux/capability.h
PR_CAPBSET_DROP, CAP_DAC_OVERRIDE = 24, 1
PROVED = ("upright", "rocking")  # done after some 2 and 4 s


def arguments(writer: str, folder: Path) -> list[str]:
    """A call of the command that writes into ``folder``."""
    golden = str(home() / "reference" / "trajectory.csv")
    return {
        "run": ["run", "reference", "--out", str(folder / "a.csv")],
        "check": ["check", golden, "--scene", "reference", "--plot", str(folder / "a.svg")],
        "golden build": ["golden", "build", "upright", "--folder", str(folder), "--workers", "2"],
        "golden certify": ["golden", "certify", *PROVED, "--folder", str(folder)],
        "sweep": [
            "sweep", "reference", "--vary", "omega_3=150:155:64", "--until", "1",
            "--workers", "2", "--out", str(folder / "sweep"),
        ],
        "sweep plot": [
            "sweep", "plot", str(folder / "rows.csv"), "--x", "a", "--y", "b",
            "--out", str(folder / "a.svg"),
        ],
        "tradeoff": ["tradeoff", "--quick", "--out", str(folder)],
        "extremes": ["extremes", "--quick", "--out", str(folder / "a.json")],
        "report": ["report", "--out", str(folder)],
    }[writer]  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What a command left: exit status (negative: the signal that killed it), stdout, stderr."""

    status: int
    out: str
    err: str

    @property
    def one_line(self) -> bool:
        """Whether it refused as it should: status 2, one line on stderr, nothing else."""
        # the last words of multiprocessing's own process, where a pool had to be left at once
        lines = [x for x in self.err.strip().splitlines() if "resource_tracker" not in x]
        return self.status == 2 and len(lines) == 1 and not self.out


class Commands:
    """The command line, here and in processes; ``cache`` stands for the user's cache folder."""

    def __init__(self, cache: Path):
        self._cache = cache
        self._started: list[subprocess.Popen[str]] = []

    def here(self, *argv: str) -> Answer:
        """The command in this process."""
        from tt_precise.cli import main

        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = main(list(argv))
        return Answer(status, out.getvalue(), err.getvalue())

    def start(
        self,
        argv: Sequence[str],
        *,
        before: Callable[[], Any] | None = None,
        stdout: Any = subprocess.PIPE,
    ) -> subprocess.Popen[str]:
        """The command in a process group of its own; ``before`` is called in it, first of all."""
        # Python does not notice when a full disk cuts off a compiled module, and every later
        # process would stumble over it
        own = {"XDG_CACHE_HOME": str(self._cache), "PYTHONDONTWRITEBYTECODE": "1"}
        process = subprocess.Popen(
            [sys.executable, "-c", ENTRY, *argv],
            env={**os.environ, **own},
            stdout=stdout,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            preexec_fn=before,
        )
        self._started.append(process)
        return process

    def outside(self, argv: Sequence[str], **options: Any) -> Answer:
        """The command in a process, to its end."""
        process = self.start(argv, **options)
        out, err = process.communicate(timeout=240)
        return Answer(process.returncode, out or "", err)

    def end(self) -> None:
        """Kill what a failed test has left running."""
        for process in self._started:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.communicate()


@pytest.fixture
def commands(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A ``Commands``; what it started and is still running after the test is killed."""
    cache = tmp_path_factory.mktemp("cache")
    if FONTS.is_dir():  # takes seconds to make; a copy, as who writes it may be killed
        shutil.copytree(FONTS, cache / "matplotlib")
    running = Commands(cache)
    yield running
    running.end()


def obey_permissions() -> None:
    """Let file permissions bind the superuser too, from the next program on."""
    # fails, without effect, for everybody else, whom they bind anyway
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)
