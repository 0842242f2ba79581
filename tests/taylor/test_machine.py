"""Compiled instructions have the same bits on every processor and in every thread."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from tests.taylor.problems import FN, FULL, PROBLEMS, bits, pieces, system
from tt_precise.taylor.machine import Machine


@pytest.mark.parametrize("limbs", [2, 3])
def test_the_same_bits_again_and_on_a_plainer_processor(limbs: int) -> None:
    name = "root"
    made = system(name, limbs)
    quick = made.machine
    first, again = pieces(name, limbs), pieces(name, limbs)
    others = [again]
    for features in (None, ""):  # "": no AVX2, no FMA
        made.machine = Machine(made.kernel.text(), features)
        others.append(pieces(name, limbs))
    made.machine = quick
    for other in others:
        assert len(other) == len(first)
        for a, b in zip(first, other, strict=True):
            assert bits(a) == bits(b)


def test_threads_share_one_machine() -> None:
    made, one = system.__wrapped__("root", 2), PROBLEMS["root"]
    initial = made.initial_data(one.start, one.parameters, FN)
    barrier = threading.Barrier(8)

    def run() -> Any:
        barrier.wait()
        return [limb for block in made.pieces(initial, 3.0, FULL[2]) for limb in bits(block)]

    with ThreadPoolExecutor(8) as pool:
        found = [future.result() for future in [pool.submit(run) for _ in range(8)]]
    assert all(other == found[0] for other in found)
