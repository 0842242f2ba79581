"""Files: written atomically; TOML and JSON, read within bounds."""

from __future__ import annotations

import fcntl
import json
import os
import stat
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from tt_precise.runtime.values import InputError, Json

A_PAGE = 4096  # bytes: the room that the smallest file needs


class _GivenUpError(Exception):
    """Leaves the old file."""


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Give a temporary path next to ``path``; without an error it replaces ``path`` at the end.

    A link stays a link: its target is replaced. An old file keeps its permissions. A device or a
    pipe, such as /dev/stdout, is not replaced but written to, from a temporary file elsewhere.

    Raises ``InputError``: the place cannot be written, or is full; or it is a dash, which means a
    stream elsewhere.
    """
    import tempfile  # here, as much imports this that does not write

    target = Path(path)
    if str(target) == "-":
        raise InputError("-: got a dash, expected a file to write; /dev/stdout is standard output")
    try:
        device = _is_device(target)
        if not device:
            target = Path(os.path.realpath(target))
            target.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(
            # a name may be as long as the file system allows, which leaves no room for a prefix
            prefix=f".{target.stem[:40]}.",
            suffix=target.suffix,
            dir=None if device else target.parent,
        )
    except OSError as error:
        raise _unwritable(target, error) from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        if device:
            import shutil

            with temporary.open("rb") as source, target.open("wb") as sink:
                shutil.copyfileobj(source, sink)
            return
        with temporary.open("rb") as written:
            os.fsync(written.fileno())
        temporary.chmod(_mode_for(target))
        temporary.replace(target)
    except OSError as error:
        raise _unwritable(target, error) from error
    finally:
        temporary.unlink(missing_ok=True)


def require_apart(outputs: Mapping[str, str | Path | None], *inputs: str) -> None:
    """Refuse to overwrite an input, or to write two outputs to one file; ``outputs`` by option.

    Raises ``InputError``: an output is one of the files ``inputs``, or is named twice.
    """
    # a bare word is the name of a scene that ships
    taken = {
        os.path.realpath(given): "which is read"
        for given in inputs
        if os.sep in given or "." in given
    }
    for option, path in outputs.items():
        if path is None or _is_device(Path(path)):
            continue
        place = os.path.realpath(path)
        if place in taken:
            raise InputError(f"{option}: got {path}, {taken[place]}; expected another file")
        taken[place] = f"which is {option} too"


def shipped(name: str) -> Path:
    """The shipped data folder ``name``: inside an installed package, next to it in a checkout."""
    package = Path(__file__).resolve().parents[1]
    installed = package / name
    return installed if installed.is_dir() else package.parent / name


def atomic_write(path: str | Path, content: str | bytes) -> None:
    """Write ``content`` (text as UTF-8) to ``path`` completely or not at all."""
    write_together({path: content})


def write_together(files: Mapping[str | Path, str | bytes]) -> None:
    """Write several files, each completely, and none unless there is room for all."""
    with ExitStack() as stack:
        for path, content in files.items():
            data = content.encode("utf-8") if isinstance(content, str) else content
            stack.enter_context(replacing(path)).write_bytes(data)


def require_writable(path: str | Path) -> None:
    """Refuse a file that cannot be written, or whose disk is full, before long work.

    Raises ``InputError``: it cannot be written.
    """
    with suppress(_GivenUpError), replacing(path) as temporary:
        temporary.write_bytes(bytes(A_PAGE))
        raise _GivenUpError


@contextmanager
def locked(folder: Path, work: str) -> Iterator[None]:
    """Lock ``folder`` against other processes with the same ``work``, until this process ends.

    Raises ``InputError``: another process works in the folder, or the folder cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise _unwritable(folder, error) from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{folder}: another {work} is running there; expected no other"
            ) from None
        yield
    finally:
        os.close(handle)


def _is_device(path: Path) -> bool:
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _mode_for(target: Path) -> int:
    """The permissions of the file that is replaced, or those of a new file."""
    with suppress(OSError):
        return stat.S_IMODE(target.stat().st_mode)
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def _unwritable(target: Path, error: OSError) -> InputError:
    return InputError(f"{target}: {error.strerror or error}; expected a place that can be written")


# ---- TOML from users -----------------------------------------------------------------------

# Bytes; a scene is a page of text. tomllib takes a second for a single key of so many parts.
LARGEST_FILE = 30_000


def read_toml(path: Path, what: str) -> str:
    """The text of a TOML file, without a byte order mark; errors say that ``what`` is expected.

    Raises ``InputError``: it cannot be read, is too large, or is not UTF-8.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)  # bounded: the path may be /dev/zero
    except OSError as error:
        raise InputError(f"{printable(path)}: {error.strerror}; expected {what}") from None
    if len(content) > LARGEST_FILE:
        raise InputError(f"{printable(path)}: larger than {LARGEST_FILE} bytes, expected {what}")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise InputError(f"{printable(path)}: not UTF-8 text, expected {what}") from None


def parse_toml(text: str) -> dict[str, Json]:
    """The table in ``text``, with floats as their written strings.

    Raises ``InputError``: it is not TOML, nested too deeply, or has a huge integer.
    """
    try:
        return tomllib.loads(text, parse_float=str)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"not a TOML file: {error}") from None
    except ValueError:  # an integer of more digits than Python reads
        raise InputError("not a TOML file: an integer of thousands of digits") from None


def printable(path: Path) -> str:
    """Return the path as printable text; the end of a long one."""
    text = str(path)
    text = text if text.isprintable() else repr(text)
    return text if len(text) <= 300 else f"...{text[-297:]}"


# ---- JSON ----------------------------------------------------------------------------------

# errors when a file's content has an unexpected form
MISSHAPEN = (ValueError, KeyError, IndexError, TypeError, AttributeError)


def parse_json(content: str | bytes, **hooks: Any) -> Json:
    """The value of a JSON text, by Python's reader with its ``hooks``.

    Raises ``ValueError``: it is not JSON, or nested too deeply.
    """
    try:
        return json.loads(content, **hooks)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def read_json(path: Path, what: str) -> dict[str, Json]:
    """The JSON object in a file, without repeated keys and NaN.

    Errors say that ``what`` is expected.

    Raises ``InputError``: it cannot be read, or does not hold such an object.
    """
    try:
        content = parse_json(
            path.read_bytes().decode("utf-8"), object_pairs_hook=_object, parse_constant=_no_number
        )
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or f"no JSON: {error}"
        raise InputError(f"{printable(path)}: {reason}; expected {what}") from None
    if not isinstance(content, dict):
        raise InputError(f"{printable(path)}: got no JSON object, expected {what}")
    return content


@contextmanager
def of_its_form(path: Path, what: str) -> Iterator[None]:
    """Turn errors about a file's content into an ``InputError``."""
    try:
        yield
    except InputError:
        raise
    except MISSHAPEN as error:
        reason = f"{type(error).__name__}: {error}"
        raise InputError(
            f"{printable(path)}: not of its form ({reason}); expected {what}"
        ) from None


def _object(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
    content = dict(pairs)
    if len(content) != len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice")
    return content


def _no_number(name: str) -> Json:
    raise ValueError(f"{name} is no number")
