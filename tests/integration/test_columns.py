"""The pose of a trajectory: its own rates, the checks of rigid bodies, and the poles."""

import numpy as np
import pytest

from tt_precise.check import conservation
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.pose import Pose
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene

RECORD = ("phi", "psi", "x", "y")


def test_the_columns_and_their_order(double: Trajectory) -> None:
    first = double.frame(pose=True, times=["0.1"])
    last = double.frame("theta", "pose:xyzw", times=["0.1"])
    assert list(first) == ["t", *Pose._fields]
    assert list(last)[:6] == ["t", "theta", "qx", "qy", "qz", "qw"]
    assert all(first[name][0] == last[name][0] for name in first)


@pytest.mark.usefixtures("no_cause")
@pytest.mark.evidence
def test_it_passes_as_the_rigid_body_of_an_engine(double: Trajectory) -> None:
    """The whole way, both poles nearly met: k, L and v_A of the pose are the scene's."""
    frame = double.frame(pose=True)
    found = conservation(frame, "reference", digits=9)
    assert (found.passed, found.columns) == (True, "rigid body")
    wrong = frame.rename(columns={"qw": "qx", "qx": "qw"})
    assert not conservation(wrong, "reference").passed


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


@pytest.mark.parametrize(("formulation", "bound"), [("newton", 1e-12), ("euler", 1e-11)])
def test_in_double_and_in_quad_alike(
    half: Scene, half_quad: Trajectory, formulation: str, bound: float
) -> None:
    coarse = integrate(half, formulation=formulation).frame(pose=True, times=["0.5"])
    fine = half_quad.frame(pose=True, times=["0.5"])
    assert np.abs(coarse.to_numpy() - fine.to_numpy()).max() < bound


def test_no_pose_where_the_axis_is_exactly_vertical(toppling: Scene) -> None:
    for scene in ("upright", toppling):
        with pytest.raises(InputError, match="an axis that is exactly vertical at some time"):
            integrate(scene).frame(pose=True)


def test_the_pose_of_a_run_that_ends_before_its_quadratures_do() -> None:
    """Contact is lost, in the run that records them, 7e-8 s before."""
    run, whole = (integrate("contact-lost", tolerance=1e-6, record=r) for r in ((), RECORD))
    table = run.frame(pose=True)
    assert whole.t_end < run.t_end == table["t"].iloc[-1]
    assert table["qw"].iloc[-1] == whole.frame("qw", times=[whole.t_end])["qw"].iloc[0]


def test_errors_of_a_pose_need_its_quadratures(half: Scene) -> None:
    with pytest.raises(InputError, match="got qw of a run without phi, psi, x, y"):
        integrate(half).frame("error:qw")
    assert 0 < integrate(half, record=RECORD).frame("error:qw")["error:qw"].max() < 1e-9


def test_what_a_notebook_shows_is_short() -> None:
    run = integrate("reference", "double-double")
    assert repr(run.at("0.5")) == "<State at t = 0.5 s: theta 0.0916644 rad, double-double>"
    assert repr(run.inversion).startswith("<InversionTimes: theta = pi/2 at 5.87975 s; A 3.18597 s")
    assert repr(integrate("upright").inversion) == "<InversionTimes: theta = pi/2 is not passed>"
    for shown in (run.state, run.inversion, run.at([0, 1])):
        assert len(repr(shown)) < 160
        assert "<table>" in shown._repr_html_()
    assert "kg m^2/s" in run.state._repr_html_()
