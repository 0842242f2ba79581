"""``verify``: golden data against their manifest and a fresh computation."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import NamedTuple

from tt_precise.golden import proofs, store
from tt_precise.golden.consensus import ordered_events
from tt_precise.golden.distance import correct_digits, scales_by_kind
from tt_precise.golden.integrity import inspect
from tt_precise.golden.places import VECTORS, Folder, Located, home, locate, require, some
from tt_precise.golden.proved import PROVED
from tt_precise.golden.runs import LADDER, Run, Task
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.workers import perform_all
from tt_precise.golden.worst import largest_error
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.workers import local_pool

FRESH_DIGITS = 28  # a fresh computation has to find at least so many
DIGITS_PER_BIT = math.log10(2)
# What golden data are compared with: by an integrator that did not make them, where there is one.
FINE, WITHOUT_LLVM = "triple-double", "quad"

# A scene loses the same digits in every arithmetic, its sensitivity. Where double or the fresh
# computation itself shows that it cannot have 28 left, the scene is computed with as many bits as
# that takes; no more than golden data are made with. Three doubles have all that are printed left,
# and do not show what they lost: two doubles do.
SPARE_BITS = 4
MOST_BITS = max(LADDER[0])

# Beyond a scene's sensitivity, rounding errors and the libraries of another machine move double by
# less than these.
DOUBLE_MARGIN = 2.5


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
    """What was found of one scene.

    ``problems`` are empty if all is well. ``digits_proved`` are those of the proof that lies beside
    the data, None if there is none. ``digits_found`` is the fewest digits that the fresh
    computation, in the arithmetic ``fresh``, has in common with the data; ``double_digits``
    likewise in double; None where nothing could be computed or compared.
    """

    scene: str
    digits_claimed: int | None
    digits_found: float | None = None
    fresh: str = ""
    double_digits: float | None = None
    problems: tuple[str, ...] = field(default=())
    digits_proved: int | None = None

    @property
    def verdict(self) -> str:
        """Either "pass" or "fail"."""
        return "fail" if self.problems else "pass"


def verify(
    scenes: Iterable[str | Path] | None = None,
    *,
    folder: Folder = None,
    workers: int | None = None,
    progress: Progress = silent,
) -> list[Verification]:
    """Verify golden data, by default all there are: hashes, proofs and fresh computations.

    Fresh is a computation in triple-double, in vector form, of which at least 28 digits of every
    entry, and every event, have to come out again; a scene too sensitive for that takes as many
    bits as it needs. Others are in double and double-double, which shows what the scene loses.
    Digits count relative to the component's size at the time.

    Raises
    ------
    InputError
        There are no such data, or none at all.
    """
    located = {one.name: one.folder for one in _asked_for(scenes, folder)}
    wanted = some(located, folder)
    found: dict[str, Verification] = {}

    @cache
    def inspected(name: str) -> tuple[Stored | None, list[str]]:
        return inspect(name, located[name])

    doubles: dict[str, Run] = {}
    roughly: dict[str, WorstEntry | None] = {}

    def finish(name: str, runs: list[Run]) -> list[Task]:
        stored, problems = inspected(name)
        if stored is None:
            return []
        run = runs[0]
        if name not in doubles:
            doubles[name] = run
            # what double has in common with damaged data says nothing about the scene
            roughly[name] = _worst(stored, run)
            rough = None if problems else roughly[name]
            fine = _fine(stored, rough and bits_needed(rough.digits, run.bits))
            return [fine, _rough(stored, "double-double")] if fine.precision == FINE else [fine]
        found[name] = judge(stored, problems, [*runs, doubles[name]], roughly[name])
        digits = found[name].digits_found
        if digits is None or digits >= FRESH_DIGITS:
            return []
        bits = bits_needed(digits, run.bits)
        return [_fine(stored, bits)] if bits else []

    # the workers compute while the files are inspected, here
    plans = {
        name: [_rough(stored, "double")]
        for name, stored in ((name, _readable(name, located[name])) for name in wanted)
        if stored
    }
    with local_pool(workers, inline=False) as pool:
        perform_all(pool, plans, finish, progress=progress)
    for name in wanted:
        if name not in found:
            found[name] = Verification(name, None, problems=tuple(inspected(name)[1]))
    return [replace(found[name], digits_proved=_proved(name, located[name])) for name in wanted]


def _asked_for(scenes: Iterable[str | Path] | None, folder: Folder) -> list[Located]:
    """Where the data are. All there are means every folder, readable or not, and those known."""
    if scenes is not None:
        found = [locate(scene, folder) for scene in scenes]
        missing = [one for one in found if not one.path.is_dir()]
        return found if not missing else [require(missing[0].name, folder)]
    place = home() if folder is None else Path(folder)
    names = {entry.name for entry in place.iterdir() if entry.is_dir()} if place.is_dir() else set()
    if place.resolve() == home().resolve():
        names |= PROVED
    names = {name for name in names if not name.startswith(".")} - {VECTORS}
    return [Located(name, place) for name in sorted(names)]


def bits_needed(digits: float, bits: int) -> int | None:
    """With how many bits a fresh computation has 28 digits left; None if that is hopeless.

    ``digits`` are what one with ``bits`` had in common with the data.
    """
    needed = bits + math.ceil((FRESH_DIGITS - digits) / DIGITS_PER_BIT)
    return needed if needed + SPARE_BITS <= MOST_BITS else None


def judge(
    stored: Stored,
    problems: Sequence[str],
    runs: Sequence[Run],
    roughly: WorstEntry | None = None,
) -> Verification:
    """The verdict on data with these ``problems`` of their own.

    ``runs`` are the finest and the one in double; between them one that is coarse enough to show
    how many digits the scene loses, if the finest is not. ``roughly`` is where the one in double
    is worst, if that is known.
    """
    finer, double, telling = runs[0], runs[-1], runs[-2]
    found = list(problems)
    status = stored.manifest.get("status")
    if finer.status != status:
        found.append(f"status: {finer.label} ends {finer.status}, the manifest says {status}")
    worst = list(_compared(stored, TRAJECTORY, finer.trajectory, found))
    worst += _compared(stored, EVENTS, _events_table(finer), found)
    found += [
        f"{one}: {finer.label} agrees to {one.digits:.1f} digits, expected {FRESH_DIGITS}"
        for one in worst
        if one.digits < FRESH_DIGITS
    ]
    digits = min((one.digits for one in worst), default=None)
    if digits is None:
        found.append(f"{finer.label}: no entry could be compared, expected all of them")
    rough, shown = roughly or _worst(stored, double), _worst(stored, telling)
    if shown is not None and rough is not None:
        left = shown.digits if telling is not finer or digits is None else digits
        lost = telling.bits * DIGITS_PER_BIT - left
        expected = double.bits * DIGITS_PER_BIT - lost - DOUBLE_MARGIN
        if rough.digits < expected:
            found.append(
                f"{rough}: double agrees to {rough.digits:.1f} digits, expected {expected:.1f}, "
                f"as {telling.label} lost {lost:.1f}"
            )
    claimed = stored.manifest.get("digits")
    return Verification(
        stored.name,
        claimed if isinstance(claimed, int) else None,
        digits,
        finer.label,
        rough.digits if rough else None,
        tuple(found),
    )


def _readable(name: str, folder: Path) -> Stored | None:
    try:
        stored = store.read(name, folder)
        stored.scene  # noqa: B018 - it has to be one
    except InputError:  # reported when the files are inspected
        return None
    return stored


def _proved(name: str, folder: Path) -> int | None:
    try:
        record = proofs.read(name, folder)
    except InputError:  # reported among the problems
        return None
    return record.digits if record else None


def _worst(stored: Stored, run: Run) -> WorstEntry | None:
    found = _compared(stored, TRAJECTORY, run.trajectory, [])
    return min(found, key=lambda one: one.digits, default=None)


def _fine(stored: Stored, bits: int | None) -> Task:
    """The fresh computation: in ``FINE``, or, where that has too few bits, in ``mp``."""
    from tt_precise.integration.precision import BITS, is_available
    from tt_precise.integration.setup import refused_in_doubles

    ours = is_available(FINE) and not refused_in_doubles(stored.scene)
    precision = FINE if ours else WITHOUT_LLVM
    if bits is None or bits <= BITS[precision]:
        return Task(stored.name, stored.scene_text, precision, None, "newton")
    return Task(stored.name, stored.scene_text, "mp", bits + SPARE_BITS, "newton")


def _rough(stored: Stored, precision: str) -> Task:
    return Task(stored.name, stored.scene_text, precision, None, "newton", events=False)


def _compared(stored: Stored, file: str, fresh: Table, problems: list[str]) -> list[WorstEntry]:
    """The worst entry of each column, apart from undefined ones; of the rows that both have."""
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
    scales = scales_by_kind(stored.trajectory, stored.scene.body)
    worst = []
    for name in golden.columns:
        if name in ("name", "direction"):
            continue
        cells = golden.column(name)
        found = fresh.column(name)
        both = enumerate(zip(found, cells, strict=False))
        blank = [row for row, (mine, cell) in both if mine and not cell]
        wrongly = next((row for row in blank if not _at_pole(golden, row)), None)
        if wrongly is not None:
            line = f"{file}, line {wrongly + 2}, {name}"
            problems.append(f"{line}: is empty, a fresh computation has a number")
        largest = largest_error(cells, found, scales.get(name))
        if largest:
            worst.append(WorstEntry(file, largest.row, name, correct_digits(largest.error)))
    return worst


def _at_pole(table: Table, row: int) -> bool:
    """Whether the axis is vertical to all digits that are verified: nothing says where it leans."""
    cells = (table.column(name)[row] for name in ("kx", "ky"))
    return all(abs(Decimal(cell or 1)) < Decimal(10) ** -FRESH_DIGITS for cell in cells)


def _events_table(run: Run) -> Table:
    names = run.trajectory.columns
    rows = [(name, t, str(way), *state) for name, way, (t, *state) in ordered_events(run)]
    return Table(("name", "t", "direction", *names[1:]), tuple(rows))
