"""Compiled instructions have the same bits on every processor and in every thread."""

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from tests.taylor.problems import FULL, PROBLEMS, bits, integrate, system
from tt_precise.taylor import machine


@pytest.mark.parametrize("limbs", [2, 3])
def test_bits_are_those_of_any_processor_and_level_of_optimisation(
    limbs: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The features "" are those of every processor of the kind: no AVX2, no FMA."""
    root = system("root", limbs)
    solutions = []
    for level, features, brief in ((0, None, False), (2, None, False), (0, "", False), (2, "", 1)):
        monkeypatch.setattr(machine, "OPTIMISATION", level)
        compiled = machine.Machine(root.kernel.text(), features, brief=bool(brief))
        monkeypatch.setattr(root, "machine", compiled)
        solutions.append([bits(b) for b in integrate(root, PROBLEMS["root"], FULL[limbs])])
    assert all(solution == solutions[0] for solution in solutions)


def test_threads_share_one_machine() -> None:
    root, barrier = system.__wrapped__("root", 2), threading.Barrier(8)

    def solution() -> list[list[bytes]]:
        barrier.wait()
        return [bits(block) for block in integrate(root, PROBLEMS["root"], FULL[2])]

    with ThreadPoolExecutor(8) as pool:
        solutions = [future.result() for future in [pool.submit(solution) for _ in range(8)]]
    assert all(other == solutions[0] for other in solutions)
