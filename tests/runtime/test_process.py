"""The process of a command: it starts fast, and Ctrl-C and SIGTERM end it tidily."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

RUN = "from tt_precise.cli import main; assert 0 == main(['run', 'reference', '--until', '0.01'])"
OURS = "process.in_a_process_of_ours()"
# which heyoka keeps on disk as it keeps equations
COMPILE = "h = process.import_heyoka(); x = h.expression('x'); h.cfunc([x], [x])"


def said(*lines: str) -> list[str]:
    """Return the words that a new interpreter prints that runs these lines."""
    code = "\n".join(("from tt_precise.runtime import process", *lines))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.split()


def test_heyoka_comes_without_sympy_in_a_process_of_ours() -> None:
    shown = "import sys; print('heyoka' in sys.modules, 'sympy' in sys.modules)"
    found = said(OURS, RUN, shown, "import sympy", shown)  # after what the command prints
    assert found[-4:] == ["True", "False", "True", "True"]
    assert said("process.import_heyoka()", shown) == ["True", "True"]


def test_linear_algebra_of_a_command_has_one_thread_unless_more_are_wanted() -> None:
    threads = "import numpy, os; print(len(os.listdir('/proc/self/task')))"
    unset = "import os; [os.environ.pop(f'{x}_NUM_THREADS', None) for x in ('OPENBLAS', 'OMP')]"
    assert said(unset, OURS, threads) == ["1"]
    # the controls: without it there is one a core, and who asks for two has them
    cores = len(os.sched_getaffinity(0))
    assert said(unset, threads) == [str(cores)]
    two = "os.environ['OMP_NUM_THREADS'] = '2'"
    assert said(unset, two, OURS, threads) == [str(min(2, cores))]


KEPT = """
class llvm_state:
    def set_diskcache_limit(size): {limit}
    def set_diskcache_enabled(enabled): print("enabled", enabled)
"""


@pytest.mark.parametrize(
    ("lines", "limit", "words"),
    [
        ((OURS,), "print(size)", [str(64 * 2**20), "{home}/tt-precise/compiled"]),
        ((OURS,), "raise RuntimeError", ["enabled", "False", "{home}/tt-precise/compiled"]),
        (("os.environ['HEYOKA_CACHE_DIR'] = '/tmp'", OURS), "print(size)", ["/tmp"]),
        ((), "print(size)", ["None"]),  # a library touches neither the place nor the limit
    ],
    ids=["ours", "full disk", "chosen", "library"],
)
def test_the_folder_of_compiled_code_has_a_place_and_a_limit(
    tmp_path: Path, lines: tuple[str, ...], limit: str, words: list[str]
) -> None:
    """A module in place of heyoka prints its settings."""
    (tmp_path / "heyoka.py").write_text(KEPT.format(limit=limit))
    home = f"os.environ['XDG_CACHE_HOME'] = {str(tmp_path)!r}"
    begin = ("import os", "os.environ.pop('HEYOKA_CACHE_DIR', None)", home)
    found = f"sys.path.insert(0, {str(tmp_path)!r})", "process.import_heyoka()"
    place = "print(os.environ.get('HEYOKA_CACHE_DIR'))"
    printed = said(*begin, *lines, "import sys", *found, place)
    assert printed == [word.format(home=tmp_path) for word in words]


@pytest.mark.evidence
def test_commands_keep_what_they_compile_in_a_small_folder_of_their_own(tmp_path: Path) -> None:
    shown = "from heyoka import llvm_state as kept; print(kept.get_diskcache_path())"
    limit = "print(kept.get_diskcache_limit())"
    home = "import os; os.environ.pop('HEYOKA_CACHE_DIR', None); os.environ['XDG_CACHE_HOME'] = "
    here, full = (f"{home}{str(place)!r}" for place in (tmp_path, tmp_path / "full"))
    folder = tmp_path / "tt-precise" / "compiled"
    assert said(here, OURS, COMPILE, shown, limit)[-2:] == [str(folder), str(64 * 2**20)]
    assert (folder / "cache.db").exists()
    # the library touches neither the place nor the limit
    assert said(here, COMPILE, shown, limit) == said(here, shown, limit)
    assert said("import os; os.environ['HEYOKA_CACHE_DIR'] = '/tmp'", OURS, shown)[-1] == "/tmp"
    # on a full disk nothing is kept, and everything goes on; setrlimit(2)
    small = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000))"
    enabled = "from heyoka import llvm_state as kept; print(kept.get_diskcache_enabled())"
    assert said(full, small, OURS, COMPILE, enabled)[-1] == "False"


HEEDED = """
import time
from tt_precise.runtime.process import Terminated, raising_signals
with raising_signals():
    try:
        {within}
        for _ in range(600):  # a signal just before a sleep is heeded after it
            time.sleep(0.05)
    except (KeyboardInterrupt, Terminated) as left:
        print(type(left).__name__, flush=True)
        {then}
time.sleep(30)
"""
SWALLOWS = """
import sys
try:
    print("here", flush=True)
    sys.stdin.readline()  # comes after the signal
except BaseException:
    print("swallowed", flush=True)
"""
KINDS = [(signal.SIGINT, "KeyboardInterrupt"), (signal.SIGTERM, "Terminated")]


def started(
    within: str, then: str = "raise SystemExit(7)", first: str = ""
) -> "subprocess.Popen[str]":
    code = first + HEEDED.format(within=within, then=then)
    process = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    assert process.stdout.readline() == "here\n"
    return process


def ended(process: "subprocess.Popen[str]") -> tuple[int, str, str]:
    out, err = process.communicate("go on\n", timeout=60)
    return process.returncode, out, err


@pytest.mark.parametrize(("signum", "name"), KINDS)
@pytest.mark.parametrize("within", ["import swallows", 'print("here", flush=True)'])
def test_a_signal_raises_and_in_an_import_waits_for_its_end(
    tmp_path: Path, within: str, signum: int, name: str
) -> None:
    (tmp_path / "swallows.py").write_text(SWALLOWS)
    process = started(f"import sys; sys.path.insert(0, {str(tmp_path)!r}); {within}")
    process.send_signal(signum)
    assert ended(process) == (7, f"{name}\n", "")


def test_outside_an_import_what_swallows_would_swallow() -> None:
    """The control: the module of the test before, not imported but run."""
    process = started(f"exec({SWALLOWS!r}); raise SystemExit(3)")
    process.send_signal(signal.SIGINT)
    assert ended(process) == (3, "swallowed\n", "")


START = """
import multiprocessing, os, signal
from multiprocessing import util
spawn = util.spawnv_passfds
def interrupted(*given):
    child = spawn(*given)
    {interrupt}
    return child
util.spawnv_passfds = interrupted
process = multiprocessing.get_context("spawn").Process(target=print, args=("served",))
print("here", flush=True)
try:
    process.start()
except BaseException:
    print("orders lost", flush=True)
    raise
"""
INTERRUPT = "os.kill(os.getpid(), signal.SIGINT)"


@pytest.mark.parametrize("interrupt", [INTERRUPT, "raise KeyboardInterrupt"])
def test_a_signal_in_the_start_of_a_worker_waits_for_its_end(interrupt: str) -> None:
    """Unlike an exception, after which the worker has no orders."""
    code = START.format(interrupt=interrupt).replace("\n", "\n        ")
    status, out, err = ended(started(code))
    assert status == 7
    if interrupt == INTERRUPT:
        assert err == ""
        # two processes write at once, each its word and then the end of its line
        words = sorted(re.findall("KeyboardInterrupt|served|\\S", out))
        assert words == ["KeyboardInterrupt", "served"]
    else:
        assert "orders lost" in out
        assert "served" not in out


def test_what_is_ignored_stays_ignored() -> None:
    code = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN)"
    within = 'print("here", flush=True); input(); raise SystemExit(5)'
    process = started(within, then="pass", first=code)
    process.send_signal(signal.SIGINT)
    assert ended(process) == (5, "", "")


def test_tidying_up_that_hangs_is_given_up() -> None:
    within = 'process.GRACE_S = 0.3; print("here", flush=True)'
    process = started(f"from tt_precise.runtime import process; {within}", then="time.sleep(600)")
    process.send_signal(signal.SIGINT)
    assert ended(process) == (128 + signal.SIGINT, "KeyboardInterrupt\n", "")
