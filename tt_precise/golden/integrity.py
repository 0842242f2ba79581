"""What a scene's golden files say of themselves: every damage to them, named, without computing."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

from tt_precise.golden import proofs, store
from tt_precise.golden.consensus import exact_decimal
from tt_precise.golden.invariants import CONSTANT_TO, constancies
from tt_precise.golden.manifest import SCHEMA, SELF_HASH, derive, scene_sha256, self_hash
from tt_precise.golden.places import Folder, home
from tt_precise.golden.printed_cells import misprinted
from tt_precise.golden.runs import columns
from tt_precise.golden.seal import missing_keys, missing_proof
from tt_precise.golden.store import EVENTS, MANIFEST, SCENE, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Json
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.scene.scene import shipped as shipped_scenes

WORDS = ("meaning", "event_meanings")  # their wording may change from version to version
FEW = 3  # of many equal problems so many are reported


def inspect(name: str | Path, folder: Folder = None) -> tuple[Stored | None, list[str]]:
    """Read the golden data of ``name``; what is wrong with the files, a line each.

    The data are None where they cannot be read at all, or hold what is no number.
    """
    try:
        stored = store.read(name, folder)
        scene = stored.scene
    except InputError as error:
        return None, [str(error)]
    problems = _problems_of_manifest(stored)
    if scene_sha256(stored.scene_text) != _stated(stored, SCENE).get("sha256"):
        problems.append(f"{SCENE}: says something else than when the data were built")
    problems += _another_scene(stored)
    expected = columns(scene)
    wanted = {TRAJECTORY: expected, EVENTS: ("name", "t", "direction", *expected[1:])}
    damaged = []
    for file, names in wanted.items():
        damaged += list(_problems_of_table(scene, file, stored.table(file), names, stored))
    problems += damaged
    if any(misprinted(file, stored.table(file), empty=False) for file in wanted):
        return None, problems
    if not damaged:
        stated = derive(scene, stored.trajectory, stored.events)
        problems += _differences(stated, stored.manifest, MANIFEST)
        problems += _inconstant(scene, stored.trajectory)
    if not problems and stored.manifest[SELF_HASH] != self_hash(stored.manifest):
        problems.append(
            f"{MANIFEST}: edited after it was built, in a value that the data do not determine "
            "(title, source, rule, evidence, versions, history or row_marks)"
        )
    return stored, problems + _problems_of_proof(stored)


def _another_scene(stored: Stored) -> list[str]:
    """Data that ship are of the scene that ships under their name."""
    if stored.folder.resolve() != home().resolve() or stored.name not in shipped_scenes():
        return []
    same = stored.scene == load_scene(stored.name)
    return [] if same else [f"{SCENE}: another scene than the {stored.name} that ships"]


def _problems_of_proof(stored: Stored) -> list[str]:
    try:
        record = proofs.read(stored.name, stored.folder)
    except InputError as error:
        return [str(error)]
    complaints = proofs.complaints(stored, record) if record else []
    return complaints or missing_proof(stored)


def _problems_of_manifest(stored: Stored) -> list[str]:
    manifest = stored.manifest
    missing = missing_keys(manifest)
    if missing:
        return [f"{MANIFEST}: {', '.join(missing)} missing, expected to be there"]
    stated = {"schema": SCHEMA, "scene": stored.name, "model": stored.scene.model}
    return [
        f"{MANIFEST}: {key} is {manifest[key]!r}, expected {value!r}"
        for key, value in stated.items()
        if manifest[key] != value
    ]


def _problems_of_table(
    scene: Scene, file: str, table: Table, names: tuple[str, ...], stored: Stored
) -> Iterator[str]:
    if table.columns != names:
        yield f"{file}: columns are {','.join(table.columns)}, expected {','.join(names)}"
        return
    stated = _stated(stored, file)
    bad = misprinted(file, table)
    yield from bad[:FEW]
    if file == TRAJECTORY and not bad:
        yield from _missing_times(scene, table, stored.manifest.get("status"))
    if table.sha256 != stated.get("sha256"):
        marks = stored.manifest.get("row_marks")
        stated_marks = marks.get(file) if isinstance(marks, dict) else ""
        yield from _changes(file, table, stated, str(stated_marks))


def _missing_times(scene: Scene, table: Table, status: Json) -> Iterator[str]:
    times = table.column("t")
    if times and status != "complete":
        times = times[:-1]
    for expected, found in zip(map(exact_decimal, scene.sample_times), times, strict=False):
        if expected is not None and found != expected:
            later = Decimal(found) > Decimal(expected)
            what = "is missing" if later else "is expected"
            yield f"{TRAJECTORY}: the row of t = {expected} {what}, there stands t = {found}"
            return
    if status == "complete" and len(times) < len(scene.sample_times):
        yield f"{TRAJECTORY}: ends at t = {times[-1] if times else 'no row'}, before the horizon"


def _changes(file: str, table: Table, stated: dict[str, Json], marks: str) -> Iterator[str]:
    """Where a table whose hash is wrong was changed."""
    before = [marks[i : i + 4] for i in range(0, len(marks), 4)]
    now = [table.row_marks[i : i + 4] for i in range(0, len(table.row_marks), 4)]
    if len(before) != len(now):
        line = next((i for i, (a, b) in enumerate(zip(before, now, strict=False)) if a != b), None)
        at = min(len(before), len(now)) if line is None else line
        yield f"{file}: {len(now)} rows, expected {len(before)}; the first change at line {at + 2}"
        return
    hashes = {n: stated.get("columns", {}).get(n, {}).get("sha256") for n in table.columns}
    changed = [n for n in table.columns if table.column_sha256(n) != hashes[n]]
    swapped = [
        f"{file}: columns {a} and {b} are swapped"
        for i, a in enumerate(changed)
        for b in changed[i + 1 :]
        if table.column_sha256(a) == hashes[b] and table.column_sha256(b) == hashes[a]
    ]
    if swapped:
        yield from swapped
        return
    lines = [i + 2 for i, (a, b) in enumerate(zip(before, now, strict=True)) if a != b]
    places = ", ".join(f"line {line}" for line in lines[:FEW]) + (" ..." if lines[FEW:] else "")
    if changed and lines:
        yield f"{file}: changed since it was built: {places}, column {', '.join(changed)}"
    else:
        yield f"{file}: its hash differs from the one in {MANIFEST}"


def _differences(derived: Json, stated: Json, where: str) -> Iterator[str]:
    """Where the manifest states something else than follows from the data."""
    if isinstance(derived, dict) and isinstance(stated, dict):
        for key, value in derived.items():
            if key in WORDS:
                continue
            yield from _differences(value, stated.get(key), f"{where}: {key}" if key else where)
    elif derived != stated:
        yield f"{where} is {str(stated)[:50]!r}, the data say {str(derived)[:50]!r}"


def _inconstant(scene: Scene, trajectory: Table) -> Iterator[str]:
    for one in constancies(scene, trajectory):
        if one.digits < CONSTANT_TO:
            yield (
                f"{TRAJECTORY}: {one.name} is constant to {one.digits:.1f} digits, expected "
                f"{CONSTANT_TO}; worst in line {one.worst_row + 2}"
            )


def _stated(stored: Stored, file: str) -> dict[str, Json]:
    files = stored.manifest.get("files")
    stated = files.get(file) if isinstance(files, dict) else None
    return stated if isinstance(stated, dict) else {}
