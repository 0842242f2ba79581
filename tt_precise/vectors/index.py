"""The files: test vectors and the index of all reference data, built and verified."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path

from tt_precise.golden import store
from tt_precise.golden.documents import Manifest
from tt_precise.golden.store import VECTORS
from tt_precise.runtime import records
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError
from tt_precise.vectors import states, steps
from tt_precise.vectors.documents import Index, Listed, States, Steps, Vectors

LICENCE = "MIT"
INDEX = "index.json"
FILES: dict[str, type[Vectors]] = {"states.json": States, "steps.json": Steps}
UNITS = {
    "m": "kg", "R": "m", "alpha": "1", "I1": "kg m^2", "I3": "kg m^2", "g": "m/s^2",
    "mu": "s/m for viscous, else 1", "epsilon": "m/s", "k": "1", "omega": "rad/s",
    "s_dot": "m/s", "quaternion": "1, body to inertial frame", "L": "kg m^2/s", "a": "m",
    "v_A": "m/s", "g_n": "N", "F": "N", "torque": "N m", "k_dot": "1/s", "L_dot": "N m",
    "stiffness": "N/m for linear, N/m^(3/2) for hunt-crossley",
    "damping": "N s/m for linear, s/m for hunt-crossley",
    "height": "m, of the lowest point above the table",
    "omega_dot": "rad/s^2", "s_ddot": "m/s^2", "v_A_dot": "m/s^2", "step_s": "s",
}  # fmt: skip
FORCES = {
    **{name: law.force for name, law in states.GLIDING.items()},
    "sticking": "v_A = 0, by a force of which |F_t| <= mu g_n",
    "rolling": "v_A = 0, by whatever force it takes",
    "none": "free flight, F = 0",
    "rigid": "g_n keeps the contact on the table: the vertical part of v_A_dot is 0",
    "linear": "g_n = max(0, stiffness delta + damping delta_dot) where delta = -height > 0, else 0",
    "hunt-crossley": "g_n = stiffness delta^(3/2) max(0, 1 + damping delta_dot) where "
    "delta = -height > 0, else 0",
}
KINDS = {
    store.SCENE: ("scene", "exact decimals and fractions"),
    store.TRAJECTORY: ("trajectory", "decimal strings"),
    store.EVENTS: ("events", "decimal strings"),
    store.MANIFEST: ("manifest", "units, digits and evidence of the scene's files"),
    "proof.json": ("proof", "what is proved of the digits"),
    "enclosure.csv": ("enclosure", "balls around the exact numbers of the trajectory"),
    "events-enclosure.csv": ("enclosure", "balls around the exact numbers of the events"),
    "certificate.json.xz": ("certificate", "the steps of a proof, for a checker of its own"),
}


def build(folder: Path, progress: Progress = silent) -> list[Path]:
    """Compute the test vectors and write them, and the index of the whole ``folder``.

    Raises ``InputError``: there are no golden data in ``folder``; this is checked before the work.
    """
    _scenes(folder)
    place = folder / VECTORS
    place.mkdir(parents=True, exist_ok=True)
    for name, text in vector_texts(progress).items():
        atomic_write(place / name, text)
    atomic_write(folder / INDEX, index_text(folder))
    return [*(place / name for name in FILES), folder / INDEX]


def verify(folder: Path, progress: Progress = silent) -> list[str]:
    """A line for each problem of the committed vectors and the index, after recomputing."""
    problems = list(stale(folder))
    for name, text in vector_texts(progress).items():
        file = folder / VECTORS / name
        if not file.is_file():
            problems.append(f"{VECTORS}/{name}: missing")
        elif file.read_text("utf-8") != text:
            problems.append(f"{VECTORS}/{name}: differs from what is computed now")
    return problems


def stale(folder: Path) -> Iterator[str]:
    """Differences between the index and the files.

    Raises ``InputError``: there are no golden data in ``folder``.
    """
    _scenes(folder)
    file = folder / INDEX
    if not file.is_file():
        yield f"{INDEX}: missing; tt-precise golden vectors --build makes it"
        return
    try:
        listed = {entry.path: entry for entry in records.load(file, Index, "the index").files}
    except InputError:
        yield f"{INDEX}: no index; tt-precise golden vectors --build makes it"
        return
    present = {entry.path: entry for entry in entries(folder)}
    for path in sorted(listed.keys() - present.keys()):
        yield f"{path}: listed in {INDEX}, and missing"
    for path in sorted(present.keys() - listed.keys()):
        yield f"{path}: not listed in {INDEX}"
    for path in sorted(listed.keys() & present.keys()):
        if listed[path] != present[path]:
            yield f"{path}: not as {INDEX} says"
    if listed == present and file.read_text("utf-8") != index_text(folder):
        yield f"{INDEX}: differs from a fresh index, except in its files"
    for path in sorted(_files(folder) - present.keys() - {INDEX, "README.md"}):
        yield f"{path}: no file of the reference data"


def _files(folder: Path) -> set[str]:
    files = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {path.as_posix() for path in files if not any(part[0] == "." for part in path.parts)}


def vector_texts(progress: Progress = silent) -> dict[str, str]:
    """Name to content of the two vector files."""
    first = {
        "meaning": "seeded states under every law of friction and contact, and each term of the "
        "equations of motion there; k is the body's third axis, s the centre of mass, a from it "
        "to the contact. What is expected of an invalid case is wrong, by the mistake that its "
        "last flag names: a comparison that passes it looks at nothing",
        "cases": states.state_file(),
    }
    second = {
        "meaning": "the states of states.json after one step of the given length",
        "cases": steps.step_file(progress),
    }
    head = {
        "licence": LICENCE,
        "digits": states.DIGITS,
        "units": UNITS,
        "forces": FORCES,
        "frame": "inertial, z up, the table at z = 0",
    }
    texts = {}
    for (name, kind), own in zip(FILES.items(), (first, second), strict=True):
        content = {"schema": kind.__struct_config__.tag, **head, **own}
        texts[name] = records.encode(records.record_of(content, kind, name, "test vectors"))
    return texts


def index_text(folder: Path) -> str:
    """The index as JSON: every file of the reference data."""
    units = "SI; of every column in the scene's manifest.json, of vectors in the files"
    return records.encode(Index(licence=LICENCE, units=units, files=list(entries(folder))))


def entries(folder: Path) -> Iterator[Listed]:
    """An entry for each file, in order.

    Raises ``InputError``: there are no golden data in ``folder``, or a file lacks its metadata.
    """
    for name in _scenes(folder):
        place = folder / name
        manifest = records.load(place / store.MANIFEST, Manifest, "the manifest of golden data")
        for file in sorted(place.iterdir()):
            if file.name in KINDS:
                kind, content = KINDS[file.name]
                yield _entry(folder, file, kind, content, name, manifest.digits)
    for name in FILES:
        file = folder / VECTORS / name
        if file.is_file():
            content = "inputs and expected values, decimal strings"
            yield _entry(folder, file, "vectors", content, None, states.DIGITS)


def _scenes(folder: Path) -> list[str]:
    names = store.scenes(folder)
    if not names:
        raise InputError(f"folder: got {folder}, expected one with golden data")
    return names


def _entry(
    folder: Path, file: Path, kind: str, content: str, scene: str | None, digits: int
) -> Listed:
    # a table names no schema
    schema = f"tt_precise.{kind}/1"
    if file.suffix == ".json":
        what = "a file of the reference data"
        with records.of_its_form(file, what):
            schema = records.read(file, what)["schema"]
    sha256 = hashlib.sha256(file.read_bytes()).hexdigest()
    path = file.relative_to(folder).as_posix()
    return Listed(path, sha256, LICENCE, kind, content, scene, schema, digits)
