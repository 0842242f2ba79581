"""``tt.sweep``: numbers or text in, a table out."""

from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tt_precise.sweeps import specification
from tt_precise.sweeps.specification import MOST_VALUES, grid_values

SHORT: dict[str, Any] = {"until": "0.05", "recheck": 0}


def test_a_sweep_is_a_table() -> None:
    rows = tt.sweep("reference", vary={"phi_dot": "-20:20:5"}, record=("climb_A",), **SHORT)
    assert isinstance(rows, pandas.DataFrame)
    assert list(rows["phi_dot"]) == [-20, -10, 0, 10, 20]
    assert rows["climb_A"].isna().all()
    summary = rows.attrs["summary"]
    assert summary["rows"] == 5
    assert summary["outcomes"]["undecided"] == 5


@pytest.mark.parametrize(
    "values",
    [
        [-20, -10, 0.0, 10],
        numpy.linspace(-20, 10, 4),
        ("-20", "-10", "0", "1e1"),
        range(-20, 11, 10),
    ],
)
def test_numbers_and_text_are_the_same_sweep(values: Any) -> None:
    texts = specification("reference", vary={"phi_dot": "-20,-10,0,10"})
    given = specification("reference", vary={"phi_dot": values})
    assert given.fingerprint == texts.fingerprint


def test_a_float_stands_for_the_decimal_that_one_writes() -> None:
    assert grid_values("phi_dot", [0.1, numpy.float64(0.2)]) == grid_values("phi_dot", "0.1,0.2")


def test_a_box_of_numbers() -> None:
    given = specification("reference", box={"phi_dot": (-1, 0.5)}, samples=3)
    assert given.fingerprint == (
        specification("reference", box={"phi_dot": "-1:0.5"}, samples=3).fingerprint
    )


@pytest.mark.parametrize(
    "values", [[float("nan")], [float("inf")], [1j], [None], [], ["x"], numpy.array([[1.0]])]
)
def test_refuses_what_is_no_number(values: Any) -> None:
    with pytest.raises(tt.InputError, match="phi_dot"):
        tt.sweep("reference", vary={"phi_dot": values})
    with pytest.raises(tt.InputError, match="phi_dot"):
        tt.sweep("reference", box={"phi_dot": (*values, *values)}, samples=3)


def test_refuses_more_values_than_fit() -> None:
    with pytest.raises(tt.InputError, match=f"expected at most {MOST_VALUES}"):
        specification("reference", vary={"omega_3": "150:155:99999999999999"})
