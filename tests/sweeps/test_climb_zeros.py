"""Zeros next to the climb are those among all zeros; no step that may hold one is left out."""

from typing import Any

import numpy
import pytest

from tt_precise.integration.idle import Idle
from tt_precise.sweeps import climb_zeros, lanes, specification
from tt_precise.sweeps.chunk import compute
from tt_precise.sweeps.samples import blocks
from tt_precise.sweeps.specification import Specification

MIXED = {"phi_dot": "-60:100", "theta_dot": "-5:5", "theta": "0.01:1.8", "omega_3": "-160:160"}
SHARE = 0.13  # of the radius of convergence: a step
TERMS = 12


@pytest.fixture
def spec() -> Specification:
    return specification("reference", box=MIXED, samples=24, seed=5, until="6")


def computed(spec: Specification) -> dict[str, Any]:
    ((_, values),) = blocks(spec, 4096, set())
    return compute(spec.plan, values, 8)


def same(first: dict[str, Any], second: dict[str, Any]) -> bool:
    return all(
        list(first[name]) == list(second[name])
        if name == "outcome"
        else numpy.array_equal(first[name], second[name], equal_nan=True)
        for name in first
    )


def anywhere(self: Any, taken: Any, *_: Any) -> Any:
    return numpy.full((len(self._sides), *taken.row.shape), climb_zeros.MAYBE)


def test_rows_are_as_if_all_zeros_were_looked_for(
    spec: Specification, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Here every step is taken again, as if it might hold a zero, which is never certain."""
    at_equator = specification(
        "reference", until="4", vary={"theta": "1.5707963267948966", "omega_3": "0,155",
        "theta_dot": "-1,0,1"},
    )  # fmt: skip
    for asked in (spec, at_equator):
        expected = computed(asked)
        with monkeypatch.context() as patched:
            patched.setattr(lanes, "_idle", Idle(lanes.Lanes))
            patched.setattr(climb_zeros.ClimbZeros, "_signs", anywhere)
            assert same(computed(asked), expected)
        assert numpy.isfinite(expected["t_init_C"]).any()


def test_a_zero_that_is_left_out_is_noticed(
    spec: Specification, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = computed(spec)
    true_signs = climb_zeros.ClimbZeros._signs

    def blind(self: Any, *given: Any) -> Any:
        found = true_signs(self, *given)
        found[1:, ::2] = 0
        return found

    monkeypatch.setattr(lanes, "_idle", Idle(lanes.Lanes))
    monkeypatch.setattr(climb_zeros.ClimbZeros, "_signs", blind)
    assert not same(computed(spec), expected)


@pytest.mark.parametrize(("waiting", "at_once"), [(0, 0), (2, 3)])
def test_when_steps_are_taken_again_changes_nothing(
    waiting: int, at_once: int, spec: Specification, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = computed(spec)
    monkeypatch.setattr(climb_zeros, "WAITING", waiting)
    monkeypatch.setattr(climb_zeros, "AT_ONCE", at_once)
    assert same(computed(spec), expected)


def test_few_steps_are_taken_again(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[int] = []
    true_zeros = climb_zeros.StepsAgain.zeros

    def zeros(self: Any, steps: Any) -> Any:
        taken.append(len(steps.row))
        return true_zeros(self, steps)

    monkeypatch.setattr(climb_zeros.StepsAgain, "zeros", zeros)
    rows = computed(specification("reference", vary={"phi_dot": "-1:1:8"}))
    assert sum(taken) < sum(rows["steps"]) / 50  # found 1/110


def step(draws: numpy.random.Generator) -> Any:
    """A polynomial whose series converges as that of a step does, moved until it nearly vanishes.

    Half of them are even about the middle, where the cubic through both ends is worst.
    """
    series = draws.normal(size=TERMS) * SHARE ** numpy.arange(TERMS)
    if draws.uniform() < 0.5:
        series = numpy.array([0, 0, 1, -2, 1]) * draws.normal() * SHARE**4
    value = numpy.polynomial.Polynomial(series)
    least = value(numpy.linspace(0, 1, 101)).min()
    return value - least - abs(least) * draws.choice([-0.1, -1e-6, 1e-6, 0.1])


def left_out(floor: float, margin: float, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many of 1,000 steps with a zero cannot have one."""
    draws = numpy.random.default_rng(3)
    inputs, has_zero = [], []
    for _ in range(1000):
        value = step(draws)
        rate, size = value.deriv(), 1.0
        inputs.append([value(0), rate(0), size, value(1), rate(1), size, 1.0])
        places = value(numpy.linspace(0, 1, 101))
        has_zero.append(places.min() < 0 < places.max())
    with monkeypatch.context() as patched:
        patched.setattr(climb_zeros, "FLOOR", floor)
        patched.setattr(climb_zeros, "MARGIN", margin)
        (signs,) = climb_zeros._sign.__wrapped__()(numpy.array(inputs).T.copy())
    assert sum(has_zero) > 300
    return int(((signs == 0) & has_zero).sum())


def test_a_step_with_a_zero_is_never_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    assert left_out(climb_zeros.FLOOR, climb_zeros.MARGIN, monkeypatch) == 0
    assert left_out(0.0, 0.0, monkeypatch) > 10
