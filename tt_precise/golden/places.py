"""Where golden data lie: those of the package, those of one's own, or a folder that is named."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from tt_precise.runtime.errors import InputError

MANIFEST = "manifest.json"
PACKAGE = Path(__file__).resolve().parents[1]
OWN = Path("golden")  # in the working directory, unless a folder is named
LONGEST_NAME = 100

Folder = str | os.PathLike[str] | None


class Located(NamedTuple):
    """A scene by name, and the folder that holds the folder of its golden data."""

    name: str
    folder: Path

    @property
    def path(self) -> Path:
        """The folder of its files."""
        return self.folder / self.name


def home() -> Path:
    """The folder of golden data: inside an installed package, beside it in a checkout."""
    installed = PACKAGE / "reference_data"
    return installed if installed.is_dir() else PACKAGE.parent / "reference_data"


def in_checkout() -> bool:
    """Whether the package's own golden data may be built: not where it is installed."""
    return (PACKAGE.parent / "pyproject.toml").is_file() and home().parent == PACKAGE.parent


def is_name(name: str) -> bool:
    """Whether ``name`` can be that of a scene's folder: no path, not hidden, printable."""
    return len(name) <= LONGEST_NAME and re.fullmatch(r"\w[\w.-]*", name) is not None


VECTORS = "vectors"  # a folder beside the scenes: test vectors, verified by a command of their own


def scenes(folder: Folder = None) -> list[str]:
    """Names of the scenes that have golden data there, by default in the package."""
    place = home() if folder is None else Path(folder)
    if not place.is_dir():
        return []
    return sorted(
        entry.name
        for entry in place.iterdir()
        if not entry.name.startswith(".") and (entry / MANIFEST).is_file()
    )


def some(names: Iterable[str], folder: Folder = None) -> list[str]:
    """These names of scenes, if there are any: a gate that looked at nothing must not pass.

    Raises
    ------
    InputError
        There are none.
    """
    found = list(names)
    if not found:
        place = home() if folder is None else Path(folder)
        raise InputError(
            f"golden data: got none in {place}, expected the folder of a scene there; "
            "`tt-precise golden build` makes it"
        )
    return found


def locate(scene: str | Path, folder: Folder = None) -> Located:
    """The golden data meant by a name, a scene's TOML file, or the folder that holds them.

    A folder is given by its path: a ``Path``, or text with a slash such as ``./mytop``. A bare name
    is looked for in ``folder``, or in the package and then in ``golden``, nowhere else. Whether
    such data exist is another question.

    Raises
    ------
    InputError
        That cannot be the name of a scene.
    """
    given = Path(scene)
    by_path = isinstance(scene, Path) or os.sep in scene
    if folder is None and by_path and (given / MANIFEST).is_file():
        place = given.resolve()
        return Located(place.name, place.parent)
    name = given.stem if given.suffix == ".toml" else str(scene)
    if not is_name(name):
        raise InputError(
            f"scene: got the file name {name[:60]!r}, expected letters, digits, - and _, "
            "because a folder is called after it"
        )
    if folder is not None:
        return Located(name, Path(folder))
    own = (OWN / name / MANIFEST).is_file() and name not in scenes()
    return Located(name, OWN if own else home())


def require(scene: str | Path, folder: Folder = None) -> Located:
    """``locate``, where there are such data.

    Raises
    ------
    InputError
        There are none.
    """
    try:
        found = locate(scene, folder)
    except InputError:
        found = None
    if found is None or not (found.path / MANIFEST).is_file():
        known = ", ".join(scenes(folder)) or "none yet; `tt-precise golden build` makes it"
        raise InputError(f"golden data: got {str(scene)[:60]!r}, expected one of: {known}")
    return found
