"""Rows as one rigid motion: its sizes, and the precision with which it is written."""

import numpy
import pytest

from tests.check.conftest import EULER, POSE, VECTORS, rows_of, solved, vectors
from tt_precise.check.rows import half_unit
from tt_precise.mechanics.flight import LiftedState

NUMBERS = numpy.random.default_rng(1).normal(size=200)


@pytest.mark.parametrize(
    ("rounded", "half"),
    [
        (NUMBERS.round(6), 5e-7),
        (numpy.append(NUMBERS.round(6), numpy.nan), 5e-7),
        (numpy.array([float(f"{x:.5e}") for x in 1e-4 * NUMBERS]), 5e-6 * 1e-4),
        (NUMBERS.astype(numpy.float32).astype(float), 6e-8 * abs(NUMBERS).max()),
        (numpy.append(NUMBERS[abs(NUMBERS) < 1].round(3), 1.0), 5e-4),  # 1 is no further digit
        (NUMBERS[:4].round(6), 5e-7),
        (NUMBERS[:3].round(6), 0.0),
        (NUMBERS, 0.0),
        (numpy.full(200, 0.1), 0.0),
        (1.7e9 + numpy.arange(40) / 100, 0.0),  # equal in 32 bits
    ],
)
def test_a_precision_is_inferred_from_the_numbers(rounded: numpy.ndarray, half: float) -> None:
    assert half_unit(rounded) * numpy.nanmax(abs(rounded)) == pytest.approx(half, rel=0.3)


@pytest.mark.parametrize(("digits", "rounding"), [(6, 1e-3), (9, 1e-6), (17, 0.0)])
def test_one_number_says_how_precise_the_state_is(digits: int, rounding: float) -> None:
    """6 decimals are 3 digits of L in kg m^2/s; conversions and parts keep them."""
    rows = rows_of(vectors(101).round(digits))
    mixed = rows.changed({"Lx": (rows.columns["Lx"] + rows.columns["Ly"]) / numpy.sqrt(2)})
    scaled = rows.changed({name: 1e9 * rows.columns[name] for name in ("Lx", "Ly", "Lz")})
    for each in (rows, mixed, scaled, rows.part(slice(0, 9))):
        assert each.rounding == pytest.approx(rounding, rel=0.05)


def test_times_are_exact_where_they_are_even() -> None:
    frame = vectors(101)
    turn = rows_of(frame).spin_rate
    assert turn == pytest.approx(155, rel=1e-3)
    assert rows_of(frame).time_rounding < 1e-12  # 2 decimals, and even
    assert rows_of(frame.drop(index=9)).time_rounding < 1e-12  # but for a missing row
    for step, decimals in ((1 / 60, 2), (1 / 59.94, 4)):
        uneven = frame.assign(t=(frame.index.to_numpy() * step).round(decimals))
        expected = 0.5 * 10**-decimals * turn
        assert rows_of(uneven).time_rounding == pytest.approx(expected, rel=0.01)
    epoch = frame.assign(t=1.7e9 + frame["t"])
    assert rows_of(epoch).time_rounding == pytest.approx(1.7e9 * 2**-51 * turn, rel=0.01)


def test_every_column_set_is_the_same_motion() -> None:
    by_vectors, by_euler, body = (rows_of(solved(n, 101, 200)) for n in (VECTORS, EULER, POSE))
    for name in ("k", "L", "v"):
        expected = getattr(by_vectors.motion, name)
        assert getattr(body.motion, name) == pytest.approx(expected, rel=1e-11, abs=1e-13)
        # without phi the direction of the axis is open
        assert getattr(by_euler.motion, name)[2] == pytest.approx(expected[2], rel=1e-11, abs=1e-12)
    assert by_vectors.motion.q is by_vectors.motion.x is None
    assert abs(by_vectors.contact_velocity[2]).max() < 1e-14
    assert abs(body.height).max() < 1e-14
    assert rows_of(vectors(9)[VECTORS[:-2]]).motion.v is None


def test_a_height_is_part_of_the_state() -> None:
    names = [*VECTORS, "height", "rise"]
    frame, body = (solved(each, 16, 250, "flight") for each in (names, POSE))
    expected = LiftedState(*(frame[name].to_numpy() for name in names[1:]))
    for table in (frame, body):
        rows = rows_of(table, "flight")
        assert rows.has_height
        for component, true in zip(rows.state, expected, strict=True):
            assert component == pytest.approx(true, rel=1e-9, abs=1e-12)
    assert not rows_of(frame[VECTORS], "flight").has_height
