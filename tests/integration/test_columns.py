"""The pose of a trajectory: its own rates, the checks of rigid bodies, and the poles."""

import numpy as np
import pytest

from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.quantities import Pose
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene


def test_the_columns_and_their_order(double: Trajectory) -> None:
    first = double.frame(pose=True, times=["0.1"])
    last = double.frame("theta", "pose:xyzw", times=["0.1"])
    assert list(first) == ["t", *Pose._fields]
    assert list(last)[:6] == ["t", "theta", "qx", "qy", "qz", "qw"]
    assert all(first[name][0] == last[name][0] for name in first)
    assert last["theta"][0] == pytest.approx(double.at("0.1").theta, rel=1e-12)


def test_it_turns_as_fast_as_the_angular_velocity_says(half_quad: Trajectory) -> None:
    """2 q' = (0, omega) q, by differences of fourth order, in quad: phi and psi count as well."""
    h = 2.0**-18
    around = [0.25 + n * h for n in (-2, -1, 0, 1, 2)]
    table = half_quad.frame(pose=True, times=around, numbers="exact")
    q, omegas, places, speeds = (
        table[names.split()].to_numpy() for names in ("qw qx qy qz", "wx wy wz", "x y", "vcx vcy")
    )
    rate = (q[0] - 8 * q[1] + 8 * q[3] - q[4]) / (12 * h)
    w, axis, omega = q[2, 0], q[2, 1:], omegas[2]
    product = np.array([-omega @ axis, *(w * omega + np.cross(omega, axis))])
    bound = 1e-9  # h^4 (155/2)^5/30 is 4e-14, and 1e5 times less for a wrong sign would show
    assert max(abs(2 * rate - product)) < bound
    assert max(abs(2 * rate + product)) > 1
    moved = (places[3] - places[1]).astype(float)
    assert moved == pytest.approx(2 * h * speeds[2].astype(float), rel=1e-5)


def test_no_pose_where_the_axis_is_exactly_vertical(toppling: Scene) -> None:
    for scene in ("upright", toppling):
        with pytest.raises(InputError, match="an axis that is exactly vertical at some time"):
            integrate(scene).frame(pose=True)


def test_a_pose_that_was_not_recorded_is_of_the_run_that_records_it() -> None:
    """Contact is lost, in that run, 7e-8 s before."""
    record = ("phi", "psi", "x", "y")
    run, whole = (integrate("contact-lost", tolerance=1e-6, record=r) for r in ((), record))
    assert whole.t_end < run.t_end
    assert run.frame("theta", pose=True).equals(whole.frame("theta", pose=True))


def test_errors_of_a_pose_need_its_quadratures(half: Scene) -> None:
    with pytest.raises(InputError, match="got a pose of a run without phi, psi, x, y"):
        integrate(half).frame("error:qw")
    recorded = integrate(half, record=("phi", "psi", "x", "y"))
    assert 0 < recorded.frame("error:qw")["error:qw"].max() < 1e-9
