"""Options that commands share, and the output of a command."""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click

from tt_precise.runtime import files, plotting
from tt_precise.runtime.files import require_writable
from tt_precise.runtime.terminal import say
from tt_precise.runtime.values import InputError, Json, listed, require_name

F = TypeVar("F", bound=Callable[..., Any])

# The last line of a help text that speaks of digits.
DIGITS = "Digits are relative to the size of each quantity; `tt-precise columns` states the rule."


class Written(click.Path):
    """A file that a command writes, refused before the work if it cannot be written.

    ``require`` refuses another suffix.
    """

    def __init__(self, require: Callable[[Path], object] = lambda path: None):
        super().__init__(dir_okay=False, writable=True, path_type=Path)
        self._require = require

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        self._require(path)
        require_writable(path)
        return path


FILE, TABLE, PICTURE = Written(), Written(files.format_of), Written(plotting.require_format)
FOLDER = click.Path(file_okay=False, path_type=Path)
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
PRECISION = click.option(
    "--precision",
    type=click.Choice(["double", "double-double", "quad", "triple-double", "mp"]),
    help="The arithmetic: 53 bits (the default), 104, 113, 155 or 200.",
)


def _cores() -> int:
    from tt_precise.runtime.workers import cores

    return cores()


WORKERS = click.option(
    "--workers", type=click.IntRange(1), default=_cores, show_default="one for each core",
    help="Number of processes.",
)  # fmt: skip


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
            if until is not None:
                if loaded is None:
                    raise InputError(f"--until: got no SCENE, expected one that ends at {until}")
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


def columns(_: click.Context, __: click.Parameter, value: str) -> tuple[str, ...]:
    """Return the columns in the text of an option, without t: quantities, poses, errors, drifts.

    Raises ``InputError``: a name is neither a column nor an error or a drift of one.
    """
    from tt_precise.integration.columns import POSE_COLUMNS
    from tt_precise.mechanics.conserved import INTEGRALS
    from tt_precise.mechanics.formulations import STATE_DIMENSIONS
    from tt_precise.mechanics.quantities import QUANTITIES

    columns = [*STATE_DIMENSIONS, *QUANTITIES, *POSE_COLUMNS, "digits"]
    names = tuple(name for name in listed(value) if name != "t")
    for name in names:
        plain = name.removeprefix("error:").removeprefix("drift:")
        drifts = INTEGRALS if name.startswith("drift:") else ()
        require_name("--columns", plain, [*columns, *drifts])
    return names


def emit(as_json: bool, content: Json, lines: Iterable[str], out: str | Path | None = None) -> None:
    """Print ``content`` (a ``Record`` or plain values) as one JSON object, or the lines.

    With ``out`` the JSON object is written to that file too.
    """
    from tt_precise.runtime.files import atomic_write
    from tt_precise.runtime.records import encode

    if out is not None:
        atomic_write(out, encode(content))
    if as_json:
        click.echo(encode(content), nl=False)
    else:
        say(lines)


def _above(least: float) -> Callable[[str], float]:
    """Return the type of finite numbers above a limit."""

    def number(text: Any) -> float:
        value = float(click.FLOAT.convert(text, None, None))
        if not (math.isfinite(value) and value > least):
            raise click.BadParameter(f"got {text!r}, expected a finite number above {least:g}")
        return value

    return number


FINITE, POSITIVE = _above(-math.inf), _above(0)
