"""Zeros along steps: none is missed, and Newton's method ends at full accuracy."""

import numpy
import pytest

from tt_precise.sweeps import zeros
from tt_precise.sweeps.zeros import classified, refined


def of_cosine(turn: float, phase: float, level: float) -> numpy.ndarray:
    """Return value and rate at both ends of level - cos(turn x - phase), x in [0, 1]."""
    ends = numpy.array([0.0, 1.0])
    values = level - numpy.cos(turn * ends - phase)
    rates = turn * numpy.sin(turn * ends - phase)
    return numpy.array([[values[0]], [rates[0]], [values[1]], [rates[1]]])


def test_a_failed_motion_has_no_zero_and_without_its_margin_a_cubic_hides_two(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    assert not classified(of_cosine(2.0, 1.0, numpy.nan))[0][0]
    assert not classified(numpy.array([[-1.0], [0.0], [numpy.nan], [numpy.nan]]))[0][0]
    assert classified(of_cosine(4.0, 2.0, 0.9))[0][0]
    monkeypatch.setattr(zeros, "MARGIN", 0.0)
    assert not classified(of_cosine(4.0, 2.0, 0.9))[0][0]


def test_no_cosine_of_a_step_hides_zeros() -> None:
    """Whatever its phase and its level: 0 and 1 zeros are counted, others are unclear."""
    x = numpy.linspace(0, 1, 4001)
    for turn in (0.5, 1.0, 2.0):
        for phase in numpy.linspace(0, 2 * numpy.pi, 25):
            for level in numpy.linspace(-1.2, 1.2, 25):
                values = level - numpy.cos(turn * x - phase)
                count = int(((values[1:] < 0) != (values[:-1] < 0)).sum())
                may, single = classified(of_cosine(turn, phase, level))
                assert may[0] or count == 0
                assert not (may[0] and single[0]) or count == 1


@pytest.mark.parametrize("root", [1e-9, 0.3, 0.999])
def test_a_zero_has_full_accuracy_and_does_not_depend_on_others(root: float) -> None:
    """Also of a triple zero, where Newton's steps shrink by a third only."""
    roots = numpy.array([root, 0.5, 0.25])
    powers = numpy.array([1, 1, 3])

    def function(at: numpy.ndarray, chosen: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
        r, p = roots[chosen], powers[chosen]
        return (at - r) ** p * (1 + at), p * (at - r) ** (p - 1) * (1 + at) + (at - r) ** p

    low, high, start = numpy.zeros(3), numpy.ones(3), numpy.full(3, 0.9)
    rising, distance = numpy.ones(3, dtype=bool), numpy.ones(3)
    found = refined(function, (low, high), start, rising, distance)
    assert found[:2] == pytest.approx(roots[:2], rel=1e-15)
    assert found[2] == pytest.approx(0.25, abs=1e-7)
    alone = refined(
        lambda at, _: function(at, numpy.zeros(1, dtype=int)),
        (low[:1], high[:1]), start[:1], rising[:1], distance[:1],
    )  # fmt: skip
    assert alone[0] == found[0]
