"""Distance from the true solution: golden rows at the same times, or rows computed afresh.

Nothing is interpolated. A row whose time misses a golden one by rounding (a sum of time steps,
say) is compared after the golden row has been moved over the difference by its own rate.
Differences are exact (``Decimal``), however many digits the trajectory was written with. Digits
count as in ``golden.compare``: relative to the true entry, or to 1e-3 of the largest entry of its
column where it is smaller than that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy

from tt_precise.check.digits import Digits, as_decimal
from tt_precise.check.reading import Block
from tt_precise.check.result import CheckFinding, Verdict
from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.errors import InputError
from tt_precise.golden import store
from tt_precise.golden.digits import EXACT
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.numerals import exact
from tt_precise.progress import Progress

if TYPE_CHECKING:
    from tt_precise.golden.table import Table

MEANING = "correct digits of every column"
SAME_TIME = 1e-9  # s; first-order motion over so short a time is exact to 1e-14
MOST_FRESH = 1024  # rows kept for a fresh computation, evenly spread over the trajectory


class Distance:
    """Compares blocks with the golden data of the scene, and keeps rows for a fresh computation.

    ``asked`` are the digits wanted, or None to report only.
    """

    def __init__(self, setup: CheckSetup, present: Sequence[str], asked: float | None, fresh: bool):
        self._setup, self._asked, self._fresh = setup, asked, fresh
        self._table, self._absent = _golden_table(setup)
        vectors = setup.columns.name == "rigid body"
        known = [*NewtonState._fields, *EulerState._fields]
        self._written = [name for name in present if name in known]
        self._derived: list[str] = []
        if vectors:
            derived = NewtonState._fields if setup.velocity_known else NewtonState._fields[:6]
            self._derived = [name for name in derived if name not in self._written]
        if setup.rolling:
            still = {"vx", "vy", "nu_x", "nu_y"}
            self._written = [name for name in self._written if name not in still]
            self._derived = [name for name in self._derived if name not in still]
        self._kept: list[tuple[Fraction, dict[str, Decimal]]] = []
        self._stride, self._seen = 1, 0
        if self._table is not None:
            self._times = numpy.array([float(cell) for cell in self._table.column("t")])
            self._cells = {
                name: self._table.column(name)
                for name in (*self._written, *self._derived)
                if name in self._table.columns
            }
            self._digits = Digits.of_columns(self._cells)

    def look(self, block: Block, samples: Samples) -> None:
        """The next rows, as given and as vectors."""
        matched = numpy.zeros(len(block), dtype=bool)
        if self._table is not None:
            t = block.values["t"]
            near = numpy.clip(numpy.searchsorted(self._times, t), 1, len(self._times) - 1)
            near -= abs(self._times[near - 1] - t) <= abs(self._times[near] - t)
            delay = t - self._times[near]
            matched = abs(delay) <= SAME_TIME
            for row in numpy.flatnonzero(matched).tolist():
                self._compare(int(near[row]), float(delay[row]), self._row(block, samples, row))
        if self._fresh:
            for row in numpy.flatnonzero(~matched).tolist():
                self._keep(block, samples, row)

    def _row(self, block: Block, samples: Samples, row: int) -> dict[str, Decimal]:
        cells = zip(self._written, block.texts(row, self._written), strict=True)
        found = {name: as_decimal(cell) for name, cell in cells}
        for name in self._derived:
            found[name] = Decimal(float(getattr(samples.state, name)[row]))
        return {name: value for name, value in found.items() if value is not None}

    def _compare(self, row: int, delay: float, given: Mapping[str, Decimal]) -> None:
        moved = self._motion(row, delay) if delay else {}
        self._digits.rows += 1
        for name, value in given.items():
            cell = self._cells[name][row] if name in self._cells else ""
            if not cell or not math.isfinite(moved.get(name, 0.0)):
                continue  # undefined at a pole
            true = Decimal(cell)
            error = EXACT.subtract(value, true)
            if name in moved:
                error = EXACT.subtract(error, Decimal(moved[name]))
            self._digits.add(float(self._times[row]), name, error, true)

    def _motion(self, row: int, delay: float) -> dict[str, float]:
        changes: dict[str, float] = {}
        for coordinates in ("newton", "euler"):
            form = formulation(self._setup.scene.model, coordinates, self._setup.scene.body.law)
            if not set(form.columns) <= self._cells.keys():
                continue
            state = [float(self._cells[name][row] or "nan") for name in form.columns]
            with numpy.errstate(all="ignore"):
                rates = form.rates(self._setup.body, form.State(*numpy.array(state)), numpy)
            changes |= {
                name: float(rate) * delay for name, rate in zip(form.columns, rates, strict=True)
            }
        return changes

    def _keep(self, block: Block, samples: Samples, row: int) -> None:
        if self._seen % self._stride == 0:
            written = block.texts(row, ["t"])[0]
            t = exact(written) if isinstance(written, str) else Fraction(float(written))
            self._kept.append((t, self._row(block, samples, row)))
            if len(self._kept) > 2 * MOST_FRESH:
                self._kept, self._stride = self._kept[::2], 2 * self._stride
        self._seen += 1

    def finding(self, progress: Progress) -> CheckFinding:
        """The distance, with a fresh computation where one is needed and allowed.

        Raises
        ------
        InputError
            Digits were asked for, but there is nothing to compare with.
        """
        if self._kept:
            from tt_precise.check.recompute import fresh_digits

            digits, note = fresh_digits(self._setup.scene, self._kept, self._asked, progress)
            if self._table is not None and self._digits.rows:
                note += f"; {self._digits.rows} rows from golden data"
                digits = min(digits, self._digits, key=lambda found: found.worst)
        elif self._table is not None and self._digits.fewest:
            digits = self._digits
            note = f"{digits.rows} rows at golden times"
        else:
            reason = self._absent or "no row at a golden time"
            if self._asked is not None:
                raise InputError(
                    f"digits: {reason}, so there is nothing to compare with; expected --fresh, "
                    "which computes the solution"
                )
            return CheckFinding(
                "golden", "skipped", reason=f"{reason}; --fresh computes the solution"
            )
        verdict: Verdict = "pass"
        if self._asked is None:
            note += "; reported only: --digits N asks for N"
        elif digits.worst < self._asked:
            verdict = "fail"
        if digits.worst < 1:
            note += "; is it another start than the scene's?"
        return CheckFinding(
            "golden", verdict, digits.worst, self._asked, digits.at, note, MEANING, "at least",
            {name: round(value, 2) for name, value in digits.fewest.items()},
        )  # fmt: skip


def _golden_table(setup: CheckSetup) -> tuple[Table | None, str]:
    name = setup.scene.name
    if name not in store.scenes():
        return None, f"no golden data of a scene {name}"
    stored = store.read(name)
    scene = stored.scene
    if (scene.model, scene.body, scene.start) != (
        setup.scene.model, setup.scene.body, setup.scene.start,
    ):  # fmt: skip
        return None, f"the golden data of {name} are of another body or start"
    return stored.trajectory, ""
