"""The Taylor steps of a run are its solution, in every arithmetic."""

from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tt_precise.scene.scene import Scene

# Relative to the largest component: polynomials in double, and values in the run's arithmetic.
IN_DOUBLE = 2.0**-44
WIDE = {
    "double": 2.0**-46,
    "double-double": 2.0**-96,
    "triple-double": 2.0**-146,
    "quad": 2.0**-104,
}


@pytest.mark.parametrize("precision", list(WIDE))
def test_polynomials_and_values_are_the_solution(reference: Scene, precision: str) -> None:
    """Against 240 bits; the control is a time that is four eps of double later."""
    run, truth = (
        tt.integrate(reference.varied(until="0.02"), name, events=(), bits=bits)
        for name, bits in ((precision, None), ("mp", 240))
    )
    (segment,), (other,) = run.run.segments, truth.run.segments
    numbers: Any = run.precision.numbers
    steps, exact = segment.series, truth.precision.mpfr
    step, position = numpy.array([len(steps) // 2]), numpy.array([0.375])
    time = mpmath.mpf(float(steps.times(step, position)[0]))

    def apart(values: list[Any], t: Any) -> float:
        with exact.precision():
            row = other.at(exact.array([t]), exact)
            return max(abs(float(exact.number(a) - b[0])) for a, b in zip(values, row, strict=True))

    inside = steps.inside(step, position)[:, 0]
    assert apart([mpmath.mpf(x) for x in inside.tolist()], time) < IN_DOUBLE
    sampled = steps.sampled(position)[:, 0, step[0]]
    assert sampled == pytest.approx(inside, rel=1e-14, abs=1e-16)
    with run.precision.mpfr.precision():
        values = [x[0] for x in segment.at(numbers.array([time]), numbers)]
        back = [mpmath.mpf(float(x)) if precision == "double" else numbers.back(x) for x in values]
    later = time * (1 + mpmath.mpf(2) ** -32)
    assert apart(back, time) < WIDE[precision] < apart(back, later)
