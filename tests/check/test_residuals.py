"""Residuals of equations from row to row: right rows, planted changes, resolution, blocks."""

from collections.abc import Callable

import numpy
import pytest

from tests.check.conftest import EULER, pose, rows_of, solved, vectors
from tests.conftest import Patch
from tt_precise.check import residuals
from tt_precise.check.residuals import RESOLVED, by_any_force, by_law, norm, unresolved

Way = Callable[..., residuals.StepResiduals]


@pytest.mark.parametrize(
    "rows", [numpy.arange(30) / 30, numpy.arange(30) ** 2 / 900, numpy.logspace(-100, 0, 30)]
)
def test_polynomials_are_exact_to_their_degree(rows: numpy.ndarray) -> None:
    for power, small in ((7, numpy.inf), (5, 1e-9)):
        integrals, error = residuals.integrate(rows, rows[None] ** power)
        exact = numpy.diff(rows ** (power + 1)) / (power + 1)
        assert abs(integrals - exact).max() < 1e-9
        assert 0 <= error.max() < small


@pytest.mark.parametrize(
    ("scene", "hertz", "least"),
    [("reference", 120, 0.0), ("reference", 960, 0.0), ("stribeck", 240, 0.6)],  # needs SAFETY
)
def test_right_rows_stay_within_their_bounds(scene: str, hertz: int, least: float) -> None:
    steps = by_any_force(rows_of(pose(481, hertz, scene), of=scene))
    shares = []
    for name in ("rotation", "momentum", "position"):
        resolved = numpy.isfinite(steps.bounds[name])
        assert resolved.mean() > 0.9
        shares.append(float((norm(getattr(steps, name)) / steps.bounds[name])[resolved].max()))
    assert least < max(shares) < 1


HERTZ = 4000


def bounds_with_a_wrong_row(name: str, column: str, size: float) -> numpy.ndarray:
    """Return the bounds of a residual of rows of which one is wrong by ``size``."""
    frame = pose(100, HERTZ)
    frame[column] += size * (frame.index == 50)
    bounds: numpy.ndarray = by_any_force(rows_of(frame)).bounds[name]
    return bounds


@pytest.mark.parametrize(
    ("name", "column", "limit"),
    [("rotation", "wz", 0.1), ("position", "vcx", 0.1 * 0.02), ("momentum", "vcx", 0.3)],
)
def test_an_interval_of_large_errors_tells_nothing(name: str, column: str, limit: float) -> None:
    """Up to 0.1 rad, 0.1 R and 0.3 m g R alpha; a row counts where the polynomials have it."""
    if name == "momentum":
        limit *= residuals.torque_unit(rows_of(pose(2)).body) / HERTZ
    before, bounds = (bounds_with_a_wrong_row(name, column, size) for size in (0.0, 1e-3))
    if name != "rotation":  # the quaternion's four components hide some intervals
        assert (bounds > 10 * before.max()).sum() == 8 + 2 * 3  # neighbours on either side
    for factor in (0.95, 1.05):
        size = 1e-3 * factor * limit / bounds.max()
        resolved = numpy.isfinite(bounds_with_a_wrong_row(name, column, size)).all()
        assert resolved == (factor < 1)


def test_nothing_is_resolved_beyond_a_quarter_turn_of_the_nutation() -> None:
    rate = float(residuals.nutation(rows_of(pose(481, 960)))[0]) * 960
    for factor, resolved in ((0.95, True), (1.05, False)):
        rows = rows_of(pose(40, rate / (factor * RESOLVED)))
        bound = by_any_force(rows).bounds["momentum"]
        assert numpy.isfinite(bound).all() == resolved
        text = unresolved(rows, bound)
        assert bool(text) != resolved
    assert text.startswith("100 % of the motion is not resolved; rows 0.009 s apart")


@pytest.mark.parametrize(("missing", "gap"), [(3, False), (5, True), (20, True)])
def test_a_gap_of_five_rows_is_named(missing: int, gap: bool) -> None:
    kept = pose(481, 960).drop(index=range(200, 200 + missing)).reset_index(drop=True)
    rows = rows_of(kept)
    text = unresolved(rows, numpy.full(len(rows.t) - 1, numpy.inf))
    assert text.startswith("no rows") == gap
    if missing == 20:
        assert text == f"no rows from {199 / 960:.6g} to {220 / 960:.6g} s"
        assert unresolved(rows, by_any_force(rows).bounds["momentum"]) == text


def test_a_part_of_the_motion_may_be_unresolved_if_it_is_allowed() -> None:
    rows = rows_of(pose(121, 240))
    for count, open_ in ((60, False), (61, True)):
        bound = numpy.where(numpy.arange(len(rows.t) - 1) < count, numpy.inf, 0.0)
        assert bool(unresolved(rows, bound, 0.5)) == open_
        assert unresolved(rows, bound).startswith(f"{100 * count / 120:.3g} % of the motion")


@pytest.mark.parametrize("way", [by_law, by_any_force])
def test_rows_in_blocks_have_the_same_residuals(way: Way, monkeypatch: Patch) -> None:
    whole = way(rows_of(pose(241, 480)))
    monkeypatch.setattr(residuals, "BLOCK", 50)
    steps = way(rows_of(pose(241, 480)))
    for name in ("rotation", "position", "momentum"):
        assert abs(getattr(steps, name) - getattr(whole, name)).max() < 1e-13
    assert len(steps.bounds["momentum"]) == 240


@pytest.mark.parametrize("way", [by_law, by_any_force])
def test_euler_angles_without_phi_have_an_inclination_only(way: Way) -> None:
    frame = solved(EULER, 200)
    wrong = frame.assign(theta_dot=frame["theta_dot"] + 0.01)
    before, after = (way(rows_of(each)) for each in (frame, wrong))
    assert not before.rotation[1:].any()
    assert abs(after.rotation[0] - before.rotation[0]).mean() > 1e-5


@pytest.mark.parametrize(("intervals", "integrated"), [(200, 200), (201, 101)])
def test_at_most_200_switches_are_integrated(
    intervals: int, integrated: int, monkeypatch: Patch
) -> None:
    scene = "coulomb-stick-slip"
    monkeypatch.setattr(residuals.ContactLaw, "may_change", lambda law, y, least: least[0] < 9)
    monkeypatch.setattr(
        residuals, "integrate_scene", lambda law, y, spans: (law.vectors(y)[0], 0 * spans)
    )
    bounds = by_law(rows_of(vectors(intervals + 1, 5000, scene), scene)).bounds["state"]
    assert numpy.isfinite(bounds).sum() == integrated
