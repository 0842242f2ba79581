"""Pictures of sweeps."""

from typing import Any

import numpy
import pandas
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.sweeps.picture import THRESHOLD, curve, label_of, map_of


def rows(grid: bool = True, law: str = "") -> pandas.DataFrame:
    x, y = (values.ravel() for values in numpy.meshgrid([1.0, 2.0, 3.0], [10.0, 20.0]))
    ends = numpy.array([1.0, 2.0, numpy.nan, 4.0, 5.0, 6.0])
    times = {f"t_init_{one}": 0.5 * ends for one in "ABC"} | {f"t_end_{one}": ends for one in "ABC"}
    outcome = numpy.where(numpy.isnan(ends), "contact_lost", "inverts")
    table = pandas.DataFrame({"mu": x, "omega_3": y, "outcome": outcome, "t_stop": 8.0, **times})
    table.attrs["law"] = law
    return table if grid else table.iloc[:-1]


@pytest.mark.parametrize(
    ("name", "law", "label"),
    [
        ("mu", "viscous", r"$\mu$ (s/m)"),
        ("mu", "coulomb", r"$\mu$"),
        ("mu", "", r"$\mu$"),  # the law is not known
        ("t_end", "", r"$t_{\theta\approx\pi}$, definition A (s)"),
        ("climb", "", "$T_{inv}$, definition A (s)"),
        ("max_nu_y", "", r"largest $\nu_y$ (m/s)"),
        ("lambda_ratio", "", r"$\lambda/\lambda_{thres}$"),
        ("omega_3", "", r"$\omega_3$(0) (rad/s)"),
        ("t_stop", "", "end of the row (s)"),
    ],
)
def test_a_label_has_its_unit(name: str, law: str, label: str) -> None:
    assert label_of(name, rows(law=law)) == label
    if name in ("mu", "omega_3", "t_end"):
        assert curve(rows(law=law), name, "omega_3").axes[0].get_xlabel() == label
        assert map_of(rows(law=law), "omega_3", "mu", name).axes[1].get_ylabel() == label


def test_a_curve_shows_every_row_with_a_value() -> None:
    axes = curve(rows(), "mu", "t_end", "outcome").axes[0]
    assert sum(int(numpy.isfinite(line.get_ydata()).sum()) for line in axes.get_lines()) == 5
    offsets: Any = curve(rows(), "mu", "climb", "omega_3").axes[0].collections[0].get_offsets()
    assert len(offsets) == 6


@pytest.mark.parametrize("grid", [True, False])
@pytest.mark.parametrize("z", ["outcome", "climb", "t_end_B"])
def test_a_map_shows_every_row(grid: bool, z: str) -> None:
    table = rows(grid)
    (drawn,) = map_of(table, "mu", "omega_3", z).axes[0].collections
    shown: Any = drawn.get_array()
    assert numpy.size(shown) == len(table)


def test_the_threshold_is_drawn_where_the_rows_have_it() -> None:
    """Its label stands upright on white, and its line has a white edge."""
    both = rows().assign(lambda_ratio=[0.5, 0.5, 0.5, 1.5, 1.5, 1.5])
    axes = map_of(both, "mu", "omega_3", "outcome").axes[0]
    line = axes.collections[1]
    (path,) = line.get_paths()
    assert numpy.asarray(path.vertices)[:, 1] == pytest.approx(15.0)
    (label,) = axes.texts
    assert (label.get_text(), label.get_rotation()) == (THRESHOLD, 0)
    patch: Any = label.get_bbox_patch()
    assert patch.get_facecolor() == (1, 1, 1, 1)
    assert line.get_path_effects()
    assert len(map_of(both, "t_end", "omega_3", "outcome").axes[0].collections) == 2
    for without in (both.assign(lambda_ratio=2.0), pandas.concat([both, both])):
        assert len(map_of(without, "mu", "omega_3", "outcome").axes[0].collections) == 1


def test_values_over_two_decades_have_a_logarithmic_scale() -> None:
    far = rows().assign(mu=[0.001, 1.0, 2.0] * 2, t_end_A=[1e-3, 1, 2, 3, 4, 5.0])
    for table, scale, norm in ((far, "log", "LogNorm"), (rows(), "linear", "Normalize")):
        axes = curve(table, "mu", "t_end").axes[0]
        assert (axes.get_xscale(), axes.get_yscale()) == (scale, scale)
        (drawn,) = map_of(table, "mu", "omega_3", "t_end").axes[0].collections
        assert type(drawn.norm).__name__ == norm


def test_the_legend_says_what_an_outcome_states_and_at_which_horizon() -> None:
    for figure in (
        curve(rows(), "mu", "t_end", "outcome"),
        map_of(rows(), "mu", "omega_3", "outcome"),
    ):
        legend = figure.axes[0].get_legend()
        assert legend is not None
        texts = {text.get_text() for text in legend.get_texts()}
        assert texts == {"equator passed, and below it at 8 s (5)", "contact lost (1)"}


def test_empty_and_unknown_columns_are_refused() -> None:
    nowhere = rows().assign(t_end_A=numpy.nan)
    for x, y in (("mu", "climb"), ("t_end", "mu")):
        with pytest.raises(InputError, match="none of 6 rows has a value"):
            curve(nowhere, x, y)
    with pytest.raises(InputError, match="none of 6 rows has a value"):
        map_of(nowhere, "mu", "omega_3", "climb")
    with pytest.raises(InputError, match="expected one of: mu"):
        curve(rows(), "mu", "nothing")
