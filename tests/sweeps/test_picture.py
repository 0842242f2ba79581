"""Pictures of sweeps."""

from typing import Any

import numpy
import pandas
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.sweeps.picture import curve, label_of, map_of


def rows(grid: bool = True) -> pandas.DataFrame:
    x, y = (values.ravel() for values in numpy.meshgrid([1.0, 2.0, 3.0], [10.0, 20.0]))
    ends = numpy.array([1.0, 2.0, numpy.nan, 4.0, 5.0, 6.0])
    times = {f"t_init_{one}": 0.5 * ends for one in "ABC"} | {f"t_end_{one}": ends for one in "ABC"}
    outcome = numpy.where(numpy.isnan(ends), "contact_lost", "inverts")
    table = pandas.DataFrame({"mu": x, "omega_3": y, "outcome": outcome, "t_stop": 8.0, **times})
    return table if grid else table.iloc[:-1]


def test_curve_shows_every_row() -> None:
    (axes, *_) = curve(rows(), "mu", "t_end", "outcome").axes
    points = [numpy.size(line.get_xdata()) for line in axes.get_lines()]
    assert sum(points) == 6  # the one without a value stands on the edge
    assert axes.get_xlabel() == "mu (s/m)"
    assert axes.get_ylabel() == "t_end_A (s)"
    assert curve(rows(), "mu", "climb", "omega_3").axes[0].get_ylabel() == "climb_A (s)"
    labels = [label_of(name) for name in ("max_nu_y", "lambda_ratio")]
    assert labels == ["max_nu_y (m/s)", "lambda_ratio"]


def test_the_legend_says_what_an_outcome_states_and_at_which_horizon() -> None:
    for axes in (
        curve(rows(), "mu", "t_end", "outcome").axes[0],
        map_of(rows(), "mu", "omega_3", "outcome").axes[0],
    ):
        legend = axes.get_legend()
        assert legend is not None
        assert "at 8 s (5)" in legend.get_texts()[0].get_text()


def test_an_empty_picture_and_unknown_columns_are_refused() -> None:
    nowhere = rows().assign(t_end_A=numpy.nan)
    for draw in (
        lambda: curve(nowhere, "mu", "climb"),
        lambda: curve(nowhere, "t_end", "mu"),
        lambda: map_of(nowhere, "mu", "omega_3", "climb"),
    ):
        with pytest.raises(InputError, match="none of 6 rows has a value"):
            draw()
    with pytest.raises(InputError, match="expected one of: mu"):
        curve(rows(), "mu", "nothing")


@pytest.mark.parametrize("grid", [True, False])
@pytest.mark.parametrize("z", ["outcome", "climb", "t_end_B"])
def test_map_shows_every_row(grid: bool, z: str) -> None:
    table = rows(grid)
    axes = map_of(table, "mu", "omega_3", z).axes[0]
    (drawn,) = axes.collections
    shown: Any = drawn.get_array()
    assert numpy.size(shown) == len(table)
