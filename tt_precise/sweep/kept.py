"""Tables of sweeps that are kept in small files, so that claims and report need not sweep again.

A file names the definition that it was made from, and counts only while that is the present one.
It is looked for in ``reports/`` of the checkout, then in the user's cache.
"""

from __future__ import annotations

import fcntl
import gzip
import hashlib
import io
import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tt_precise.files import atomic_write

if TYPE_CHECKING:
    import pandas

DIGITS = 12  # significant, in the file


def kept(
    file: str, definition: Mapping[str, Any], compute: Callable[[], pandas.DataFrame]
) -> pandas.DataFrame:
    """The table in ``file``, or from ``compute`` if there is none of this ``definition``.

    Several processes that ask for the same at once compute it once.
    """
    mark = fingerprint(definition)
    found = _found(file, mark)
    if found is not None:
        return found
    with _alone(file):
        found = _found(file, mark)  # somebody else may have made it meanwhile
        if found is not None:
            return found
        content = packed(compute(), mark)
        for folder in _folders():
            if folder.is_dir() and os.access(folder, os.W_OK):
                atomic_write(folder / file, content)
                break
    # from the bytes, so that nobody sees other digits than the next one who reads the file
    table = unpacked(content, mark)
    assert table is not None
    return table


def fingerprint(definition: Mapping[str, Any]) -> str:
    """SHA-256 of a definition in plain JSON values."""
    return hashlib.sha256(json.dumps(definition, sort_keys=True).encode("utf-8")).hexdigest()


def packed(table: pandas.DataFrame, mark: str) -> bytes:
    """The file of a table; the same table gives the same bytes."""
    text = table.to_csv(index=False, float_format=f"%.{DIGITS}g", lineterminator="\n")
    sink = io.BytesIO()
    # no time and no name in the header, which would change with every run
    with gzip.GzipFile(filename="", mode="wb", fileobj=sink, mtime=0) as file:
        file.write(f"# {mark}\n{text}".encode())
    return sink.getvalue()


def unpacked(content: bytes, mark: str) -> pandas.DataFrame | None:
    """The table of a file, unless it was made from another definition."""
    import pandas

    text = gzip.decompress(content).decode("utf-8")
    if not text.startswith(f"# {mark}\n"):
        return None
    return pandas.read_csv(io.StringIO(text), comment="#")


def _found(file: str, mark: str) -> pandas.DataFrame | None:
    for folder in _folders():
        if (folder / file).is_file():
            table = unpacked((folder / file).read_bytes(), mark)
            if table is not None:
                return table
    return None


def _folders() -> tuple[Path, ...]:
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    checkout = Path(__file__).parents[2]
    known = [checkout / "reports"] if (checkout / "pyproject.toml").is_file() else []
    return (*known, home / "tt-precise")


@contextmanager
def _alone(file: str) -> Iterator[None]:
    folder = _folders()[-1]
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"{file}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
