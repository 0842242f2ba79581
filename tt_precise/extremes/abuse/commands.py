"""Running the command line from a case: here, or in a process that is to be mistreated."""

from __future__ import annotations

import ctypes
import io
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FONTS = Path.home() / ".cache" / "matplotlib"
ENTRY = "from tt_precise.cli import entry; entry()"
# linux/prctl.h, linux/capability.h
PR_CAPBSET_DROP, CAP_DAC_OVERRIDE = 24, 1


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

    @property
    def told(self) -> str:
        """In words, for a table."""
        lines = self.err.strip().splitlines() or [""]
        return f"status {self.status}, {len(lines)} line(s): {lines[-1][-80:]}"


def here(*argv: str) -> Answer:
    """The command in this process; an exception is the caller's, and so the case's failure."""
    from tt_precise.cli import main

    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        status = main(list(argv))
    return Answer(status, out.getvalue(), err.getvalue())


def beginning(
    argv: Sequence[str],
    cache: Path,
    code: str = ENTRY,
    before: Callable[[], Any] | None = None,
    **options: Any,
) -> subprocess.Popen[str]:
    """The command in a process group of its own; ``cache`` keeps what the user's would get."""
    return subprocess.Popen(
        [sys.executable, "-c", code, *argv],
        # matplotlib's list of fonts is no matter of this package, and takes seconds to make
        env={"MPLCONFIGDIR": str(FONTS), **os.environ, "XDG_CACHE_HOME": str(cache)},
        stdout=options.pop("stdout", subprocess.PIPE),
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=before,
        **options,
    )


def outside(argv: Sequence[str], cache: Path, **options: Any) -> Answer:
    """The command in a process, to its end."""
    process = beginning(argv, cache, **options)
    out, err = process.communicate(timeout=240)
    return Answer(process.returncode, out or "", err)


def obey_permissions() -> None:
    """Let file permissions bind the superuser too, from the next program on."""
    # fails, without effect, for everybody else, whom they bind anyway
    ctypes.CDLL(None).prctl(PR_CAPBSET_DROP, CAP_DAC_OVERRIDE, 0, 0, 0)
