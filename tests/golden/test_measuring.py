"""Rows against the true ones, at golden times and between: errors count by the entry's size."""

from __future__ import annotations

import random
from collections.abc import Sequence
from decimal import Decimal

import numpy
import pytest

from tt_precise.check.golden import DigitsOverTime
from tt_precise.golden import measuring
from tt_precise.golden.carrying import Carrier
from tt_precise.golden.digits import EXACT
from tt_precise.golden.fewest import FewestDigits
from tt_precise.golden.measuring import TrueRows
from tt_precise.golden.store import Stored, read
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState

ROWS = numpy.array([40, 100, 250])
ERROR = 1e-6


def columns_at(stored: Stored, rows: numpy.ndarray) -> dict[str, numpy.ndarray]:
    """Golden vectors of these rows in double."""
    table = stored.trajectory
    return {n: numpy.array(list(map(float, table.column(n))))[rows] for n in NewtonState._fields}


@pytest.mark.parametrize("delay", [0.0, 0.003])
@pytest.mark.parametrize("name", ["kz", "Lz", "Lx", "vy"])
def test_a_relative_error_is_found_as_it_was_made(delay: float, name: str) -> None:
    stored = read("reference")
    true = TrueRows(stored.scene, stored.trajectory)
    columns = [
        numpy.array(list(map(float, stored.trajectory.column(n)))) for n in NewtonState._fields
    ]
    delays = numpy.full(len(ROWS), delay)
    carried = Carrier(stored.scene, columns).carry(ROWS, delays, 0 * delays).values
    values = {one: carried[one].copy() for one in NewtonState._fields}
    near = sizes(stored.scene.body.numbers(float), columns_at(stored, ROWS), numpy)
    values[name] += ERROR * near[name]

    def exactly(row: int, names: object) -> list[str]:
        return [repr(float(values[one][row])) for one in names]  # type: ignore[attr-defined]

    found = true.measure(true.times[ROWS] + delay, values, exactly)
    assert found.compared.all()
    assert not found.start.any()
    # between golden times the size is that of the nearest golden row
    assert found.errors[name] == pytest.approx([ERROR] * len(ROWS), rel=1e-3)
    assert (found.worst() == found.errors[name]).all()
    for other in set(values) - {name}:
        assert (found.errors[other] <= numpy.fmax(found.bounds[other], 1e-15)).all()
    assert ((found.bounds[name] == 0) == (delay == 0)).all()


def spoiled(cell: str, error: str, digits: int) -> str:
    """A printed number with a relative error, written with so many digits."""
    factor = EXACT.add(1, Decimal(error))
    return f"{EXACT.multiply(Decimal(cell), factor):.{digits - 1}e}" if cell else ""


def found_of(true: TrueRows, cells: dict[str, list[str]], **how: bool) -> tuple[object, ...]:
    """What the checks make of the errors, and at how many entries decimals were looked at."""
    looked = 0

    def exactly(row: int, names: Sequence[str]) -> list[str]:
        nonlocal looked
        looked += len(names)
        return [cells[name][row] for name in names]

    values = {n: numpy.array([float(one or "nan") for one in c]) for n, c in cells.items()}
    fewest, over_time = FewestDigits(), DigitsOverTime()
    found = true.measure(true.times, values, exactly, **how)
    fewest.add(found)
    over_time.add(found)
    return looked, (fewest.digits, fewest.at, fewest.rows, fewest.exactly, str(over_time))


@pytest.mark.parametrize("scene", ["reference", "upright", "contact-lost", "flight"])
def test_sparing_decimals_changes_no_figure(scene: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stored = read(scene)
    true = TrueRows(stored.scene, stored.trajectory)
    columns = {name: stored.trajectory.column(name) for name in true.names}
    seed = random.Random(scene)
    spared = differing = 0
    for largest in ("0", "1e-33", "1e-17", "3e-16", "1e-15", "1e-14", "1e-13", "3e-13", "1e-11"):
        for digits in (16, 17, 18, 34):
            cells = {
                name: [
                    spoiled(cell, f"{seed.uniform(-1, 1) * float(largest):.20e}", digits)
                    for cell in column
                ]
                for name, column in columns.items()
            }
            every, expected = found_of(true, cells)
            some, figures = found_of(true, cells, largest_only=True)
            assert figures == expected, (largest, digits)
            assert isinstance(every, int)
            assert isinstance(some, int)
            spared += every - some
            with monkeypatch.context() as without:  # the control: doubles alone
                without.setattr(measuring, "FIGURES", -1.0)
                differing += found_of(true, cells, largest_only=True)[1] != expected
    assert spared > 0
    assert differing > 0
