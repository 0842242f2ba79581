"""The process of a command or a worker: a fast start, a tidy end, lines and progress bars.

The settings of a process that uses the package as a library are not changed. heyoka, pandas, SymPy
and matplotlib take a second to import, so neither ``import tt_precise`` nor code that only reads
files imports them.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

# Bytes of heyoka's compiled equations in the cache folder, which drops the least recently used.
COMPILED_BYTES = 64 * 2**20
_lock = threading.Lock()
_ours = False


class Terminated(BaseException):
    """Raised at SIGTERM, as KeyboardInterrupt at SIGINT."""


def in_a_process_of_ours() -> None:
    """Set up the process of a command or a worker, before anything heavy is imported.

    NumPy's OpenBLAS starts no threads, unless the caller wants some: no matrix here is large enough
    for two, and starting them takes a seventh of the processor time of ``import numpy``. heyoka
    keeps compiled equations in the package's cache folder, unless another one is set. Pictures are
    drawn into files, whatever backend a notebook has set for its children.
    """
    global _ours
    _ours = True
    os.environ["MPLBACKEND"] = "agg"
    if "OMP_NUM_THREADS" not in os.environ:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with contextlib.suppress(RuntimeError):
        os.environ.setdefault("HEYOKA_CACHE_DIR", str(user_folder() / "compiled"))


def import_heyoka() -> ModuleType:
    """Import heyoka; in a command or worker without SymPy, and with a bound on its disk cache.

    SymPy takes half of heyoka's start and is only needed to convert expressions, which nothing here
    does.
    """
    with _lock:
        first = _ours and "heyoka" not in sys.modules
        if hidden := first and "sympy" not in sys.modules:
            sys.modules["sympy"] = None  # type: ignore[assignment] # how Python marks what is absent
        try:
            import heyoka
        finally:
            if hidden:
                del sys.modules["sympy"]
        heyoka.set_logger_level_critical()  # statuses and unresolved events say what it would log
        if first and os.environ.get("HEYOKA_CACHE_DIR", "").endswith("tt-precise/compiled"):
            try:
                heyoka.llvm_state.set_diskcache_limit(COMPILED_BYTES)
            except RuntimeError:  # a full disk, or a broken file: continue without the cache
                heyoka.llvm_state.set_diskcache_enabled(False)
    return heyoka


def user_folder() -> Path:
    """Return the user's cache folder for this package, which may not exist yet.

    Raises ``RuntimeError``: the user has no home folder.
    """
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tt-precise"


def raise_at_sigterm() -> None:
    """Make SIGTERM raise ``Terminated``, so that files and worker processes are tidied up."""

    def leave(*_: object) -> None:
        raise Terminated

    signal.signal(signal.SIGTERM, leave)


# control characters but tab; line separators; bytes of file names that are not UTF-8
HIDDEN = re.compile("[\x00-\x08\x0a-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


def one_line(text: str) -> str:
    r"""The text with control characters as \uXXXX and newlines as \n, so that no line is forged."""
    return HIDDEN.sub(lambda found: f"\\u{ord(found[0]):04x}", text.replace("\n", "\\n"))


def say(lines: Iterable[str]) -> None:
    """Print lines on stdout; each stays a single line."""
    import click  # here, because code outside commands imports progress

    for line in lines:
        click.echo(one_line(line))


Progress = Callable[[float], None]


def silent(fraction: float) -> None:
    """No progress display: the default everywhere."""


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """A progress bar on a terminal, percents in a notebook, removed when done; else ``silent``."""
    if "ipykernel" in sys.modules:  # where rich would need ipywidgets
        yield lambda fraction: print(f"\r{label}: {fraction:.0%}", end="", file=sys.stderr)
        print("\r" + " " * (len(label) + 6), end="\r", file=sys.stderr)
        return
    if not sys.stderr.isatty() or multiprocessing.parent_process():
        yield silent
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress as Bars

    with Bars(console=Console(stderr=True), transient=True) as bars:
        task = bars.add_task(escape(one_line(label)), total=1.0)
        yield lambda fraction: bars.update(task, completed=fraction)
