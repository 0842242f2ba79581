"""What each setting of the integrator costs and delivers: the measured table behind ``digits``.

``cost_table.csv`` holds one row for each formulation, precision and tolerance; ``python -m
benchmarks.settings_table`` writes it from golden and seeded scenes, nobody else does. Its
numbers are only where a choice begins: whether a scene got its digits is decided by the estimate
of that very run.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from tt_precise.integration.accuracy import RATIO
from tt_precise.integration.precision import DOUBLES, precision_named
from tt_precise.integration.system import full_tolerance

TABLE = Path(__file__).with_name("cost_table.csv")
DIGITS_PER_BIT = math.log10(2)
FINER = {"double": "extended", "extended": "quad"}


@dataclass(frozen=True, eq=False)  # compared and hashed as an object, fast
class Setting:
    """One way to integrate. ``bits`` is 0 but for mp; ``tolerance`` 0 stands for the eps.

    ``digits`` of the worst entry at the worst time, in the median scene; ``cost`` of the
    run on the reference scene, relative to double at its full accuracy.
    """

    formulation: str
    precision: str
    bits: int
    tolerance: float
    digits: float
    cost: float


@cache
def measured() -> tuple[Setting, ...]:
    """The table, cheapest first."""
    with TABLE.open(encoding="utf-8", newline="") as lines:
        rows = [
            Setting(
                row["formulation"], row["precision"], 0, float(row["tolerance"]),
                float(row["digits_median"]), float(row["cost"]),
            )
            for row in csv.DictReader(lines)
        ]  # fmt: skip
    return tuple(sorted(rows, key=lambda row: row.cost))


@cache
def settings(formulation: str | None, available: frozenset[str]) -> tuple[Setting, ...]:
    """The settings worth using, cheapest first: each has more digits than all before it.

    Only of one formulation if it is given, and of the ``available`` precisions. What its reference
    runs cost counts too.
    """
    worth: list[Setting] = []
    for setting in sorted(measured(), key=cost_with_estimate):
        wanted = setting.precision in available and formulation in (None, setting.formulation)
        if wanted and (not worth or setting.digits > worth[-1].digits):
            worth.append(setting)
    return tuple(worth)


@cache
def cost_with_estimate(setting: Setting) -> float:
    """What a run and its reference runs cost; inf where the table does not say.

    The ``cost`` is that of both where a run has its reference with it: a coarse one of the Newton
    form in double, in the same batch; and in several doubles, all but the finest.
    """
    newton = setting.formulation == "newton"
    if setting.tolerance and newton:
        together = setting.precision == "double" or setting.precision in DOUBLES
        return setting.cost if together else 2 * setting.cost
    reference = setting.precision if setting.tolerance else FINER.get(setting.precision)
    full = [
        row.cost
        for row in measured()
        if (row.formulation, row.precision, row.tolerance) == (setting.formulation, reference, 0)
    ]
    twice = 2 if setting.tolerance else 1
    return twice * setting.cost + (full[0] if full else math.inf)


def wide(digits: float, formulation: str | None, available: frozenset[str]) -> Setting:
    """What has ``digits``, beyond those of the table, where the median scene loses what it does.

    Triple-double down to its finest tolerance, beyond which only mp has the bits.
    """
    finest = [row for row in measured() if row.precision == "triple-double"]
    if finest and "triple-double" in available and formulation in (None, "newton"):
        last = min(finest, key=lambda row: row.tolerance)
        tolerance = last.tolerance * 10 ** (last.digits - digits)
        if tolerance >= RATIO * full_tolerance(precision_named("triple-double")):
            return replace(last, tolerance=tolerance, digits=digits)
    lost = max(
        113 * DIGITS_PER_BIT - row.digits
        for row in measured()
        if (row.precision, row.tolerance) == ("quad", 0)
    )
    bits = math.ceil((digits + lost) / DIGITS_PER_BIT)
    return Setting(formulation or "newton", "mp", max(bits, 128), 0.0, digits, math.inf)
