"""``conservation``: every check that a trajectory's columns and its scene allow, and assertions."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy

from tt_precise.check import causes
from tt_precise.check.checks import DEFAULT_LIMITS, chosen_limits, finite, judge
from tt_precise.check.columns import QUATERNION, TRACK, Columns, choose_set, require_whole
from tt_precise.check.conventions import OURS, convention_of, convert, engine_table
from tt_precise.check.result import Result
from tt_precise.check.rows import Assumptions, Rows
from tt_precise.check.solution import DECIDING, Texts, agreement, distance, find_start
from tt_precise.check.sources import FileRows, open_table, read_rows
from tt_precise.golden.solution import TrueSolution
from tt_precise.golden.store import Folder
from tt_precise.mechanics.conserved import OF_QUANTITY
from tt_precise.mechanics.digits import MOST_GOLDEN
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.terminal import Progress, one_line, silent
from tt_precise.runtime.values import Check, InputError, listed, require_name
from tt_precise.scene.scene import Scene, load_scene

OF_FILE = ("finite", "start", "agreement", "golden")  # checks that are not made row by row
FULL = 1e-12  # relative rounding below which numbers are as good as doubles


def conservation(
    trajectory: object,
    scene: str | Path | Scene,
    *,
    limits: Mapping[str, float] | None = None,
    until: float | None = None,
    digits: float | None = None,
    friction: str = "scene",
    start: str = "scene",
    allow: str | Sequence[str] = (),
    engine: str | None = None,
    world: str = "z-up",
    axis: str = "z",
    columns: Mapping[str, str] | None = None,
    folder: Folder = None,
    progress: Progress = silent,
) -> Result:
    """Check the conservation laws of a trajectory, and its agreement with the scene's solution.

    The result passes only if no check fails and every deciding check was made: with the scene's
    friction the equations, or the distance from the solution to three digits; with another friction
    attitude and momentum; the start; every known column.

    Parameters
    ----------
    trajectory
        A path (.csv, .csv.gz, .parquet, .h5 ...; "-" is standard input), a DataFrame, a mapping
        from column names to arrays, or a ``Trajectory``; SI, in one of the column sets of
        ``columns.COLUMN_SETS``.
    scene
        Body, friction and model: a ``Scene``, a shipped name or a TOML file.
    limits
        Limits by name of the check; other checks keep their defaults.
    until
        Rows after this time (s) are left out.
    digits
        Correct digits required of every column; without ``digits`` they are only reported.
    friction
        "scene", or "other" for the checks that hold for every friction law.
    start
        "scene", or "other" if the motion has another start than the scene's.
    allow
        Names of checks that may stay open, also as one text with commas.
    engine
        The engine whose own state ``trajectory`` has: "mujoco", "drake", "bullet", ...
    world, axis
        A name of ``conventions.WORLDS`` and the body's symmetry axis, for rigid-body columns.
    columns
        A mapping from the trajectory's column names to the names of ``columns.COLUMN_SETS``.
    folder
        Folder of golden data; by default the package's, and ``golden``.

    Raises
    ------
    InputError
        The trajectory cannot be used; one line gives the place and the reason.
    """
    chosen, allow = chosen_limits(limits or {}), listed(allow)
    for name in allow:
        require_name("allow", name, (*chosen, *OF_FILE))
    cutoff = math.inf if until is None else finite("until", until)
    if digits is not None and not 0 < finite("digits", digits) <= MOST_GOLDEN:
        raise InputError(f"digits: got {digits!r}, expected 0 < digits <= {MOST_GOLDEN}")
    for option, value in (("friction", friction), ("start", start)):
        if digits is not None and value != "scene":
            raise InputError(f"digits: got {option} {value}, expected the scene's own {option}")
    scene = load_scene(scene)
    convention = (convention_of(engine) if engine else OURS).in_world(world, axis)
    if engine:
        table = engine_table(trajectory, engine, columns or {})
    else:
        table = open_table(trajectory, columns)
    # overflow and undefined values fail the check instead of giving a warning
    with numpy.errstate(all="ignore"):
        column_set = choose_set(table.names, table.where)
        velocity = require_whole(table.names, column_set.velocity, "velocity", table.where)
        if scene.lifts and velocity:
            require_whole(table.names, column_set.height, "height and its rate", table.where)
        file_rows = read_rows(table, cutoff)
        rows = Rows.of(Assumptions(scene, column_set, friction, start), file_rows.columns)
        if convention != OURS and column_set.name != "rigid body":
            raise InputError(
                f"{table.where}: got {column_set.name} columns, expected those of a rigid body "
                "with another world or axis"
            )

        def reader(body: Parameters) -> Columns:
            return {} if convention == OURS else convert(file_rows.columns, convention, body)

        rows = rows.changed(reader(rows.body))
        solution = TrueSolution(scene, folder, progress)
        texts = table.texts if convention == OURS else None
        result = Result(
            table.where, scene.name, column_set.name, len(rows.t), file_rows.t_first,
            file_rows.t_first + float(rows.t.max(initial=0.0)), (file_rows.finite,),
        )  # fmt: skip
        if len(rows.t) < 2:
            note, names = "fewer than two finite rows", (*DEFAULT_LIMITS, *OF_FILE[1:])
            skipped = [Check(name, "skipped", note=note) for name in names]
            return replace(result, checks=(file_rows.finite, *skipped))
        checks = _checks(rows, file_rows, texts, chosen, digits, cutoff, solution)
        result = replace(
            result, checks=tuple(checks), unseen=_unseen(checks, rows.assumed, allow),
            written=f"some {-math.log10(rows.rounding):.0f} digits" if rows.rounding > FULL else "",
        )  # fmt: skip
        return _explained(result, rows, chosen, solution, reader)


def _checks(
    rows: Rows, file_rows: FileRows, texts: Texts | None, limits: Mapping[str, float],
    digits: float | None, cutoff: float, solution: TrueSolution,
) -> list[Check]:  # fmt: skip
    """Return the results of all checks."""
    by_name = {check.name: check for check in judge(rows, limits)}
    if all(check.holds for check in by_name.values()):
        rows.cache.clear()  # the comparison with the solution needs the memory
    begin, alone = find_start(rows, file_rows.t_first, solution), None
    if by_name["equations"].verdict in ("open", "skipped"):
        alone = 4 * max(rows.rounding, rows.position_rounding) + rows.time_rounding
    end = cutoff if file_rows.finite.holds else float(rows.t[-1])
    golden = distance(rows, texts, begin, file_rows.t_first, end, digits, alone, solution)
    # columns beside the state that the attitude, or the solution, has looked at
    good = golden.parts if golden.verdict == "pass" else {}
    followed = {name for name in TRACK if good.get(name, 0.0) >= DECIDING}
    if by_name["kinematics"].verdict == "pass":
        moves = rows.has_velocity and rows.assumed.columns.azimuth
        followed |= {"x", "y", "z"} if moves else set()
        followed |= set() if rows.assumed.scene.lifts else {"z"}
        followed |= {"psi", *QUATERNION} if rows.motion.q is not None else set()
    row_checks = [by_name[name] for name in DEFAULT_LIMITS if name in by_name]
    return [file_rows.finite, *row_checks, begin.check, agreement(rows, followed), golden]


def _unseen(checks: Sequence[Check], assumed: Assumptions, allow: Sequence[str]) -> tuple[str, ...]:
    """Return the deciding checks that were not made, in words."""
    deciding = {"the attitude": ["kinematics"], "the momentum": ["contact_momentum"]}
    if assumed.friction == "scene":
        deciding = {"the equations of motion": ["equations", "golden"]}
    deciding |= {"the start": ["start"], "all columns": ["agreement"]}
    made = {check.name for check in checks if check.verdict in ("pass", "fail")} | {*allow}
    made |= {"start"} if assumed.start == "other" else set()
    notes = {check.name: f"{check.name}: {check.note}" for check in checks}
    return tuple(
        f"{what} ({', '.join(notes[name] for name in names)})"
        for what, names in deciding.items()
        if not made & {*names}
    )


def _explained(
    result: Result,
    rows: Rows,
    limits: Mapping[str, float],
    solution: TrueSolution,
    reader: causes.Reader,
) -> Result:
    """Return a result with the causes of its failures, or with what a pass would have seen.

    An open check of the attitude fails where another convention resolves it.
    """
    if not result.unseen and {check.name for check in result.failures} <= {"finite"}:
        return replace(result, would_have_seen=causes.power(rows, limits, reader))

    def repeat(other: Rows) -> Iterator[Check]:
        if not result["start"].holds:
            yield find_start(other, result.t_first, solution).check
        yield from judge(other, limits)

    found, checks = causes.explain(rows, result.checks, repeat, reader), list(result.checks)
    for cause in found:
        attitude = result["kinematics"]
        if cause.kind == "convention" and attitude.verdict == "open":
            checks[checks.index(attitude)] = replace(
                attitude, verdict="fail", value=None, at=None, since=0.0, curve=None,
                note=f"the rows follow from each other if {cause.text}",
            )  # fmt: skip
    return replace(result, checks=tuple(checks), causes=tuple(found))


def assert_conserves(
    trajectory: object,
    scene: str | Path | Scene,
    *,
    limits: Mapping[str, float] | None = None,
    **options: Any,
) -> Result:
    """Assert that the trajectory passes; ``options`` are those of ``conservation``.

    A limit can be a keyword argument, ``jellett=1e-9``; the assertion then also fails if this check
    could not be made.

    Raises
    ------
    AssertionError
        A check failed (one line each, with time, value and limit), or a deciding check could not be
        made.
    InputError
        The trajectory cannot be used.
    """
    __tracebackhide__ = True
    accepted = inspect.signature(conservation).parameters
    demanded = {OF_QUANTITY.get(n, n): options.pop(n) for n in [*options] if n not in accepted}
    result = conservation(trajectory, scene, limits={**(limits or {}), **demanded}, **options)
    checks = {check.name: check for check in result.checks}
    lines = []
    for name in demanded:
        check = checks.get(name, Check(name, "skipped", note="of flight only"))
        if check.verdict in ("skipped", "open"):
            lines.append(
                f"{name}: a limit was given, but the check is {check.verdict}: {check.note}"
            )
    return _asserted(result, result.passed and not lines, lines)


def assert_matches_golden(
    trajectory: object, scene: str | Path | Scene, *, digits: float, **options: Any
) -> Result:
    """Assert that every column has ``digits`` correct digits of the scene's solution.

    ``options`` are those of ``conservation``.

    Raises
    ------
    AssertionError
        A column has fewer digits; the message names time and columns.
    InputError
        The trajectory cannot be used, or there is no solution to compare it with.
    """
    __tracebackhide__ = True
    result = conservation(trajectory, scene, digits=digits, **options)
    golden = result["golden"]
    few = [f"{name} {correct:.1f}" for name, correct in golden.parts.items() if correct < digits]
    lines = [f"correct digits: {', '.join(few)}"] if few else []
    lines.append(f"over time: {golden.history or 'nothing to compare'}")
    return _asserted(result, golden.verdict == "pass" and result["finite"].holds, lines)


def _asserted(result: Result, good: bool, lines: Sequence[str]) -> Result:
    """Return a ``good`` result; else raise ``AssertionError`` with its summary and ``lines``."""
    __tracebackhide__ = True
    if not good:
        raise AssertionError("\n  ".join(map(one_line, [*result.summary(), *lines])))
    return result
