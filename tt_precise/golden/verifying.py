"""``verify``: golden data against their manifest, their proof and a fresh computation.

``inspect`` names every damage to the files, and computes nothing. ``verify_scene`` also computes
the solution with another integrator than that of the data, and compares entry by entry.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path

import numpy

from tt_precise.golden import proofs, store
from tt_precise.golden.building import derive
from tt_precise.golden.runs import BITS, GoldenRun, columns, exact_decimal, perform
from tt_precise.golden.solution import relative_errors
from tt_precise.golden.store import EVENTS, MANIFEST, PROOF, SCENE, TRAJECTORY, Folder, Stored
from tt_precise.golden.table import LABELS, Table, correct_digits, malformed_cells, prints
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Json
from tt_precise.runtime.workers import Call, Failure, local_pool
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.scene.scene import shipped as shipped_scenes

FRESH_DIGITS = 28  # A fresh computation confirms so many digits of data with a proof.
# The precision of the fresh computation, by another integrator than the data's if possible.
FINE, WHERE_REFUSED = "triple-double", "quad"
WORDS = ("meaning", "event_meanings")  # Their wording may change from version to version.
FEW = 3  # Reported problems of the same kind.


@dataclass(frozen=True)
class Verification:
    """The result for one scene.

    ``problems`` is empty for valid data. ``digits_proved`` are the digits of a valid proof, None
    without one. ``digits_found`` is the fewest digits in which the fresh computation, in the
    arithmetic ``fresh``, agrees with the data; None where nothing could be compared.
    """

    scene: str
    digits_claimed: int | None
    digits_found: float | None = None
    fresh: str = ""
    problems: tuple[str, ...] = ()
    digits_proved: int | None = None

    @property
    def verdict(self) -> str:
        return "fail" if self.problems else "pass"


def verify(
    scenes: Iterable[str | Path] | None = None,
    *,
    folder: Folder = None,
    workers: int | None = None,
    progress: Progress = silent,
) -> list[Verification]:
    """Verify golden data, by default all: hashes, proofs and a fresh computation of each.

    A fresh computation must have the same events. It must confirm 28 digits of every proved number,
    and all printed digits of every other number. Digits count as in ``mechanics.digits``.

    Raises ``InputError``: the data do not exist.
    """
    if scenes is None:  # every folder, readable or not
        paths = sorted(x for x in Path(folder or store.home()).glob("[!.]*/") if x.is_dir())
        paths = [path for path in paths if path.name != store.VECTORS]
    else:
        paths = [store.locate(scene, folder) for scene in scenes]
        paths = [path if path.is_dir() else store.require(path.name, folder) for path in paths]
    store.some((path.name for path in paths), folder)
    verified: dict[Path, Verification] = {}
    with local_pool(workers) as pool:
        calls = [Call(path, (path,)) for path in dict.fromkeys(paths)]
        for call, result in pool.perform(verify_scene, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            verified[call.key] = result
    return [verified[path] for path in dict.fromkeys(paths)]


def verify_scene(path: Path) -> Verification:
    """Verify the data in the folder of one scene.

    Without a proof, and where the scene magnifies errors so far that the fresh computation keeps
    less than 28 digits, a run with the bits of the data must confirm every digit.
    """
    from tt_precise.integration.setup import refused_in_doubles

    stored, problems = inspect(path)
    if stored is None:
        return Verification(path.name, None, problems=tuple(problems))
    proved = (proofs.summary(stored) or {}).get("digits")
    claimed, scene = stored.manifest["digits"], stored.scene
    digits, label, contradictions = None, "", list[str]()
    try:
        if proved is not None:
            run = perform(scene, WHERE_REFUSED if refused_in_doubles(scene) else FINE)
            label, (digits, contradictions) = run.label, judge(stored, run)
        if proved is None or (not problems and digits is not None and digits < FRESH_DIGITS):
            run = perform(scene, "mp", _bits(stored))
            label, (digits, contradictions) = run.label, judge(stored, run, every_digit=True)
    except (InputError, ArithmeticError) as error:
        problems.append(f"no fresh computation: {error}")
    return Verification(path.name, claimed, digits, label, (*problems, *contradictions), proved)


def _bits(stored: Stored) -> int:
    """The bits of the coarsest run of the data, within those of ``build``."""
    least = min((run["bits"] for run in stored.manifest["evidence"]["runs"]), default=0)
    return min(max(least, BITS[0][0]), BITS[-1][1])


def judge(
    stored: Stored, run: GoldenRun, *, every_digit: bool = False
) -> tuple[float | None, list[str]]:
    """The fewest digits in which a fresh ``run`` agrees with the data, and the contradictions.

    The run must confirm 28 digits of each entry; with ``every_digit`` all that are printed.
    """
    status, problems = stored.manifest["status"], list[str]()
    if run.status != status:
        problems.append(f"status: {run.label} ends {run.status}, the manifest says {status}")
    fewest: list[float] = []
    for file, golden in stored.tables.items():
        fresh = run.tables[file]
        if len(fresh.rows) != len(golden.rows):
            problems.append(f"{file}: {len(golden.rows)} rows, a fresh one has {len(fresh.rows)}")
        if fresh.columns != golden.columns:
            problems.append(f"{file}: has other columns than a fresh computation")
            continue
        count = min(len(golden.rows), len(fresh.rows))
        golden, fresh = (Table(table.columns, table.rows[:count]) for table in (golden, fresh))
        problems += _other_cells(stored, file, golden, fresh, every_digit)
        cells = {name: golden.column(name) for name in golden.numbers}
        numbers = {name: numpy.array(fresh.floats(name)) for name in golden.numbers}
        errors = relative_errors(stored.scene, cells, numbers, fresh.cells)
        for name in golden.numbers:
            if numpy.isnan(errors[name]).all():
                continue
            row = int(numpy.nanargmax(errors[name]))
            digits = correct_digits(float(errors[name][row]))
            fewest.append(digits)
            if digits < FRESH_DIGITS:
                problems.append(
                    f"{file}, line {row + 2}, {name}: {run.label} agrees to {digits:.1f} digits, "
                    f"expected {FRESH_DIGITS}"
                )
    if not fewest:
        return None, [*problems, f"{run.label}: no entry could be compared, expected all of them"]
    confirmed = every_digit and not problems
    return float(stored.manifest["digits"]) if confirmed else min(fewest), problems


def _other_cells(
    stored: Stored, file: str, golden: Table, fresh: Table, every_digit: bool
) -> Iterator[str]:
    """The first cell of each column that a fresh computation contradicts, whatever its size."""
    for name in golden.columns:
        exact = file == TRAJECTORY and name == "t"
        pairs = zip(golden.column(name), fresh.column(name), strict=True)
        for row, (cell, other) in enumerate(pairs):
            if name in LABELS:
                wrong = cell != other
            elif not cell:
                wrong = bool(other) and not _at_pole(golden, row)
            else:
                rounded = other and prints(cell, Decimal(other), stored.scales[name])
                wrong = every_digit and not (exact or rounded)
            if wrong:
                what = f"got {cell or 'nothing'}, a fresh computation has {other or 'nothing'}"
                yield f"{file}, line {row + 2}, {name}: {what}"
                break


def _at_pole(table: Table, row: int) -> bool:
    """True if the axis is vertical to all verified digits: its azimuth is undefined."""
    axis = (table.column(name)[row] for name in ("kx", "ky"))
    return all(abs(Decimal(cell or 1)) < Decimal(10) ** -FRESH_DIGITS for cell in axis)


def inspect(name: str | Path, folder: Folder = None) -> tuple[Stored | None, list[str]]:
    """Read the golden data of ``name``; returns them and a line for each problem of the files.

    The data are None if they cannot be read or compared.
    """
    try:
        stored = store.read_files(name, folder)
        scene = stored.scene
        changed = store.changes(stored)
    except InputError as error:
        return None, [str(error)]
    expected = columns(scene)
    columns_of = {TRAJECTORY: expected, EVENTS: ("name", "t", "direction", *expected[1:])}
    damaged = []
    for file, table in stored.tables.items():
        if table.columns != columns_of[file]:
            names = ",".join(columns_of[file])
            damaged.append(f"{file}: columns are {','.join(table.columns)}, expected {names}")
        damaged += malformed_cells(file, table)[:FEW]
    if damaged:
        return None, [*damaged, *changed]
    problems = [*_other_times(scene, stored)]
    ships = stored.path.parent.resolve() == store.home().resolve()
    if ships and stored.name in shipped_scenes() and scene != load_scene(stored.name):
        problems.append(f"{SCENE}: another scene than the {stored.name} that ships")
    problems += [line for line in changed if not line.startswith(PROOF)]
    if not any(line.startswith((TRAJECTORY, EVENTS)) for line in problems):
        stated = derive(scene, stored.scene_text, stored.tables)
        problems += _differences(stated, stored.manifest, MANIFEST)
    try:
        proofs.read_proof(stored)
        problems += [line for line in changed if line.startswith(PROOF)]
    except InputError as error:
        problems.append(str(error))
    return stored, problems


def _other_times(scene: Scene, stored: Stored) -> Iterator[str]:
    """The first row at another time than the scene's samples, or a missing end."""
    printed = stored.trajectory.column("t")
    expected: Iterator[str | None] = map(exact_decimal, scene.sample_times)
    if stored.manifest["status"] != "complete":  # the end is computed
        printed, expected = printed[:-1], itertools.islice(expected, len(printed) - 1)
    for mine, sample in itertools.zip_longest(printed, expected, fillvalue="nothing"):
        if sample not in (None, mine):
            yield f"{TRAJECTORY}: got a row of t = {mine}, expected t = {sample}"
            break


def _differences(derived: Json, stated: Json, where: str) -> Iterator[str]:
    """Differences between the manifest and the statements that follow from the data."""
    if isinstance(derived, dict) and isinstance(stated, dict):
        for key, value in derived.items():
            if key not in WORDS:
                yield from _differences(value, stated.get(key), f"{where}: {key}" if key else where)
    elif derived != stated:
        yield f"{where} is {str(stated)[:50]!r}, the data say {str(derived)[:50]!r}"
