"""TOML from users, read within bounds of size and time."""

from __future__ import annotations

import tomllib
from pathlib import Path

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json

LARGEST_FILE = 100_000  # bytes; a scene is a page of text
# tomllib's time grows with the square of the parts of a dotted key, which stands in one line:
# 0.1 s for so many, 8 s for ten times as many
MOST_DOTS = 2_000


def read_text(path: Path, what: str) -> str:
    """The text of a TOML file, without a byte order mark; errors say that ``what`` is expected.

    Raises
    ------
    InputError
        It cannot be read, is too large, or no UTF-8.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)  # bounded: the path may be /dev/zero
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{shown(path)}: {reason}; expected {what}") from None
    if len(content) > LARGEST_FILE:
        raise InputError(f"{shown(path)}: larger than {LARGEST_FILE} bytes, expected {what}")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise InputError(f"{shown(path)}: not UTF-8 text, expected {what}") from None


def parse(text: str) -> dict[str, Json]:
    """The table in ``text``, with floats as the strings that stand there.

    Raises
    ------
    InputError
        It is not TOML, or exceeds the bounds.
    """
    if any(line.count(".") > MOST_DOTS for line in text.splitlines()):
        raise InputError(f"not a TOML file: more than {MOST_DOTS} dots in a line")
    try:
        return tomllib.loads(text, parse_float=str)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"not a TOML file: {error}") from None
    except ValueError:  # an integer of more digits than Python reads
        raise InputError("not a TOML file: an integer of thousands of digits") from None


def shown(path: Path) -> str:
    """The path for an error: printable, and its end if it is long."""
    text = str(path)
    text = text if text.isprintable() else repr(text)
    return text if len(text) <= 300 else f"...{text[-297:]}"
