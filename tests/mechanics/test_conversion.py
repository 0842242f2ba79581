"""The states that engines write, as vectors."""

import random
from fractions import Fraction

import pytest

from tt_precise.mechanics import newton
from tt_precise.mechanics.conversion import RigidBodyState, vectors_from_rigid_body
from tt_precise.mechanics.vectors import cross
from tt_precise.scene.body import TippeTop


def quaternion(seed: int) -> tuple[Fraction, ...]:
    source = random.Random(seed)
    return tuple(Fraction(source.randint(-9, 9), source.randint(1, 9)) for _ in range(4))


@pytest.mark.parametrize("seed", range(6))
def test_rigid_bodies_exactly(body: TippeTop, seed: int) -> None:
    """The third column of the rotation matrix, L = I omega, and v_A = s_dot + omega x a."""
    q = quaternion(seed)
    w, x, y, z = q
    norm = sum(n * n for n in q)
    omega = (Fraction(2), Fraction(-3), Fraction(7, 2))
    k = (2 * (x * z + w * y) / norm, 2 * (y * z - w * x) / norm, 1 - 2 * (x * x + y * y) / norm)
    s_dot = tuple(-n for n in cross(omega, newton.contact_arm(body, k)))
    state = RigidBodyState(*(*q, *omega, *s_dot))
    vectors, sinking = vectors_from_rigid_body(body, state)
    assert vectors.k == k
    assert sum(n * n for n in vectors.k) == 1
    assert newton.angular_velocity(body, vectors) == omega
    assert (*vectors.v, sinking) == (0, 0, 0, 0)
    longer = state._replace(qw=3 * w, qx=3 * x, qy=3 * y, qz=3 * z)
    assert vectors_from_rigid_body(body, longer)[0] == vectors
    falling = vectors_from_rigid_body(body, state._replace(vcz=state.vcz - Fraction(1, 10**40)))
    assert falling[1] == -Fraction(1, 10**40)
