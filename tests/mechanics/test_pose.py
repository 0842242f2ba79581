"""The pose leads back to the vectors it was made from, at both poles too."""

import random
from typing import Any

import numpy as np
import pytest

from tt_precise.mechanics.conversion import axis_of
from tt_precise.mechanics.euler import EulerState, vectors_from_euler
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.pose import Pose, pose
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import horizontal_length
from tt_precise.scene.body import TippeTop

PHI, PSI = "0.7", "-1.9"


def made(body: Parameters, theta: Any, fn: Any, seed: int = 1) -> tuple[Motion, Pose]:
    """A motion at inclination ``theta``, and its pose."""
    source = random.Random(seed)
    state = EulerState(theta, *(source.uniform(-3, 3) for _ in range(5)))
    phi, psi = type(theta)(PHI), type(theta)(PSI)
    q = Motion(body, vectors_from_euler(body, state, fn, phi), fn)
    return q, pose(q, horizontal_length(fn, q.state.kx, q.state.ky), phi, psi, 0, 0)


@pytest.mark.parametrize("theta", ["0.3", "1.5", "2.9", "1e-40"])
def test_a_rigid_body_in_this_pose_has_its_axis(body: TippeTop, mp: Any, theta: str) -> None:
    """By ``axis_of``, which shares no formula with ``pose``."""
    numbers = body.numbers(lambda value: mp.mpf(value.numerator) / value.denominator)
    q, found = made(numbers, mp.mpf(theta), mp)
    bound = 100 * mp.eps  # a dozen operations on numbers below 10
    assert abs(sum(component**2 for component in found[:4]) - 1) <= bound
    swapped = (found.qx, found.qw, *found[2:4])
    for quaternion, right in ((found[:4], True), (swapped, False)):
        error = max(abs(a - b) for a, b in zip(axis_of(*quaternion), q.k, strict=True))
        assert (error <= bound) == right


@pytest.mark.parametrize("theta", [1e-9, 0.4, 2.0, np.pi - 1e-9])
def test_the_quaternion_is_that_of_the_euler_angles(body: TippeTop, theta: float) -> None:
    from scipy.spatial.transform import Rotation

    q, found = made(body.numbers(float), theta, np)
    angles = [float(PHI), theta, float(PSI)]
    matrix = Rotation.from_euler("ZYZ", angles).as_matrix()
    given = Rotation.from_quat(found[:4], scalar_first=True).as_matrix()
    assert np.abs(given - matrix).max() < 1e-15 * 10  # ten operations
    body_frame = matrix.T @ np.array([found.wx, found.wy, found.wz])
    assert np.allclose(body_frame, [found.wbx, found.wby, found.wbz], rtol=0, atol=1e-13)
    assert found.wbz == pytest.approx(float(np.dot(q.omega, q.k)), abs=1e-13)
