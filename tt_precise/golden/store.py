"""The folders of golden data: reading, verification of hashes, replacement.

The manifest of a scene lists its files with hashes of their content; line ends and comments do not
count. The hashes detect damage and careless edits. Whoever rewrites the files can also rewrite the
hashes, but the history of the repository shows this.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

from tt_precise.golden.digits import scales_of
from tt_precise.golden.table import FORMAT, Table
from tt_precise.runtime.files import MISSHAPEN, atomic_write, parse_toml, read_json, shipped
from tt_precise.runtime.values import InputError, Json, wrong_name
from tt_precise.scene.scene import Scene, parse_scene

SCENE, TRAJECTORY, EVENTS = "scene.toml", "trajectory.csv", "events.csv"
MANIFEST, PROOF = "manifest.json", "proof.json"
FILES = (SCENE, TRAJECTORY, EVENTS, MANIFEST)
DOCUMENT = "the manifest of golden data"

PACKAGE = Path(__file__).resolve().parents[1]
OWN = Path("golden")  # The folder in the working directory, unless another is named.
VECTORS = "vectors"  # a folder next to the scenes: test vectors, which another command verifies
LONGEST_NAME = 100
WORK = "golden build"  # the work that locks a folder

Folder = str | os.PathLike[str] | None


class Located(NamedTuple):
    """The name of a scene, and the parent folder of its golden data."""

    name: str
    folder: Path

    @property
    def path(self) -> Path:
        return self.folder / self.name


def home() -> Path:
    """The folder of golden data: inside an installed package, in a checkout next to it."""
    return shipped("reference_data")


def in_checkout() -> bool:
    """True in a checkout, where the package's golden data may be built."""
    return (PACKAGE.parent / "pyproject.toml").is_file() and home().parent == PACKAGE.parent


def scenes(folder: Folder = None) -> list[str]:
    """Names of the scenes with golden data in ``folder``, by default in the package."""
    place = home() if folder is None else Path(folder)
    if not place.is_dir():
        return []
    return sorted(
        entry.name
        for entry in place.iterdir()
        if not entry.name.startswith(".") and (entry / MANIFEST).is_file()
    )


def some(names: Iterable[str], folder: Folder = None) -> list[str]:
    """The names of scenes, at least one: a check without input is an error.

    Raises ``InputError``: there are none.
    """
    chosen = list(names)
    if not chosen:
        place = home() if folder is None else Path(folder)
        raise InputError(
            f"golden data: got none in {place}, expected the folder of a scene; "
            "`tt-precise golden build` makes it"
        )
    return chosen


def locate(scene: str | Path, folder: Folder = None) -> Located:
    """The golden data for a name, a scene's TOML file, or the folder of the data.

    A folder is given by its path: a ``Path``, or text with a slash such as ``./mytop``. A bare name
    is sought in ``folder``, or in the package and then in ``golden``, nowhere else. The existence
    of the data is not checked.

    Raises ``InputError``: the name is not a possible name of a scene.
    """
    given = Path(scene)
    by_path = isinstance(scene, Path) or os.sep in scene
    if folder is None and by_path and (given / MANIFEST).is_file():
        place = given.resolve()
        return Located(place.name, place.parent)
    name = given.stem if given.suffix == ".toml" else str(scene)
    # no path, not hidden, printable
    if len(name) > LONGEST_NAME or not re.fullmatch(r"\w[\w.-]*", name):
        raise InputError(
            f"scene: got the file name {name[:60]!r}, expected letters, digits, - and _, "
            "because it names a folder"
        )
    if folder is not None:
        return Located(name, Path(folder))
    own = (OWN / name / MANIFEST).is_file() and name not in scenes()
    return Located(name, OWN if own else home())


def require(scene: str | Path, folder: Folder = None) -> Located:
    """Locate existing golden data.

    Raises ``InputError``: there are no such data.
    """
    place = locate(scene, folder)
    if not (place.path / MANIFEST).is_file():
        known = scenes(folder)
        also = "" if known else "none yet; `tt-precise golden build` makes it"
        raise wrong_name("golden data", str(scene), known, also)
    return place


@dataclass(frozen=True)
class Stored:
    """The golden data in the folder of one scene."""

    name: str
    scene_text: str
    trajectory: Table
    events: Table
    manifest: dict[str, Json]
    folder: Path = OWN

    @cached_property
    def scene(self) -> Scene:
        return parse_scene(self.scene_text, self.name, f"{self.name}/{SCENE}")

    @cached_property
    def scales(self) -> dict[str, Decimal]:
        """The largest printed entry of each column; 0 for times."""
        return {**scales_of(self.trajectory), "t": Decimal(0)}

    def table(self, file: str) -> Table:
        return self.trajectory if file == TRAJECTORY else self.events


def read_files(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene`` (see ``locate``), without verifying them.

    Raises ``InputError``: there are no such data, or a file is missing or unreadable.
    """
    from tt_precise.golden.documents import Manifest  # what only reads whole data does without
    from tt_precise.runtime.records import read_as_record

    place = require(scene, folder).path
    read_as_record(place / MANIFEST, Manifest, DOCUMENT)
    return _read_files(place)


def _read_files(data: Path) -> Stored:
    trajectory, events = (_table(data / file) for file in (TRAJECTORY, EVENTS))
    manifest = read_json(data / MANIFEST, DOCUMENT)
    return Stored(data.name, _text(data / SCENE), trajectory, events, manifest, data.parent)


def read_whole(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene``, and compare them with their manifest.

    A process reads the data of each manifest only once.

    Raises ``InputError``: there are no such data, or they have changed since they were built.
    """
    place = require(scene, folder)
    return _whole(place.path.absolute(), _text(place.path / MANIFEST))


@lru_cache(maxsize=64)
def _whole(data: Path, manifest: str) -> Stored:
    stored = _read_files(data)
    try:
        problems = changes(stored)
        problems += [] if stored.manifest["schema"] == FORMAT else [MANIFEST]
    except MISSHAPEN:
        problems = [MANIFEST]
    if problems:
        _ = read_files(data.name, data.parent).scene  # refuses another form
        raise InputError(
            f"{stored.name}: {problems[0]}; `tt-precise golden verify {stored.name}` says where"
        )
    return stored


def replace_folder(target: Path, files: dict[str, str]) -> None:
    """Put ``files`` into the folder ``target`` all at once, by renaming a complete new folder.

    Other files in the folder, such as a proof of the digits, stay.

    Raises ``InputError``: the folder cannot be written, or the disk is full; the old data stay.
    """
    import shutil  # here, because a check does not write

    fresh, old = (target.with_name(f".{which}-{target.name}") for which in ("new", "old"))
    try:
        if old.exists() and not target.exists():  # killed between the two renames
            old.rename(target)
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir(parents=True)
        for other in target.iterdir() if target.exists() else ():
            if other.name not in files and other.is_file():
                shutil.copy2(other, fresh)
        for name, text in files.items():
            with (fresh / name).open("w", encoding="utf-8", newline="\n") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            if (target / name).exists():
                shutil.copymode(target / name, fresh / name)
        if target.exists():
            shutil.copymode(target, fresh)
            target.rename(old)
        try:
            fresh.rename(target)
        except BaseException:
            if old.exists():
                old.rename(target)
            raise
        shutil.rmtree(old, ignore_errors=True)
    except OSError as error:
        reason = error.strerror or type(error).__name__
        raise InputError(f"{target}: {reason}; expected a writable place") from error
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def json_text(content: dict[str, Json]) -> str:
    """Return the text of a JSON file of golden data."""
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def scene_sha256(text: str) -> str:
    """SHA-256 of the content of a scene's TOML, without comments and layout.

    Raises ``InputError``: the content is not TOML.
    """
    try:
        return _json_hash(parse_toml(text))
    except InputError as error:
        raise InputError(f"{SCENE}: {error}") from None


def _json_hash(content: Json) -> str:
    text = json.dumps(content, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def changes(stored: Stored) -> list[str]:
    """Return a line for each file whose hash differs from the manifest."""
    hashes = {
        SCENE: scene_sha256(stored.scene_text),
        TRAJECTORY: stored.trajectory.sha256,
        EVENTS: stored.events.sha256,
    }
    proof = proof_sha256(stored.folder / stored.name)
    if proof is not None:
        hashes[PROOF] = proof
    listed = {file: entry["sha256"] for file, entry in stored.manifest["files"].items()}
    again = f"; run `tt-precise golden certify {stored.name}`"
    lines = []
    for file in dict.fromkeys([*hashes, *listed]):
        if file not in hashes:
            lines.append(f"{file}: missing, but {MANIFEST} lists it{again}")
        elif file not in listed:
            lines.append(f"{file}: not listed in {MANIFEST}{again}")
        elif hashes[file] != listed[file]:
            lines.append(f"{file}: changed since it was written; `git diff` may show where")
    return lines


def proof_sha256(data: Path) -> str | None:
    """Return the hash of the proof in a scene's folder; None without a proof, "" if not JSON."""
    path = data / PROOF
    if not path.is_file():
        return None
    try:
        return _json_hash(read_json(path, "a proof"))
    except InputError:
        return ""


def record_proof(data: Path) -> None:
    """Write the hash of the proof in a scene's folder into its manifest.

    Raises ``InputError``: the manifest is missing or has another form.
    """
    stored = read_files(data.name, data.parent)
    files = {file: entry for file, entry in stored.manifest["files"].items() if file != PROOF}
    sha256 = proof_sha256(data)
    if sha256:
        files[PROOF] = {"sha256": sha256}
    atomic_write(data / MANIFEST, json_text({**stored.manifest, "files": files}))


def _table(path: Path) -> Table:
    text = _text(path)
    try:
        table = Table.parse(text)
        if path.name == TRAJECTORY and not table.rows:
            raise InputError("no row, expected one for each time")
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return table


def _text(path: Path) -> str:
    # A device or a pipe has no end; a link may lead anywhere, but for those of an installer.
    if (path.is_symlink() and home() not in path.parents) or (path.exists() and not path.is_file()):
        raise InputError(f"{path}: no regular file; expected golden data")
    try:
        return path.read_text("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text, expected golden data") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected golden data") from None
