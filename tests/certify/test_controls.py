"""Every hypothesis has a control, which passes on the modules as they are.

The tests of each trusted module drop its hypotheses in turn; a control notices each.
"""

import pytest

from tests.certify.controls import CONTROLS, run
from tests.certify.harness import MODULES, unchanged
from tests.certify.mutants import MUTANTS


@pytest.mark.parametrize("name", CONTROLS)
def test_what_is_right_passes(name: str) -> None:
    run(name, unchanged())


def test_every_control_has_a_mutant() -> None:
    assert {mutant.control for mutant in MUTANTS} == set(CONTROLS)
    assert {mutant.module for mutant in MUTANTS} == {*MODULES} - {"propose"}
    assert len({*MUTANTS}) == len(MUTANTS)
