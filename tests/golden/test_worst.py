"""The largest error of a column, against the same looked for row by row in decimals."""

from __future__ import annotations

import random
from collections.abc import Sequence
from decimal import Decimal

import pytest

from tt_precise.golden.distance import as_decimal, relative_error, scales_by_kind
from tt_precise.golden.store import read
from tt_precise.golden.worst import DECAYED, NEIGHBOURS, largest_error, size

SCALE = Decimal("3.2")


def row_by_row(
    cells: Sequence[str], fresh: Sequence[str], scale: Decimal | None
) -> tuple[int, Decimal] | None:
    own = [abs(Decimal(cell or 0)) for cell in cells]
    errors = {}
    for row, (cell, mine) in enumerate(zip(cells, fresh, strict=False)):
        if not cell:
            continue
        around = own[max(0, row - NEIGHBOURS) : row + NEIGHBOURS + 1]
        if scale is None:
            divisor = own[row]
        else:
            divisor = max(*around, scale * DECAYED) if any(own) else scale
        errors[row] = relative_error(as_decimal(mine), Decimal(cell), divisor)
    if not errors:
        return None
    worst = max(errors, key=errors.__getitem__)
    return worst, errors[worst]


def disturbed(cell: str, rng: random.Random, place: int) -> str:
    """The number with an error somewhere behind that digit."""
    if not cell:
        return ""
    number = Decimal(cell)
    error = Decimal(rng.randint(-999, 999)).scaleb(number.adjusted() - place - rng.randint(0, 9))
    return f"{number + error:.47e}"


@pytest.mark.parametrize("scene", ["reference", "rocking", "upright", "beside-the-pole", "rolling"])
@pytest.mark.parametrize("place", [14, 33])
def test_it_is_that_of_decimals(scene: str, place: int) -> None:
    rng = random.Random(f"{scene} {place}")
    stored = read(scene)
    scales = scales_by_kind(stored.trajectory, stored.scene.body)
    for name in stored.trajectory.columns:
        cells = stored.trajectory.column(name)[:120]
        fresh = [disturbed(cell, rng, place) for cell in cells]
        assert largest_error(cells, fresh, scales.get(name)) == row_by_row(
            cells, fresh, scales.get(name)
        )


@pytest.mark.parametrize(
    ("cells", "fresh"),
    [
        (["1", "2e-3", "-4"], ["1", "2e-3", "-4"]),  # no error at all
        (["0", "0", "0"], ["0.0", "1e-40", "-2e-40"]),  # nothing to count by but the scale
        (["1", "", "3"], ["1.5", "2", "3.1"]),  # an undefined entry
        (["", ""], ["", "1"]),
        ([], []),
        (["1", "2", "3"], ["1", "", "3"]),  # what is missing is infinitely far
        (["1", "2", "3"], ["1", "nan", "3"]),
        (["1", "2", "3"], ["1", "inf", "3"]),
        (["1e-320", "2e-330"], ["1.1e-320", "2e-330"]),  # no doubles
        (["1e+400", "1"], ["1.1e+400", "1"]),
        (["1", "2", "3"], ["1.25", "2.5"]),  # rows that both have
        (["1", "1", "1"], ["1.00000000002", "1.000000000020001", "1.00000000002"]),  # nearly equal
        (["1", "1", "1"], ["0.9", "1.1", "1.1"]),  # the first of equal ones
        (["2E0", "1"], ["2.5", "1"]),  # a form that golden data do not have
    ],
)
@pytest.mark.parametrize("scale", [SCALE, Decimal("1e-250"), None])
def test_odd_columns_too(cells: list[str], fresh: list[str], scale: Decimal | None) -> None:
    assert largest_error(cells, fresh, scale) == row_by_row(cells, fresh, scale)


def test_an_error_counts_by_what_is_near_it() -> None:
    cells = ["1e+0"] * 30 + ["1e-6"] * 60
    assert size(cells, 10, SCALE) == 1
    assert size(cells, 30 + NEIGHBOURS, SCALE) == Decimal("1e-6")
    assert size(["1e-30"] * 3, 1, SCALE) == SCALE * DECAYED
    assert size(["0", ""], 0, SCALE) == SCALE
    assert size(["-7", "9"], 0, None) == 7
