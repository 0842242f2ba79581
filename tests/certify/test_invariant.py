from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

pytest.importorskip("flint", reason="needs python-flint (extra certify)")

from flint import arb

import tt_precise as tt
from tt_precise.certify import Problem, problem_of
from tt_precise.certify.problem import exact_zeros, restored, without


def names(problem: Problem) -> set[str]:
    return {problem.columns[i] for i in exact_zeros(problem)}


def test_what_stays_zero_in_the_scenes() -> None:
    still = {"kx", "ky", "Lx", "Ly", "s_dot_x", "s_dot_y"}
    assert names(problem_of(tt.load_scene("upright"))) == still
    assert names(problem_of(tt.load_scene("rocking"))) == {"ky", "Lx", "Lz", "s_dot_y"}
    # zero at the start is not enough
    assert names(problem_of(tt.load_scene("reference"))) == set()


def test_a_spin_however_small_leaves_the_plane() -> None:
    scene = tt.load_scene("rocking")
    start = replace(scene.start, omega_3=Fraction(1, 10**60))
    assert names(problem_of(replace(scene, start=start))) == set()


def test_zero_at_the_start_by_chance_does_not_count() -> None:
    def rates(parameters: Sequence[Any], state: Sequence[Any], fn: Any) -> Sequence[Any]:
        x, y = state
        return 1 + 0 * x, x - 1 + y

    problem = Problem("chance", ("x", "y"), rates, list, lambda: [arb(1), arb(0)], lambda: arb(1))
    assert exact_zeros(problem) == frozenset()


def test_the_problem_without_them() -> None:
    problem = problem_of(tt.load_scene("rocking"))
    zeros = exact_zeros(problem)
    inner = without(problem, zeros)
    assert inner.columns == ("kx", "kz", "Ly", "s_dot_x")
    whole = problem.rates(problem.parameters(), problem.start(), None)
    part = inner.rates(inner.parameters(), inner.start(), None)
    again = restored(part, zeros, 8, 0)
    assert all(arb(a).overlaps(arb(b)) for a, b in zip(whole, again, strict=True))
