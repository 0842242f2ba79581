"""Zeros in a step: each hypothesis, dropped in turn, is noticed by a closed form."""

from tests.certify.harness import Mutant
from tests.certify.mutants import assert_noticed, mutants_of


@mutants_of("zeros")
def test_a_dropped_hypothesis_is_noticed(mutant: Mutant) -> None:
    assert_noticed(mutant)
