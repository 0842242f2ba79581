"""``conservation``: every check that a trajectory's columns and its scene allow, and assertions."""

from __future__ import annotations

import inspect
import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial, wraps
from pathlib import Path
from typing import Any, NamedTuple, ParamSpec

import numpy

from tt_precise.check.agreement import agreement
from tt_precise.check.checks import checks_of, chosen_limits, finite
from tt_precise.check.columns import (
    TRACK,
    Block,
    CheckSetup,
    Columns,
    Samples,
    choose_set,
    recognised_columns,
)
from tt_precise.check.conventions import AXES, OURS, WORLDS, Convention, Given, convert
from tt_precise.check.golden import (
    Compared,
    Position,
    Wanted,
    decide_alone,
    decides,
    distance_from_solution,
    no_solution,
    rotate_about_z,
)
from tt_precise.check.precision import described, times_of
from tt_precise.check.result import Cause, Result, shortened
from tt_precise.check.sources import NotFinite, RowSource, UsableRows, open_source, usable_rows
from tt_precise.check.start import Begin, look_for_start, rounding
from tt_precise.golden.solution import TrueSolution
from tt_precise.golden.store import Folder
from tt_precise.mechanics.digits import MOST_GOLDEN
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.terminal import Progress, one_line, silent
from tt_precise.runtime.values import Array, Check, InputError, Verdict, listed, require_name
from tt_precise.scene.scene import Scene, load_scene

P = ParamSpec("P")
MEANING = "every column holds finite numbers, except Euler angles where they are undefined"
OPTIONS_OF_COMMAND = "columns|limit|until|digits|from|allow|world|axis|friction|start"
WITH_VALUE = re.compile(rf"--({OPTIONS_OF_COMMAND}) ([^\s,;:()]+)")
ALONE = re.compile(rf"--({OPTIONS_OF_COMMAND})\b")


def examine(
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
    wanted = chosen_limits(limits or {})
    allow = listed(allow)
    for name in allow:
        require_name("allow", name, (*wanted, *FURTHER))
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
    convention, others = OURS, dict[str, Convention]()
    if engine is not None:
        from tt_precise.check.engine_states import conventions_of_engine, engine_source

        trajectory = engine_source(trajectory, engine, columns or {})
        convention, others = conventions_of_engine(engine)
    convention = convention.in_world(world, axis)
    alternatives = {
        f"it is read with --from {name}": other.in_world(world, axis)
        for name, other in others.items()
    }
    if (world, axis) != ("z-up", "z"):
        for pair in itertools.product(WORLDS, AXES):
            if pair != (world, axis):
                alternatives[_with_options(*pair)] = convention.in_world(*pair)
    # overflow and undefined values fail the check instead of giving a warning
    with closing(open_source(trajectory, columns)) as table, numpy.errstate(all="ignore"):
        setup = _setup(table, scene, friction, start)
        file = _load(table, setup, convention, alternatives, cutoff, progress)
        examination = _Examination(setup, file, wanted, digits, cutoff, allow)
        return examination.result(TrueSolution(scene, folder, progress))


def _with_options(world: str, axis: str) -> str:
    """Say with which options a file is read."""
    options = [f"--world {world}"] * (world != "z-up") + [f"--axis {axis}"] * (axis != "z")
    said = f"with {' '.join(options)}" if options else "without --world, --axis"
    return f"it is read {said}"


def in_python(text: str) -> str:
    """Return a message with the options of the command line as arguments of ``conservation``."""
    return ALONE.sub(lambda found: _name(found[1]), WITH_VALUE.sub(_argument, text))


def _name(option: str) -> str:
    return {"from": "engine", "limit": "limits"}.get(option, option)


def _argument(found: re.Match[str]) -> str:
    name, value = found[1], found[2]
    left, equals, right = value.partition("=")
    if name == "columns" and equals:
        return f'columns={{"{left}": "{right}"}}'
    if name == "limit" and equals:
        return f'limits={{"{left}": {right}}}'
    if name == "allow":
        return f'allow=("{value}",)'
    if name in ("until", "digits"):
        return f"{name}={value}"
    return f'{_name(name)}="{value}"'


def _said_in_python(check: Callable[P, Result]) -> Callable[P, Result]:
    """Return ``check`` whose messages name arguments where the command names its options."""

    @wraps(check)
    def call(*given: P.args, **options: P.kwargs) -> Result:
        try:
            result = check(*given, **options)
        except InputError as error:
            raise InputError(in_python(str(error))) from None
        return replace(
            result,
            checks=tuple(replace(one, note=in_python(one.note)) for one in result.checks),
            causes=tuple(Cause(cause.kind, in_python(cause.text)) for cause in result.causes),
            unseen=tuple(map(in_python, result.unseen)),
        )

    return call


conservation = _said_in_python(examine)
# errors of a call name the function by what stands in its ``__qualname__``
conservation.__name__ = conservation.__qualname__ = examine.__qualname__ = "conservation"
OPTIONS = inspect.signature(conservation).parameters
# Checks that are not made row by row.
FURTHER = ("finite", "start", "agreement", "golden")


class _ReadTable(NamedTuple):
    """A trajectory as read: origin, columns and rows."""

    where: str
    alternatives: Mapping[str, Callable[[], Block]]
    whole: Block
    usable: UsableRows


def _load(
    table: RowSource,
    setup: CheckSetup,
    convention: Convention,
    alternatives: Mapping[str, Convention],
    cutoff: float,
    progress: Progress,
) -> _ReadTable:
    height = setup.columns.height if setup.height_given else ()
    names = ("t", *(n for n in (*setup.columns.names, *height) if n in table.names))
    also = [name for name in recognised_columns(table.names) if name not in names]
    whole = table.load(names, also, progress)
    if convention != OURS and setup.columns.name != "rigid body":
        raise InputError(
            f"{table.where}: got {setup.columns.name} columns, expected those of a rigid body "
            "with another world or axis"
        )
    usable = usable_rows(whole, names, table.where, cutoff)
    rows = len(usable.block)
    if rows < 2 and not usable.broken:
        raise InputError(
            f"{table.where}: got {'one row' if rows else 'no rows'}"
            + (f" up to t = {cutoff:g} s" if cutoff < math.inf else "")
            + ", expected a trajectory of at least two"
        )

    def in_convention(one: Convention, given: Columns) -> Columns:
        return convert(Given.of_columns(given), one, setup.body).columns

    block = usable.block
    others = {
        text: partial(block.converted, partial(in_convention, one))
        for text, one in alternatives.items()
    }
    if convention != OURS:
        usable = usable._replace(block=block.converted(partial(in_convention, convention)))
    return _ReadTable(table.where, others, whole, usable)


def finiteness(block: Block, also: Sequence[str], broken: NotFinite | None) -> Check:
    """Count entries that are not finite in ``also``, and the row where the checks stop.

    Euler angles are undefined where the axis is vertical; columns of a state break the rows.
    """
    count, first, at = 0, "", None
    vertical = _vertical(block)
    for name in also:
        wrong = numpy.flatnonzero(~numpy.isfinite(block.values[name]) & ~vertical)
        count += len(wrong)
        if len(wrong) and (at is None or block.values["t"][wrong[0]] < at):
            row = int(wrong[0])
            at = float(block.values["t"][row])
            first = f"{name} = {block.values[name][row]} in {block.where(row)}"
    if broken is not None:
        count, first = count + 1, f"{broken}, where the checks stop"
        at = broken.t if at is None else min(at, broken.t)
    verdict: Verdict = "fail" if count else "pass"
    return Check("finite", verdict, float(count), 0.0, at, first, MEANING, since=at)


def _vertical(block: Block) -> Array:
    tilt = [block.values[name] for name in ("kx", "ky") if name in block.values]
    return numpy.all([x == 0 for x in tilt], axis=0) if tilt else numpy.zeros(len(block), bool)


@dataclass
class _Examination:
    """The checks of one file, in the order of their dependence."""

    setup: CheckSetup
    file: _ReadTable
    limits: Mapping[str, float]
    digits: float | None
    cutoff: float
    allow: Sequence[str]

    def result(self, solution: TrueSolution) -> Result:
        """Return all findings and the verdict."""
        block, setup = self.file.usable.block, self.setup
        also = [n for n in block.values if n not in ("t", *setup.columns.names)]
        findings = [finiteness(block, also, self.file.usable.broken)]
        unseen: tuple[str, ...] = ()
        causes: tuple[Cause, ...] = ()
        written = ""
        if len(block) < 2:
            reason = f"fewer than two rows before {self.file.usable.broken}"
            missed = [*(check.name for check in checks_of(setup.scene)), *FURTHER[1:]]
            findings += [Check(name, "skipped", note=reason) for name in missed]
        else:
            rows = setup.samples(block)
            found, written = self.judge(rows), _written(self.file.whole.values["t"], rows)
            findings += found
            findings += self._against_solution(rows, found, solution)
            unseen = self._unseen(findings)
            # a number that is not finite is named by its check
            failed = {one.name for one in findings if one.verdict == "fail"} - {"finite"}
            if unseen or failed:
                from tt_precise.check.explain import explain  # a file that passes needs none

                alternatives, true = self.file.alternatives, self._true_rows(solution)
                causes = tuple(explain(rows, findings, self.judge, alternatives, true))
                findings = [_by_cause(one, causes) for one in findings]
        t_first = self.file.usable.t_first
        return Result(
            trajectory=self.file.where,
            scene=setup.scene.name,
            columns=setup.columns.name,
            rows=len(block),
            t_first=t_first,
            t_last=t_first + float(block.values["t"][-1]) if len(block) else t_first,
            checks=tuple(findings),
            unseen=unseen,
            causes=causes,
            written=written,
        )

    def judge(self, rows: Samples) -> list[Check]:
        """Return the results of the checks that are made row by row."""
        limits = self.limits
        return [check.result(rows, limits[check.name]) for check in checks_of(rows.setup.scene)]

    def _against_solution(
        self, rows: Samples, found: Sequence[Check], solution: TrueSolution
    ) -> list[Check]:
        """Return the checks of the start, of the columns' agreement, and of the solution."""
        setup, t_first = self.setup, self.file.usable.t_first
        by_name = {finding.name: finding for finding in found}
        followed: frozenset[str] = frozenset()
        if by_name["kinematics"].verdict == "pass":
            followed = rows.shared.get("extra columns", followed)
        if all(finding.verdict != "fail" for finding in found):
            rows.forget()  # what remains to be done needs the memory
        self._begin = begin = look_for_start(rows, t_first, solution.vectors)
        further = {*TRACK} & {*rows.given} - {*setup.columns.names}
        compared = self._compare(rows, begin, solution, frozenset(further - followed))
        golden = compared.finding
        if by_name["equations"].verdict in ("open", "skipped") and setup.friction == "scene":
            golden = decide_alone(golden, rounding(rows) + rows.blur)
        return [begin.finding, agreement(rows, followed | compared.columns), golden]

    def _true_rows(self, solution: TrueSolution) -> Callable[[Array], Array | None]:
        """Return the solution at times (s) from the first row on, as vectors in the file's axes."""
        t_first, until = self.file.usable.t_first, float(self.setup.scene.until)
        begin, time = self._begin, self._begin.time
        if time is None:
            time = t_first if 0 <= t_first <= until else 0.0

        def true(t: Array) -> Array | None:
            found = solution.vectors(t + time)
            if found is None:
                return None
            columns = dict(zip(NewtonState._fields, found, strict=True))
            return numpy.array([*rotate_about_z(columns, -begin.turn).values()])

        return true

    def _compare(
        self, rows: Samples, begin: Begin, solution: TrueSolution, further: frozenset[str]
    ) -> Compared:
        setup, t_first = self.setup, self.file.usable.t_first
        if setup.friction == "other":
            return no_solution("the scene's solution has the scene's own friction")
        if begin.finding.verdict == "skipped":
            return no_solution("the scene's solution has the scene's own start")
        time = begin.time
        if time is None:
            if not 0 <= t_first <= float(setup.scene.until):
                return no_solution("the first row is no state of the solution")
            time = t_first
        ended = f"the rows end at {self.file.usable.broken}" if self.file.usable.broken else ""
        position = Position(time, begin.turn, whole=t_first == time == 0)
        wanted = Wanted(self.digits, self.cutoff - t_first, ended, further)
        return distance_from_solution(rows, self.file.usable.block, position, solution, wanted)

    def _unseen(self, findings: Sequence[Check]) -> tuple[str, ...]:
        """The deciding checks that could not be made, in words."""
        by_name = {finding.name: finding for finding in findings}

        def seen(*names: str) -> bool:
            return any(name in self.allow or by_name[name].verdict == "pass" for name in names)

        def why(*names: str) -> str:
            reasons = (f"{name}: {shortened(by_name[name].note)}" for name in names)
            return ", ".join(reasons)

        unseen = []
        if self.setup.friction == "scene":
            decided = seen("equations") or decides(by_name["golden"]) or "golden" in self.allow
            if not decided:
                unseen.append(f"the equations of motion ({why('equations', 'golden')})")
        else:
            for name, what in (
                ("kinematics", "the attitude"),
                ("contact_momentum", "the momentum"),
            ):
                if not seen(name):
                    unseen.append(f"{what} ({why(name)})")
        for name, what in (("start", "the start"), ("agreement", "all columns")):
            if by_name[name].verdict == "open" and name not in self.allow:
                unseen.append(f"{what} ({by_name[name].note})")
        return tuple(unseen)


def _by_cause(finding: Check, causes: Sequence[Cause]) -> Check:
    """Return an open check of the attitude as a failure where another convention resolves it."""
    if finding.name != "kinematics" or finding.verdict != "open":
        return finding
    named = [cause.text for cause in causes if cause.kind == "convention"]
    if not named or ", or " in named[0]:  # one of several: which is not seen
        return finding
    note = f"the rows follow from each other if {named[0]}"
    return replace(finding, verdict="fail", value=None, at=None, since=0.0, note=note, curve=None)


def _written(t: Array, rows: Samples) -> str:
    """Name the columns with fewer digits than doubles, and times that are not even for that."""
    clock = times_of(t)
    found = {name: one for name, one in rows.precisions.items() if name != "t"}
    texts = [f"t: {clock.words}" if clock.words else "", described(found)]
    return "; ".join(filter(None, texts))


def _setup(table: RowSource, scene: Scene, friction: str, start: str) -> CheckSetup:
    chosen = choose_set(table.names, table.where)
    velocity = _all_or_none(table, chosen.velocity, "velocity")
    height = scene.lifts and velocity and _all_or_none(table, chosen.height, "height and its rate")
    return CheckSetup(scene, chosen, velocity, friction, height, start=start)


def _all_or_none(table: RowSource, wanted: Sequence[str], what: str) -> bool:
    given = [name for name in wanted if name in table.names]
    missing = [name for name in wanted if name not in given]
    if given and missing:
        raise InputError(
            f"{table.where}: has {', '.join(given)} but not {', '.join(missing)}, "
            f"expected all of the {what} or none"
        )
    return bool(given)


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
    lines: list[str] = []
    checks = {finding.name: finding for finding in result.checks}
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
    if golden.verdict != "pass":
        few = {name: correct for name, correct in golden.parts.items() if correct < digits}
        listed = ", ".join(f"{name} {correct:.1f}" for name, correct in few.items())
        lines = [*result.summary(), f"correct digits: {listed}"] if few else result.summary()
        raise _failure([*lines, f"over time: {golden.history or 'nothing to compare'}"])
    return result


def _failure(lines: Sequence[str]) -> AssertionError:
    return AssertionError("\n  ".join(map(one_line, lines)))
