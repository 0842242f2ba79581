"""Pictures of sweeps."""

from typing import Any

import numpy
import pandas
import pytest

from tt_precise.runtime.values import InputError
from tt_precise.sweeps.picture import THRESHOLD, label_of, picture_of


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
        ("max_nu_y", "", r"largest $\nu_y$ (m/s)"),
        ("omega_3", "", r"$\omega_3$(0) (rad/s)"),
    ],
)
def test_a_label_has_its_unit(name: str, law: str, label: str) -> None:
    assert label_of(name, rows(law=law)) == label
    if name in ("mu", "omega_3", "t_end"):
        assert picture_of(rows(law=law), name, "omega_3").axes[0].get_xlabel() == label
        assert picture_of(rows(law=law), "omega_3", "mu", name).axes[1].get_ylabel() == label


@pytest.mark.parametrize("grid", [True, False])
@pytest.mark.parametrize("colour", ["outcome", "climb", "t_end_B"])
def test_every_row_is_drawn_and_outcomes_are_counted(grid: bool, colour: str) -> None:
    table = rows(grid)
    axes = picture_of(table, "mu", "omega_3", colour).axes[0]
    (drawn,) = axes.collections
    shown: Any = drawn.get_array()
    assert numpy.size(shown) == len(table)
    assert type(drawn).__name__ == ("QuadMesh" if grid else "PathCollection")
    if legend := axes.get_legend():
        texts = {text.get_text() for text in legend.get_texts()}
        assert texts == {f"inverts ({5 if grid else 4})", "contact lost (1)"}
        assert legend.get_title().get_text() == "up to 8 s"


def test_the_threshold_is_drawn_where_the_rows_have_it() -> None:
    """Its label stands upright on white, and its line has a white edge."""
    both = rows().assign(lambda_ratio=[0.5, 0.5, 0.5, 1.5, 1.5, 1.5])
    axes = picture_of(both, "mu", "omega_3", "outcome").axes[0]
    line = axes.collections[1]
    (path,) = line.get_paths()
    assert numpy.asarray(path.vertices)[:, 1] == pytest.approx(15.0)
    (label,) = axes.texts
    assert (label.get_text(), label.get_rotation()) == (THRESHOLD, 0)
    assert line.get_path_effects()
    for without in (both.assign(lambda_ratio=2.0), pandas.concat([both, both])):
        assert len(picture_of(without, "mu", "omega_3", "outcome").axes[0].collections) == 1


def test_empty_and_unknown_columns_are_refused() -> None:
    nowhere = rows().assign(t_end_A=numpy.nan)
    with pytest.raises(InputError, match="none of 6 rows has a value"):
        picture_of(nowhere, "mu", "omega_3", "climb")
    with pytest.raises(InputError, match="expected one of: mu"):
        picture_of(rows(), "mu", "nothing")
