"""The Taylor steps of a run are its solution, in every arithmetic."""

from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tests.conftest import Patch
from tt_precise.integration.steps import Steps
from tt_precise.integration.zeros import Zeros
from tt_precise.runtime.values import Array
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


def steps_of(scene: str, until: str, monkeypatch: Patch) -> Steps:
    """The steps of a run in double."""
    found: list[Steps] = []
    monkeypatch.setattr(Zeros, "search", lambda self, steps: found.append(steps))
    tt.integrate(scene, until=until, events=("theta_max",))
    (steps,) = found
    return steps


def lost(steps: Steps, position: float, values: Array) -> Array:
    """The errors of components at a position in every step, in roundings."""
    with mpmath.workprec(200):
        exact = [
            [mpmath.polyval(list(map(mpmath.mpf, terms[::-1])), span) for terms in step]
            for step, span in zip(
                steps.series.tolist(), [mpmath.mpf(x) * position for x in steps.span], strict=True
            )
        ]
        apart = (numpy.array(exact).T - values).astype(float)
    return abs(apart) * 2.0**53


def test_sums_from_the_smallest_term_on_lose_less(monkeypatch: Patch) -> None:
    """A sum from the largest term on, the control, loses more than four roundings of it."""
    steps = steps_of("below-threshold", "0.3", monkeypatch)
    sampled = steps.sampled(numpy.ones(1))
    inside = steps.inside(numpy.arange(len(steps)), numpy.ones(len(steps)))
    powers = numpy.vander(steps.span, steps.series.shape[2], increasing=True)
    forward = numpy.einsum("sct,st->cs", steps.series, powers)
    found = [lost(steps, 1.0, x) for x in (inside, sampled.row[:, 0], forward)]
    assert [bool((x <= 4 * sampled.size).all()) for x in found] == [True, True, False]


@pytest.mark.parametrize(
    ("scene", "until"), [("below-threshold", "0.1"), ("regularised-1e-4", "0.01")]
)
def test_a_component_has_at_most_the_roundings_that_are_claimed(
    scene: str, until: str, monkeypatch: Patch
) -> None:
    """The control: a fifth of them is too few."""
    steps, most = steps_of(scene, until, monkeypatch), numpy.zeros(2)
    for position in (0.5, 0.9, 1.0):
        sampled = steps.sampled(numpy.array([position]))
        inside = steps.inside(numpy.arange(len(steps)), numpy.full(len(steps), position))
        for kind, values in enumerate((inside, sampled.row[:, 0])):
            found = lost(steps, position, values)
            assert (found <= sampled.lost).all()
            most[kind] = max(most[kind], (found[:, 1:] / sampled.lost[:, 1:]).max())
    assert (most > 0.2).all()


@pytest.mark.parametrize("precision", ["double", "quad"])
def test_a_function_has_the_roundings_of_its_components(precision: str, monkeypatch: Patch) -> None:
    """A thousand times as many are most of the error in the first step."""
    found: list[tuple[Zeros, Steps]] = []
    monkeypatch.setattr(Zeros, "search", lambda self, steps: found.append((self, steps)))
    run = tt.integrate("reference", precision, until="0.02", events=("zero:E_pot",))
    ((zeros, steps),) = found
    sampled = steps.sampled(numpy.array([0.0, 1.0]))
    sampled = sampled._replace(lost=1000 * sampled.lost)
    error, doubt = (x[0, 0] for x in zeros._errors(steps, sampled))
    expected = float(run.scene.body.alpha) * sampled.lost[2, 0]  # E_pot is 1 - alpha kz
    assert error * 2.0**run.precision.bits == pytest.approx(expected, rel=0.02)
    assert doubt * 2.0**53 == pytest.approx(expected, rel=0.02)
