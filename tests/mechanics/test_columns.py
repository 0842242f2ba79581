"""Every column that is read or written has a unit and a meaning."""

import pytest

from tt_precise.check.columns import COLUMN_SETS
from tt_precise.mechanics.columns import DESCRIPTIONS, described
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.pose import Pose


def test_every_column_is_described() -> None:
    read = {name for found in COLUMN_SETS.values() for name in found.names}
    for name in {*read, *STATE_DIMENSIONS, *Pose._fields, "t"}:
        assert all(described(name)), name
    with pytest.raises(KeyError):
        described("lean")


def test_units_are_those_of_the_dimensions() -> None:
    for name in DESCRIPTIONS.keys() & STATE_DIMENSIONS.keys() - {"phi", "psi"}:
        assert DESCRIPTIONS[name].unit == STATE_DIMENSIONS[name].unit
