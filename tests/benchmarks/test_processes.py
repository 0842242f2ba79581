"""Commands are measured as a shell starts them."""

import os
import subprocess

import pytest

from benchmarks import processes
from tt_precise.runtime.startup import THREADS, keep_linear_algebra_to_one_thread

LOOK = f"import os, sys; sys.exit({THREADS!r} in os.environ)"


def test_the_yardstick_has_the_threads_that_a_shell_gives_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bench, a command itself, has one for its own children."""
    for name in (THREADS, "OMP_NUM_THREADS"):
        monkeypatch.setenv(name, "0")
        monkeypatch.delenv(name)
    keep_linear_algebra_to_one_thread()
    assert os.environ[THREADS] == "1"
    processes._call(LOOK)
    with pytest.raises(subprocess.CalledProcessError):
        processes._call(LOOK, **{THREADS: "1"})
