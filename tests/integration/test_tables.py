"""Reading a run in double: arrays against the same numbers, row by row, in mpmath."""

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy
import pytest

from tt_precise.integration import Trajectory, integrate, reading
from tt_precise.integration.dense_output import Times, long_double
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import load_scene

EPS = 2.0**-52
EVENTS = ("theta_min", "phi_dot_zero", "equator")


@pytest.fixture(scope="module", params=["reference", "rolling", "contact-lost"])
def runs(request: pytest.FixtureRequest) -> Iterator[tuple[Trajectory, Trajectory]]:
    """The same run twice; the second is read row by row in mpmath."""
    scene = load_scene(request.param)
    scene = replace(scene, until=min(scene.until, Fraction(1)))
    names = [name for name in EVENTS if scene.model == "gliding" or name != "phi_dot_zero"]
    runs = tuple(integrate(scene, events=names, record=("phi", "x")) for _ in range(2))
    with pytest.MonkeyPatch.context() as patch:
        slow = reading.has_long_double
        patch.setattr(reading, "has_long_double", lambda: False)
        by_row = runs[1]
        by_row.frame_by_row = by_row.frame(*QUANTITIES, "kx", "vx", "phi", "x", numbers="text")  # type: ignore[attr-defined]
        by_row.drift, by_row.events  # noqa: B018 - cached while arrays are out of reach
        patch.setattr(reading, "has_long_double", slow)
        yield runs[0], by_row


def test_text_is_the_nearest_double_to_what_mpmath_reads(
    runs: tuple[Trajectory, Trajectory],
) -> None:
    arrays, by_row = runs
    found = arrays.frame(*QUANTITIES, "kx", "vx", "phi", "x", numbers="text")
    for name, column in by_row.frame_by_row.items():  # type: ignore[attr-defined]
        largest = max(abs(mpmath.mpf(text)) for text in column if text is not None)
        for got, expected in zip(found[name], column, strict=True):
            assert (got is None) == (expected is None), name
            if got is not None:
                # time is known to 64 bits there, and fast entries move by some eps in that
                assert abs(mpmath.mpf(got) - mpmath.mpf(expected)) <= 4 * EPS * largest, name
                assert repr(float(got)) == got


def test_drift_in_long_double_is_that_of_mpmath(runs: tuple[Trajectory, Trajectory]) -> None:
    arrays, by_row = runs
    assert arrays.drift.keys() == by_row.drift.keys() >= {"jellett", "axis_norm"}
    for name, expected in by_row.drift.items():
        # what a row's time lacks beyond 64 bits, and the arithmetic's own 2^-64, are far below eps
        assert abs(arrays.drift[name] - expected) < EPS / 20, name


def test_events_are_those_of_mpmath(runs: tuple[Trajectory, Trajectory]) -> None:
    arrays, by_row = runs
    assert list(arrays.events.columns) == list(by_row.events.columns)
    assert list(arrays.events["name"]) == list(by_row.events["name"])
    for name in by_row.events.columns[1:]:
        found, expected = (run.events[name].to_numpy(float) for run in runs)
        # at a turning point theta_dot is zero but for rounding, beside the other rates
        kind = ("theta_dot", "phi_dot", "omega_3")
        compared = by_row.events[list(kind)] if name in kind else expected
        scale = numpy.abs(numpy.asarray(compared, dtype=float)).max(initial=0)
        numpy.testing.assert_allclose(found, expected, rtol=0, atol=2 * EPS * scale)


def test_a_table_is_a_frame_without_pandas(double: Trajectory) -> None:
    table, frame = double.table("theta", "E"), double.frame("theta", "E")
    assert list(table) == list(frame.columns) == ["t", "theta", "E"]
    for name in table:
        assert numpy.array_equal(table[name], frame[name].to_numpy())
    with pytest.raises(InputError, match="numbers: got 'exact', expected one of: native"):
        double.table("theta", numbers="exact")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "seconds",
    [
        [Fraction(k, 100) for k in range(801)],
        [Fraction(1, 3), Fraction("0.1") + Fraction(1, 10**30)],
    ],
)
def test_times_lose_nothing_to_rounding(seconds: list[Fraction]) -> None:
    context = mpmath.mp.clone()
    context.prec = 200
    unit = context.sqrt(context.mpf("0.02") / context.mpf("9.82"))
    times = Times.of(seconds, unit)
    assert times.seconds.tolist() == [float(t) for t in seconds]
    for exact, rounded, delay in zip(seconds, times.rounded, times.delay, strict=True):
        inner = context.mpf(exact.numerator) / exact.denominator / unit
        # three roundings to 64 bits
        assert abs(inner - rounded - delay) <= 3 * 2.0**-64 * inner
        assert rounded == float(inner)


def test_a_long_double_holds_64_bits() -> None:
    with mpmath.workprec(100):
        third = long_double(mpmath.mpf(1) / 3)
    assert third == numpy.longdouble(1) / 3
    assert third != numpy.longdouble(1 / 3)
