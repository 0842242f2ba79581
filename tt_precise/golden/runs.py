"""From computations of a scene to the published tables.

A ``Task`` is a computation, a ``GoldenRun`` its result; ``reconcile`` keeps the digits that all
runs share. heyoka's ``real`` numbers leak memory under NumPy 2.4 and later; therefore runs are
text, and each scene is computed in a separate process.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from tt_precise.golden.digits import (
    DIGITS,
    ZERO,
    agreement,
    common_text,
    digits_of,
    is_near_zero,
    scales_of,
)
from tt_precise.golden.measuring import TrueRows
from tt_precise.golden.table import Table
from tt_precise.integration.events import EVENTS, JOINING, TERMINAL, not_alternating
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import Scene, parse_scene

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

# Bits of the two working precisions. The next pair is taken while digits are missing; the middle
# one shares a run with the first. With the first pair all three runs agree to 40 digits on the
# reference scene; 6 more than are published make it unlikely (1e-6 an entry) that a rounding to
# 34 digits stays undecided.
LADDER = ((160, 176), (176, 192), (240, 256))
ENOUGH = DIGITS + 1  # Digits; with less agreement the last digit may be wrong by chance.

TERMINAL_DIRECTION = -1  # contact and singular contact are functions that fall to zero


@dataclass(frozen=True)
class Task:
    """One computation: a scene (name and TOML text), a precision, a formulation.

    ``bits`` is only for the precision "mp". ``events`` requests the whole catalogue.
    """

    name: str
    text: str
    precision: str
    bits: int | None
    formulation: str
    events: bool = True

    @property
    def scene(self) -> Scene:
        return parse_scene(self.text, self.name, f"{self.name}.toml")

    @property
    def label(self) -> str:
        """The name of the run, such as "newton 176"."""
        return f"{self.formulation} {self.bits or self.precision}"


@dataclass(frozen=True)
class GoldenRun:
    """The outcome of a task: tables in full working precision, SI.

    ``trajectory`` has the scene's sample times and, as last row, an end of the solution before its
    horizon. ``events`` lack the terminal event. ``suspects`` names events whose directions do not
    alternate, so that one may be missing. ``seconds`` is the CPU time, reported but not published.
    """

    label: str
    formulation: str
    bits: int
    order: int
    status: str
    trajectory: Table
    events: Table
    suspects: tuple[str, ...]
    seconds: float = 0.0


def tasks(scene: Scene, bits: tuple[int, int]) -> list[Task]:
    """The computations whose agreement is the evidence; the first is published."""
    low, high = bits
    wanted = [
        Task(scene.name, scene.text, "mp", high, "newton"),
        Task(scene.name, scene.text, "mp", low, "newton"),
    ]
    if not (scene.start.theta.at_pole or scene.refused_in_angles):
        wanted.append(Task(scene.name, scene.text, "mp", low, "euler"))
    return wanted


def columns(scene: Scene) -> tuple[str, ...]:
    """The columns of a golden trajectory: time, vectors, Euler angles, recorded quadratures."""
    from tt_precise.integration.columns import EULER_COLUMNS, VECTOR_COLUMNS

    return ("t", *VECTOR_COLUMNS, *EULER_COLUMNS, *scene.further_columns, *scene.record)


def perform(task: Task) -> GoldenRun:
    """Compute a task."""
    from tt_precise.integration import catalogue, integrate

    began = time.process_time()
    scene = task.scene
    record = {*scene.record, "phi"} if task.formulation == "euler" else scene.record
    trajectory = integrate(
        scene,
        task.precision,
        bits=task.bits,
        formulation=task.formulation,
        events=catalogue(scene.model) if task.events else (),
        record=record,
    )
    names = columns(scene)
    frame = trajectory.frame(*names[1:], numbers="text")
    happened = events_table(trajectory, names)
    return GoldenRun(
        label=task.label,
        formulation=task.formulation,
        bits=trajectory.precision.bits,
        order=trajectory.order,
        status=trajectory.status,
        trajectory=Table.of_columns({name: list(map(_text, frame[name])) for name in names}),
        events=happened,
        suspects=not_alternating(((row[0], int(row[2])) for row in happened.rows), EVENTS),
        seconds=time.process_time() - began,
    )


def _text(value: Scalar) -> str:
    return value if isinstance(value, str) else ""


def events_table(trajectory: Trajectory, names: Sequence[str]) -> Table:
    """The table of events: columns name, t, direction and the state ``names[1:]``."""
    precision, table = trajectory.precision, trajectory.event_table(names[1:])
    wide = precision.mpfr

    def texts(name: str) -> list[str]:
        return [text or "" for text in wide.texts(wide.array(table[name]), precision.decimals)]

    with wide.precision():
        times, states = texts("t"), {name: texts(name) for name in names[1:]}
    directions = [str(int(direction)) for direction in table["direction"]]
    return Table.of_columns({"name": table["name"], "t": times, "direction": directions, **states})


SAME_TIME = Decimal(
    "1e-30"
)  # relative; events closer than this count as simultaneous and are listed by name
UNDEFINED_AT_POLE = ("theta_dot", "phi_dot", "nu_x", "nu_y")
ORDER = [*EVENTS, *JOINING, *TERMINAL]


Agreements = dict[str, dict[str, float]]


@dataclass(frozen=True)
class Consensus:
    """The tables of a scene, with the worst agreement of each run with the first, in digits.

    ``agreements`` maps the name of a table, then a column, then the label of a run to the digits of
    agreement over all entries that are not near zero; infinite where all entries are equal. A run
    without a row to compare is left out. ``contradictions`` name the entries on which the runs
    share no digit.
    """

    status: str
    trajectory: Table
    events: Table
    agreements: dict[str, Agreements]
    contradictions: tuple[str, ...] = ()

    @property
    def agreement(self) -> float:
        """The worst of all agreements."""
        return min(
            digits
            for columns in self.agreements.values()
            for runs in columns.values()
            for digits in runs.values()
        )

    @property
    def complete(self) -> bool:
        """True if all cells have all digits (near zero: relative to their scale).

        The runs must also agree so far that the last digit is not right by chance.
        """
        scales = scales_of(self.trajectory)
        if self.contradictions or self.agreement < ENOUGH:
            return False
        return all(
            digits_of(entry) >= DIGITS or is_near_zero(entry, scales[name])
            for table in (self.trajectory, self.events)
            for name in table.columns
            if name in scales and name != "t"
            for entry in table.column(name)
            if entry
        )


def reconcile(scene: Scene, runs: Sequence[GoldenRun]) -> Consensus:
    """Tables with the digits on which all ``runs`` agree; the first run has the finest numbers.

    A run that ends at a pole (Euler form) counts for the rows before it.

    Raises ``ArithmeticError``: the runs disagree: another end, another number of events, an event
    whose directions do not alternate; or no run has a row to compare with the first run.
    """
    first = runs[0]
    for run in runs:
        if run.status not in (first.status, "pole"):
            raise ArithmeticError(
                f"{scene.name}: {first.label} ended {first.status}, {run.label} {run.status}"
            )
        if run.suspects:
            raise ArithmeticError(
                f"{scene.name}: {run.label} may have missed an event: {', '.join(run.suspects)}"
            )
    scales = _scales(scene, runs)
    rows = [_rows(run) for run in runs]
    if not any(rows[1:]):
        raise ArithmeticError(f"{scene.name}: no run has a row to compare with {first.label}")
    lists = [ordered_events(run) for run in runs]
    _require_same_events(scene, runs, lists)
    names = first.trajectory.columns
    labels = [run.label for run in runs[1:]]
    trajectory, agreements, lost = _merged(names, labels, rows, scales)
    exact_times = [exact_decimal(t) for t in scene.sample_times[: len(trajectory)]]
    if first.status != "complete":
        exact_times[-1] = None
    dated = [(time or row[0], *row[1:]) for time, row in zip(exact_times, trajectory, strict=True)]
    happened = [[cells for _, _, cells in listed] for listed in lists]
    events, agreements_at_events, lost_events = _merged(names, labels, happened, scales)
    labelled = [
        (name, row[0], str(direction), *row[1:])
        for (name, direction, _), row in zip(lists[0], events, strict=True)
    ]
    return Consensus(
        status=first.status,
        trajectory=Table(names, tuple(dated)),
        events=Table(("name", "t", "direction", *names[1:]), tuple(labelled)),
        agreements={"trajectory": agreements, "events": agreements_at_events},
        contradictions=(*lost, *lost_events),
    )


def _scales(scene: Scene, runs: Sequence[GoldenRun]) -> dict[str, Decimal]:
    """The largest entry of each column; the quantity's size if all entries are rounding errors.

    Rounding errors are less than 1e-34 of the size and differ between runs.
    """
    first = runs[0]
    scales = [scales_of(run.trajectory) for run in runs if run.status == first.status]
    for name, unit in TrueRows.of_table(scene, first.trajectory).units.items():
        largest = {of_run[name] for of_run in scales}
        if len(largest) > 1 and max(largest) < Decimal(unit).scaleb(-DIGITS):
            scales[0][name] = Decimal(unit)
    return scales[0]


def exact_decimal(time: Fraction) -> str | None:
    """A time as a plain decimal; None for a decimal of more than 34 digits."""
    for places in range(DIGITS):
        scaled = time * 10**places
        if scaled.denominator == 1:
            return f"{Decimal(scaled.numerator).scaleb(-places):f}"
    return None


Cells = tuple[str, ...]
Event = tuple[str, int, Cells]


def _rows(run: GoldenRun) -> list[Cells]:
    rows = list(run.trajectory.rows)
    return rows[:-1] if run.status == "pole" else rows


def ordered_events(run: GoldenRun) -> list[Event]:
    """All events with the terminal event, by time, then in the catalogue's order."""
    events: list[Event] = [
        (name, int(direction), (t, *state)) for name, t, direction, *state in run.events.rows
    ]
    if run.status not in ("complete", "pole"):
        events.append((run.status, TERMINAL_DIRECTION, run.trajectory.rows[-1]))
    ordered: list[Event] = []
    for event in sorted(events, key=lambda item: Decimal(item[2][0])):
        position = len(ordered)
        while position and _before_at_once(event, ordered[position - 1]):
            position -= 1
        ordered.insert(position, event)
    return ordered


def _before_at_once(event: Event, other: Event) -> bool:
    time, earlier = Decimal(event[2][0]), Decimal(other[2][0])
    return time - earlier <= SAME_TIME * time and ORDER.index(event[0]) < ORDER.index(other[0])


def _require_same_events(
    scene: Scene, runs: Sequence[GoldenRun], lists: Sequence[list[Event]]
) -> None:
    for run, events in zip(runs[1:], lists[1:], strict=True):
        expected = lists[0]
        if run.status == "pole":
            expected = expected[: len(events)]
        for mine, other in zip(expected, events, strict=False):
            if mine[:2] != other[:2]:
                raise ArithmeticError(
                    f"{scene.name}: {runs[0].label} has {mine[0]} ({mine[1]:+d}) at "
                    f"{float(mine[2][0]):.9g} s, where {run.label} has {other[0]} "
                    f"({other[1]:+d}) at {float(other[2][0]):.9g} s"
                )
        if len(expected) != len(events):
            counts = Counter(e[0] for e in expected)
            counts.subtract(e[0] for e in events)
            raise ArithmeticError(
                f"{scene.name}: {runs[0].label} and {run.label} differ in the number of events: "
                + ", ".join(f"{name} by {n}" for name, n in counts.items() if n)
            )


def _merged(
    names: Cells,
    labels: Sequence[str],
    tables: Sequence[Sequence[Cells]],
    scales: dict[str, Decimal],
) -> tuple[list[Cells], Agreements, list[str]]:
    """Published rows, the worst agreement of each later table with the first, contradictions."""
    # a run that ended before the first row has no agreement
    compared = [label for label, t in zip(labels, tables[1:], strict=True) if t or not tables[0]]
    worst = {name: dict.fromkeys(compared, math.inf) for name in names}
    merged: list[Cells] = []
    contradictions = []
    for index, cells in enumerate(tables[0]):
        rows = [
            (label, t[index]) for label, t in zip(labels, tables[1:], strict=True) if index < len(t)
        ]
        row = []
        for position, name in enumerate(names):
            texts = [cells[position], *(other[position] for _, other in rows)]
            if "" in texts:
                row.append("")
                continue
            values = [Decimal(text) for text in texts]
            row.append(common_text(values, scales[name]))
            if row[-1] and not is_near_zero(row[-1], scales[name]):
                for (label, _), value in zip(rows, values[1:], strict=True):
                    worst[name][label] = min(worst[name][label], agreement(values[0], value))
        tilted = not row[names.index("kx")] == row[names.index("ky")] == ZERO
        for position, name in enumerate(names):
            if not tilted and name in UNDEFINED_AT_POLE:
                # the direction of a computed 1e-50 is rounding, even if all runs agree
                row[position] = ""
            elif not row[position] and cells[position]:
                contradictions.append(f"{name} at t = {float(cells[0]):.9g} s")
        merged.append(tuple(row))
    return merged, worst, contradictions
