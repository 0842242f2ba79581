"""JSON that somebody may have edited or torn: an object, or one line of what is wrong."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.toml import shown
from tt_precise.runtime.untyped import Json

Found = TypeVar("Found")
# what taking a file's content apart may raise when it is not what was written
MISSHAPEN = (ValueError, KeyError, IndexError, TypeError, AttributeError)


def parse(content: str | bytes) -> Json:
    """The value that JSON stands for, as Python's own reader has it.

    Raises
    ------
    ValueError
        It is no JSON, or nested deeper than anybody writes.
    """
    try:
        return json.loads(content)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def parse_strictly(content: bytes) -> Json:
    """``parse``, where a key that stands twice, or NaN, is no JSON.

    Raises
    ------
    ValueError
        As ``parse``; or it is no UTF-8.
    """
    try:
        text = content.decode("utf-8")
        return json.loads(text, object_pairs_hook=_object, parse_constant=_no_number)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def read(path: Path, what: str) -> dict[str, Json]:
    """The JSON object in a file; ``what`` it should have been.

    Raises
    ------
    InputError
        It cannot be read, or holds no object.
    """
    try:
        content = parse_strictly(path.read_bytes())
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or f"no JSON: {error}"
        raise InputError(f"{shown(path)}: {reason}; expected {what}") from None
    if not isinstance(content, dict):
        raise InputError(f"{shown(path)}: got no JSON object, expected {what}")
    return content


def read_as(path: Path, what: str, take: Callable[[dict[str, Json]], Found]) -> Found:
    """What ``take`` makes of the object in a file.

    Raises
    ------
    InputError
        The file cannot be read, or lacks what ``take`` looks for.
    """
    content = read(path, what)
    with of_its_form(path, what):
        return take(content)


@contextmanager
def of_its_form(path: Path, what: str) -> Iterator[None]:
    """What goes wrong in reading a file is the file's fault, if it exists: an ``InputError``."""
    try:
        yield
    except InputError:
        raise
    except MISSHAPEN as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError(f"{shown(path)}: not of its form ({reason}); expected {what}") from None


def _object(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    found = dict(pairs)
    if len(found) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice")
    return found


def _no_number(name: str) -> Json:
    raise ValueError(f"{name} is no number")
