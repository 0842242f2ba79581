"""``verify``: golden data against their manifest, their proof and a fresh computation.

``inspect`` names every damage to the files, and computes nothing. ``verify_scene`` also computes
the solution with another integrator than that of the data, and compares entry by entry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

from tt_precise.golden import proofs, store
from tt_precise.golden.building import CONSTANT_TO, constancies, derive
from tt_precise.golden.digits import correct_digits, malformed_cells, prints
from tt_precise.golden.measuring import apart_of
from tt_precise.golden.runs import (
    LADDER,
    GoldenRun,
    Task,
    columns,
    exact_decimal,
    ordered_events,
    perform,
)
from tt_precise.golden.store import (
    EVENTS,
    MANIFEST,
    PROOF,
    SCENE,
    TRAJECTORY,
    Folder,
    Located,
    Stored,
)
from tt_precise.golden.table import Table
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion, jellett
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, InputError, Json
from tt_precise.runtime.workers import Call, Failure, local_pool
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.scene.scene import shipped as shipped_scenes

FRESH_DIGITS = 28  # A fresh computation confirms so many digits of data with a proof.
DIGITS_PER_BIT = math.log10(2)
# The precision of the fresh computation, by another integrator than the data's if possible.
FINE, WHERE_REFUSED = "triple-double", "quad"

# A scene loses the same digits in every arithmetic. Where the fresh computation has less than 28
# left, the scene is computed with as many bits as it needs, at most with those of the golden data.
SPARE_BITS = 4
MOST_BITS = max(LADDER[0])
# Data without a proof are computed with so many bits, which have to confirm every printed digit.
ALL_BITS = min(LADDER[0])

WORDS = ("meaning", "event_meanings")  # Their wording may change from version to version.
FEW = 3  # Reported problems of the same kind.


class WorstEntry(NamedTuple):
    """The entry of a column with the fewest correct digits."""

    file: str
    row: int
    column: str
    digits: float

    def __str__(self) -> str:
        return f"{self.file}, line {self.row + 2}, {self.column}"


@dataclass(frozen=True)
class Verification:
    """The result for one scene.

    ``problems`` is empty for valid data. ``digits_proved`` are the digits of a valid proof of the
    data, None without one. ``digits_found`` is the fewest digits in which the fresh computation, in
    the arithmetic ``fresh``, agrees with the data; None where nothing could be computed or
    compared.
    """

    scene: str
    digits_claimed: int | None
    digits_found: float | None = None
    fresh: str = ""
    problems: tuple[str, ...] = field(default=())
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

    Raises
    ------
    InputError
        The data do not exist.
    """
    located = {place.name: place.folder for place in scenes_to_verify(scenes, folder)}
    calls = [Call(name, (name, located[name])) for name in store.some(located, folder)]
    verified: dict[str, Verification] = {}
    with local_pool(workers) as pool:
        for call, result in pool.perform(verify_scene, calls, progress):
            if isinstance(result, Failure):
                raise result.error
            verified[call.key] = result
    return [verified[name] for name in located]


def verify_scene(name: str, folder: Path) -> Verification:
    """Verify the data of one scene."""
    stored, problems = inspect(name, folder)
    if stored is None:
        return Verification(name, None, problems=tuple(problems))
    proved = (proofs.summary(stored, folder) or {}).get("digits")
    try:
        verification = recompute(stored, problems, proved is not None)
    except (InputError, ArithmeticError) as error:
        problems.append(f"no fresh computation: {error}")
        verification = Verification(name, stored.manifest["digits"], problems=tuple(problems))
    return replace(verification, digits_proved=proved)


def recompute(stored: Stored, problems: Sequence[str], proved: bool) -> Verification:
    """Compute the tables again and compare them, in every digit if there is no proof."""
    if not proved:
        return judge(stored, problems, perform(_in_mp(stored, ALL_BITS)), every_digit=True)
    run = perform(_fine(stored))
    verification = judge(stored, problems, run)
    digits = verification.digits_found
    if digits is not None and digits < FRESH_DIGITS and not problems:
        bits = bits_needed(digits, run.bits)
        if bits is not None:
            return judge(stored, problems, perform(_in_mp(stored, bits + SPARE_BITS)))
    return verification


def scenes_to_verify(scenes: Iterable[str | Path] | None, folder: Folder) -> list[Located]:
    """The folders of the data; by default every folder, readable or not, and the known scenes."""
    if scenes is not None:
        places = [store.locate(scene, folder) for scene in scenes]
        missing = [wanted for wanted in places if not wanted.path.is_dir()]
        return places if not missing else [store.require(missing[0].name, folder)]
    place = store.home() if folder is None else Path(folder)
    names = {entry.name for entry in place.iterdir() if entry.is_dir()} if place.is_dir() else set()
    names = {name for name in names if not name.startswith(".")} - {store.VECTORS}
    return [Located(name, place) for name in sorted(names)]


def bits_needed(digits: float, bits: int) -> int | None:
    """The bits with which a fresh computation keeps 28 digits; None if that is impossible.

    ``digits`` are the digits on which a computation with ``bits`` agrees with the data.
    """
    needed = bits + math.ceil((FRESH_DIGITS - digits) / DIGITS_PER_BIT)
    return needed if needed + SPARE_BITS <= MOST_BITS else None


def judge(
    stored: Stored, problems: Sequence[str], run: GoldenRun, *, every_digit: bool = False
) -> Verification:
    """Return the verdict of a fresh ``run`` on data with these ``problems`` in their files.

    With ``every_digit`` the run must confirm all printed digits, not only 28.
    """
    complaints = list(problems)
    status = stored.manifest["status"]
    if run.status != status:
        complaints.append(f"status: {run.label} ends {run.status}, the manifest says {status}")
    fresh = {TRAJECTORY: run.trajectory, EVENTS: _events_table(run)}
    worst = [
        entry
        for file, table in fresh.items()
        for entry in _worst_cells(stored, file, table, complaints)
    ]
    complaints += [
        f"{entry}: {run.label} agrees to {entry.digits:.1f} digits, expected {FRESH_DIGITS}"
        for entry in worst
        if entry.digits < FRESH_DIGITS
    ]
    digits = min((entry.digits for entry in worst), default=None)
    if digits is None:
        complaints.append(f"{run.label}: no entry could be compared, expected all of them")
    if every_digit and digits is not None:
        other = [
            line for file, table in fresh.items() for line in _other_digits(stored, file, table)
        ]
        complaints += [f"{line}, {run.label} rounds otherwise" for line in other[:FEW]]
        if not other:
            digits = float(stored.manifest["digits"])
    claimed = stored.manifest["digits"]
    return Verification(stored.name, claimed, digits, run.label, tuple(complaints))


def _other_digits(stored: Stored, file: str, fresh: Table) -> Iterator[str]:
    """Name the cells that differ from the fresh numbers after rounding to the printed digits."""
    golden = stored.table(file)
    for name in golden.columns:
        if name in ("name", "direction") or (name == "t" and file == TRAJECTORY):
            continue
        pairs = zip(golden.column(name), fresh.column(name), strict=False)
        for row, (cell, text) in enumerate(pairs):
            if cell and not prints(cell, Decimal(text), stored.scales[name]):
                yield str(WorstEntry(file, row, name, 0))


def _fine(stored: Stored) -> Task:
    """Return the fresh computation of proved data, if possible by another integrator."""
    from tt_precise.integration.setup import refused_in_doubles

    precision = WHERE_REFUSED if refused_in_doubles(stored.scene) else FINE
    return Task(stored.name, stored.scene_text, precision, None, "newton")


def _in_mp(stored: Stored, bits: int) -> Task:
    return Task(stored.name, stored.scene_text, "mp", bits, "newton")


def _worst_cells(stored: Stored, file: str, fresh: Table, problems: list[str]) -> list[WorstEntry]:
    """The worst defined entry of each column, over the rows of both tables."""
    golden = stored.table(file)
    if len(fresh.rows) != len(golden.rows):
        problems.append(f"{file}: {len(golden.rows)} rows, a fresh one has {len(fresh.rows)}")
    if golden.columns != fresh.columns:
        differ = set(golden.columns) ^ set(fresh.columns)
        which = ", ".join(sorted(differ)) or "their order"
        problems.append(f"{file}: has other columns than a fresh computation: {which}")
        return []
    for label in ("name", "direction"):
        if label not in golden.columns:
            continue
        pairs = zip(golden.column(label), fresh.column(label), strict=False)
        for row, (mine, other) in enumerate(pairs):
            if mine != other:
                line = f"{file}, line {row + 2}, {label}"
                problems.append(f"{line}: got {mine}, a fresh computation has {other}")
                return []
    sizes_by_name, worst = column_sizes(stored, golden), []
    for name in golden.columns:
        if name in ("name", "direction"):
            continue
        cells = golden.column(name)
        values = fresh.column(name)
        both = enumerate(zip(values, cells, strict=False))
        blank = [row for row, (mine, cell) in both if mine and not cell]
        wrongly = next((row for row in blank if not _at_pole(golden, row)), None)
        if wrongly is not None:
            line = f"{file}, line {wrongly + 2}, {name}"
            problems.append(f"{line}: is empty, a fresh computation has a number")
        if any(cells[: len(values)]):
            errors = cell_errors(cells, values, sizes_by_name[name])
            row = int(errors.argmax())
            worst.append(WorstEntry(file, row, name, correct_digits(float(errors[row]))))
    return worst


def _at_pole(table: Table, row: int) -> bool:
    """True if the axis is vertical to all verified digits: its azimuth is undefined."""
    cells = (table.column(name)[row] for name in ("kx", "ky"))
    return all(abs(Decimal(cell or 1)) < Decimal(10) ** -FRESH_DIGITS for cell in cells)


def _events_table(run: GoldenRun) -> Table:
    names = run.trajectory.columns
    rows = [(name, t, str(way), *state) for name, way, (t, *state) in ordered_events(run)]
    return Table(("name", "t", "direction", *names[1:]), tuple(rows))


def inspect(name: str | Path, folder: Folder = None) -> tuple[Stored | None, list[str]]:
    """Read the golden data of ``name``; returns them and a line for each problem of the files.

    The data are None if they cannot be read or contain text that is not a number.
    """
    try:
        stored = store.read_files(name, folder)
        scene = stored.scene
    except InputError as error:
        return None, [str(error)]
    problems = _problems_of_manifest(stored)
    changed = [line for line in store.changes(stored) if not line.startswith(PROOF)]
    expected = columns(scene)
    wanted = {TRAJECTORY: expected, EVENTS: ("name", "t", "direction", *expected[1:])}
    damaged = [
        problem
        for file, names in wanted.items()
        for problem in _problems_of_table(scene, file, stored.table(file), names, stored)
    ]
    problems += damaged
    problems += changed
    if any(malformed_cells(file, stored.table(file), empty=False) for file in wanted):
        return None, problems
    if not damaged and not any(line.startswith((TRAJECTORY, EVENTS)) for line in changed):
        stated = derive(scene, stored.trajectory, stored.events)
        problems += _differences(stated, stored.manifest, MANIFEST)
        for integral in constancies(scene, stored.trajectory):
            cancelled = _cancelled(stored) if integral.name.startswith("jellett") else 0
            if integral.digits < CONSTANT_TO - cancelled:
                problems.append(
                    f"{TRAJECTORY}: {integral.name} is constant to {integral.digits:.1f} digits, "
                    f"expected {CONSTANT_TO - cancelled}; worst in line {integral.worst_row + 2}"
                )
    return stored, problems + _problems_of_proof(stored)


def _cancelled(stored: Stored) -> int:
    """The whole digits that cancel in the sum lambda at the start."""
    start = (stored.trajectory.floats(name)[0] for name in NewtonState._fields)
    q = Motion(stored.scene.body.numbers(float), NewtonState(*start), math)
    lambda_, terms = abs(jellett(q)), q.body.R * math.hypot(*q.state.L)
    return int(math.log10(terms / lambda_)) if 0 < lambda_ < terms else 0


def _problems_of_proof(stored: Stored) -> list[str]:
    try:
        record = proofs.read_proof(stored.name, stored.folder)
    except InputError as error:
        return [str(error)]
    complaints = proofs.complaints(stored, record) if record else []
    return complaints or [line for line in store.changes(stored) if line.startswith(PROOF)]


def _problems_of_manifest(stored: Stored) -> list[str]:
    manifest = stored.manifest
    scene = stored.scene
    stated = {
        "scene": stored.name, "model": scene.model, "title": scene.title, "source": scene.source
    }  # fmt: skip
    problems = [
        f"{MANIFEST}: {key} is {manifest[key]!r}, expected {value!r}"
        for key, value in stated.items()
        if manifest[key] != value
    ]
    ships = stored.folder.resolve() == store.home().resolve() and stored.name in shipped_scenes()
    if ships and scene != load_scene(stored.name):
        problems.append(f"{SCENE}: another scene than the {stored.name} that ships")
    return problems


def _problems_of_table(
    scene: Scene, file: str, table: Table, names: tuple[str, ...], stored: Stored
) -> Iterator[str]:
    if table.columns != names:
        yield f"{file}: columns are {','.join(table.columns)}, expected {','.join(names)}"
        return
    bad = malformed_cells(file, table)
    yield from bad[:FEW]
    if file == TRAJECTORY and not bad:
        yield from _missing_times(scene, table, stored.manifest["status"])


def _missing_times(scene: Scene, table: Table, status: Json) -> Iterator[str]:
    times = table.column("t")
    if status != "complete":
        times = times[:-1]
    for expected, printed in zip(map(exact_decimal, scene.sample_times), times, strict=False):
        if expected is not None and printed != expected:
            later = Decimal(printed) > Decimal(expected)
            what = "is missing" if later else "is expected"
            yield f"{TRAJECTORY}: the row of t = {expected} {what}, got t = {printed}"
            return
    if status == "complete" and len(times) < len(scene.sample_times):
        yield f"{TRAJECTORY}: ends at t = {times[-1]}, before the horizon"


def _differences(derived: Json, stated: Json, where: str) -> Iterator[str]:
    """Differences between the manifest and the statements that follow from the data."""
    if isinstance(derived, dict) and isinstance(stated, dict):
        for key, value in derived.items():
            if key in WORDS:
                continue
            yield from _differences(value, stated.get(key), f"{where}: {key}" if key else where)
    elif derived != stated:
        yield f"{where} is {str(stated)[:50]!r}, the data say {str(derived)[:50]!r}"


def cell_errors(cells: Sequence[str], fresh: Sequence[str], size: Array) -> Array:
    """Return errors of ``fresh`` entries relative to their sizes; 0 where the golden cell is empty.

    Differences are exact, sizes doubles. A missing fresh entry has an infinite error.
    """
    import numpy

    pairs = zip(cells, fresh, strict=False)
    apart = numpy.array([abs(apart_of("", new, cell)) if cell else 0.0 for cell, new in pairs])
    apart[numpy.isnan(apart)] = numpy.inf
    with numpy.errstate(all="ignore"):
        return numpy.where(numpy.equal(apart, 0), 0.0, numpy.divide(apart, size[: len(apart)]))


def column_sizes(stored: Stored, table: Table) -> dict[str, Array]:
    """Return the sizes of the entries of a table, by the one rule of digits."""
    import numpy

    body = stored.scene.body.numbers(float)
    numbers = {
        name: numpy.array(table.floats(name))
        for name in table.columns
        if name not in ("name", "direction")
    }
    times = numbers.pop("t")
    with numpy.errstate(all="ignore"):
        by_name = sizes(body, numbers, numpy)
    return {**by_name, "t": numpy.maximum(times, math.sqrt(body.R / body.g))}
