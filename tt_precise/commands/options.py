"""Options shared by several commands, and parameter types."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

from tt_precise.runtime.values import Json, listed

F = TypeVar("F", bound=Callable[..., Any])

# The last line of a help text that speaks of digits.
DIGITS = "Digits are relative to the size of each quantity; `tt-precise columns` states the rule."
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
PRECISION = click.option(
    "--precision",
    type=click.Choice(["double", "extended", "double-double", "quad", "triple-double", "mp"]),
    help="The arithmetic: 53 bits (the default), 64, 104, 113, 155 or 200.",
)


class Several(click.Choice):
    """Some of several names, separated by commas; with ``several``, of all values of an option."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        return tuple(super(Several, self).convert(name, param, ctx) for name in listed(value))


def several(names: Iterable[str], option: str, text: str) -> Callable[[F], F]:
    """Return an option that takes some of ``names``, separated by commas or repeated."""
    return click.option(
        option,
        multiple=True,
        type=Several(list(names)),
        callback=lambda _, __, given: tuple(itertools.chain.from_iterable(given)),
        help=f"{text}; separated by commas, or repeated.",
    )


class Group(click.Group):
    """A group of commands that refuse an option given twice, of which click drops the first."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the name, the command and its arguments."""
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None and not isinstance(command, click.Group):
            _refuse_repeats(command, ctx, rest)
        return name, command, rest


def _refuse_repeats(command: click.Command, ctx: click.Context, args: list[str]) -> None:
    settings: dict[str, Any] = {"parent": ctx, "info_name": command.name}
    tried = click.Context(command, **settings, **command.context_settings)
    try:
        _, _, order = command.make_parser(tried).parse_args(list(args))
    except click.UsageError as error:
        error.ctx = tried  # whose help says what an option expects
        raise
    counts = Counter(p for p in order if isinstance(p, click.Option) and not p.is_flag)
    for option, count in counts.items():
        if count > 1 and not option.multiple:
            raise click.UsageError(
                f"{option.opts[-1]}: got it {count} times, expected it once; give all of it in one"
            )


def emit(as_json: bool, content: Json, lines: Iterable[str], out: str | Path | None = None) -> None:
    """Print ``content`` (a ``Record`` or plain values) as one JSON object, or the lines.

    With ``out`` the JSON object is written to that file too.
    """
    from tt_precise.runtime.files import atomic_write
    from tt_precise.runtime.terminal import say

    text = ""
    if as_json or out is not None:
        from tt_precise.runtime.records import encode

        text = encode(content)
    if out is not None:
        atomic_write(out, text)
    if as_json:
        click.echo(text, nl=False)
    else:
        say(lines)


class _Finite(click.ParamType):
    """A finite float above a limit."""

    name = "number"

    def __init__(self, above: float = -math.inf):
        self._above = above
        self._expected = "a finite number" + (f" above {above:g}" if above > -math.inf else "")

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        try:
            number = float(value)
        except (TypeError, ValueError):
            number = math.nan
        if not math.isfinite(number) or number <= self._above:
            self.fail(f"got {str(value)[:60]!r}, expected {self._expected}", param, ctx)
        return number


FINITE, POSITIVE = _Finite(), _Finite(above=0)


def workers(default: str) -> Callable[[F], F]:
    """Return the option ``--workers``; ``default`` describes the number without it."""
    from tt_precise.runtime.workers import most_workers

    kind = click.IntRange(1, most_workers())

    def decorate(function: F) -> F:
        return click.option("--workers", type=kind, help=f"Number of processes; {default}.")(
            function
        )

    return decorate
