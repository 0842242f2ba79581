"""Output to the terminal: lines and progress bars."""

from __future__ import annotations

import multiprocessing
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

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
