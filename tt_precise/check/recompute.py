"""Distance of rows from the scene's solution, integrated anew to just their times."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import numpy

from tt_precise.golden.fewest import FewestDigits
from tt_precise.golden.measuring import Measured, TrueRows
from tt_precise.golden.table import Table
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress
from tt_precise.scene.scene import Scene
from tt_precise.scene.start import LIFTED

SPARE_DIGITS = 2.0  # by which the solution must be better than what is asked of the trajectory
USUAL_DIGITS = 13.0  # what a trajectory in double can have
STEP_UP = {"extended": 3.0, "quad": 17.0}  # digits that the wider arithmetics have beyond double

Row = tuple[Fraction, Mapping[str, Decimal | None]]


def recomputed(
    scene: Scene, rows: Sequence[Row], asked: float | None, progress: Progress
) -> tuple[Measured, str]:
    """Distance of rows (exact time in s, name to value) from the solution at their own times.

    The solution is computed in double and compared with the next finer arithmetic; if double's
    digits are not enough for what is ``asked``, it is computed in quad. Errors count for no less
    than the solution's own. Rows beyond the end of the solution are not compared.

    Raises
    ------
    InputError
        The solution ends before the first row.
    """
    from tt_precise.integration.precision import finer, precision_named

    # the whole state says what errors count beside
    every = [*NewtonState._fields, *EulerState._fields, *(LIFTED if scene.lifts else ())]
    names = [*dict.fromkeys([*every, *(name for _, given in rows for name in given)])]
    scene = replace(scene, until=max(t for t, _ in rows), events=(), record=())
    enough = (USUAL_DIGITS if asked is None else asked) + SPARE_DIGITS
    wider = finer(precision_named("double")).name
    rough = _solution(scene, "double", names, rows, progress)
    fine = _solution(scene, wider, names, rows, progress)
    in_double = FewestDigits()
    in_double.add(_measured(scene, fine, _rows(rough)))
    if in_double.worst < enough and wider != "quad":
        wider, fine = "quad", _solution(scene, "quad", names, rows, progress)
    found = _measured(scene, fine, rows)
    own = 10.0 ** -(in_double.worst + STEP_UP[wider])
    errors = {name: numpy.maximum(error, own) for name, error in found.errors.items()}
    beyond = int((~found.compared).sum())
    note = f"{len(rows) - beyond} rows computed afresh in {wider}"
    return replace(found, errors=errors), (
        note + (f"; {beyond} rows lie beyond the solution's end" if beyond else "")
    )


def _solution(
    scene: Scene, precision: str, names: list[str], rows: Sequence[Row], progress: Progress
) -> Table:
    from tt_precise.integration import integrate
    from tt_precise.scene.numerals import as_fraction

    trajectory = integrate(scene, precision, progress=progress)
    end = scene.until if trajectory.status == "complete" else as_fraction(trajectory.t_end)
    times = [t for t, _ in rows if 0 <= t <= end]
    if not times:
        raise InputError(
            f"{scene.name}: the solution ends ({trajectory.status}) at "
            f"t = {float(trajectory.t_end):g} s, before any row to compare"
        )
    frame = trajectory.frame(*names, times=times, numbers="text")
    columns = {name: [cell if cell is not None else "" for cell in frame[name]] for name in names}
    return Table.of_columns({"t": [repr(float(t)) for t in times], **columns})


def _rows(table: Table) -> list[Row]:
    found: list[Row] = []
    for t, *cells in table.rows:
        entries = zip(table.columns[1:], cells, strict=True)
        numbers = {name: Decimal(cell) if cell else None for name, cell in entries}
        found.append((Fraction(float(t)), numbers))
    return found


def _measured(scene: Scene, true: Table, given: Sequence[Row]) -> Measured:
    times = {float(cell) for cell in true.column("t")}
    rows = [row for row in given if float(row[0]) in times]
    others = len(given) - len(rows)
    names = [name for name in true.columns if name in given[0][1]]
    found = TrueRows(scene, true).measure(
        numpy.array([float(t) for t, _ in rows]),
        {name: _floats(row[1].get(name) for row in rows) for name in names},
        lambda row, wanted: [rows[row][1].get(name) for name in wanted],
    )
    if not others:
        return found
    missing = numpy.full(others, numpy.nan)
    return Measured(
        numpy.append(found.t, [float(t) for t, _ in given if float(t) not in times]),
        {name: numpy.append(errors, missing) for name, errors in found.errors.items()},
        {name: numpy.append(bounds, missing) for name, bounds in found.bounds.items()},
        numpy.append(found.compared, numpy.zeros(others, bool)),
        numpy.append(found.start, numpy.zeros(others, bool)),
    )


def _floats(numbers: Iterable[Decimal | None]) -> numpy.ndarray:
    return numpy.array([numpy.nan if number is None else float(number) for number in numbers])
