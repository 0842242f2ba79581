r"""Output to the terminal, without escape sequences from files, headers or titles.

Escape sequences could move the cursor or hide lines. ``sanitized`` filters everything that a
command prints and writes such characters as \u001b, except what rich draws: progress bars and
coloured tables.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from rich.console import Console

# control characters but tab and newline; line separators; bytes of file names that are not UTF-8
HIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff]")


def visible(text: str) -> str:
    r"""The text with control characters as \uXXXX, which JSON reads back."""
    return HIDDEN.sub(_escaped, text)


def one_line(text: str) -> str:
    r"""``visible`` text of one line: with newlines as \n, so that it cannot forge another line."""
    return visible(text).replace("\n", "\\n")


def say(lines: Iterable[str]) -> None:
    """Print lines on stdout; each stays a single line."""
    import click  # here, because code outside commands imports progress

    for line in lines:
        click.echo(one_line(line))


def console(*, stderr: bool = False) -> Console:
    """A console of rich's, which draws with escape sequences of its own."""
    from rich.console import Console

    stream = sys.stderr if stderr else sys.stdout
    return Console(file=stream.plain if isinstance(stream, _Sanitizing) else stream)


@contextmanager
def sanitized() -> Iterator[None]:
    """A context in which output to stdout and stderr is ``visible``."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (_Sanitizing(stream) for stream in before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def open_closed_streams() -> None:
    """Open /dev/null for a standard stream that the parent has closed."""
    while (free := os.open(os.devnull, os.O_RDWR)) <= 2:
        pass  # the lowest number that is free, so this one is a standard stream now
    os.close(free)
    for name, number in (("stdin", 0), ("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w" if number else "r", encoding="utf-8"))


class _Sanitizing:
    def __init__(self, plain: TextIO):
        self.plain = plain
        self.encoding, self.errors = plain.encoding, plain.errors

    def write(self, text: str) -> int:
        if not isinstance(text, str):
            raise TypeError(f"got {type(text).__name__}, expected str")
        shown = visible(text)
        encoding = self.encoding or "utf-8"
        self.plain.write(shown.encode(encoding, "backslashreplace").decode(encoding))
        return len(text)

    def flush(self) -> None:
        self.plain.flush()

    def isatty(self) -> bool:
        return self.plain.isatty()

    def fileno(self) -> int:
        return self.plain.fileno()


def _escaped(match: re.Match[str]) -> str:
    return f"\\u{ord(match[0]):04x}"


# ---- progress -----------------------------------------------------------------------------

Progress = Callable[[float], None]


def silent(fraction: float) -> None:
    """No progress display: the default everywhere."""


@contextmanager
def progress_bar(label: str) -> Iterator[Progress]:
    """A progress bar if stderr is a terminal, removed when done; else ``silent``."""
    if not sys.stderr.isatty():
        yield silent
        return
    from rich.markup import escape
    from rich.progress import Progress as Bars

    with Bars(console=console(stderr=True), transient=True) as bars:
        task = bars.add_task(escape(one_line(label)), total=1.0)
        yield lambda fraction: bars.update(task, completed=fraction)
