"""Every hypothesis has a control, and every control is seen to fail when it is dropped."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import flint
import pytest

from tests.certify.controls import CONTROLS
from tests.certify.harness import BITS, Mutant, program
from tests.certify.mutants import MUTANTS

GUARD = 40
DEATHS = (AssertionError, ArithmeticError, ValueError, pytest.fail.Exception)


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(BITS + GUARD):
        yield


@cache
def unchanged() -> Any:
    return program()


@pytest.mark.parametrize("name", CONTROLS)
def test_what_is_right_passes(name: str) -> None:
    CONTROLS[name](unchanged())


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_a_dropped_hypothesis_is_noticed(mutant: Mutant) -> None:
    with pytest.raises(DEATHS):
        CONTROLS[mutant.control](program(mutant))


def test_every_control_has_a_mutant() -> None:
    assert {mutant.control for mutant in MUTANTS} == set(CONTROLS)
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS)
