"""Distance from the true solution: golden data, or the solution computed afresh.

The rule is that of ``golden.distance``, the same as in ``golden.compare``. A row between golden
times is compared with the golden row nearest to it, carried to its time by the equations of
motion; with ``fresh``, rows that golden data do not reach are compared with a solution that is
computed at their own times.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy

from tt_precise.check.blocks import Block
from tt_precise.check.digits_over_time import DigitsOverTime
from tt_precise.check.evidence import Evidence
from tt_precise.check.finding import CheckFinding, Verdict
from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.golden import store
from tt_precise.golden.distance import as_decimal
from tt_precise.golden.fewest import FewestDigits
from tt_precise.golden.measuring import RESOLVED, Measured, TrueRows
from tt_precise.golden.places import MANIFEST, Folder, locate
from tt_precise.golden.seal import read_whole
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress
from tt_precise.scene.numerals import exact
from tt_precise.scene.start import LIFTED

MEANING = "correct digits of every column"
MOST_RECOMPUTED = 1024  # rows computed afresh, evenly spread over those that need it
FEW_ENOUGH = 10
SPARE_DIGITS = 1.0  # by which a carried row must be better than what is asked


class GoldenDistance:
    """Compares blocks with the golden data of the scene, and keeps rows for a fresh computation.

    ``asked`` are the digits wanted, or None to report only.
    """

    def __init__(
        self,
        setup: CheckSetup,
        present: Sequence[str],
        asked: float | None,
        fresh: bool,
        folder: Folder = None,
    ):
        self._setup, self._asked, self._fresh = setup, asked, fresh
        self._true, self._absent = _golden_rows(setup, folder)
        lifted = LIFTED if setup.scene.lifts else ()
        known = [*NewtonState._fields, *EulerState._fields, *lifted]
        still = {"vx", "vy", "nu_x", "nu_y"} if setup.rolling else set()
        self._written = [name for name in present if name in known and name not in still]
        self._derived: list[str] = []
        if setup.columns.name == "rigid body":
            derived = NewtonState._fields if setup.velocity_known else NewtonState._fields[:6]
            derived = (*derived, *(LIFTED if setup.height_given else ()))
            taken = {*self._written, *still}
            self._derived = [name for name in derived if name not in taken]
        self._fewest, self._evidence = FewestDigits(), Evidence()
        self._over_time = DigitsOverTime()
        self._rows: list[tuple[Fraction, dict[str, Decimal | None]]] = []
        self._stride, self._seen = 1, 0
        self._resolved = RESOLVED if asked is None else 10.0 ** -(asked + SPARE_DIGITS)

    def look(self, block: Block, samples: Samples) -> None:
        """The next rows, as given and as vectors."""
        t = block.values["t"]
        start, compared = abs(t) <= 0, numpy.zeros(len(block), bool)
        if self._true is not None:
            values = {name: block.values[name] for name in self._written}
            values |= {name: getattr(samples.state, name) for name in self._derived}
            found = self._true.measure(
                t,
                values,
                partial(self._cells, block, samples),
                self._resolved,
                largest_only=True,
            )
            self._take(found)
            compared = found.compared
        if self._fresh:
            for row in numpy.flatnonzero(~compared & ~start).tolist():
                self._keep(block, samples, row)
            compared = compared | ~start
        self._evidence.add(t, compared, start)

    def _take(self, found: Measured) -> None:
        self._fewest.add(found)
        self._over_time.add(found)

    def _cells(self, block: Block, samples: Samples, row: int, names: Sequence[str]) -> list[Any]:
        written = [name for name in names if name in self._written]
        cells = dict(zip(written, block.texts(row, written), strict=True))
        # text that is no number counts as missing, as in ``block.values``
        return [
            (cells[name] if numpy.isfinite(block.values[name][row]) else None)
            if name in cells
            else float(getattr(samples.state, name)[row])
            for name in names
        ]

    def _keep(self, block: Block, samples: Samples, row: int) -> None:
        if self._seen % self._stride == 0:
            written = block.texts(row, ["t"])[0]
            t = exact(written) if isinstance(written, str) else Fraction(float(written))
            names = [*self._written, *self._derived]
            cells = map(as_decimal, self._cells(block, samples, row, names))
            self._rows.append((t, dict(zip(names, cells, strict=True))))
            if len(self._rows) > 2 * MOST_RECOMPUTED:
                self._rows, self._stride = self._rows[::2], 2 * self._stride
        self._seen += 1

    def finding(self, until: float, broken: str, progress: Progress) -> CheckFinding:
        """The distance up to time ``until`` (s), with a fresh computation where one is allowed.

        ``broken`` says why rows are missing at the end, "" if none are.

        Raises
        ------
        InputError
            Digits were asked for, but there is nothing to compare with, or not enough.
        """
        notes = []
        if self._fewest.rows:
            notes.append(f"{self._fewest.rows} rows compared with golden data")
        if self._rows:
            from tt_precise.check.recompute import recomputed

            found, note = recomputed(self._setup.scene, self._rows, self._asked, progress)
            self._take(found)
            notes.append(note)
            self._evidence.compared -= int((~found.compared).sum()) * self._stride
        left_out = self._evidence.rows - self._evidence.compared
        if notes and left_out:
            notes.append(f"{left_out} of {self._evidence.rows} rows after the start were not")
        lacking = self._absent or "no row at a time of the golden data"
        if self._fewest.rows:
            lacking = broken or self._evidence.lacking(*self._reach(until))
        few = bool(self._fewest.rows) and self._fewest.worst < (self._asked or 0.0)
        if self._asked is not None and lacking and not (few or broken):
            raise InputError(f"digits: {lacking}; {self._advice()}")
        if not self._fewest.rows:
            failed = broken and self._asked is not None
            reason = broken or f"{lacking}; --fresh computes the solution"
            return CheckFinding("golden", "fail" if failed else "skipped", reason=reason)
        verdict: Verdict = "pass"
        worst = self._fewest.worst
        if self._asked is None:
            notes.append("reported only: --digits N asks for N")
        elif few or broken:
            verdict = "fail"
        if broken:
            notes.append(broken)
        if worst < 1 and self._over_time.from_the_start:
            notes.append("is it another start than the scene's?")
        return CheckFinding(
            "golden", verdict, worst, self._asked, self._fewest.at, "; ".join(notes), MEANING,
            "at least", {name: round(value, 2) for name, value in self._fewest.digits.items()},
            history=str(self._over_time),
        )  # fmt: skip

    def _reach(self, until: float) -> tuple[float, int]:
        """The time (s) up to which rows are expected, and how many golden times there are."""
        if self._true is None:
            return min(until, float(self._setup.scene.until)), FEW_ENOUGH
        times = self._true.times
        return min(until, float(times[-1])), int((times <= until).sum()) - 1

    def _advice(self) -> str:
        if self._fresh:
            return "expected rows that reach over the whole of it"
        if self._true is None:
            return "expected --fresh, which computes the solution"
        times = self._true.times
        shown = ", ".join(f"{t:g}" for t in times[:3])
        return (
            "expected --fresh, which computes the solution at the trajectory's own times, or rows "
            f"at the golden times {shown} ... {times[-1]:g} s"
        )


def _golden_rows(setup: CheckSetup, folder: Folder) -> tuple[TrueRows | None, str]:
    name = setup.scene.name
    try:
        place = locate(name, folder)
    except InputError:
        place = None
    if place is None or not (place.path / MANIFEST).is_file():
        where = "" if folder is None else f" in {folder}"
        return None, f"no golden data of a scene {name}{where}"
    stored = read_whole(name, place.folder)
    stamp = store.stamp(place.path / store.TRAJECTORY)
    make = _true_rows if stamp else _true_rows.__wrapped__  # unless it was written just now
    true = make(place.path.resolve(), stamp)
    scene = stored.scene
    if (scene.model, scene.body, scene.start) != (
        setup.scene.model, setup.scene.body, setup.scene.start,
    ):  # fmt: skip
        return None, f"the golden data of {name} are of another body or start"
    return true, ""


@lru_cache(maxsize=32)
def _true_rows(place: Path, stamp: store.Stamp | None) -> TrueRows:
    stored = read_whole(place.name, place.parent)
    return TrueRows(stored.scene, stored.trajectory)
