"""Where golden data lies, and how a scene's folder is read and replaced as a whole."""

from __future__ import annotations

import ctypes
import errno
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

from tt_precise.golden.places import MANIFEST, OWN, Folder, require
from tt_precise.golden.places import home as home
from tt_precise.golden.places import scenes as scenes
from tt_precise.golden.table import Table
from tt_precise.runtime import records
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene, parse_scene

SCENE, TRAJECTORY, EVENTS = "scene.toml", "trajectory.csv", "events.csv"
Looked = TypeVar("Looked")
FILES = (SCENE, TRAJECTORY, EVENTS, MANIFEST)
SETTLED_NS = 100_000_000  # far more than the steps in which file systems count time
AT_FDCWD, RENAME_EXCHANGE = -100, 2  # linux/fcntl.h, linux/fs.h
EXCHANGES = 10  # during which reading is tried again
WORK = "golden build"  # what nobody else may be at in a folder meanwhile


@dataclass(frozen=True)
class Stored:
    """The golden data of one scene, as it stands in its folder."""

    name: str
    scene_text: str
    trajectory: Table
    events: Table
    manifest: dict[str, Json]
    folder: Path = OWN

    @property
    def scene(self) -> Scene:
        """The scene that the data are for."""
        return _scene(self.scene_text, self.name)

    def table(self, file: str) -> Table:
        """The table in ``file``."""
        return self.trajectory if file == TRAJECTORY else self.events


def read(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene`` (see ``places.locate``), without verifying them.

    Tables are parsed once a process, as long as path, size and time of a file stay the same.
    What a build puts in their place meanwhile is read as a whole, or not at all.

    Raises
    ------
    InputError
        There is none, or a file is missing or unreadable.
    """
    name, home = require(scene, folder)
    return steadily(home / name, lambda: _read(name, home))


def steadily(place: Path, look: Callable[[], Looked]) -> Looked:
    """What ``look`` finds in the folder ``place``, which is the same folder all the while.

    ``replace_folder`` exchanges the folder under its name: of files that are opened one by one
    some could be of the old folder, and some of the new one.

    Raises
    ------
    InputError
        The folder is exchanged again and again; and whatever ``look`` raises.
    """
    for _ in range(EXCHANGES):
        before = _number(place)
        try:
            found = look()
        except InputError:
            if _number(place) == before:
                raise
            continue
        if _number(place) == before:
            return found
    raise InputError(f"{place}: is exchanged again and again; expected it to stay for a moment")


def _number(place: Path) -> int | None:
    try:
        return place.stat().st_ino
    except OSError:
        return None


@lru_cache(maxsize=128)
def _scene(text: str, name: str) -> Scene:
    return parse_scene(text, name, f"{name}/{SCENE}")


def _read(name: str, home: Path) -> Stored:
    place = home / name
    manifest = records.read(place / MANIFEST, "the manifest of golden data")
    tables = {file: _table(place / file) for file in (TRAJECTORY, EVENTS)}
    return Stored(name, _text(place / SCENE), tables[TRAJECTORY], tables[EVENTS], manifest, home)


Stamp = tuple[int, int, int, int]


def stamp(path: Path) -> Stamp | None:
    """What changes when a file is written: size, times, number; the second time nobody can set.

    None where there is no file, or one so new that another writing might not change its time.
    """
    try:
        found = path.stat()
    except OSError:
        return None
    if time.time_ns() - found.st_mtime_ns < SETTLED_NS:
        return None
    return (found.st_size, found.st_mtime_ns, found.st_ctime_ns, found.st_ino)


@lru_cache(maxsize=128)
def _unchanged_table(path: Path, unchanged: Stamp) -> Table:
    return _parsed(path)


def _table(path: Path) -> Table:
    unchanged = stamp(path)
    return _parsed(path) if unchanged is None else _unchanged_table(path, unchanged)


def _parsed(path: Path) -> Table:
    try:
        return Table.parse(_text(path))
    except InputError as error:
        named = str(error).startswith(str(path))
        raise InputError(str(error) if named else f"{path}: {error}") from None


def replace_folder(target: Path, files: dict[str, str]) -> None:
    """Put ``files`` into the folder ``target`` all at once; whoever looks sees old or new.

    Other files that lie there, such as a proof of the digits, stay.

    Raises
    ------
    InputError
        The place cannot be written, or is full; the old data stand.
    """
    import shutil  # here, because a check does not write

    fresh = target.with_name(f".new-{target.name}")
    shutil.rmtree(fresh, ignore_errors=True)
    try:
        fresh.mkdir(parents=True)
        for other in target.iterdir() if target.exists() else ():
            if other.name not in files and other.is_file():
                shutil.copy2(other, fresh)
        for name, text in files.items():
            with (fresh / name).open("w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        if target.exists():
            _exchange(fresh, target)
        else:
            fresh.rename(target)
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError(f"{target}: {reason}; expected a place that can be written") from error
    finally:
        # the old folder after an exchange, or what an interruption left half done
        shutil.rmtree(fresh, ignore_errors=True)


def _exchange(fresh: Path, target: Path) -> None:
    import shutil

    # Python has no call for an atomic exchange of two folders
    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is not None:
        paths = os.fsencode(fresh), os.fsencode(target)
        if rename(AT_FDCWD, paths[0], AT_FDCWD, paths[1], RENAME_EXCHANGE) == 0:
            return
        code = ctypes.get_errno()
        if code not in (errno.EINVAL, errno.ENOSYS):
            raise OSError(code, os.strerror(code), str(target))
    # a file system without exchange: two renames, the first undone if the second fails
    old = target.with_name(f".old-{target.name}")
    shutil.rmtree(old, ignore_errors=True)
    target.rename(old)
    try:
        fresh.rename(target)
    except BaseException:
        old.rename(target)
        raise
    old.rename(fresh)


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text, expected golden data") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected golden data") from None
