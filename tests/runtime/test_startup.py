"""heyoka without SymPy, in processes of our own only."""

import os
import subprocess
import sys
from pathlib import Path

LOADED = "import sys; print('sympy' in sys.modules)"
HIDE = "from tt_precise.runtime.startup import hide_sympy_from_heyoka as hide; hide(); hide()"


def said(*lines: str) -> list[str]:
    """What a new interpreter prints that runs these lines."""
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)], capture_output=True, text=True, check=True
    )
    return done.stdout.split()


def test_heyoka_does_not_load_sympy_in_a_process_of_ours() -> None:
    integrated = "import tt_precise as tt; print(tt.integrate('upright').status)"
    assert said(HIDE, "import heyoka", LOADED, integrated) == ["False", "complete"]
    # the control: without the hook it does
    assert said("import heyoka", LOADED) == ["True"]


def test_sympy_is_there_for_everybody_else() -> None:
    use = "import sympy; print(sympy.sqrt(4))"
    assert said(HIDE, "import heyoka", use) == ["2"]
    proof = "from tt_precise.exact.jellett import *; print('proved')"
    assert said(HIDE, "import heyoka", proof, "import sympy") == ["proved"]


def test_sympy_that_is_loaded_already_stays() -> None:
    convert = "print(heyoka.from_sympy(sympy.Symbol('x')))"
    assert said("import sympy", HIDE, "import heyoka", convert) == ["x"]


def test_the_library_hides_nothing_from_its_users() -> None:
    convert = "import heyoka, sympy; print(heyoka.from_sympy(sympy.Symbol('x')))"
    assert said("import tt_precise as tt; tt.integrate('upright')", convert) == ["x"]


def test_linear_algebra_of_a_command_has_one_thread_unless_more_are_wanted() -> None:
    keep = (
        "from tt_precise.runtime.startup import keep_linear_algebra_to_one_thread as keep; keep()"
    )
    threads = "import numpy, os; print(len(os.listdir('/proc/self/task')))"
    unset = "import os; [os.environ.pop(f'{x}_NUM_THREADS', None) for x in ('OPENBLAS', 'OMP')]"
    assert said(unset, keep, threads) == ["1"]
    # the controls: without it there is one a core, and who asks for two has them
    cores = len(os.sched_getaffinity(0))
    assert said(unset, threads) == [str(cores)]
    two = "os.environ['OMP_NUM_THREADS'] = '2'"
    assert said(unset, two, keep, threads) == [str(min(2, cores))]


def test_commands_keep_what_they_compile_in_a_small_folder_of_their_own(tmp_path: Path) -> None:
    shown = "from heyoka import llvm_state as kept; print(kept.get_diskcache_path())"
    limit = "print(kept.get_diskcache_limit())"
    home = (
        "import os; os.environ.pop('HEYOKA_CACHE_DIR', None); "
        f"os.environ['XDG_CACHE_HOME'] = {str(tmp_path)!r}"
    )
    ours = "from tt_precise import cli; cli.main(['columns'])"
    run = "import tt_precise as tt; tt.integrate('upright')"
    own = said(home, ours, run, shown, limit)[-2:]
    assert own == [str(tmp_path / "tt-precise" / "compiled"), str(256 * 2**20)]
    assert (tmp_path / "tt-precise" / "compiled" / "cache.db").exists()
    # the library touches neither the place nor the limit
    assert said(home, run, shown, limit) == said(home, shown, limit)
    assert said(home, "os.environ['HEYOKA_CACHE_DIR'] = '/tmp'", ours, shown)[-1] == "/tmp"
