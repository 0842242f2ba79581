"""Where golden data lies, and how a scene's folder is read and replaced as a whole."""

from __future__ import annotations

import ctypes
import errno
import json
import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tt_precise.errors import InputError
from tt_precise.golden.table import Table
from tt_precise.scene import Scene, parse_scene

SCENE, TRAJECTORY, EVENTS, MANIFEST = FILES = (
    "scene.toml", "trajectory.csv", "events.csv", "manifest.json",
)  # fmt: skip
PACKAGE = Path(__file__).resolve().parents[1]
LONGEST_NAME = 100
AT_FDCWD, RENAME_EXCHANGE = -100, 2  # linux/fcntl.h, linux/fs.h
WORK = "golden build"  # what nobody else may be at in a folder meanwhile


@dataclass(frozen=True)
class Stored:
    """The golden data of one scene, as it stands in its folder."""

    name: str
    scene_text: str
    trajectory: Table
    events: Table
    manifest: dict[str, Any]

    @property
    def scene(self) -> Scene:
        """The scene that the data are for."""
        return parse_scene(self.scene_text, self.name, f"{self.name}/{SCENE}")

    def table(self, file: str) -> Table:
        """The table in ``file``."""
        return self.trajectory if file == TRAJECTORY else self.events


def home() -> Path:
    """The folder of golden data: inside an installed package, beside it in a checkout."""
    installed = PACKAGE / "reference_data"
    return installed if installed.is_dir() else PACKAGE.parent / "reference_data"


def is_name(name: str) -> bool:
    """Whether ``name`` can be that of a scene's folder: no path, not hidden, printable."""
    return len(name) <= LONGEST_NAME and re.fullmatch(r"\w[\w.-]*", name) is not None


def scenes(folder: Path | None = None) -> list[str]:
    """Names of the scenes that have golden data."""
    place = folder or home()
    if not place.is_dir():
        return []
    return sorted(
        entry.name
        for entry in place.iterdir()
        if not entry.name.startswith(".") and (entry / MANIFEST).is_file()
    )


def read(name: str, folder: Path | None = None) -> Stored:
    """Read the golden data of the scene ``name``, without judging it.

    Raises
    ------
    InputError
        There is none, or a file is missing or unreadable.
    """
    place = (folder or home()) / name
    if name not in scenes(folder):
        known = ", ".join(scenes(folder)) or "none yet; `tt-precise golden build` makes it"
        raise InputError(f"golden data: got {name[:60]!r}, expected one of: {known}")
    texts = {file: _text(place / file) for file in FILES}
    try:
        manifest = json.loads(texts[MANIFEST])
    except ValueError as error:
        raise InputError(f"{place / MANIFEST}: no JSON: {error}") from None
    if not isinstance(manifest, dict):
        raise InputError(f"{place / MANIFEST}: got no JSON object, expected one")
    tables = {}
    for file in (TRAJECTORY, EVENTS):
        try:
            tables[file] = Table.parse(texts[file])
        except InputError as error:
            raise InputError(f"{place / file}: {error}") from None
    return Stored(name, texts[SCENE], tables[TRAJECTORY], tables[EVENTS], manifest)


def replace_folder(target: Path, files: dict[str, str]) -> None:
    """Put ``files`` into the folder ``target`` all at once; whoever looks sees old or new.

    Other files that lie there, such as a proof of the digits, stay.

    Raises
    ------
    InputError
        The place cannot be written, or is full; the old data stand.
    """
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
