"""Cached results: files in ``reports/`` of the checkout or the user's cache.

Each is valid while the inputs that it records are unchanged. An unreadable one counts as absent.
"""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import io
import json
import re
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.terminal import user_folder
from tt_precise.runtime.values import InputError, Json

if TYPE_CHECKING:
    import pandas

# the code behind a trajectory's numbers; tests/test_structure.py compares it with the imports
SOURCES = (
    "runtime/values.py", "runtime/mpfr.py", "runtime/files.py",
    "scene", "mechanics", "taylor", "integration", "nonsmooth",
)  # fmt: skip
PACKAGE = Path(__file__).parents[1]
OWN_IMPORTS = re.compile(r"(?m)^ *from tt_precise\S* import (?:\(([^)]*)\)|(.*))\n")
DIGITS = 12  # significant, in a cached table


def fingerprint(definition: Json) -> str:
    """SHA-256 of a definition in plain JSON values."""
    return hashlib.sha256(json.dumps(definition, sort_keys=True).encode("utf-8")).hexdigest()


def source_hash(*paths: str) -> str:
    """SHA-256 of source files, given as files and folders relative to this package.

    A path that does not exist has no content. Of the package's own imports only the names count.
    """
    digest = hashlib.sha256()
    for source in paths:
        path = PACKAGE / source
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path] * path.exists():
            text = file.read_text("utf-8")
            names = {*re.findall(r"\w+", " ".join(map("".join, OWN_IMPORTS.findall(text))))}
            digest.update("\n".join([OWN_IMPORTS.sub("", text), *sorted(names)]).encode())
    return digest.hexdigest()


def code_of(*sources: str) -> dict[str, str]:
    """Return the hash of ``SOURCES`` and of further ``sources``, for a record of evidence."""
    return {path: source_hash(path) for path in (*SOURCES, *sources)}


def changed(code: Mapping[str, str]) -> tuple[str, ...]:
    """Return the sources that have changed since ``code_of`` hashed them."""
    # a program outside the package ("../benchmarks") need not be installed
    there = [path for path in code if (PACKAGE / path).exists() or not path.startswith("..")]
    return tuple(path for path in there if source_hash(path) != code[path])


def cached_table(
    file: str, definition: Mapping[str, Json], compute: Callable[[], pandas.DataFrame]
) -> pandas.DataFrame:
    """The table in ``file`` if it has this ``definition``, otherwise from ``compute``.

    It is searched in ``reports/`` of the checkout, then in the user's cache.
    """
    mark = fingerprint(definition)
    for folder in _folders():
        with contextlib.suppress(OSError, EOFError, zlib.error, ValueError):
            return unpacked((folder / file).read_bytes(), mark)
    content = packed(compute(), mark)
    for folder in _folders():
        with contextlib.suppress(InputError):  # read-only or full
            atomic_write(folder / file, content)
            break
    return unpacked(content, mark)  # from the bytes, so that every reader gets the same digits


def packed(table: pandas.DataFrame, mark: str) -> bytes:
    """The file of a table; the same table gives the same bytes."""
    text = table.to_csv(index=False, float_format=f"%.{DIGITS}g", lineterminator="\n")
    return gzip.compress(f"# {mark}\n{text}".encode(), mtime=0)


def unpacked(content: bytes, mark: str) -> pandas.DataFrame:
    """The table of a file; a ``ValueError`` for another definition."""
    import pandas

    text = gzip.decompress(content).decode("utf-8")
    if not text.startswith(f"# {mark}\n"):
        raise ValueError("another definition")
    return pandas.read_csv(io.StringIO(text), comment="#")


def _folders() -> list[Path]:
    checkout = PACKAGE.parent
    folders = [checkout / "reports/measured"] if (checkout / "pyproject.toml").is_file() else []
    with contextlib.suppress(RuntimeError):
        folders.append(user_folder())
    return folders
