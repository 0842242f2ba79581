"""``conservation``: every check that a trajectory's columns and its scene allow, and assertions."""

from __future__ import annotations

import inspect
import math
import operator
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy

from tt_precise.check.checks import RowCheck, checks_of, chosen_limits, finite
from tt_precise.check.columns import Block, CheckSetup, Samples, choose_set, known_columns
from tt_precise.check.golden import GoldenDistance
from tt_precise.check.result import Result, RunningWorst
from tt_precise.check.sources import NotFinite, RowSource, UsableRows, open_source
from tt_precise.check.units import refuse_other_units
from tt_precise.golden.store import Folder
from tt_precise.mechanics.digits import MOST_GOLDEN
from tt_precise.runtime.terminal import Progress, one_line, silent
from tt_precise.runtime.values import Check, InputError, Verdict
from tt_precise.scene.scene import Scene, load_scene

MEANING = "every column holds finite numbers, except Euler angles where they are undefined"


class Finiteness:
    """Counts entries that are not finite, in the state's columns and the columns ``also``."""

    def __init__(self, also: Sequence[str]):
        self._also = also
        self._count, self._first = 0, ""
        self._at: float | None = None

    def look(self, block: Block, samples: Samples) -> None:
        tilted = (samples.state.kx != 0) | (samples.state.ky != 0)
        for name in self._also:
            wrong = numpy.flatnonzero(~numpy.isfinite(block.values[name]) & tilted)
            self._count += len(wrong)
            if len(wrong) and (self._at is None or samples.t[wrong[0]] < self._at):
                row = int(wrong[0])
                self._at = float(samples.t[row])
                self._first = f"{name} = {block.values[name][row]} in {block.place(row)}"

    def finding(self, broken: NotFinite | None) -> Check:
        """The number of entries that are not finite, including the row where reading stopped."""
        count, at, first = self._count, self._at, self._first
        if broken is not None:
            count, first = count + 1, f"{broken}, where the checks stop"
            at = broken.t if at is None else min(at, broken.t)
        return Check("finite", "fail" if count else "pass", float(count), 0.0, at, first, MEANING)


HOLDS = {"at most": operator.le, "above": operator.gt, "at least": operator.ge}


def conservation(
    trajectory: object,
    scene: str | Path | Scene,
    *,
    limits: Mapping[str, float] | None = None,
    until: float | None = None,
    digits: float | None = None,
    fresh: bool = False,
    friction: str = "scene",
    engine: str | None = None,
    columns: Mapping[str, str] | None = None,
    folder: Folder = None,
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
        Body, friction and model: a ``Scene``, a shipped name or a TOML file.
    limits
        By name of the check; other checks keep their defaults.
    until
        Rows after this time (s) are left out.
    digits
        Correct digits required of every column, relative to golden data; without ``digits`` the
        distance is only reported.
    fresh
        Compute the solution where there is no golden row (imports heyoka).
    friction
        "scene", or "other" if the contact force is not the scene's: then only checks that hold
        for every friction law are made.
    engine
        The engine that wrote the file ``trajectory``: "mujoco", "drake", "bullet", ...
    columns
        Renames: their name to ours.
    folder
        Folder of golden data; by default the package's, and ``golden``.

    Raises
    ------
    InputError
        The trajectory cannot be used: one line that says where and why.
    """
    wanted = chosen_limits(limits or {})
    cutoff = math.inf if until is None else finite("until", until)
    if digits is not None and not 0 < finite("digits", digits) <= MOST_GOLDEN:
        raise InputError(
            f"digits: got {digits!r}, expected a number above 0 and at most {MOST_GOLDEN}, where "
            "golden data end"
        )
    if digits is not None and friction != "scene":
        raise InputError("digits: golden data obey the scene's friction; expected friction scene")
    golden = partial(GoldenDistance, asked=digits, fresh=fresh, folder=folder)
    scene = load_scene(scene)
    if engine is not None:
        from tt_precise.check.engine_states import engine_source

        if not isinstance(trajectory, str | Path):
            got = type(trajectory).__name__
            raise InputError(f"trajectory: got a {got}, expected the path of an engine's file")
        trajectory = engine_source(str(trajectory), engine, scene, columns or {})
    # overflow and undefined values fail the check instead of giving a warning
    with closing(open_source(trajectory, columns)) as table, numpy.errstate(all="ignore"):
        setup = _setup(table, scene, friction)
        return _checked(table, setup, wanted, cutoff, golden, progress)


OPTIONS = inspect.signature(conservation).parameters


def _checked(
    table: RowSource,
    setup: CheckSetup,
    limits: Mapping[str, float],
    cutoff: float,
    golden: Callable[[CheckSetup, Sequence[str]], GoldenDistance],
    progress: Progress,
) -> Result:
    height = setup.columns.height if setup.height_given else ()
    names = ("t", *(n for n in (*setup.columns.names, *height) if n in table.names))
    also = [name for name in known_columns(table.names) if name not in names]
    finiteness, distance = Finiteness(also), None
    running: list[_Running] = []
    checks = checks_of(setup.scene)
    rows, samples, first = 0, None, None
    usable = UsableRows(table.blocks(names, also, progress), names, table.where, cutoff)
    for block in usable:
        read = setup.samples(block)
        if first is None:
            try:
                refuse_other_units(setup, read, block, table.names, table.otherwise)
            except InputError as error:
                raise InputError(f"{table.where}: {error}") from None
            first = read
            running = [_Running(check, setup, read, limits) for check in checks]
            if setup.friction == "scene":
                # golden data are read only if there are rows
                distance = golden(setup, table.names)
        joined = read if samples is None else samples.continued(read)
        for check in running:
            check.look(joined)
        finiteness.look(block, read)
        if distance is not None:
            distance.look(block, read)
        rows, samples = rows + len(block), read
    if rows < 2 and not usable.broken:
        raise InputError(
            f"{table.where}: got {'one row' if rows else 'no rows'}"
            + (f" up to t = {cutoff:g} s" if cutoff < math.inf else "")
            + ", expected a trajectory of at least two"
        )
    findings = [finiteness.finding(usable.broken)]
    if rows < 2:
        reason = f"fewer than two rows before {usable.broken}"
        missed = (*(check.name for check in checks), "golden")
        findings += [Check(name, "skipped", note=reason) for name in missed]
    else:
        found = [check.finding() for check in running]
        findings += found if setup.flies else _with_advice(found)
        if distance is None:
            reason = "golden data obey the scene's own friction"
            findings.append(Check("golden", "skipped", note=reason))
        else:
            ended = f"the rows end at {usable.broken}" if usable.broken else ""
            findings.append(distance.finding(cutoff, ended, progress))
    end = usable.broken.t if usable.broken else 0.0
    return Result(
        trajectory=table.where,
        scene=setup.scene.name,
        columns=setup.columns.name,
        rows=rows,
        t_first=float(first.t[0]) if first else end,
        t_last=float(samples.t[-1]) if samples else end,
        checks=tuple(findings),
    )


def _with_advice(findings: list[Check]) -> list[Check]:
    """Add advice to the result of ``equations`` if only the contact force can differ."""
    failed = {finding.name: finding for finding in findings if finding.verdict == "fail"}
    equations = failed.get("equations")
    proven = failed.keys() & {"kinematics", "contact_momentum"}
    # a cause that is named stands before the error bound
    if equations is None or proven or not equations.note.startswith("error bound"):
        return findings
    advice = "if the contact force is another one than the scene's, --friction other"
    advised = f"{equations.note}; {advice}"
    return [replace(check, note=advised) if check is equations else check for check in findings]


def _setup(table: RowSource, scene: Scene, friction: str) -> CheckSetup:
    chosen = choose_set(table.names, table.where)
    velocity = _all_or_none(table, chosen.velocity, "velocity")
    height = scene.lifts and velocity and _all_or_none(table, chosen.height, "height and its rate")
    return CheckSetup(scene, chosen, velocity, friction, height)


def _all_or_none(table: RowSource, wanted: Sequence[str], what: str) -> bool:
    given = [name for name in wanted if name in table.names]
    missing = [name for name in wanted if name not in given]
    if given and missing:
        raise InputError(
            f"{table.where}: has {', '.join(given)} but not {', '.join(missing)}, "
            f"expected all of the {what} or none"
        )
    return bool(given)


class _Running:
    """A check that processes the rows."""

    def __init__(
        self, check: RowCheck, setup: CheckSetup, first: Samples, limits: Mapping[str, float]
    ):
        self._check, self._limit = check, limits[check.name]
        self._skipped = check.skipped(setup, first)
        self._worst = RunningWorst(largest_is_worst=check.sense == "at most")
        self._watch = None if self._skipped else check.watch(setup, first, self._limit)

    def look(self, samples: Samples) -> None:
        if self._watch:
            self._worst.add(samples.t, self._watch(samples))

    def finding(self) -> Check:
        check, value, limit = self._check, self._worst.worst, self._limit
        verdict: Verdict = "skipped"
        reason = self._skipped
        if self._watch and value is not None:
            holds = HOLDS[check.sense](value, limit)
            verdict = "pass" if holds else "fail"
            watch: Any = self._watch
            # not getattr: an AttributeError within ``note`` is a bug, not a missing note
            reason = watch.note if hasattr(type(watch), "note") else ""
            if not math.isfinite(value):
                reason = "not finite there"
            if holds and getattr(watch, "error_bound", -math.inf) > limit:
                verdict, reason = "skipped", f"rows too far apart: {reason}"
        return Check(
            name=check.name,
            verdict=verdict,
            value=value,
            limit=limit if self._watch else None,
            at=self._worst.at,
            note=reason,
            meaning=check.meaning,
            sense=check.sense,
            curve=self._worst.curve if self._watch else None,
        )


def assert_conserves(
    trajectory: object,
    scene: str | Path | Scene,
    *,
    limits: Mapping[str, float] | None = None,
    **options: Any,
) -> Result:
    """Assert that no check fails; ``options`` are those of ``conservation``.

    A limit can be given as a keyword, ``jellett=1e-9``; the assertion then also fails if this check
    was skipped.

    Raises
    ------
    AssertionError
        A check failed; one line for each with its time, value and limit.
    InputError
        The trajectory cannot be used.
    """
    __tracebackhide__ = True
    demanded = {name: options.pop(name) for name in [*options] if name not in OPTIONS}
    result = conservation(trajectory, scene, limits={**(limits or {}), **demanded}, **options)
    lines = [finding.sentence() for finding in result.failures]
    checks = {finding.name: finding for finding in result.checks}
    for name in demanded:
        if name not in checks:
            lines.append(f"{name}: a limit was given, but the check is of flight only")
        elif checks[name].verdict == "skipped":
            reason = checks[name].note
            lines.append(f"{name}: a limit was given, but the check was skipped: {reason}")
    if lines:
        raise _failure(result, lines)
    return result


def assert_matches_golden(
    trajectory: object, scene: str | Path | Scene, *, digits: float, **options: Any
) -> Result:
    """Assert that every column has ``digits`` correct digits at the golden times.

    ``options`` are those of ``conservation``; with ``fresh`` the solution is computed at times
    without a golden row.

    Raises
    ------
    AssertionError
        A column has fewer digits; the message names time and columns.
    InputError
        The trajectory cannot be used, or there is no solution to compare it with.
    """
    __tracebackhide__ = True
    if digits is None:
        raise InputError("digits: got None, expected the number of correct digits wanted")
    result = conservation(trajectory, scene, digits=digits, **options)
    golden = result["golden"]
    if golden.verdict != "pass":
        few = {name: correct for name, correct in golden.parts.items() if correct < digits}
        listed = ", ".join(f"{name} {correct:.1f}" for name, correct in few.items())
        lines = [golden.sentence()]
        lines += [f"correct digits: {listed}"] if few else []
        lines.append(f"over time: {golden.history or 'nothing to compare'}")
        raise _failure(result, lines)
    return result


def _failure(result: Result, lines: Sequence[str]) -> AssertionError:
    heading = f"{result.trajectory} against {result.scene}:"
    return AssertionError("\n  ".join(map(one_line, [heading, *lines])))
