"""Where the files of a sweep lie: a folder of this machine, or any URL that fsspec knows.

A URL may be a shared folder (``file:///shared/sweep``) or an object store (``s3://bucket/sweep``,
with the package s3fs): every worker that can reach it writes its own chunks there.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import atomic_write


class Place(Protocol):
    """Files by name, each a few letters with / between folders."""

    def read(self, name: str) -> bytes | None:
        """The content of a file; None if there is none."""

    def write(self, name: str, content: bytes) -> None:
        """Write a file; whoever reads it while it is written may see a part of it."""

    def append(self, name: str, text: str) -> None:
        """Add lines to a log, which is on disk when this returns."""

    def log(self, name: str) -> str:
        """All lines of a log."""

    def names(self) -> set[str]:
        """The files and folders directly in it."""

    def remove(self, name: str) -> None:
        """Remove a file, or a folder with all that is in it; it need not be there."""


def place_of(where: str | Path) -> Folder | Url:
    """The place of a path or a URL."""
    return Url(str(where)) if "://" in str(where) else Folder(Path(where))


@dataclass(frozen=True)
class Folder:
    """A folder of this machine. Files are replaced as a whole."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def read(self, name: str) -> bytes | None:
        try:
            return (self.path / name).read_bytes()
        except (FileNotFoundError, NotADirectoryError):
            return None

    def write(self, name: str, content: bytes) -> None:
        atomic_write(self.path / name, content)

    def append(self, name: str, text: str) -> None:
        with (self.path / name).open("a", encoding="utf-8") as log:
            log.write(text)
            log.flush()
            os.fsync(log.fileno())

    def log(self, name: str) -> str:
        return (self.read(name) or b"").decode("utf-8", "replace")

    def names(self) -> set[str]:
        return {one.name for one in self.path.iterdir()} if self.path.is_dir() else set()

    def remove(self, name: str) -> None:
        import shutil

        file = self.path / name
        if file.is_dir():
            shutil.rmtree(file)
        else:
            file.unlink(missing_ok=True)


@dataclass(frozen=True)
class Url:
    """A place of fsspec's. Nothing can be appended to in an object store: a log is many files."""

    url: str

    def __str__(self) -> str:
        return self.url

    @cached_property
    def _opened(self) -> tuple[Any, str]:
        try:
            import fsspec
        except ImportError:
            raise InputError(
                f"{self.url}: fsspec is not installed, expected pip install 'tt-precise[dask]'"
            ) from None
        try:
            files, root = fsspec.core.url_to_fs(self.url)
        except (ImportError, ValueError, OSError) as error:  # s3fs is missing, for example
            raise InputError(f"{self.url}: {error}; expected a URL that fsspec knows") from None
        return files, root.rstrip("/")

    def __getstate__(self) -> dict[str, str]:
        return {"url": self.url}  # connections do not travel

    def read(self, name: str) -> bytes | None:
        files, root = self._opened
        try:
            content: bytes = files.cat_file(f"{root}/{name}")
        except FileNotFoundError:
            return None
        return content

    def write(self, name: str, content: bytes) -> None:
        files, root = self._opened
        target = f"{root}/{name}"
        files.makedirs(target.rpartition("/")[0], exist_ok=True)
        files.pipe_file(target, content)

    def append(self, name: str, text: str) -> None:
        number = len(self._parts(name))
        self.write(f"{name}.d/{number:06}", text.encode())

    def log(self, name: str) -> str:
        files, _ = self._opened
        parts = [files.cat_file(part) for part in self._parts(name)]
        return b"".join(parts).decode("utf-8", "replace")

    def names(self) -> set[str]:
        return {one.rpartition("/")[2] for one in self._listed("")}

    def remove(self, name: str) -> None:
        files, root = self._opened
        if files.exists(f"{root}/{name}"):
            files.rm(f"{root}/{name}", recursive=True)

    def _parts(self, name: str) -> list[str]:
        return sorted(self._listed(f"{name}.d"))

    def _listed(self, folder: str) -> list[str]:
        files, root = self._opened
        files.invalidate_cache()
        try:
            found: list[str] = files.ls(f"{root}/{folder}".rstrip("/"), detail=False)
        except FileNotFoundError:
            return []
        return found
