"""Rows against the true ones, at golden times and between: errors count by the entry's size."""

from __future__ import annotations

import numpy
import pytest

from tt_precise.golden.carrying import Carrier
from tt_precise.golden.measuring import TrueRows
from tt_precise.golden.store import read
from tt_precise.mechanics.newton import NewtonState

ROWS = numpy.array([40, 100, 250])
ERROR = 1e-6


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
    values[name] *= 1 + ERROR

    def exactly(row: int, names: object) -> list[str]:
        return [repr(float(values[one][row])) for one in names]  # type: ignore[attr-defined]

    found = true.measure(true.times[ROWS] + delay, values, exactly)
    assert found.compared.all()
    assert not found.start.any()
    # between golden times the size is that of the nearest golden row
    near = 0.3 if delay else 1e-3
    assert found.errors[name] == pytest.approx([ERROR] * len(ROWS), rel=near)
    assert (found.worst() == found.errors[name]).all()
    for other in set(values) - {name}:
        assert (found.errors[other] <= numpy.fmax(found.bounds[other], 1e-15)).all()
    assert ((found.bounds[name] == 0) == (delay == 0)).all()
