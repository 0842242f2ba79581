"""Independent runs of a scene, and their consensus: the published tables.

``perform`` computes a scene in one arithmetic and formulation; ``reconcile`` keeps the digits that
all runs share. heyoka's ``real`` numbers leak memory under NumPy 2.4 and later; therefore runs are
text, and each scene is computed in a separate process.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cmp_to_key
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy

from tt_precise.golden.store import EVENTS, TRAJECTORY
from tt_precise.golden.table import (
    DIGITS,
    ZERO,
    Table,
    agreement,
    claims,
    common_text,
    is_near_zero,
)
from tt_precise.integration import events as catalogue
from tt_precise.mechanics.digits import sizes
from tt_precise.scene.scene import Scene

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

# Bits of the two working precisions; the next pair is taken while digits are missing. With the
# first one runs agree to 40 digits: 6 more than are published leave one rounding in 1e6 undecided.
BITS = ((160, 176), (176, 192), (240, 256))
ENOUGH = DIGITS + 1  # Digits; with less agreement the last digit may be right by chance.
SAME_TIME = Decimal("1e-30")  # Relative; closer events are simultaneous, and listed by name.
UNDEFINED_AT_POLE = ("theta_dot", "phi_dot", "nu_x", "nu_y")
ORDER = [*catalogue.EVENTS, *catalogue.JOINING, *catalogue.TERMINAL]
Cells = tuple[str, ...]


@dataclass(frozen=True)
class GoldenRun:
    """One computation of a scene: tables by file, in full working precision, SI.

    The trajectory has the scene's sample times and, as last row, an end of the solution before its
    horizon, but for a pole, where only the angles end. The events have the event that ends the
    motion.
    """

    label: str
    formulation: str
    bits: int
    order: int
    status: str
    tables: dict[str, Table]


def columns(scene: Scene) -> Cells:
    """The columns of a golden trajectory: time, vectors, Euler angles, recorded quadratures."""
    from tt_precise.integration.columns import EULER_COLUMNS, VECTOR_COLUMNS

    return ("t", *VECTOR_COLUMNS, *EULER_COLUMNS, *scene.further_columns, *scene.record)


def perform(
    scene: Scene, precision: str = "mp", bits: int | None = None, formulation: str = "newton"
) -> GoldenRun:
    """Compute a scene with all events; ``bits`` are only for the precision "mp"."""
    from tt_precise.integration import catalogue as names_of_events
    from tt_precise.integration import integrate

    record = {*scene.record, "phi"} if formulation == "euler" else scene.record
    events = names_of_events(scene.model)
    run = integrate(
        scene, precision, bits=bits, formulation=formulation, events=events, record=record
    )
    names = columns(scene)
    frame = run.frame(*names[1:], numbers="text")
    cells = {name: [x if isinstance(x, str) else "" for x in frame[name]] for name in names}
    samples, happened = Table.of_columns(cells), events_table(run, names)
    rows = [*happened.rows]
    if run.status not in ("complete", "pole"):  # contact ends where a function falls to zero
        time, *state = samples.rows[-1]
        rows.append((run.status, time, "-1", *state))
    if run.status == "pole":
        samples = Table(names, samples.rows[:-1])
    return GoldenRun(
        label=f"{formulation} {bits or precision}",
        formulation=formulation,
        bits=run.precision.bits,
        order=run.order,
        status=run.status,
        tables={TRAJECTORY: samples, EVENTS: Table(happened.columns, tuple(in_order(rows)))},
    )


def events_table(trajectory: Trajectory, names: Sequence[str]) -> Table:
    """The table of events: columns name, t, direction and the state ``names[1:]``."""
    wide, decimals = trajectory.precision.mpfr, trajectory.precision.decimals
    table = trajectory.event_table(names[1:])
    with wide.precision():
        cells = {n: [x or "" for x in wide.texts(wide.array(table[n]), decimals)] for n in names}
    directions = [str(int(direction)) for direction in table["direction"]]
    labels = {"name": table["name"], "t": cells.pop("t"), "direction": directions}
    return Table.of_columns({**labels, **cells})


def in_order(events: Sequence[Cells]) -> list[Cells]:
    """Events by time; simultaneous ones in the order of the catalogue."""

    def order(event: Cells, other: Cells) -> int:
        time, later = Decimal(event[1]), Decimal(other[1])
        if abs(time - later) <= SAME_TIME * max(time, later):
            return ORDER.index(event[0]) - ORDER.index(other[0])
        return int(time > later) - int(time < later)

    return sorted(events, key=cmp_to_key(order))


Agreements = dict[str, dict[str, float]]


@dataclass(frozen=True)
class Consensus:
    """The tables of a scene by file, with the worst agreement of each run with the first.

    ``agreements`` maps a file, then a column, then the label of a run to the digits of agreement
    over all entries that are not near zero; infinite where all entries are equal. A run without a
    row to compare is left out. ``contradictions`` name the entries on which runs share no digit.
    """

    status: str
    tables: dict[str, Table]
    agreements: dict[str, Agreements]
    contradictions: tuple[str, ...] = ()

    @property
    def agreement(self) -> float:
        """The worst of all agreements."""
        by_column = [runs for table in self.agreements.values() for runs in table.values()]
        return min(digits for runs in by_column for digits in runs.values())

    @property
    def complete(self) -> bool:
        """True if all cells have all digits (near zero: relative to their scale).

        The runs must also agree so far that the last digit is not right by chance.
        """
        scales = self.tables[TRAJECTORY].scales
        if self.contradictions or self.agreement < ENOUGH:
            return False
        return all(
            claims(table.column(name), scales[name])["digits"] in (None, DIGITS)
            for table in self.tables.values()
            for name in table.numbers[1:]
        )


def reconcile(scene: Scene, runs: Sequence[GoldenRun]) -> Consensus:
    """Tables with the digits on which all ``runs`` agree; the first run has the finest numbers.

    A run that ends at a pole (Euler form) counts for the rows before it.

    Raises ``ArithmeticError``: the runs disagree: another end, another list of events, an event
    whose directions do not alternate; or no run has a row to compare with the first run.
    """
    first, *others = runs
    for run in runs:
        if run.status not in (first.status, "pole"):
            raise ArithmeticError(
                f"{scene.name}: {first.label} ended {first.status}, {run.label} {run.status}"
            )
        events = ((row[0], int(row[2])) for row in run.tables[EVENTS].rows)
        if missing := ", ".join(catalogue.not_alternating(events)):
            raise ArithmeticError(f"{scene.name}: {run.label} may have missed an event: {missing}")
        if difference := _other_events(first, run):
            raise ArithmeticError(f"{scene.name}: {first.label} has {difference} in {run.label}")
    if not any(run.tables[TRAJECTORY].rows for run in others):
        raise ArithmeticError(f"{scene.name}: no run has a row to compare with {first.label}")
    scales = _scales(scene, runs)
    tables, agreements, contradictions = {}, {}, list[str]()
    for file in (TRAJECTORY, EVENTS):
        tables[file], agreements[file], lost = _merged(file, runs, scales)
        contradictions += lost
    samples = tables[TRAJECTORY]
    times = [exact_decimal(t) for t in scene.sample_times[: len(samples.rows)]]
    if first.status != "complete":
        times[-1] = None  # an early end is computed
    dated = [(time or row[0], *row[1:]) for time, row in zip(times, samples.rows, strict=True)]
    tables[TRAJECTORY] = Table(samples.columns, tuple(dated))
    return Consensus(first.status, tables, agreements, tuple(contradictions))


def _other_events(first: GoldenRun, run: GoldenRun) -> str:
    """The first event in which two runs differ, or ""; after a pole a run has no events."""
    for mine, other in zip_longest(first.tables[EVENTS].rows, run.tables[EVENTS].rows):
        if other is None and run.status == "pole":
            break
        if mine is None or other is None or (mine[0], mine[2]) != (other[0], other[2]):
            return ", ".join(
                f"{row[0]} ({row[2]}) at {float(row[1]):.9g} s" if row else "no further event"
                for row in (mine, other)
            )
    return ""


def _scales(scene: Scene, runs: Sequence[GoldenRun]) -> dict[str, Decimal]:
    """The largest entry of each column; the quantity's size if all entries are rounding errors.

    Rounding errors are less than 1e-34 of the size and differ between runs.
    """
    tables = [run.tables[TRAJECTORY] for run in runs if run.status == runs[0].status]
    numbers = {name: numpy.array(tables[0].floats(name)) for name in tables[0].numbers[1:]}
    with numpy.errstate(all="ignore"):
        size_by_name = sizes(scene.body.numbers(float), numbers, numpy)
    scales = dict(tables[0].scales)
    for name, size in size_by_name.items():
        least = Decimal(float(min(size[numpy.isfinite(size)], default=1.0)))
        largest = {table.scales[name] for table in tables}
        if len(largest) > 1 and max(largest) < least.scaleb(-DIGITS):
            scales[name] = least
    return scales


def _merged(
    file: str, runs: Sequence[GoldenRun], scales: dict[str, Decimal]
) -> tuple[Table, Agreements, list[str]]:
    """The published table, the worst agreement of each later run, and contradictions."""
    first = runs[0].tables[file]
    # a run that ended before the first row has no agreement
    others = {run.label: run.tables[file] for run in runs[1:]}
    others = {label: table for label, table in others.items() if table.rows or not first.rows}
    worst = {name: dict.fromkeys(others, math.inf) for name in first.numbers}
    merged = {name: [*first.column(name)] for name in first.columns}
    for name in first.numbers:
        witnesses = {label: table.column(name) for label, table in others.items()}
        for row, cell in enumerate(first.column(name)):
            cells = {label: x[row] for label, x in witnesses.items() if row < len(x)}
            merged[name][row] = ""
            if "" in (cell, *cells.values()):
                continue
            value, values = Decimal(cell), {label: Decimal(x) for label, x in cells.items()}
            text = merged[name][row] = common_text((value, *values.values()), scales[name])
            if text and not is_near_zero(text, scales[name]):
                for label, other in values.items():
                    worst[name][label] = min(worst[name][label], agreement(value, other))
    contradictions = []
    for row, time in enumerate(first.column("t")):
        at_pole = merged["kx"][row] == merged["ky"][row] == ZERO
        for name in first.numbers:
            if at_pole and name in UNDEFINED_AT_POLE:
                # the direction of a computed 1e-50 is rounding, even if all runs agree
                merged[name][row] = ""
            elif first.column(name)[row] and not merged[name][row]:
                contradictions.append(f"{name} at t = {float(time):.9g} s")
    return Table.of_columns(merged), worst, contradictions


def exact_decimal(time: Fraction) -> str | None:
    """A time as a plain decimal; None for a decimal of more than 34 digits."""
    for places in range(DIGITS):
        scaled = time * 10**places
        if scaled.denominator == 1:
            return f"{Decimal(scaled.numerator).scaleb(-places):f}"
    return None
