"""Residuals of equations from row to row: right rows, planted changes, resolution, blocks."""

from collections.abc import Callable

import numpy
import pandas
import pytest

from tests.check.conftest import Healthy, pose, rows_of
from tests.conftest import Patch
from tt_precise.check import residuals
from tt_precise.check.residuals import (
    RESOLVED,
    SAFETY,
    StepResiduals,
    by_any_force,
    by_law,
    differentiate,
    norm,
    nutation,
    stencils,
    unresolved,
)

Change = Callable[[pandas.DataFrame], pandas.DataFrame]


def right(hertz: int, until: float = 0.5) -> pandas.DataFrame:
    return pose([n / hertz for n in range(round(until * hertz) + 1)])


def test_polynomials_are_exact_to_their_degree() -> None:
    t = numpy.sort(numpy.random.default_rng(3).random(30))
    for rows in (t, numpy.arange(30) / 30):
        for count in (6, 8):
            power, h = count - 1, numpy.diff(rows)
            (near, whole), (_, slope) = (stencils(rows, count, way) for way in (True, False))
            integrals = (whole * rows[near] ** power).sum(axis=1) * h
            assert abs(integrals - numpy.diff(rows ** (power + 1)) / (power + 1)).max() < 1e-9
            rates = (slope * rows[near] ** power).sum(axis=1) / h
            assert abs(rates - power * rows[:-1] ** (power - 1)).max() < 1e-7
        rates, error = differentiate(rows, rows[None] ** 5)
        assert abs(rates - 5 * rows[:-1] ** 4).max() < 1e-7
        assert error.max() < 1e-7


@pytest.mark.parametrize("hertz", [120, 240, 960])
def test_right_rows_stay_within_the_bounds_of_any_force(hertz: int) -> None:
    """The factor of safety is used to a third at least where rows are coarse."""
    steps = by_any_force(rows_of(right(hertz)))
    largest = 0.0
    for name in ("rotation", "momentum", "position"):
        values, bound = norm(getattr(steps, name)), steps.bounds[name]
        seen = numpy.isfinite(bound)
        assert seen.all()
        assert (values <= bound + 1e-11 * values.max() + 1e-13)[seen].all()
        largest = max(largest, float((values / bound)[seen].max(initial=0.0)))
    assert largest < 1


def test_fast_friction_needs_the_factor_of_the_bound() -> None:
    """Half a millimetre per second: regularised friction changes within a row."""
    rows = rows_of("regularised-1e-2")
    steps, shares = by_any_force(rows), []
    for name in ("rotation", "momentum"):
        seen = numpy.isfinite(steps.bounds[name])
        shares.append((norm(getattr(steps, name)) / steps.bounds[name])[seen].max(initial=0.0))
    assert max(shares) < 1
    assert SAFETY == 10


def test_nothing_is_resolved_beyond_a_quarter_turn_of_the_nutation() -> None:
    rate = float(nutation(rows_of(right(960)))[0]) * 960
    for factor, resolved in ((0.95, True), (1.05, False)):
        step = factor * RESOLVED / rate
        rows = rows_of(pose([step * n for n in range(40)]))
        bound = by_any_force(rows).bounds["momentum"]
        assert numpy.isfinite(bound).all() == resolved
        text = unresolved(rows, bound)
        assert bool(text) != resolved
        if not resolved:
            assert text.startswith("100 % of the motion is not resolved; rows 0.009 s apart")


def test_a_gap_is_named(healthy: Healthy) -> None:
    frame = right(960).drop(index=range(200, 220)).reset_index(drop=True)
    rows = rows_of(frame)
    assert unresolved(rows, by_any_force(rows).bounds["momentum"]) == (
        f"no rows from {199 / 960:.6g} to {220 / 960:.6g} s"
    )


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("rotation", lambda f: f.assign(wz=1.001 * f["wz"])),
        ("position", lambda f: f.assign(x=f["x"] + 1e-4 * (f["t"] > 0.2))),
        ("momentum", lambda f: f.assign(vcx=f["vcx"] + 1e-3 * (f["t"] > 0.2))),
        ("momentum", lambda f: f.assign(vcz=f["vcz"] + 1e-3 * (f["t"] > 0.2))),
    ],
)
@pytest.mark.parametrize("way", [by_law, by_any_force])
def test_planted_changes_are_seen(
    way: Callable[..., StepResiduals], name: str, change: Change
) -> None:
    before, steps = (way(rows_of(frame)) for frame in (right(480), change(right(480))))
    assert norm(getattr(steps, name)).max() > 100 * norm(getattr(before, name)).max()


def test_rows_in_blocks_have_the_same_residuals(monkeypatch: Patch) -> None:
    frame = right(480)
    ways = [by_law, by_any_force]
    whole = [way(rows_of(frame)) for way in ways]
    monkeypatch.setattr(residuals, "BLOCK", 50)
    for one, way in zip(whole, ways, strict=True):
        steps = way(rows_of(frame))
        for name in ("rotation", "position", "momentum"):
            assert abs(getattr(steps, name) - getattr(one, name)).max() < 1e-13
        assert len(steps.bounds["momentum"]) == len(frame) - 1


def test_euler_angles_without_phi_have_an_inclination_only() -> None:
    frame = rows_of("reference").columns
    names = ("t", "theta", "theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
    table = pandas.DataFrame({name: frame[name] for name in names})[:200]
    wrong = table.assign(theta_dot=table["theta_dot"] + 0.01)
    for way, least in ((by_law, 1e-5), (by_any_force, 1e-5)):
        before, after = (way(rows_of(one)) for one in (table, wrong))
        assert not before.rotation[1:].any()
        assert abs(after.rotation[0] - before.rotation[0]).mean() > least


def test_a_part_of_the_motion_may_be_unresolved_if_it_is_allowed() -> None:
    rows = rows_of(right(240))
    for count, open_ in ((60, False), (61, True)):
        bound = numpy.where(numpy.arange(len(rows.t) - 1) < count, numpy.inf, 0.0)
        assert bool(unresolved(rows, bound, 0.5)) == open_
        assert unresolved(rows, bound).startswith(f"{100 * count / 120:.3g} % of the motion")
