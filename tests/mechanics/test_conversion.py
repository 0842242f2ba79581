"""The states that engines write, as vectors."""

import random
from fractions import Fraction

import pytest

from tt_precise.mechanics.conversion import axis_of, spin


@pytest.mark.parametrize("seed", range(6))
def test_the_axis_is_the_third_column_of_the_rotation_matrix(seed: int) -> None:
    """For a quaternion of any length."""
    source = random.Random(seed)
    w, x, y, z = (Fraction(source.randint(-9, 9), source.randint(1, 9)) for _ in range(4))
    norm = w * w + x * x + y * y + z * z
    column = (
        2 * (x * z + w * y) / norm,
        2 * (y * z - w * x) / norm,
        1 - 2 * (x * x + y * y) / norm,
    )
    assert axis_of(w, x, y, z) == axis_of(3 * w, 3 * x, 3 * y, 3 * z) == column


def test_the_spin_has_the_precession_along_the_axis() -> None:
    assert spin(Fraction(7), Fraction(4), Fraction(-1, 2)) == 5
