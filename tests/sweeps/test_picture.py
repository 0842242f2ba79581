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
    assert axes.get_xlabel() == r"$\mu$"  # the law is not known
    assert axes.get_ylabel() == r"$t_{\theta\approx\pi}$, definition A (s)"
    climb = curve(rows(), "mu", "climb", "omega_3").axes[0]
    assert climb.get_ylabel() == "$T_{inv}$, definition A (s)"
    labels = [label_of(name) for name in ("max_nu_y", "lambda_ratio", "omega_3", "t_stop")]
    assert labels == [
        r"largest $\nu_y$ (m/s)", r"$\lambda/\lambda_{thres}$", r"$\omega_3(0)$ (rad/s)",
        "end of the row (s)",
    ]  # fmt: skip


@pytest.mark.parametrize(("law", "unit"), [("viscous", " (s/m)"), ("coulomb", ""), ("", "")])
def test_the_unit_of_mu_is_that_of_the_law(law: str, unit: str) -> None:
    table = rows()
    table.attrs["law"] = law
    assert curve(table, "mu", "omega_3").axes[0].get_xlabel() == rf"$\mu${unit}"
    assert map_of(table, "omega_3", "mu", "outcome").axes[0].get_ylabel() == rf"$\mu${unit}"
    assert map_of(table, "omega_3", "t_stop", "mu").axes[1].get_ylabel() == rf"$\mu${unit}"


def test_cells_without_a_value_are_explained() -> None:
    (legend,) = map_of(rows(), "mu", "omega_3", "climb").legends
    assert [text.get_text() for text in legend.get_texts()] == [
        "no $T_{inv}$, definition A (1):\n  contact lost (1)"
    ]
    assert map_of(rows().dropna(), "mu", "omega_3", "climb").legends == []


def test_the_threshold_is_drawn_where_the_rows_know_it() -> None:
    both = rows().assign(lambda_ratio=[0.5, 0.5, 0.5, 1.5, 1.5, 1.5])
    _, line = map_of(both, "mu", "omega_3", "outcome").axes[0].collections
    (path,) = line.get_paths()
    assert numpy.asarray(path.vertices)[:, 1] == pytest.approx(15.0)
    assert len(map_of(both, "t_end", "omega_3", "outcome").axes[0].collections) == 2
    for without in (both.assign(lambda_ratio=2.0), pandas.concat([both, both])):
        (cells,) = map_of(without, "mu", "omega_3", "outcome").axes[0].collections
        shown: Any = cells.get_array()
        assert numpy.size(shown) == len(without)


def test_values_over_two_decades_have_a_logarithmic_scale() -> None:
    far = rows().assign(mu=[0.001, 1.0, 2.0] * 2, t_end_A=[1e-3, 1, 2, 3, 4, 5.0])
    axes = curve(far, "mu", "t_end").axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    plain = curve(rows(), "mu", "t_end").axes[0]
    assert (plain.get_xscale(), plain.get_yscale()) == ("linear", "linear")
    (drawn,) = map_of(far, "mu", "omega_3", "t_end").axes[0].collections
    assert type(drawn.norm).__name__ == "LogNorm"


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
    with pytest.raises(InputError, match="; a sweep with --record t_equator has"):
        map_of(rows(), "mu", "omega_3", "t_equator")


@pytest.mark.parametrize("grid", [True, False])
@pytest.mark.parametrize("z", ["outcome", "climb", "t_end_B"])
def test_map_shows_every_row(grid: bool, z: str) -> None:
    table = rows(grid)
    axes = map_of(table, "mu", "omega_3", z).axes[0]
    (drawn,) = axes.collections
    shown: Any = drawn.get_array()
    assert numpy.size(shown) == len(table)
