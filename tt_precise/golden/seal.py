"""Whether golden files are still what was built: their hashes, held against the manifest.

A hash shows damage and careless edits. Who writes the files anew can write new hashes, too; that
takes a signature of the release, see ``reference_data/README.md``.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from tt_precise.golden import places, store
from tt_precise.golden.hashes import (
    PROOF,
    PROOF_KEY,
    SELF_HASH,
    dump,
    scene_sha256,
    self_hash,
    with_proof,
)
from tt_precise.golden.places import Folder, home
from tt_precise.golden.proved import PROVED
from tt_precise.golden.store import EVENTS, FILES, MANIFEST, SCENE, TRAJECTORY, Stored
from tt_precise.runtime import records
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.untyped import Json

NEEDED = {"schema", "scene", "model", "status", "digits", "files", "evidence", SELF_HASH}


def read_whole(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene``, and hold them against their manifest.

    Raises
    ------
    InputError
        There are no such data, or they are not what was built.
    """
    name, home = places.require(scene, folder)

    def look() -> Stored:
        stored = store.read(name, home)
        require_whole(stored)
        return stored

    return store.steadily(home / name, look)


def require_whole(stored: Stored) -> None:
    """Hold the files of ``stored`` against its manifest, once while they stay the same.

    Raises
    ------
    InputError
        They are not what was built, or a proof that was there is gone.
    """
    place = stored.folder / stored.name
    stamps = tuple(store.stamp(place / file) for file in (*FILES, PROOF))
    # the proof may be missing, the other files must be there and settled to be remembered
    known = all(stamps[: len(FILES)])
    problems = _remembered(place.resolve(), stamps) if known else _broken(stored)
    if problems:
        raise InputError(
            f"{stored.name}: {problems[0]}; `tt-precise golden verify {stored.name}` says where"
        )


@lru_cache(maxsize=128)
def _remembered(place: Path, stamps: tuple[store.Stamp | None, ...]) -> tuple[str, ...]:
    return _broken(store.read(place.name, place.parent))


def _broken(stored: Stored) -> tuple[str, ...]:
    manifest = stored.manifest
    files = manifest.get("files")
    recorded = files if isinstance(files, dict) else {}
    found = {
        MANIFEST: (self_hash(manifest), manifest.get(SELF_HASH)),
        SCENE: (scene_sha256(stored.scene_text), _hash(recorded, SCENE)),
        TRAJECTORY: (stored.trajectory.sha256, _hash(recorded, TRAJECTORY)),
        EVENTS: (stored.events.sha256, _hash(recorded, EVENTS)),
    }
    changed = [file for file, (now, then) in found.items() if now != then]
    if changed:
        return (f"{', '.join(changed)} got changed since it was built",)
    return tuple(missing_proof(stored))


def missing_keys(manifest: dict[str, Json]) -> list[str]:
    """What a manifest of golden data has to have, and this one lacks."""
    return sorted(NEEDED - manifest.keys())


def require_manifest(stored: Stored) -> None:
    """Refuse to prove, or to seal, what no build has written.

    Raises
    ------
    InputError
        The manifest lacks keys, or is not the one that its own hash is of.
    """
    manifest, name = stored.manifest, stored.name
    missing = missing_keys(manifest)
    if missing:
        raise InputError(
            f"{name}: {MANIFEST} got no {', '.join(missing)}, expected what "
            f"`tt-precise golden build {name}` writes"
        )
    if self_hash(manifest) != manifest[SELF_HASH]:
        raise InputError(
            f"{name}: {MANIFEST} got changed since it was built; "
            f"`tt-precise golden verify {name}` says where"
        )


def record_proof(place: Path) -> None:
    """Write the hash of the proof that lies in a scene's folder into its manifest.

    Raises
    ------
    InputError
        The manifest is not one that was built.
    """
    stored = store.read(place.name, place.parent)
    require_manifest(stored)
    text = dump(with_proof(stored.manifest, proof_hash(place)))
    atomic_write(place / MANIFEST, text)


def proof_hash(place: Path) -> str | None:
    """The hash of the proof in a scene's folder; None if there is none, "" if it is spoiled."""
    path = place / PROOF
    if not path.is_file():
        return None
    try:
        content = records.read(path, "a proof")
        sealed = self_hash(content, PROOF_KEY)
        return sealed if sealed == content[PROOF_KEY] else ""
    except (InputError, KeyError):
        return ""


def missing_proof(stored: Stored) -> list[str]:
    """Whether the proof that the manifest records, or the package knows of, is there."""
    recorded = stored.manifest.get(PROOF_KEY)
    found = proof_hash(stored.folder / stored.name)
    again = f"run `tt-precise golden certify {stored.name}`"
    if found == "":
        return [f"{PROOF}: spoiled, its own hash does not fit; {again}"]
    shipped = stored.folder.resolve() == home().resolve() and stored.name in PROVED
    if found is None and (recorded or shipped):
        knows = f"{MANIFEST} records" if recorded else "the package knows of"
        return [f"{PROOF}: missing, but {knows} a proof of these digits"]
    if found != recorded:
        return [f"{PROOF}: not the one that {MANIFEST} records; {again}"]
    return []


def _hash(files: dict[str, object], file: str) -> object:
    entry = files.get(file)
    return entry.get("sha256") if isinstance(entry, dict) else None
