"""``conservation``: every check that a trajectory's columns and its scene allow, and assertions."""

from __future__ import annotations

import inspect
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy

from tt_precise.check.checks import (
    DEFAULT_LIMITS,
    chosen_limits,
    finite,
    judge,
    position_rounding,
)
from tt_precise.check.columns import QUATERNION, TRACK, choose_set, require_whole
from tt_precise.check.conventions import AXES, OURS, WORLDS, Convention, convert
from tt_precise.check.engine_states import convention_of, engine_table, other_engines
from tt_precise.check.result import Cause, Result
from tt_precise.check.rows import Assumptions, Rows
from tt_precise.check.solution import (
    DECIDING,
    Demand,
    agreement,
    decide_alone,
    decides,
    distance,
    find_start,
)
from tt_precise.check.sources import FileRows, Source, open_table, read_rows
from tt_precise.golden.solution import TrueSolution
from tt_precise.golden.store import Folder
from tt_precise.mechanics.digits import MOST_GOLDEN
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
        Correct digits required of every column, relative to the solution; without ``digits`` the
        distance is only reported.
    friction
        "scene", or "other" if the contact force is not the scene's; "other" makes only the checks
        that hold for every friction law.
    start
        "scene", or "other" if the motion has another start than the scene's.
    allow
        Names of checks that may stay open, also as one text with commas.
    engine
        The engine whose own state ``trajectory`` has: "mujoco", "drake", "bullet", ...
    world, axis
        The handedness and the vertical of the rigid-body columns: "z-up", "y-up",
        "left-handed-z-up" or "left-handed-y-up"; and the body's symmetry axis, "z", "y" or "x".
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
        raise InputError(
            f"digits: got {digits!r}, expected a number above 0 and at most {MOST_GOLDEN}, where "
            "golden data end"
        )
    for option, value in (("friction", friction), ("start", start)):
        if digits is not None and value != "scene":
            raise InputError(
                f"digits: the solution has the scene's {option}; expected {option} scene"
            )
    scene = load_scene(scene)
    own = convention_of(engine) if engine else OURS
    convention = own.in_world(world, axis)
    if engine:
        table = engine_table(trajectory, engine, columns or {})
    else:
        table = open_table(trajectory, columns)
    # overflow and undefined values fail the check instead of giving a warning
    with numpy.errstate(all="ignore"):
        assumed = _assumptions(table, scene, friction, start)
        file_rows = read_rows(table, cutoff)
        rows = Rows.of(assumed, file_rows.columns)
        if convention != OURS:
            if assumed.columns.name != "rigid body":
                raise InputError(
                    f"{table.where}: got {assumed.columns.name} columns, expected those of a rigid "
                    "body with another world or axis"
                )
            rows = rows.changed(convert(rows.columns, convention, rows.body))
        options = _other_options(file_rows, engine, convention, (world, axis))
        texts = table.texts if convention == OURS else None
        examination = partial(_examine, rows, table, file_rows, chosen, digits, cutoff, allow)
        return examination(TrueSolution(scene, folder, progress), options, texts)


# assertions accept the options of ``conservation``; the command calls it by this name
OPTIONS = inspect.signature(conservation).parameters
examine = conservation


def _assumptions(table: Source, scene: Scene, friction: str, start: str) -> Assumptions:
    """Return the assumptions on a table.

    Raises ``InputError``: it has only some of the columns of the velocity, or of the height.
    """
    chosen = choose_set(table.names, table.where)
    velocity = require_whole(table.names, chosen.velocity, "velocity", table.where)
    if scene.lifts and velocity:
        require_whole(table.names, chosen.height, "height and its rate", table.where)
    return Assumptions(scene, chosen, friction, start)


def _other_options(
    file_rows: FileRows, engine: str | None, convention: Convention, world: tuple[str, str]
) -> dict[str, Callable[[Rows], Rows]]:
    """Return how the file would be read with other options, by their text."""
    conventions: dict[str, Convention] = {}
    if engine:
        conventions = {f"with --from {name.removeprefix('--from ')}": other.in_world(*world)
                       for name, other in other_engines(engine).items()}  # fmt: skip
    if world != ("z-up", "z"):
        for pair in itertools.product(WORLDS, AXES):
            names = [f"--world {pair[0]}"] * (pair[0] != "z-up")
            names += [f"--axis {pair[1]}"] * (pair[1] != "z")
            text = f"with {' '.join(names)}" if names else "without --world, --axis"
            if pair != world:
                conventions[text] = convention.in_world(*pair)

    def change(rows: Rows, other: Convention) -> Rows:
        columns = {name: values[: len(rows.t)] for name, values in file_rows.columns.items()}
        return rows.changed(convert(columns, other, rows.body))

    return {text: partial(change, other=other) for text, other in conventions.items()}


def _examine(
    rows: Rows, table: Source, file_rows: FileRows, limits: Mapping[str, float],
    digits: float | None, cutoff: float, allow: Sequence[str], solution: TrueSolution,
    options: Mapping[str, Callable[[Rows], Rows]], texts: Any,
) -> Result:  # fmt: skip
    """Return the results of all checks, the verdict, and the causes of failures."""
    checks, t_first, assumed = [file_rows.finite], file_rows.t_first, rows.assumed
    unseen, causes, powers = list[str](), list[Cause](), dict[str, float]()
    if len(rows.t) < 2:
        note = "fewer than two finite rows"
        checks += [Check(name, "skipped", note=note) for name in (*DEFAULT_LIMITS, *OF_FILE[1:])]
    else:
        by_name = {check.name: check for check in judge(rows, limits)}
        if all(check.verdict != "fail" for check in by_name.values()):
            rows.cache.clear()  # the comparison with the solution needs the memory
        begin = find_start(rows, t_first, solution)
        broken = (
            "" if file_rows.finite.verdict == "pass" else f"the rows end: {file_rows.finite.note}"
        )
        demand = Demand(digits, cutoff - t_first, broken)
        golden = distance(rows, texts, begin, t_first, demand, solution)
        if by_name["equations"].verdict in ("open", "skipped") and assumed.friction == "scene":
            written = 4 * max(rows.rounding, position_rounding(rows)) + rows.time_rounding
            golden = decide_alone(golden, written)
        followed = _columns_followed(rows, by_name["kinematics"], golden)
        checks += [by_name[name] for name in DEFAULT_LIMITS if name in by_name]
        checks += [begin.check, agreement(rows, followed), golden]
        unseen = _unseen({check.name: check for check in checks}, assumed, allow)
        failed = {check.name for check in checks if check.verdict == "fail"} - {"finite"}
        if unseen or failed:
            from tt_precise.check.causes import explain  # a file that passes needs none

            def repeat(other: Rows) -> Iterator[Check]:
                if begin.check.verdict == "fail":
                    yield find_start(other, t_first, solution).check
                yield from judge(other, limits)

            causes = explain(rows, checks, repeat, options)
            checks = [_by_cause(check, causes) for check in checks]
        else:
            from tt_precise.check.causes import power

            powers = power(rows, limits)
    digits_written = ""
    if len(rows.t) > 1 and rows.rounding > FULL:
        digits_written = f"some {-math.log10(rows.rounding):.0f} digits"
    return Result(
        table.where, assumed.scene.name, assumed.columns.name, len(rows.t), t_first,
        t_first + (float(rows.t[-1]) if len(rows.t) else 0.0), tuple(checks), tuple(unseen),
        tuple(causes), digits_written, powers,
    )  # fmt: skip


def _columns_followed(rows: Rows, kinematics: Check, golden: Check) -> set[str]:
    """Return the columns beside the state that the attitude, or the solution, has looked at."""
    followed = set()
    if kinematics.verdict == "pass":
        followed |= {"phi"} if rows.assumed.columns.azimuth else set()
        followed |= {"psi", *QUATERNION} if rows.motion.q is not None else set()
        x = rows.motion.x
        moves = x is not None and rows.has_velocity and rows.assumed.columns.azimuth
        followed |= {"x", "y", "z"} if moves else set()
        followed |= {"z"} if x is not None and not rows.assumed.scene.lifts else set()
    if golden.verdict == "pass":
        followed |= {name for name in TRACK if golden.parts.get(name, 0.0) >= DECIDING}
    return followed


def _unseen(checks: Mapping[str, Check], assumed: Assumptions, allow: Sequence[str]) -> list[str]:
    """Return the deciding checks that were not made, in words."""

    def has_verdict(name: str) -> bool:
        return name in allow or checks[name].verdict in ("pass", "fail")

    def reasons(*names: str) -> str:
        return ", ".join(f"{name}: {checks[name].note}" for name in names)

    unseen = []
    if assumed.friction == "scene":
        if not (has_verdict("equations") or decides(checks["golden"]) or "golden" in allow):
            unseen.append(f"the equations of motion ({reasons('equations', 'golden')})")
    else:
        for name, what in (("kinematics", "the attitude"), ("contact_momentum", "the momentum")):
            if not has_verdict(name):
                unseen.append(f"{what} ({reasons(name)})")
    for name, what in (("start", "the start"), ("agreement", "all columns")):
        if checks[name].verdict == "open" and name not in allow:
            unseen.append(f"{what} ({checks[name].note})")
    return unseen


def _by_cause(check: Check, causes: Sequence[Cause]) -> Check:
    """Return an open check of the attitude as a failure where another convention resolves it."""
    named = [cause.text for cause in causes if cause.kind == "convention"]
    if check.name != "kinematics" or check.verdict != "open" or not named:
        return check
    note = f"the rows follow from each other if {named[0]}"
    return replace(check, verdict="fail", value=None, at=None, since=0.0, note=note, curve=None)


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
    demanded = {name: options.pop(name) for name in [*options] if name not in OPTIONS}
    result = conservation(trajectory, scene, limits={**(limits or {}), **demanded}, **options)
    checks = {check.name: check for check in result.checks}
    lines = []
    for name in demanded:
        if name not in checks:
            lines.append(f"{name}: a limit was given, but the check is of flight only")
        elif checks[name].verdict in ("skipped", "open"):
            verdict, note = checks[name].verdict, checks[name].note
            lines.append(f"{name}: a limit was given, but the check is {verdict}: {note}")
    if lines or not result.passed:
        raise _failure([*result.summary(), *lines])
    return result


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
    if digits is None:
        raise InputError("digits: got None, expected the number of correct digits wanted")
    result = conservation(trajectory, scene, digits=digits, **options)
    golden = result["golden"]
    if golden.verdict != "pass" or result["finite"].verdict != "pass":
        few = {name: correct for name, correct in golden.parts.items() if correct < digits}
        names = ", ".join(f"{name} {correct:.1f}" for name, correct in few.items())
        lines = [*result.summary(), f"correct digits: {names}"] if few else result.summary()
        raise _failure([*lines, f"over time: {golden.history or 'nothing to compare'}"])
    return result


def _failure(lines: Sequence[str]) -> AssertionError:
    return AssertionError("\n  ".join(map(one_line, lines)))
