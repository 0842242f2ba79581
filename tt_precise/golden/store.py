"""The folders of golden data: reading, and hashes that detect damage and careless edits.

The manifest of a scene lists its files with hashes of their content; line ends and comments do not
count.
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

from tt_precise.golden.table import Table
from tt_precise.runtime.files import atomic_write, parse_toml, read_json, shipped
from tt_precise.runtime.values import InputError, Json, wrong_name
from tt_precise.scene.scene import Scene, parse_scene

SCENE, TRAJECTORY, EVENTS = "scene.toml", "trajectory.csv", "events.csv"
MANIFEST, PROOF = "manifest.json", "proof.json"
FILES = (SCENE, TRAJECTORY, EVENTS, MANIFEST)
DOCUMENT = "the manifest of golden data"
OWN = Path("golden")  # The folder in the working directory, unless another is named.
VECTORS = "vectors"  # A folder next to the scenes: test vectors, which another command verifies.
WORK = "golden build"  # The work that locks a folder.

Folder = str | os.PathLike[str] | None


def home() -> Path:
    """The folder of golden data: inside an installed package, in a checkout next to it."""
    return shipped("reference_data")


def in_checkout() -> bool:
    """True in a checkout, where the package's golden data may be built."""
    package = Path(__file__).resolve().parents[1]
    return (package.parent / "pyproject.toml").is_file() and home().parent == package.parent


def scenes(folder: Folder = None) -> list[str]:
    """Names of the scenes with golden data in ``folder``, by default in the package."""
    return sorted(path.parent.name for path in Path(folder or home()).glob(f"[!.]*/{MANIFEST}"))


def some(names: Iterable[str], folder: Folder = None) -> list[str]:
    """The names of scenes, at least one: a check without input is an error.

    Raises ``InputError``: there are none.
    """
    if not (chosen := list(names)):
        expected = "expected the folder of a scene; `tt-precise golden build` makes it"
        raise InputError(f"golden data: got none in {folder or home()}, {expected}")
    return chosen


def locate(scene: str | Path, folder: Folder = None) -> Path:
    """The folder of the golden data for a name, a scene's TOML file, or that folder itself.

    A folder is given by its path: a ``Path``, or text with a slash such as ``./mytop``. A bare name
    is sought in ``folder``, or in the package and then in ``golden``, nowhere else. The existence
    of the data is not checked.

    Raises ``InputError``: the name is not a possible name of a scene.
    """
    path = Path(scene)
    by_path = isinstance(scene, Path) or os.sep in scene
    if folder is None and by_path and (path / MANIFEST).is_file():
        return path.resolve()
    name = path.stem if path.suffix == ".toml" else str(scene)
    # no path, not hidden, printable
    if not re.fullmatch(r"\w[\w.-]{0,99}", name):
        raise InputError(f"scene: got the name {name[:60]!r}, expected letters, digits, - and _")
    if folder is not None:
        return Path(folder) / name
    own = (OWN / name / MANIFEST).is_file() and name not in scenes()
    return (OWN if own else home()) / name


def require(scene: str | Path, folder: Folder = None) -> Path:
    """Locate golden data; raise ``InputError`` if there are none."""
    path = locate(scene, folder)
    if not (path / MANIFEST).is_file():
        names = scenes(folder)
        also = "" if names else "none yet; `tt-precise golden build` makes it"
        raise wrong_name("golden data", str(scene), names, also)
    return path


@dataclass(frozen=True)
class Stored:
    """The golden data in the folder ``path`` of one scene; ``tables`` by file."""

    path: Path
    scene_text: str
    tables: dict[str, Table]
    manifest: dict[str, Json]

    @property
    def name(self) -> str:
        return self.path.name

    @property
    def trajectory(self) -> Table:
        return self.tables[TRAJECTORY]

    @property
    def events(self) -> Table:
        return self.tables[EVENTS]

    @cached_property
    def scene(self) -> Scene:
        return parse_scene(self.scene_text, self.name, f"{self.name}/{SCENE}")

    @cached_property
    def scales(self) -> dict[str, Decimal]:
        """The largest printed entry of each column; 0 for times."""
        return {**self.trajectory.scales, "t": Decimal(0)}


def read_files(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene`` (see ``locate``), without verifying their hashes.

    Raises ``InputError``: there are no such data, or a file is missing or unreadable.
    """
    from tt_precise.golden.documents import Manifest  # needed by those who read data only
    from tt_precise.runtime.records import read_as_record

    path = require(scene, folder)
    manifest = read_as_record(path / MANIFEST, Manifest, DOCUMENT)
    tables = {file: _table(path / file) for file in (TRAJECTORY, EVENTS)}
    return Stored(path, _text(path / SCENE), tables, manifest)


def read_whole(scene: str | Path, folder: Folder = None) -> Stored:
    """Read the golden data of ``scene`` once, and compare them with the hashes in their manifest.

    Raises ``InputError``: there are no such data, or they have changed since they were built.
    """
    path = require(scene, folder)
    return _whole(path.absolute(), _text(path / MANIFEST))


@lru_cache(maxsize=64)
def _whole(path: Path, manifest: str) -> Stored:
    stored = read_files(path.name, path.parent)
    for problem in changes(stored):
        again = f"`tt-precise golden verify {stored.name}` says where"
        raise InputError(f"{stored.name}: {problem}; {again}")
    return stored


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
    tables = {file: table.sha256 for file, table in stored.tables.items()}
    hashes = {SCENE: scene_sha256(stored.scene_text), **tables, PROOF: proof_sha256(stored.path)}
    listed = {file: entry["sha256"] for file, entry in stored.manifest["files"].items()}
    again = f"; run `tt-precise golden certify {stored.name}`"
    lines = []
    for file, sha256 in hashes.items():
        if sha256 is None and file in listed:
            lines.append(f"{file}: missing, but {MANIFEST} lists it{again}")
        elif sha256 is not None and file not in listed:
            lines.append(f"{file}: not listed in {MANIFEST}{again}")
        elif sha256 != listed.get(file):
            lines.append(f"{file}: changed since it was written; `git diff` may show where")
    return lines


def proof_sha256(path: Path) -> str | None:
    """Return the hash of the proof in a scene's folder; None without a proof, "" if not JSON."""
    if not (path / PROOF).is_file():
        return None
    try:
        return _json_hash(read_json(path / PROOF, "a proof"))
    except InputError:
        return ""


def record_proof(path: Path) -> None:
    """Write the hash of the proof in a scene's folder into its manifest.

    Raises ``InputError``: the manifest is missing or has another form.
    """
    manifest = read_files(path.name, path.parent).manifest
    files = {file: entry for file, entry in manifest["files"].items() if file != PROOF}
    if sha256 := proof_sha256(path):
        files[PROOF] = {"sha256": sha256}
    atomic_write(path / MANIFEST, json_text({**manifest, "files": files}))


def _table(path: Path) -> Table:
    text = _text(path)
    try:
        table = Table.parse(text)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    if path.name == TRAJECTORY and not table.rows:
        raise InputError(f"{path}: no row, expected one for each time")
    return table


def _text(path: Path) -> str:
    # A device or a pipe has no end; a link may lead anywhere, but for those of an installer.
    if (path.is_symlink() and home() not in path.parents) or (path.exists() and not path.is_file()):
        raise InputError(f"{path}: no regular file; expected golden data")
    try:
        return path.read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise InputError(f"{path}: {reason}; expected golden data") from None
