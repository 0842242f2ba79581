"""Digits of a run in several doubles, against golden data, and what they are made of."""

from fractions import Fraction
from typing import Any

import numpy
import pytest

from benchmarks.settings_table import MeasuredSetting, integrated, right_digits
from tt_precise.integration import deviation, integrate
from tt_precise.integration.accuracy import worst_digits
from tt_precise.integration.columns import Columns
from tt_precise.integration.paired_in_doubles import PairInDoubles
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.formulations import COORDINATES
from tt_precise.scene.scene import load_scene
from tt_precise.taylor.numbers import added, multiples, number


@pytest.mark.parametrize(
    ("precision", "tolerance"),
    [("double-double", 1e-16), ("double-double", 1e-22), ("triple-double", 1e-33)],
)
def test_the_estimate_is_what_is_lost(precision: str, tolerance: float) -> None:
    scene = load_scene("reference").varied(until="0.25")
    run = integrated(scene, MeasuredSetting("newton", precision, tolerance), ())
    assert isinstance(run._pair, PairInDoubles)
    truth = integrated(scene, MeasuredSetting("newton", "triple-double", 0.0), ())
    times = scene.sample_times[1:-1]
    least = 99.0
    for t in times:
        ours, theirs = run.at(t).values, truth.at(t).values
        errors = {name: abs(ours[name] - theirs[name]) for name in ours}
        least = min(least, worst_digits(truth.at(t), errors, truth.start))
    assert run.digits_throughout == pytest.approx(least, abs=0.3)


def test_what_does_not_deviate_has_all_its_digits() -> None:
    scene = load_scene("rolling").varied(until="0.1")
    run = integrated(scene, MeasuredSetting("newton", "double-double", 1e-18), ())
    assert 14 < run.digits_throughout < 20


def test_a_run_at_its_finest_has_no_reference_beside_it() -> None:
    scene = load_scene("reference").varied(until="0.1")
    assert integrated(scene, MeasuredSetting("newton", "double-double", 0.0), ())._pair is None


@pytest.mark.parametrize("model", ["gliding", "rolling"])
@pytest.mark.parametrize("coordinates", COORDINATES)
def test_deviations_of_every_column_are_those_of_finite_differences(
    model: str, coordinates: str
) -> None:
    scene = load_scene("reference" if model == "gliding" else "rolling").varied(until="0.1")
    record = ("phi", "psi", "x", "y")
    run = integrate(scene, formulation=coordinates, record=record, events=())
    columns, row = Columns(run.setup, run.start), numpy.array(run._dense_output.propagation.state)
    apart = numpy.random.default_rng(22).uniform(-1, 1, len(row))

    def read(h: Any, fn: Any = numpy) -> Any:
        entries = tuple((row + h * apart)[:, None])
        return columns.of_arrays(columns.names, entries, float, fn)

    found, ahead, behind = read(1e-20j, deviation), read(1e-6), read(-1e-6)
    for name, one in found.items():
        slope, size = (ahead[name] - behind[name])[0] / 2e-6, 1 + abs(one.real[0])
        assert one.real[0] == pytest.approx(read(0)[name][0], rel=1e-15)
        assert one.imag[0] / 1e-20 == pytest.approx(slope, rel=1e-6, abs=1e-6 * size), name


def test_multiples_and_sums_in_parts() -> None:
    fn = precision_named("mp", 400).context
    step = fn.mpf(1) / 97
    counts = numpy.array([0, 1, 12345, 4_000_000])
    for count, row in zip(counts.tolist(), multiples(step, counts).tolist(), strict=True):
        assert abs(number(row, fn) - count * step) <= count * step * fn.mpf(2) ** -156
    terms = [numpy.array([1.0]), numpy.array([2.0**-70]), numpy.array([-1.0]), numpy.array([3e-30])]
    exact = sum(Fraction(float(term[0])) for term in terms)
    total = number(added(terms, 3)[0].tolist(), fn)
    assert total == fn.mpf(exact.numerator) / exact.denominator


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["reference", "phi-dot-195", "rolling", "beside-the-pole"])
def test_the_estimate_is_what_golden_data_say(scene: str) -> None:
    for precision, tolerance in (("double-double", 1e-20), ("triple-double", 1e-32)):
        setting = MeasuredSetting("newton", precision, tolerance)
        run = integrated(load_scene(scene), setting, ())
        assert run.digits_throughout == pytest.approx(right_digits(run), abs=0.3)
