"""Three-vectors as plain tuples of scalars of any arithmetic."""

from __future__ import annotations

from tt_precise.runtime.arithmetic import Scalar

Vector = tuple[Scalar, Scalar, Scalar]


def dot(a: Vector, b: Vector) -> Scalar:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product, right-handed."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def scaled(factor: Scalar, a: Vector) -> Vector:
    """``factor`` times ``a``."""
    return (factor * a[0], factor * a[1], factor * a[2])


def added(a: Vector, *others: Vector) -> Vector:
    """Sum of vectors."""
    for b in others:
        a = (a[0] + b[0], a[1] + b[1], a[2] + b[2])
    return a


def subtracted(a: Vector, b: Vector) -> Vector:
    """``a - b``."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
