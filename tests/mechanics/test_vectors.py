"""Vector algebra, exactly."""

import random
from fractions import Fraction

import mpmath
import numpy
import pytest

from tt_precise.mechanics.vectors import (
    Vector,
    added,
    axis_of,
    cross,
    dot,
    horizontal_length,
    scaled,
    spin,
    subtracted,
)

X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def drawn(source: random.Random) -> Vector:
    x, y, z = (Fraction(source.randint(-99, 99), source.randint(1, 99)) for _ in range(3))
    return (x, y, z)


def test_the_frame_is_right_handed() -> None:
    assert (cross(X, Y), cross(Y, Z), cross(Z, X)) == (Z, X, Y)
    assert cross(Y, X) != Z


@pytest.mark.parametrize("seed", range(5))
def test_lagrange_and_jacobi(seed: int) -> None:
    source = random.Random(seed)
    a, b, c = (drawn(source) for _ in range(3))
    assert dot(cross(a, b), cross(a, b)) == dot(a, a) * dot(b, b) - dot(a, b) ** 2
    assert cross(a, cross(b, c)) == subtracted(scaled(dot(a, c), b), scaled(dot(a, b), c))
    assert dot(a, cross(a, b)) == dot(b, cross(a, b)) == 0
    assert not any(added(cross(a, cross(b, c)), cross(b, cross(c, a)), cross(c, cross(a, b))))
    assert any(added(cross(a, cross(b, c)), cross(b, cross(c, a)), cross(c, cross(b, a))))


def test_without_hypot_a_square_root_serves() -> None:
    class Plain:
        sqrt = staticmethod(mpmath.sqrt)

    assert horizontal_length(Plain, 3, 4) == 5
    assert horizontal_length(numpy, 3e-200, 4e-200) == pytest.approx(5e-200, rel=2**-51, abs=0)


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
