"""Progress: a function that gets the fraction done; silent unless stderr is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tt_precise.runtime.terminal import console, one_line

Progress = Callable[[float], None]


def silent(fraction: float) -> None:
    """Progress that nobody sees: the default everywhere."""


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """A progress bar on stderr while it is a terminal, gone when done; else ``silent``."""
    if not sys.stderr.isatty():
        yield silent
        return
    from rich.markup import escape
    from rich.progress import Progress as Bars

    with Bars(console=console(stderr=True), transient=True) as bars:
        task = bars.add_task(escape(one_line(label)), total=1.0)
        yield lambda fraction: bars.update(task, completed=fraction)
