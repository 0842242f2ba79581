"""The manifest: claims from the tables alone, and the constancy of integrals."""

import pytest

from tt_precise.golden.manifest import constancies
from tt_precise.golden.store import read_files
from tt_precise.golden.table import DIGITS, Table


def few(scene: str, rows: int = 12) -> Table:
    table = read_files(scene).trajectory
    return Table(table.columns, table.rows[:rows])


@pytest.mark.parametrize(
    ("scene", "names"),
    [
        ("reference", {"jellett", "jellett_euler"}),
        ("upright", {"jellett"}),  # a pole: no Euler angles
        ("rocking", {"jellett"}),  # lambda = 0
    ],
)
def test_integrals_are_constant_to_all_digits(scene: str, names: set[str]) -> None:
    constant = constancies(read_files(scene).scene, few(scene))
    assert constant.keys() & {"jellett", "jellett_euler"} == names
    assert min(constant.values()) >= DIGITS - 1
