"""The precision of a file's numbers is told from the values alone."""

import numpy
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check
from tt_precise.check.precision import described, precision_of, precisions, times_of

NUMBERS = numpy.random.default_rng(1).normal(size=200)


@pytest.mark.parametrize(
    ("rounded", "words", "half_unit"),
    [
        (NUMBERS.round(6), "6 decimals", 5e-7),
        (numpy.array([float(f"{x:.5e}") for x in 1e-4 * NUMBERS]), "6 significant digits", 5e-10),
        (NUMBERS.astype(numpy.float32).astype(float), "32-bit floats", 6e-8 * 3),
        (numpy.append(NUMBERS[:8].round(6), numpy.nan), "6 decimals", 5e-7),
        (NUMBERS[:7].round(6), "", 0.0),
        (NUMBERS.round(12), "", 0.0),
        (NUMBERS, "", 0.0),
        (numpy.full(200, 0.1), "", 0.0),
        (numpy.zeros(200), "", 0.0),
    ],
)
def test_a_rounding_is_recognised(rounded: numpy.ndarray, words: str, half_unit: float) -> None:
    found = precision_of(rounded)
    assert found.words == words
    assert found.half_unit == pytest.approx(half_unit, rel=0.3)


def test_components_of_a_vector_are_looked_at_together() -> None:
    """A constant component shows no digits alone."""
    given = {"kx": NUMBERS.round(4), "ky": NUMBERS[::-1].round(4), "kz": numpy.full(200, 0.25)}
    found = {name: one.half_unit for name, one in precisions(given).items()}
    assert found == dict.fromkeys(given, 5e-5)
    assert described(precisions(given)) == "kx ky kz: 4 decimals"


def test_times_that_are_even_but_for_rounding_are_made_even() -> None:
    exact = numpy.arange(300) / 240
    for given in (exact.round(6), exact.astype(numpy.float32).astype(float)):
        found = times_of(given)
        assert abs(found.t - found.t[0] - exact).max() < 1e-12
        assert "evenly spaced but for that" in found.words
    assert times_of(exact).words == ""
    # a grid of 2 decimals without one of its rows is no rounded grid of another step
    for missing in (numpy.delete(exact[:20] * 2.4, 9), numpy.delete(numpy.arange(801) / 100, 401)):
        found = times_of(missing)
        assert numpy.array_equal(found.t, missing)
        assert not found.drifts
    # nor is a row of it that is off by a unit of the last place rounded
    jumps = numpy.arange(40) / 100 + 0.001 * (numpy.arange(40) % 7 == 3)
    found = times_of(jumps.round(3))
    assert numpy.array_equal(found.t, jumps.round(3))
    assert not found.drifts
    with numpy.errstate(all="ignore"):  # as in a check, of a file that is refused
        for last in (0.0, -1e-320, numpy.inf, -numpy.inf, numpy.nan):
            assert len(times_of(numpy.append(jumps.round(3), last)).t) == 41
    uneven = numpy.cumsum(abs(NUMBERS) + 0.1).round(5)
    found = times_of(uneven)
    assert (found.words, found.rounding) == ("5 decimals", 5e-6)
    assert numpy.array_equal(found.t, uneven)


@pytest.mark.parametrize(
    ("step", "rows", "decimals", "known"),
    [
        (1 / 60, 360, 2, True),
        (0.0123, 300, 3, True),
        (0.0005, 300, 4, True),
        (1 / 59.94, 300, 4, False),  # of a video camera: 60 Hz are not seen at the ends
        (1 / 60, 12, 2, False),  # 59 and 61 Hz too
    ],
)
def test_the_rate_of_rounded_times_is_known_where_one_grid_fits(
    step: float, rows: int, decimals: int, known: bool
) -> None:
    exact = step * numpy.arange(rows)
    found = times_of(exact.round(decimals))
    if known:
        assert abs(found.t - found.t[0] - exact).max() < 1e-12
    else:
        assert numpy.array_equal(found.t, exact.round(decimals))
        assert found.rounding == pytest.approx(0.5 * 10.0**-decimals)


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(("hertz", "decimals"), [(59.94, 4), (97.3, 3)])
def test_right_rows_on_another_grid_do_not_fail_by_the_digits_of_their_times(
    hertz: float, decimals: int
) -> None:
    rows = tt.integrate("reference").frame(
        *VECTORS[1:], times=[i / hertz for i in range(int(6 * hertz))], numbers="float"
    )
    rows["t"] = rows["t"].round(decimals)
    found = check(rows, "reference")
    assert (found.verdict, found.failures) == ("incomplete", ())
    assert "equations: the file has too few digits" in found.heading
    assert check(rows, "reference", friction="other").failures == ()


@pytest.mark.usefixtures("no_cause")
def test_times_of_few_digits_may_be_exact(healthy: Healthy) -> None:
    """A grid of 2 decimals without a row, with a wrong momentum; irregular times of 4 decimals."""
    gap = healthy()[VECTORS].head(101).drop(index=50).reset_index(drop=True)
    assert check(gap, "reference")["equations"].verdict == "pass"
    wrong = gap.assign(Lz=gap["Lz"] * (1 + 1e-4 * gap["t"]))
    assert check(wrong, "reference")["equations"].verdict == "fail"
    times = numpy.unique(numpy.random.default_rng(1).uniform(0, 1, 120).round(4)).tolist()
    rows = tt.integrate("reference").frame(*VECTORS[1:], times=[0.0, *times], numbers="float")
    assert check(rows, "reference")["equations"].verdict == "pass"
