"""``verify``: golden data against their manifest and a fresh computation."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

from tt_precise.errors import InputError
from tt_precise.golden import store
from tt_precise.golden.comparing import Worst, compare_tables, near_zero_below
from tt_precise.golden.inspection import inspect
from tt_precise.golden.publication import ordered_events
from tt_precise.golden.recipe import Run, Task
from tt_precise.golden.store import EVENTS, TRAJECTORY, Stored
from tt_precise.golden.table import Table
from tt_precise.golden.workers import cores, perform_all, pool
from tt_precise.progress import Progress, silent

FRESH_DIGITS = 28  # a fresh computation has to find at least so many
DIGITS_PER_BIT = math.log10(2)
QUAD_BITS, DOUBLE_BITS = 113, 53

# A scene loses the same digits in every arithmetic (its sensitivity); beyond that, rounding
# errors and the libraries of another machine move double by less than these.
DOUBLE_MARGIN = 2.5


@dataclass(frozen=True)
class Verification:
    """What was found of one scene.

    ``problems`` are empty if all is well. ``digits_found`` is the fewest digits that the fresh
    computation, in the arithmetic ``fresh``, has in common with the data; ``double_digits``
    likewise in double; None where nothing could be computed or compared.
    """

    scene: str
    digits_claimed: int | None
    digits_found: float | None = None
    fresh: str = ""
    double_digits: float | None = None
    problems: tuple[str, ...] = field(default=())

    @property
    def verdict(self) -> str:
        """Either "pass" or "fail"."""
        return "fail" if self.problems else "pass"


def verify(
    scenes: Iterable[str] | None = None,
    *,
    folder: Path | None = None,
    workers: int | None = None,
    progress: Progress = silent,
) -> list[Verification]:
    """Judge golden data, by default all there are, by their hashes and by fresh computations.

    Fresh is a computation in quad (at least 28 digits of every entry have to come out again, and
    every event), in vector form; a scene too sensitive for quad takes as many bits as it needs. A
    second one is in double. Entries near a zero of their component count relative to its scale.

    Raises
    ------
    InputError
        There are no such data.
    """
    wanted = list(dict.fromkeys(store.scenes(folder) if scenes is None else scenes))
    unknown = [name for name in wanted if not ((folder or store.home()) / name).is_dir()]
    if unknown:
        known = ", ".join(store.scenes(folder)) or "none yet; `tt-precise golden build` makes it"
        raise InputError(f"golden data: got {unknown[0][:60]!r}, expected one of: {known}")
    inspected = {name: inspect(name, folder) for name in wanted}
    found: dict[str, Verification] = {}

    def finish(name: str, runs: list[Run]) -> list[Task]:
        stored, problems = inspected[name]
        if stored:
            found[name] = _judged(stored, problems, runs)
        return []

    plans = {name: fresh_tasks(stored) for name, (stored, _) in inspected.items() if stored}
    with pool(workers or cores(), recycled=False) as executor:
        perform_all(executor, plans, finish, progress=progress)
    for name, (stored, problems) in inspected.items():
        if not stored:
            found[name] = Verification(name, None, problems=tuple(problems))
    return [found[name] for name in wanted]


def fresh_tasks(stored: Stored) -> list[Task]:
    """The computations that the data are judged by, the finer one first."""
    bits = math.ceil((FRESH_DIGITS + 1 + _digits_lost(stored)) / DIGITS_PER_BIT)
    name, text = stored.name, stored.scene_text
    finer = (
        Task(name, text, "quad", None, "newton")
        if bits <= QUAD_BITS
        else Task(name, text, "mp", bits, "newton")
    )
    return [finer, Task(name, text, "double", None, "newton", events=False)]


def _digits_lost(stored: Stored) -> float:
    """Digits that the sensitivity of the scene costs: what a run lost against its precision."""
    try:
        runs = stored.manifest["evidence"]["runs"]
        low = next(run for run in runs[1:] if run["formulation"] == "newton")
        agreements = [
            column["agreement"][low["name"]]
            for file in (TRAJECTORY, EVENTS)
            for column in stored.manifest["files"][file]["columns"].values()
            if "agreement" in column
        ]
        kept = min(digits for digits in agreements if digits != "equal")
        return float(low["bits"] * DIGITS_PER_BIT - kept)
    except (KeyError, TypeError, ValueError, StopIteration):
        return 0.0  # an edited manifest; the inspection tells that


def _judged(stored: Stored, problems: list[str], runs: list[Run]) -> Verification:
    finer, double = runs
    floors = {**near_zero_below(stored), "t": Decimal(0)}
    problems = list(problems)
    worst = list(_compared(TRAJECTORY, finer.trajectory, stored.trajectory, floors, problems))
    worst += _compared(EVENTS, _events_table(finer), stored.events, floors, problems)
    status = stored.manifest.get("status")
    if finer.status != status:
        problems.append(f"status: {finer.label} ends {finer.status}, the manifest says {status}")
    for file, one in worst:
        if one.digits < FRESH_DIGITS:
            problems.append(
                f"{file}, line {one.row + 2}, {one.column}: {finer.label} agrees to "
                f"{one.digits:.1f} digits, expected {FRESH_DIGITS}"
            )
    digits = min((one.digits for _, one in worst), default=None)
    rough = list(_compared(TRAJECTORY, double.trajectory, stored.trajectory, floors, []))
    double_digits = min((one.digits for _, one in rough), default=None)
    if digits is not None and double_digits is not None:
        lost = finer.bits * DIGITS_PER_BIT - digits
        expected = DOUBLE_BITS * DIGITS_PER_BIT - lost - DOUBLE_MARGIN
        if double_digits < expected:
            problems.append(
                f"{TRAJECTORY}: double agrees to {double_digits:.1f} digits, expected "
                f"{expected:.1f}, as {finer.label} lost {lost:.1f}"
            )
    claimed = stored.manifest.get("digits")
    return Verification(
        stored.name,
        claimed if isinstance(claimed, int) else None,
        digits,
        finer.label,
        double_digits,
        tuple(problems),
    )


def _compared(
    file: str, fresh: Table, golden: Table, floors: dict[str, Decimal], problems: list[str]
) -> list[tuple[str, Worst]]:
    """The worst entry of each column, apart from undefined ones; row by row where rows agree."""
    if len(fresh.rows) != len(golden.rows):
        problems.append(f"{file}: {len(golden.rows)} rows, a fresh one has {len(fresh.rows)}")
    known = {name: floors[name] for name in golden.columns if name in floors}
    if not set(known) <= set(fresh.columns):
        return []
    for label in ("name", "direction"):
        if label in golden.columns:
            pairs = zip(golden.column(label), fresh.column(label), strict=False)
            for row, (mine, other) in enumerate(pairs):
                if mine != other:
                    line = f"{file}, line {row + 2}, {label}"
                    problems.append(f"{line}: got {mine}, a fresh computation has {other}")
                    return []
    worst = compare_tables(fresh, golden, known)
    return [(file, one) for one in worst if not math.isnan(one.digits)]


def _events_table(run: Run) -> Table:
    names = run.trajectory.columns
    rows = [(name, t, str(way), *state) for name, way, (t, *state) in ordered_events(run)]
    return Table(("name", "t", "direction", *names[1:]), tuple(rows))
