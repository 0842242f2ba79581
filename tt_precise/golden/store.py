"""The folders of golden data: reading, verification of hashes, replacement.

Three hashes identify the built data: of each file (of its content, so that line ends and comments
do not count), in ``manifest.json``; of the manifest itself and of the proof, inside each of them.
They show damage and careless edits.
Somebody who rewrites the files can also rewrite the hashes; a signature of the release protects
against that, see ``reference_data/README.md``.
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
from tt_precise.runtime.values import InputError, Json
from tt_precise.scene.scene import Scene, parse_scene

SCENE, TRAJECTORY, EVENTS = "scene.toml", "trajectory.csv", "events.csv"
MANIFEST, PROOF = "manifest.json", "proof.json"
FILES = (SCENE, TRAJECTORY, EVENTS, MANIFEST)
DOCUMENT = "the manifest of golden data"
MANIFEST_HASH, PROOF_HASH = "sha256_of_manifest", "sha256_of_proof"

PACKAGE = Path(__file__).resolve().parents[1]
OWN = Path("golden")  # in the working directory, unless a folder is named
VECTORS = "vectors"  # a folder next to the scenes: test vectors, which another command verifies
LONGEST_NAME = 100
WORK = "golden build"  # the work that locks a folder

# scenes that ship with a proof, so that none is deleted unnoticed
PROVED = frozenset(
    {
        "below-threshold", "beside-the-pole", "contact-lost", "coulomb-gliding", "elastic-linear",
        "flight", "frictionless", "from-initiation", "inverted", "just-above-threshold",
        "just-below-threshold", "kicked",
        "phi-dot-195", "phi-dot-83", "phi-dot-minus-10", "reference", "regularised-1e-2",
        "regularised-1e-4", "rocking", "rolling", "smoothest", "stays-upright", "steep",
        "tippetopsim", "track", "upright"
    }
)  # fmt: skip

Folder = str | os.PathLike[str] | None


class Located(NamedTuple):
    """A scene by name, and the folder that holds the folder of its golden data."""

    name: str
    folder: Path

    @property
    def path(self) -> Path:
        return self.folder / self.name


def home() -> Path:
    """The folder of golden data: inside an installed package, next to it in a checkout."""
    return shipped("reference_data")


def in_checkout() -> bool:
    """Whether the package's golden data may be built: only in a checkout."""
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
    """These names of scenes, if there are any: a check without input is an error.

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
    is looked for in ``folder``, or in the package and then in ``golden``, nowhere else. Whether
    such data exist is not checked.

    Raises ``InputError``: it is not a possible name of a scene.
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
    """``locate`` for existing data.

    Raises ``InputError``: there are none.
    """
    place = locate(scene, folder)
    if not (place.path / MANIFEST).is_file():
        known = ", ".join(scenes(folder)) or "none yet; `tt-precise golden build` makes it"
        raise InputError(f"golden data: got {str(scene)[:60]!r}, expected one of: {known}")
    return place


@dataclass(frozen=True)
class Stored:
    """The golden data of one scene, as in its folder."""

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


def read(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene`` (see ``locate``), without verifying them.

    Raises ``InputError``: there is none, or a file is missing or unreadable.
    """
    from tt_precise.golden.documents import Manifest  # what only reads whole data does without
    from tt_precise.runtime.records import read_as_record

    place = require(scene, folder).path
    read_as_record(place / MANIFEST, Manifest, DOCUMENT)
    return _read(place)


def _read(place: Path) -> Stored:
    trajectory, events = (_table(place / file) for file in (TRAJECTORY, EVENTS))
    manifest = read_json(place / MANIFEST, DOCUMENT)
    return Stored(place.name, _text(place / SCENE), trajectory, events, manifest, place.parent)


def read_whole(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene``, and compare them with their manifest.

    Once a process for each manifest: data that fit it are the same again.

    Raises ``InputError``: there are no such data, or they have changed since they were built.
    """
    place = require(scene, folder)
    return _whole(place.path.absolute(), _text(place.path / MANIFEST))


@lru_cache(maxsize=64)
def _whole(place: Path, manifest: str) -> Stored:
    stored = _read(place)
    try:
        problems = [f"{file} changed since it was built" for file in changed_files(stored)]
        problems += [] if problems else missing_proof(stored)
        problems += [] if stored.manifest["schema"] == FORMAT else [MANIFEST]
    except MISSHAPEN:
        problems = [MANIFEST]
    if problems:
        _ = read(place.name, place.parent).scene  # refuses another form
        raise InputError(
            f"{stored.name}: {problems[0]}; `tt-precise golden verify {stored.name}` says where"
        )
    return stored


def replace_folder(target: Path, files: dict[str, str]) -> None:
    """Put ``files`` into the folder ``target`` all at once, by renaming a complete new folder.

    Other files in the folder, such as a proof of the digits, stay.

    Raises ``InputError``: the place cannot be written, or is full; the old data stay.
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


def manifest_text(manifest: dict[str, Json]) -> str:
    """The text of manifest.json, with the manifest's own hash added."""
    return _with_hash(manifest, MANIFEST_HASH)


def proof_text(content: dict[str, Json]) -> str:
    """The text of proof.json, with the proof's own hash added."""
    return _with_hash(content, PROOF_HASH)


def _with_hash(content: dict[str, Json], key: str) -> str:
    hashed = {**content, key: self_hash(content, key)}
    return json.dumps(hashed, indent=1, ensure_ascii=False) + "\n"


def with_proof(manifest: dict[str, Json], sha256: str | None) -> dict[str, Json]:
    """The manifest (without its own hash) of data with a proof of that hash, or without a proof."""
    content = {k: v for k, v in manifest.items() if k not in (MANIFEST_HASH, PROOF_HASH)}
    return content if sha256 is None else {**content, PROOF_HASH: sha256}


def self_hash(content: dict[str, Json], key: str = MANIFEST_HASH) -> str:
    """SHA-256 of a document's content without the hash itself, which is stored under ``key``."""
    return _json_hash({name: value for name, value in content.items() if name != key})


def scene_sha256(text: str) -> str:
    """SHA-256 of the content of a scene's TOML, without comments and layout.

    Raises ``InputError``: it is no TOML.
    """
    try:
        return _json_hash(parse_toml(text))
    except InputError as error:
        raise InputError(f"{SCENE}: {error}") from None


def _json_hash(content: Json) -> str:
    text = json.dumps(content, sort_keys=True, ensure_ascii=False, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def changed_files(stored: Stored) -> list[str]:
    """Files that have changed since they were built, by their hashes."""
    manifest = stored.manifest
    hashes = {
        SCENE: scene_sha256(stored.scene_text),
        TRAJECTORY: stored.trajectory.sha256,
        EVENTS: stored.events.sha256,
    }
    changed = [
        file for file, sha256 in hashes.items() if sha256 != manifest["files"][file]["sha256"]
    ]
    return changed if self_hash(manifest) == manifest[MANIFEST_HASH] else [*changed, MANIFEST]


def require_manifest(stored: Stored) -> None:
    """Refuse to prove data, or record a proof of data, that no build has written.

    Raises ``InputError``: the manifest does not match its own hash.
    """
    name = stored.name
    if MANIFEST in changed_files(stored):
        raise InputError(
            f"{name}: {MANIFEST} has changed since it was built; "
            f"`tt-precise golden verify {name}` says where"
        )


def record_proof(place: Path) -> None:
    """Write the hash of the proof in a scene's folder into its manifest.

    Raises ``InputError``: no build has written the manifest.
    """
    stored = read(place.name, place.parent)
    require_manifest(stored)
    atomic_write(place / MANIFEST, manifest_text(with_proof(stored.manifest, proof_hash(place))))


def proof_hash(place: Path) -> str | None:
    """The hash of the proof in a scene's folder; None if there is none, "" if it is spoiled."""
    path = place / PROOF
    if not path.is_file():
        return None
    try:
        content = read_json(path, "a proof")
    except InputError:
        return ""
    digest = self_hash(content, PROOF_HASH)
    return digest if digest == content.get(PROOF_HASH) else ""


def missing_proof(stored: Stored) -> list[str]:
    """Whether the proof that the manifest records, or the package knows of, is there."""
    recorded = stored.manifest.get(PROOF_HASH)
    digest = proof_hash(stored.folder / stored.name)
    again = f"run `tt-precise golden certify {stored.name}`"
    if digest == "":
        return [f"{PROOF}: spoiled, its own hash does not fit; {again}"]
    shipped = stored.folder.resolve() == home().resolve() and stored.name in PROVED
    if digest is None and (recorded or shipped):
        knows = f"{MANIFEST} records" if recorded else "the package knows of"
        return [f"{PROOF}: missing, but {knows} a proof of these digits"]
    if digest != recorded:
        return [f"{PROOF}: not the one that {MANIFEST} records; {again}"]
    return []


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
    try:
        return path.read_text("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not UTF-8 text, expected golden data") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}; expected golden data") from None
