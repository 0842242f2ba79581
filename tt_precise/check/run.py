"""``conservation``: every check that a trajectory's columns and its scene allow."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy

from tt_precise.check.checks import CHECKS, RowCheck, Watch
from tt_precise.check.columns import choose_set, known_columns
from tt_precise.check.golden import Distance
from tt_precise.check.limits import chosen_limits
from tt_precise.check.reading import Block, RowSource, checked_blocks, open_source
from tt_precise.check.result import CheckFinding, Result, Verdict
from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.check.unit_guard import refuse_other_units
from tt_precise.check.worst import RunningWorst
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
    """RowCheck what a trajectory must conserve.

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
    with closing(open_source(trajectory, columns)) as table, numpy.errstate(all="ignore"):
        return _checked(table, load_scene(scene), wanted, until, digits, fresh, friction, progress)


def _checked(
    table: RowSource,
    scene: Scene,
    limits: Mapping[str, float],
    until: float | None,
    digits: float | None,
    fresh: bool,
    friction: str,
    progress: Progress,
) -> Result:
    setup = _setup(table, scene, friction)
    cutoff = math.inf if until is None else _cutoff(until)
    if digits is not None and not setup.own_force:
        raise InputError("digits: golden data obey the scene's friction; expected friction scene")
    distance = Distance(setup, table.names, digits, fresh) if setup.own_force else None
    names = ("t", *(name for name in setup.columns.names if name in table.names))
    also = [name for name in known_columns(table.names) if name not in names]
    running: list[_Running] | None = None
    rows, samples, first = 0, None, None
    for block in checked_blocks(table.blocks(names, also, progress), table.where, cutoff):
        read = setup.samples(block)
        if running is None:
            _refuse(setup, read, block, table)
            running, first = [_Running(check, setup, read, limits) for check in CHECKS], read
        joined = read if samples is None else samples.continued(read)
        for check in running:
            check.look(joined)
        if distance is not None:
            distance.look(block, read)
        rows, samples = rows + len(block), read
    if running is None or first is None or samples is None or rows < 2:
        raise InputError(
            f"{table.where}: got {'one row' if rows else 'no rows'}"
            + (f" up to t = {cutoff:g} s" if cutoff < math.inf else "")
            + ", expected a trajectory of at least two"
        )
    if distance is None:
        golden = CheckFinding(
            "golden", "skipped", reason="golden data obey the scene's own friction"
        )
    else:
        golden = distance.finding(progress)
    return Result(
        trajectory=table.where,
        scene=scene.name,
        columns=setup.columns.name,
        rows=rows,
        t_first=float(first.t[0]),
        t_last=float(samples.t[-1]),
        checks=(*(check.finding() for check in running), golden),
    )


def _setup(table: RowSource, scene: Scene, friction: str) -> CheckSetup:
    chosen = choose_set(table.names, table.where)
    given = [name for name in chosen.velocity if name in table.names]
    if given and len(given) < len(chosen.velocity):
        missing = [name for name in chosen.velocity if name not in given]
        raise InputError(
            f"{table.where}: has {', '.join(given)} but not {', '.join(missing)}, "
            "expected all of the velocity or none"
        )
    return CheckSetup(scene, chosen, bool(given), friction)


def _refuse(setup: CheckSetup, first: Samples, block: Block, table: RowSource) -> None:
    try:
        refuse_other_units(setup, first, block, table.names)
    except InputError as error:
        raise InputError(f"{table.where}: {error}") from None


def _cutoff(until: float) -> float:
    if not isinstance(until, int | float) or math.isnan(until):
        raise InputError(f"until: got {until!r}, expected a time in s")
    return float(until)


class _Running:
    """One check on its way through the rows."""

    def __init__(
        self, check: RowCheck, setup: CheckSetup, first: Samples, limits: Mapping[str, float]
    ):
        self._check, self._limit = check, limits[check.name]
        self._skipped = check.skipped(setup, first)
        self._worst = RunningWorst(largest_is_worst=check.sense == "at most")
        self._watch: Watch | None = (
            None if self._skipped else check.watch(setup, first, self._limit)
        )

    def look(self, samples: Samples) -> None:
        if self._watch:
            self._worst.add(samples.t, self._watch(samples))

    def finding(self) -> CheckFinding:
        check, value, limit = self._check, self._worst.worst, self._limit
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
        return CheckFinding(
            name=check.name,
            verdict=verdict,
            value=value,
            limit=limit if self._watch else None,
            at=self._worst.at,
            reason=reason,
            meaning=check.meaning,
            sense=check.sense,
            curve=self._worst.curve if self._watch else None,
        )
