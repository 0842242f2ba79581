"""Maps of starts: cells and their fates, and sides that are none."""

from __future__ import annotations

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

import tt_precise as tt
from tt_precise.certify.starts import NEVER, UPRIGHT
from tt_precise.certify.starts_map import MapSide, proved_map
from tt_precise.runtime.errors import InputError


def test_cells_of_a_map() -> None:
    # slow tops stay upright; in the next row some may tumble, and faster ones may invert
    sides = MapSide.parse("phi_dot=0:10:2"), MapSide.parse("omega_3=20:32:3")
    found = proved_map(tt.load_scene("reference"), *sides)
    assert found.as_dict()["cells"] == ["gg", "nn", "nn"]
    assert found.shares == {UPRIGHT: 1 / 3, NEVER: 2 / 3}
    fast = MapSide.parse("phi_dot=0:10:2"), MapSide.parse("omega_3=60:160:2")
    assert not proved_map(tt.load_scene("reference"), *fast).proved


@pytest.mark.parametrize(
    "text",
    [
        "theta=0:1:2",
        "phi_dot=1:0:3",
        "phi_dot=0:1",
        "omega_3=a:b:3",
        "phi_dot=0:1:99999999",
        "phi_dot=0:1:5/2",
        "phi_dot=1/0:2:3",
        "phi_dot=1e-999999999:1:3",  # a fraction of a billion digits
    ],
)
def test_a_map_that_is_none(text: str) -> None:
    with pytest.raises(InputError, match=r"map: got .{1,200} expected"):
        MapSide.parse(text)


def test_a_side_that_is_none_says_which_there_are() -> None:
    with pytest.raises(InputError, match="with one of theta_dot, phi_dot, omega_3"):
        MapSide.parse("theta=0:1:2")


def test_a_map_of_one_entry_is_none() -> None:
    side = MapSide.parse("phi_dot=0:10:2")
    with pytest.raises(InputError, match="map: got phi_dot twice"):
        proved_map(tt.load_scene("reference"), side, side)
