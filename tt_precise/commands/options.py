"""Options that commands share, and the output of a command."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

from tt_precise.runtime.values import Json, listed, require_name

F = TypeVar("F", bound=Callable[..., Any])

# The last line of a help text that speaks of digits.
DIGITS = "Digits are relative to the size of each quantity; `tt-precise columns` states the rule."


class _Written(click.Path):
    """A file that a command writes, refused before the work if it cannot be written."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        from tt_precise.runtime.files import require_writable

        path = super().convert(value, param, ctx)
        require_writable(str(path))
        return path


FILE = _Written(dir_okay=False, writable=True, path_type=Path)
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
PRECISION = click.option(
    "--precision",
    type=click.Choice(["double", "double-double", "quad", "triple-double", "mp"]),
    help="The arithmetic: 53 bits (the default), 64, 104, 113, 155 or 200.",
)


def _cores() -> int:
    from tt_precise.runtime.workers import cores

    return cores()


WORKERS = click.option(
    "--workers",
    type=click.IntRange(1),
    default=_cores,
    show_default="one for each core",
    help="Number of processes.",
)


def scene(**argument: Any) -> Callable[[F], F]:
    """Return a decorator that adds the argument SCENE and the option --until.

    The command receives the ``Scene`` with that horizon (None without a scene that may be absent).
    ``argument`` are settings of click's argument, such as ``default="reference"``.
    """

    def decorate(function: F) -> F:
        @click.argument("scene", **argument)
        @click.option("--until", help="Horizon in s, instead of the scene's.")
        @functools.wraps(function)
        def command(scene: str | None, until: str | None, **rest: Any) -> Any:
            from tt_precise.scene.scene import load_scene

            loaded = None if scene is None else load_scene(scene)
            if loaded is not None and until is not None:
                loaded = loaded.varied(until=until)
            return function(scene=loaded, **rest)

        return command  # type: ignore[return-value]

    return decorate


def several(names: Iterable[str], option: str, text: str) -> Callable[[F], F]:
    """Return an option that takes some of ``names``, separated by commas."""
    names = list(names)

    def chosen(_: click.Context, __: click.Parameter, value: str) -> tuple[str, ...]:
        for name in listed(value):
            require_name(option, name, names)
        return listed(value)

    help_text = f"{text}, separated by commas: {', '.join(names)}."
    return click.option(option, default="", callback=chosen, help=help_text)


def emit(as_json: bool, content: Json, lines: Iterable[str], out: str | Path | None = None) -> None:
    """Print ``content`` (a ``Record`` or plain values) as one JSON object, or the lines.

    With ``out`` the JSON object is written to that file too.
    """
    from tt_precise.runtime.terminal import say

    text = ""
    if as_json or out is not None:
        from tt_precise.runtime.records import encode

        text = encode(content)
    if out is not None:
        from tt_precise.runtime.files import atomic_write

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
        number = float(click.FLOAT.convert(value, param, ctx))
        if not (math.isfinite(number) and number > self._above):
            self.fail(f"got {value!r}, expected {self._expected}", param, ctx)
        return number


FINITE, POSITIVE = _Finite(), _Finite(above=0)
