"""The Taylor steps of a run are its solution, in every arithmetic."""

from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tests.conftest import Patch
from tt_precise.integration.steps import Steps
from tt_precise.integration.zeros import ROUNDINGS, Zeros
from tt_precise.scene.scene import Scene

# Relative to the largest component: the series in double, and the wide reading of a step.
IN_DOUBLE = 2.0**-48
WIDE = {"extended": 2.0**-58, "double-double": 2.0**-98, "quad": 2.0**-104, "mp": 2.0**-110}


@pytest.mark.parametrize("precision", ["double", *WIDE])
def test_series_and_wide_rows_are_the_solution(
    reference: Scene, precision: str, monkeypatch: Patch
) -> None:
    found: list[Steps] = []
    monkeypatch.setattr(Zeros, "search", lambda self, steps: found.append(steps))
    words: dict[str, Any] = {"bits": 120} if precision == "mp" else {}
    run = tt.integrate(reference.varied(until="0.02"), precision, events=("theta_max",), **words)
    steps, (segment,) = found[0], run.run.segments

    def apart(time: Any, values: list[Any]) -> float:
        (row,) = segment.output.rows([time])
        with mpmath.workprec(200):
            return float(max(abs(a - b) for a, b in zip(values, row, strict=True)))

    step, position = len(steps) // 2, 0.375
    inside = [float(x[0]) for x in steps.inside(numpy.array([step]), numpy.array([position]))]
    row = steps.sampled(numpy.array([position])).row
    assert [float(x[0, step]) for x in row] == pytest.approx(inside)
    time = steps.begin[step] + position * steps.length[step]
    assert apart(mpmath.mpf(float(time)), inside) < IN_DOUBLE
    later = steps.part(step, step + 1)
    assert [x[0, 0] for x in later.sampled(numpy.array([position])).row] == pytest.approx(inside)
    if precision == "double":
        assert steps.wide is None
        return
    assert steps.wide is not None
    assert later.wide is not None
    for wide, number in ((steps.wide, step), (later.wide, 0)):
        with run.precision.mpfr.precision():
            exact, rows = wide.rows(numpy.array([number]), numpy.array([position]))
        assert apart(wide.back(exact[0]), [wide.back(row[0]) for row in rows]) < WIDE[precision]
    # the control: four eps of double later they are another state
    late = wide.back(exact[0]) * (1 + 2.0**-50)
    assert apart(late, [wide.back(row[0]) for row in rows]) > WIDE[precision]


def test_a_component_has_the_roundings_that_are_claimed(monkeypatch: Patch) -> None:
    """One is that of the coefficients. A sum from the largest term on, the control, has more."""
    found: list[Steps] = []
    monkeypatch.setattr(Zeros, "search", lambda self, steps: found.append(steps))
    tt.integrate("below-threshold", until="0.3", events=("theta_max",))
    (steps,) = found
    end = numpy.ones(1)
    sampled, every = steps.sampled(end), numpy.arange(len(steps))
    inside = steps.inside(every, numpy.ones(len(steps)))
    powers = numpy.vander(steps.span, steps.series.shape[2], increasing=True)
    forward = numpy.einsum("sct,st->cs", steps.series, powers)
    with mpmath.workprec(200):
        exact = [
            [mpmath.polyval(list(map(mpmath.mpf, terms[::-1])), mpmath.mpf(span)) for terms in step]
            for step, span in zip(steps.series.tolist(), steps.span.tolist(), strict=True)
        ]
        lost = [
            numpy.array((numpy.array(exact).T - values).astype(float)) / sampled.size
            for values in (inside, sampled.row[:, 0], forward)
        ]
    assert [bool((abs(x) <= (ROUNDINGS - 1) * 2.0**-53).all()) for x in lost] == [True, True, False]
