"""Processes of ours start fast, and a user's process is left alone."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

RUN = "from tt_precise.cli import main; assert 0 == main(['run', 'reference', '--until', '0.01'])"
OURS = "from tt_precise.runtime import startup; startup.in_a_process_of_ours()"


def said(*lines: str) -> list[str]:
    """What a new interpreter prints that runs these lines."""
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def loaded(code: str, **environment: str) -> set[str]:
    """The modules that a process has loaded at its end."""
    ending = "print('\\n' + ' '.join(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}\n{ending}"],
        capture_output=True, text=True, check=True, env={**os.environ, **environment},
    )  # fmt: skip
    return set(run.stdout.splitlines()[-1].split())


@pytest.mark.parametrize(("before", "hidden"), [(OURS, True), ("", False)])
def test_heyoka_comes_without_sympy_in_a_process_of_ours(before: str, hidden: bool) -> None:
    modules = loaded(f"{before}\n{RUN}")
    assert "heyoka" in modules
    assert ("sympy" not in modules) == hidden


def test_sympy_is_there_afterwards() -> None:
    assert "sympy" in loaded(f"{OURS}\n{RUN}\nimport sympy")


def test_linear_algebra_of_a_command_has_one_thread_unless_more_are_wanted() -> None:
    threads = "import numpy, os; print(len(os.listdir('/proc/self/task')))"
    unset = "import os; [os.environ.pop(f'{x}_NUM_THREADS', None) for x in ('OPENBLAS', 'OMP')]"
    assert said(unset, OURS, threads) == ["1"]
    # the controls: without it there is one a core, and who asks for two has them
    cores = len(os.sched_getaffinity(0))
    assert said(unset, threads) == [str(cores)]
    two = "os.environ['OMP_NUM_THREADS'] = '2'"
    assert said(unset, two, OURS, threads) == [str(min(2, cores))]


def test_commands_keep_what_they_compile_in_a_small_folder_of_their_own(tmp_path: Path) -> None:
    shown = "from heyoka import llvm_state as kept; print(kept.get_diskcache_path())"
    limit = "print(kept.get_diskcache_limit())"
    home = (
        "import os; os.environ.pop('HEYOKA_CACHE_DIR', None); "
        f"os.environ['XDG_CACHE_HOME'] = {str(tmp_path)!r}"
    )
    ours = OURS
    run = "import tt_precise as tt; tt.integrate('upright')"
    own = said(home, ours, run, shown, limit)[-2:]
    assert own == [str(tmp_path / "tt-precise" / "compiled"), str(256 * 2**20)]
    assert (tmp_path / "tt-precise" / "compiled" / "cache.db").exists()
    # the library touches neither the place nor the limit
    assert said(home, run, shown, limit) == said(home, shown, limit)
    assert said(home, "os.environ['HEYOKA_CACHE_DIR'] = '/tmp'", ours, shown)[-1] == "/tmp"
