"""The balance of changes and rates: its own doubt bounds it, at every sampling interval."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.check.columns import COLUMN_SETS
from tt_precise.check.equation_residual import EquationResidual, SummedResidual
from tt_precise.check.reading import open_source
from tt_precise.check.samples import CheckSetup

Healthy = Callable[..., pandas.DataFrame]


def balance(frame: pandas.DataFrame, columns: str) -> tuple[Any, Any]:
    setup = CheckSetup(tt.load_scene("reference"), COLUMN_SETS[columns], True)
    block = next(open_source(frame).blocks(("t", *setup.columns.names)))
    samples = setup.samples(block)
    return EquationResidual(setup, samples).balance(samples), samples


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
@pytest.mark.parametrize("rows", [101, 151, 201, 301, 401, 801, 1601])
def test_the_doubt_bounds_the_error_of_the_quadrature(
    healthy: Healthy, columns: str, rows: int
) -> None:
    found, _ = balance(healthy("reference", rows), columns)
    resolved = found.doubt < 1e-6
    error = numpy.abs(numpy.vstack((found.state, found.energy)))[:, resolved].max(axis=0)
    # the states themselves are rounded, and the coarser the steps, the larger their powers
    rounding = 1e-12
    assert (error <= found.doubt[resolved] + rounding).all()
    assert resolved.mean() > (0.99 if rows > 400 else 0.02)


def test_dense_rows_are_passed_over_and_nothing_is_lost(healthy: Healthy) -> None:
    frame = healthy("reference", 20001, 0.5)
    found, samples = balance(frame, "vectors")
    assert len(found.ends) < len(samples.t) / 5
    assert found.ends[-1] == len(samples.t) - 1
    change = frame["Lz"].iloc[len(samples.t) - 1] - frame["Lz"].iloc[0]
    assert abs(change) > 1e-8
    assert abs(found.state).max() < 1e-13


def test_coarse_rows_are_told_not_judged(healthy: Healthy) -> None:
    result = tt.check.conservation(healthy("reference", 41), "reference")
    equations = result["equations"]
    assert equations.verdict == "skipped"
    assert equations.reason.startswith("rows too far apart: ")
    assert "intervals too wide to tell" in equations.reason
    assert result.passed


def test_an_interval_as_doubtful_as_the_limit_is_still_resolved(healthy: Healthy) -> None:
    frame = healthy("reference", 401)
    found, samples = balance(frame, "vectors")
    setup = CheckSetup(tt.load_scene("reference"), COLUMN_SETS["vectors"], True)
    limit = float(numpy.sort(found.doubt)[-3])
    for allowed, unresolved in ((limit, 2), (float(numpy.nextafter(limit, 0)), 3)):
        total = SummedResidual(EquationResidual(setup, samples), "state", allowed)
        total(samples)
        assert (total.unresolved, total.intervals) == (unresolved, len(found.doubt))


@pytest.mark.parametrize("columns", ["vectors", "Euler"])
def test_a_rolling_top_has_no_power_and_no_velocity_of_its_own(
    healthy: Healthy, columns: str
) -> None:
    """Its contact point rests: E is constant, and v is no part of the state."""
    frame = healthy("rolling", 401)
    setup = CheckSetup(tt.load_scene("rolling"), COLUMN_SETS[columns], True)
    block = next(open_source(frame).blocks(("t", *setup.columns.names)))
    samples = setup.samples(block)
    found = EquationResidual(setup, samples).balance(samples)
    assert len(found.state) == (6 if columns == "vectors" else 4)
    assert abs(found.energy).max() < 1e-12
    assert (abs(found.state).max(axis=0) <= found.doubt + 1e-12).all()
