"""The folders of golden data: their documents, reading, and hashes that detect careless edits.

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
from typing import Annotated

from tt_precise.golden.table import FORMAT, Table
from tt_precise.runtime.files import atomic_write, parse_toml, read_json, shipped
from tt_precise.runtime.records import UNSET, Record, Unset, means, read_as_record
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

Sha256 = Annotated[str, means("SHA-256 of the content")]
SceneName = Annotated[str, means("name of the scene")]
Digits = Annotated[int | None, means("fewest significant digits; null if all are 0")]
Bits = Annotated[int, means("working precision in bits")]
Status = Annotated[str, means("how the trajectory ended")]
Versions = Annotated[dict[str, str], means("versions of the packages used")]
Agreement = float | str  # "equal" where nothing differs
TABLES = {"trajectory": TRAJECTORY, "events": EVENTS}


class ColumnClaims(Record, frozen=True, kw_only=True):
    """The meaning of a column of a golden table, and its claims."""

    unit: Annotated[str, means("SI unit")]
    meaning: Annotated[str, means("meaning, with the place in the paper")]
    digits: Digits
    scale: Annotated[str | Unset, means("largest absolute value of the column")] = UNSET
    near_zero: Annotated[int | Unset, means("entries near a zero, see rule")] = UNSET
    undefined: Annotated[int | Unset, means("entries without a value")] = UNSET
    agreement: Annotated[dict[str, Agreement] | Unset, means("digits shared with other runs")] = (
        UNSET
    )


class Hashed(Record, frozen=True):
    """A file."""

    sha256: Sha256


class TableClaims(Record, frozen=True, kw_only=True):
    """A golden table."""

    rows: Annotated[int, means("number of rows")]
    sha256: Sha256
    columns: Annotated[dict[str, ColumnClaims], means("the columns")]
    counts: Annotated[dict[str, int] | Unset, means("how often each event occurs")] = UNSET


class Files(Record, frozen=True, rename={**TABLES, "scene": SCENE, "proof": PROOF}):
    """The files of a scene, with their hashes."""

    scene: Annotated[Hashed, means("the scene")]
    trajectory: Annotated[TableClaims, means("samples")]
    events: Annotated[TableClaims, means("events")]
    proof: Annotated[Hashed | Unset, means("statements proved about the tables")] = UNSET


class Computation(Record, frozen=True, kw_only=True):
    """A run."""

    name: Annotated[str, means("name")]
    formulation: Annotated[str, means("coordinates: newton or euler")]
    bits: Bits
    status: Status
    rows: Annotated[int, means("number of rows")]
    order: Annotated[int | Unset, means("order of the Taylor method")] = UNSET
    tolerance: Annotated[str | Unset, means("relative tolerance")] = UNSET


class Evidence(Record, frozen=True, kw_only=True):
    """The evidence for the digits."""

    agreement: Annotated[Agreement, means("digits in which the runs agree")]
    runs: Annotated[list[Computation], means("the computations")]
    constant_over_printed_rows: Annotated[
        dict[str, Agreement], means("digits to which each integral is constant")
    ]
    events: Annotated[str, means("agreement of the runs on the events")]


class Manifest(Record, frozen=True, kw_only=True, tag_field="schema", tag=FORMAT):
    """`manifest.json` of a scene's golden data."""

    scene: SceneName
    title: Annotated[str, means("title of the scene")]
    source: Annotated[str, means("where the numbers come from")]
    model: Annotated[str, means("gliding, rolling or flight")]
    status: Status
    t_end: Annotated[str, means("end in s")]
    digits: Annotated[int, means("fewest significant digits of any column")]
    files: Annotated[Files, means("each file")]
    event_meanings: Annotated[dict[str, str], means("event to the function whose zero it is")]
    rule: Annotated[str, means("how digits are counted")]
    evidence: Annotated[Evidence, means("evidence for the digits")]
    versions: Versions


class Ball(Record, frozen=True):
    """An interval that contains the exact number."""

    middle: Annotated[str, means("middle of the interval")]
    radius: Annotated[str, means("radius of the interval")]


class ContactForce(Record, frozen=True, kw_only=True):
    """The proved statement about the contact force."""

    g_n_positive: Annotated[bool | str, means("whether g_n > 0 is proved")]
    g_n_at_least_mg: Annotated[str | Unset | None, means("lower bound of g_n in units of m g")] = (
        UNSET
    )
    energy_never_grows: Annotated[bool | Unset, means("whether it is proved")] = UNSET
    lost_at_s: Annotated[Ball | Unset, means("time of the loss of contact in s")] = UNSET


class ProvedClimb(Record, frozen=True):
    """The climb in one definition; null where there is none up to the horizon."""

    t_init: Annotated[Ball | None, means("initiation time in s")]
    t_end: Annotated[Ball | None, means("ending time in s")]


class Inversion(Record, frozen=True, kw_only=True):
    """Times of the climb, or the reason why nothing is proved about them."""

    failure: Annotated[str | Unset, means("reason why nothing is proved")] = UNSET
    equator: Annotated[
        Ball | Unset | None, means("first time at which theta crosses pi/2, in s")
    ] = UNSET
    A: Annotated[ProvedClimb | Unset, means("signed perigee")] = UNSET
    B: Annotated[ProvedClimb | Unset, means("L.k = L.z and L.k = -L.z")] = UNSET
    C: Annotated[ProvedClimb | Unset, means("change of sign of phi_dot")] = UNSET


class Neighbourhood(Record, frozen=True, kw_only=True):
    """A neighbourhood of a vertical spin that the solution is proved never to leave."""

    theta_tends_to: Annotated[str, means("limit of theta: 0 or pi")]
    since_s: Annotated[str, means("time in s from which the solution is in the neighbourhood")]
    g_n_at_least_mg: Annotated[str, means("lower bound of g_n from then on, in units of m g")]
    sin_theta_at_most: Annotated[str, means("bound of sin theta from then on")]
    limits: Annotated[dict[str, Ball], means("limits of the quantities, in SI")]


class ProofRecord(Record, frozen=True, tag_field="schema", tag="tt_precise.proof/5", rename=TABLES):
    """`proof.json`: what is proved about a scene's golden data."""

    scene: SceneName
    scene_sha256: Annotated[str, means("SHA-256 of the scene's content")]
    trajectory: Annotated[Hashed, means("the table of samples that was proved")]
    events: Annotated[Hashed, means("the table of events that was proved")]
    theorem: Annotated[str, means("place of the theorem")]
    bits: Bits
    steps: Annotated[int, means("verified steps")]
    entries: Annotated[int, means("compared printed numbers")]
    rounded: Annotated[int, means("printed numbers proved to be correctly rounded: all")]
    proved_events: Annotated[
        dict[str, int],
        means("number of occurrences of each event; each exists, and there is no other"),
    ]
    contact: Annotated[ContactForce, means("the proved statement about the contact force")]
    inversion: Annotated[Inversion, means("times of the climb")]
    forever: Annotated[
        dict[str, Neighbourhood | str],
        means("all later times: the first neighbourhood (held), the last (at_the_end); or failure"),
    ]
    conserved_within: Annotated[dict[str, str], means("bounds of the change of integrals")]
    versions: Versions
    code: Annotated[
        dict[str, str] | Unset, means("SHA-256 of the sources that a reader has to trust")
    ] = UNSET


PROOF_SCHEMA = str(ProofRecord.__struct_config__.tag)


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
