"""The kernel: each hypothesis of the theorem, dropped in turn, is noticed by a closed form."""

from tests.certify.harness import Mutant
from tests.certify.mutants import assert_noticed, mutants_of


@mutants_of("kernel")
def test_a_dropped_hypothesis_is_noticed(mutant: Mutant) -> None:
    assert_noticed(mutant)
