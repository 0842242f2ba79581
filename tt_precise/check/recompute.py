"""Distance of rows from the scene's solution, integrated anew to just their times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

from tt_precise.check.digits import Digits
from tt_precise.errors import InputError
from tt_precise.golden.digits import EXACT
from tt_precise.progress import Progress
from tt_precise.scene import Scene

SPARE_DIGITS = 2.0  # by which the solution must be better than what is asked of the trajectory
USUAL_DIGITS = 13.0  # what a trajectory in double can have
STEP_UP = {"extended": 3.0, "quad": 17.0}  # digits that the wider arithmetics have beyond double

Row = tuple[Fraction, Mapping[str, Decimal]]


def fresh_digits(
    scene: Scene, rows: Sequence[Row], asked: float | None, progress: Progress
) -> tuple[Digits, str]:
    """Digits of rows (exact time in s, name to value) against the solution at their own times.

    The solution is computed in double and judged by the next finer arithmetic; if double's
    digits are not enough for what is ``asked``, it is computed in quad. No row is told more
    digits than the solution has.

    Raises
    ------
    InputError
        The solution ends before the first row.
    """
    from tt_precise.integrate.precision import finer, precision_named

    names = sorted({name for _, given in rows for name in given})
    scene = replace(scene, until=max(t for t, _ in rows), events=(), record=())
    enough = (USUAL_DIGITS if asked is None else asked) + SPARE_DIGITS
    wider = finer(precision_named("double")).name
    rough = _solution(scene, "double", names, rows, progress)
    fine = _solution(scene, wider, names, rows, progress)
    in_double = _compared(fine, rough)
    if in_double.worst < enough and wider != "quad":
        wider, fine = "quad", _solution(scene, "quad", names, rows, progress)
    digits = _compared(fine, rows)
    most = in_double.worst + STEP_UP[wider]
    digits.fewest = {name: min(found, most) for name, found in digits.fewest.items()}
    digits.worst = min(digits.worst, most)
    note = f"{len(fine)} rows computed afresh in {wider}"
    beyond = len(rows) - len(fine)
    return digits, note + (f"; {beyond} rows lie beyond the solution's end" if beyond else "")


def _solution(
    scene: Scene, precision: str, names: list[str], rows: Sequence[Row], progress: Progress
) -> list[Row]:
    from tt_precise.integrate import integrate
    from tt_precise.numerals import as_fraction

    trajectory = integrate(scene, precision, progress=progress)
    end = scene.until if trajectory.status == "complete" else as_fraction(trajectory.t_end)
    times = [t for t, _ in rows if 0 <= t <= end]
    if not times:
        raise InputError(
            f"{scene.name}: the solution ends ({trajectory.status}) at "
            f"t = {float(trajectory.t_end):g} s, before any row to compare"
        )
    frame = trajectory.frame(*names, times=times, numbers="text")
    columns = {name: list(frame[name]) for name in names}
    return [
        (t, {name: Decimal(columns[name][i]) for name in names if columns[name][i] is not None})
        for i, t in enumerate(times)
    ]


def _compared(true: Sequence[Row], given: Sequence[Row]) -> Digits:
    names = {name for _, row in true for name in row}
    digits = Digits.of_columns(
        {name: [str(row[name]) for _, row in true if name in row] for name in names}
    )
    values = dict(given)
    for t, row in true:
        digits.rows += 1
        for name, entry in row.items():
            if name in values[t]:
                error = EXACT.subtract(values[t][name], entry)
                digits.add(float(t), name, error, entry)
    return digits
