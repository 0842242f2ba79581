"""``conservation``: every check that a trajectory's columns and its scene allow."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy

from tt_precise.check.checks import CHECKS, Check, Watch
from tt_precise.check.columns import choose_set, known_columns
from tt_precise.check.golden import Distance
from tt_precise.check.limits import chosen_limits
from tt_precise.check.reading import Block, Table, checked_blocks, open_table
from tt_precise.check.result import Finding, Result, Verdict
from tt_precise.check.stretch import Case, Stretch
from tt_precise.check.suspicion import refuse_other_units
from tt_precise.check.trace import Trace
from tt_precise.errors import InputError
from tt_precise.progress import Progress, silent
from tt_precise.scene import Scene, load_scene

HOLDS = {"at most": operator.le, "above": operator.gt, "at least": operator.ge}


def conservation(
    trajectory: Any,
    scene: str | Path | Scene,
    *,
    limits: Mapping[str, float] | None = None,
    until: float | None = None,
    digits: float | None = None,
    fresh: bool = False,
    friction: str = "scene",
    columns: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> Result:
    """Check what a trajectory must conserve.

    Parameters
    ----------
    trajectory
        A path (.csv, .csv.gz, .parquet; "-" is standard input), a DataFrame, a mapping from
        column names to arrays, or a ``Trajectory``; SI, in one of the column sets of
        ``columns.COLUMN_SETS``.
    scene
        Says the body, the friction and the model: a ``Scene``, a shipped name or a TOML file.
    limits
        By name of the check; the others keep their defaults.
    until
        Rows after this time (s) are left out.
    digits
        Correct digits wanted of every column where there is golden data; without it the
        distance is reported and fails nothing.
    fresh
        Compute the solution where there is no golden row (imports heyoka).
    friction
        "scene", or "other" where the contact force is not the scene's: then only what holds for
        every friction law is checked.
    columns
        Renames: their name to ours.

    Raises
    ------
    InputError
        The trajectory cannot be used: one line that says where and why.
    """
    wanted = chosen_limits(limits or {})
    # what overflows or is undefined becomes a value that fails, not a warning
    with closing(open_table(trajectory, columns)) as table, numpy.errstate(all="ignore"):
        return _checked(table, load_scene(scene), wanted, until, digits, fresh, friction, progress)


def _checked(
    table: Table,
    scene: Scene,
    limits: Mapping[str, float],
    until: float | None,
    digits: float | None,
    fresh: bool,
    friction: str,
    progress: Progress,
) -> Result:
    case = _case(table, scene, friction)
    cutoff = math.inf if until is None else _cutoff(until)
    if digits is not None and not case.own_force:
        raise InputError("digits: golden data obey the scene's friction; expected friction scene")
    distance = Distance(case, table.names, digits, fresh) if case.own_force else None
    names = ("t", *(name for name in case.columns.names if name in table.names))
    also = [name for name in known_columns(table.names) if name not in names]
    running: list[_Running] | None = None
    rows, stretch, first = 0, None, None
    for block in checked_blocks(table.blocks(names, also, progress), table.where, cutoff):
        read = case.stretch(block)
        if running is None:
            _refuse(case, read, block, table)
            running, first = [_Running(check, case, read, limits) for check in CHECKS], read
        joined = read if stretch is None else stretch.continued(read)
        for check in running:
            check.look(joined)
        if distance is not None:
            distance.look(block, read)
        rows, stretch = rows + len(block), read
    if running is None or first is None or stretch is None or rows < 2:
        raise InputError(
            f"{table.where}: got {'one row' if rows else 'no rows'}"
            + (f" up to t = {cutoff:g} s" if cutoff < math.inf else "")
            + ", expected a trajectory of at least two"
        )
    if distance is None:
        golden = Finding("golden", "skipped", reason="golden data obey the scene's own friction")
    else:
        golden = distance.finding(progress)
    return Result(
        trajectory=table.where,
        scene=scene.name,
        columns=case.columns.name,
        rows=rows,
        t_first=float(first.t[0]),
        t_last=float(stretch.t[-1]),
        checks=(*(check.finding() for check in running), golden),
    )


def _case(table: Table, scene: Scene, friction: str) -> Case:
    chosen = choose_set(table.names, table.where)
    given = [name for name in chosen.velocity if name in table.names]
    if given and len(given) < len(chosen.velocity):
        missing = [name for name in chosen.velocity if name not in given]
        raise InputError(
            f"{table.where}: has {', '.join(given)} but not {', '.join(missing)}, "
            "expected all of the velocity or none"
        )
    return Case(scene, chosen, bool(given), friction)


def _refuse(case: Case, first: Stretch, block: Block, table: Table) -> None:
    try:
        refuse_other_units(case, first, block, table.names)
    except InputError as error:
        raise InputError(f"{table.where}: {error}") from None


def _cutoff(until: float) -> float:
    if not isinstance(until, int | float) or math.isnan(until):
        raise InputError(f"until: got {until!r}, expected a time in s")
    return float(until)


class _Running:
    """One check on its way through the rows."""

    def __init__(self, check: Check, case: Case, first: Stretch, limits: Mapping[str, float]):
        self._check, self._limit = check, limits[check.name]
        self._skipped = check.skipped(case, first)
        self._trace = Trace(largest_is_worst=check.sense == "at most")
        self._watch: Watch | None = None if self._skipped else check.watch(case, first, self._limit)

    def look(self, stretch: Stretch) -> None:
        if self._watch:
            self._trace.add(stretch.t, self._watch(stretch))

    def finding(self) -> Finding:
        check, value, limit = self._check, self._trace.worst, self._limit
        verdict: Verdict = "skipped"
        reason = self._skipped
        if self._watch and value is not None:
            holds = HOLDS[check.sense](value, limit)
            verdict = "pass" if holds else "fail"
            doubt = getattr(self._watch, "doubt", -math.inf)
            reason = getattr(self._watch, "note", "")
            if not math.isfinite(value):
                reason = "not finite there"
            if holds and doubt > limit:
                verdict, reason = "skipped", f"rows too far apart: {reason}"
        return Finding(
            name=check.name,
            verdict=verdict,
            value=value,
            limit=limit if self._watch else None,
            at=self._trace.at,
            reason=reason,
            meaning=check.meaning,
            sense=check.sense,
            curve=self._trace.curve if self._watch else None,
        )
