"""Progress: a function that gets the fraction done; silent unless stderr is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tt_precise.terminal import console, one_line

Progress = Callable[[float], None]
Announce = Callable[[str], None]  # called with what is being done now


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


@contextmanager
def progress_bars(label: str, steps: int) -> Iterator[tuple[Progress, Announce]]:
    """A progress bar, and another one that names the step at work, out of so many ``steps``."""
    if not sys.stderr.isatty():
        yield silent, lambda _: None
        return
    from rich.markup import escape
    from rich.progress import Progress as Bars

    with Bars(console=console(stderr=True), transient=True) as bars:
        named = bars.add_task("", total=float(steps))
        task = bars.add_task(escape(one_line(label)), total=1.0)
        begun = 0

        def announce(step: str) -> None:
            nonlocal begun
            bars.update(named, description=escape(one_line(step)), completed=begun)
            begun += 1

        yield (lambda fraction: bars.update(task, completed=fraction)), announce
