"""The checks as assertions, for tests: pass, or fail with check, time, value and limit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.terminal import one_line

if TYPE_CHECKING:
    import os
    from pathlib import Path

    from tt_precise.check.result import Result
    from tt_precise.scene.scene import Scene


def assert_conserves(
    trajectory: object,
    scene: str | Path | Scene,
    *,
    limits: Mapping[str, float] | None = None,
    until: float | None = None,
    digits: float | None = None,
    fresh: bool = False,
    friction: str = "scene",
    columns: Mapping[str, str] | None = None,
    folder: str | os.PathLike[str] | None = None,
    **demanded: float,
) -> Result:
    """Assert that no check fails; arguments are those of ``conservation``.

    A limit can be given as a keyword, ``jellett=1e-9``; then the check must also have been
    possible, and fails where it was skipped.

    Raises
    ------
    AssertionError
        A check failed; one line for each says its time, value and limit.
    InputError
        The trajectory cannot be used.
    """
    __tracebackhide__ = True
    from tt_precise.check.run import conservation

    result = conservation(
        trajectory,
        scene,
        limits={**(limits or {}), **demanded},
        until=until,
        digits=digits,
        fresh=fresh,
        friction=friction,
        columns=columns,
        folder=folder,
    )
    lines = [finding.sentence() for finding in result.failures]
    found = {finding.name: finding for finding in result.checks}
    for name in demanded:
        if name not in found:
            lines.append(f"{name}: a limit was given, but the check is of flight only")
        elif found[name].verdict == "skipped":
            reason = found[name].reason
            lines.append(f"{name}: a limit was given, but the check was skipped: {reason}")
    if lines:
        raise AssertionError("\n  ".join([_of(result), *map(one_line, lines)]))
    return result


def assert_matches_golden(
    trajectory: object,
    scene: str | Path | Scene,
    *,
    digits: float,
    until: float | None = None,
    fresh: bool = False,
    columns: Mapping[str, str] | None = None,
    folder: str | os.PathLike[str] | None = None,
) -> Result:
    """Assert that every column has ``digits`` correct digits at the golden times.

    With ``fresh`` the solution is computed at the trajectory's own times where there is no golden
    row.

    Raises
    ------
    AssertionError
        It has fewer; the message names time and columns.
    InputError
        The trajectory cannot be used, or there is nothing to compare it with.
    """
    __tracebackhide__ = True
    from tt_precise.check.run import conservation

    if digits is None:
        raise InputError("digits: got None, expected the number of correct digits wanted")
    result = conservation(
        trajectory,
        scene,
        until=until,
        digits=digits,
        fresh=fresh,
        columns=columns,
        folder=folder,
    )
    golden = result["golden"]
    if golden.verdict != "pass":
        few = {name: found for name, found in golden.parts.items() if found < digits}
        listed = ", ".join(f"{name} {found:.1f}" for name, found in few.items())
        lines = [_of(result), one_line(golden.sentence())]
        lines += [f"correct digits: {listed}"] if few else []
        lines.append(f"over time: {golden.history or 'nothing to compare'}")
        raise AssertionError("\n  ".join(lines))
    return result


def _of(result: Result) -> str:
    return one_line(f"{result.trajectory} against {result.scene}:")
