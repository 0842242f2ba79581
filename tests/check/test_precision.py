"""The precision of a file's numbers is told from the values alone."""

import numpy
import pytest

from tt_precise.check.precision import described, precision_of, precisions, times_of

NUMBERS = numpy.random.default_rng(1).normal(size=200)


@pytest.mark.parametrize(
    ("rounded", "words", "half_unit"),
    [
        (NUMBERS.round(6), "6 decimals", 5e-7),
        (numpy.array([float(f"{x:.5e}") for x in 1e-4 * NUMBERS]), "6 significant digits", 5e-10),
        (NUMBERS.astype(numpy.float32).astype(float), "32-bit floats", 6e-8 * 3),
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
    uneven = numpy.cumsum(abs(NUMBERS) + 0.1).round(5)
    found = times_of(uneven)
    assert (found.words, found.rounding) == ("5 decimals", 5e-6)
    assert numpy.array_equal(found.t, uneven)
