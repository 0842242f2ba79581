"""Rows as one rigid motion: its sizes, and the precision with which it is written."""

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check, pose
from tt_precise.check.columns import COLUMN_SETS
from tt_precise.check.rows import Assumptions, Rows, half_unit
from tt_precise.mechanics.flight import LiftedState

NUMBERS = numpy.random.default_rng(1).normal(size=200)


def rows_of(frame: pandas.DataFrame, columns: str = "vectors", scene: str = "reference") -> Rows:
    """Return the rows of a frame of one column set."""
    assumed = Assumptions(tt.load_scene(scene), COLUMN_SETS[columns])
    return Rows.of(assumed, {str(name): frame[name].to_numpy(float) for name in frame})


@pytest.mark.parametrize(
    ("rounded", "half"),
    [
        (NUMBERS.round(6), 5e-7),
        (numpy.append(NUMBERS.round(6), numpy.nan), 5e-7),
        (numpy.array([float(f"{x:.5e}") for x in 1e-4 * NUMBERS]), 5e-6 * 1e-4),
        (NUMBERS.astype(numpy.float32).astype(float), 6e-8 * abs(NUMBERS).max()),
        (numpy.append(NUMBERS[abs(NUMBERS) < 1].round(3), 1.0), 5e-4),  # 1 is no further digit
        (NUMBERS[:3].round(6), 0.0),
        (NUMBERS.round(12), 0.0),
        (NUMBERS, 0.0),
        (numpy.full(200, 0.1), 0.0),
        (numpy.zeros(200), 0.0),
        (1.7e9 + numpy.arange(40) / 100, 0.0),  # equal in 32 bits
    ],
)
def test_a_precision_is_inferred_from_the_numbers(rounded: numpy.ndarray, half: float) -> None:
    assert half_unit(rounded) * numpy.nanmax(abs(rounded)) == pytest.approx(half, rel=0.3)


@pytest.mark.parametrize(("digits", "expected"), [(6, 1e-3), (9, 1e-6), (17, 0.0)])
def test_one_number_says_how_precise_the_state_is(
    healthy: Healthy, digits: int, expected: float
) -> None:
    """6 decimals are 3 digits of L in kg m^2/s."""
    rounding = rows_of(healthy("reference", 101, 1)[VECTORS].round(digits)).rounding
    assert rounding == pytest.approx(expected, rel=0.02)


def test_the_precision_goes_with_converted_columns(healthy: Healthy) -> None:
    """Sums and multiples of rounded numbers have no decimals."""
    rows = rows_of(healthy("reference", 101, 1)[VECTORS].round(6))
    other = rows.changed({"Lx": (rows.columns["Lx"] + rows.columns["Ly"]) / numpy.sqrt(2)})
    scaled = other.changed({name: 1e9 * rows.columns[name] for name in ("Lx", "Ly", "Lz")})
    for changed in (other, scaled, other.part(slice(0, 9))):
        assert changed.rounding == pytest.approx(rows.rounding, rel=0.05)


def test_times_are_exact_where_they_are_even(healthy: Healthy) -> None:
    frame = healthy("reference", 101, 1)[VECTORS]
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


def test_every_column_set_is_the_same_motion(healthy: Healthy) -> None:
    frame = healthy("reference", 101, 0.5)
    vectors, euler = rows_of(frame[VECTORS]), rows_of(frame, "Euler")
    body = rows_of(pose(frame["t"].tolist()), "rigid body")
    for name in ("k", "L", "v"):
        expected = getattr(vectors.motion, name)
        assert getattr(body.motion, name) == pytest.approx(expected, rel=1e-11, abs=1e-13)
        # without phi the direction of the axis is open
        assert getattr(euler.motion, name)[2] == pytest.approx(expected[2], rel=1e-11, abs=1e-12)
    assert vectors.motion.q is vectors.motion.x is None
    assert vectors.state.vx is frame["vx"].to_numpy() or (vectors.state.vx == frame["vx"]).all()
    assert abs(vectors.contact_velocity[2]).max() < 1e-14
    assert abs(body.height).max() < 1e-14
    assert rows_of(frame[VECTORS[:-2]]).motion.v is None


def test_a_height_is_part_of_the_state() -> None:
    frame = tt.integrate("flight").frame(*VECTORS[1:], "height", "rise", numbers="float")
    rows = rows_of(frame, scene="flight")
    assert rows.has_height
    assert isinstance(rows.state, LiftedState)
    assert (rows.state.height == frame["height"]).all()
    assert rows.state.rise == pytest.approx(frame["rise"].to_numpy(), abs=1e-14)
    assert rows.height == pytest.approx(frame["height"].to_numpy(), abs=1e-14)
    body = rows_of(pose(frame["t"].tolist(), "flight"), "rigid body", "flight")
    for name, expected in zip(body.state._fields, rows.state, strict=True):
        assert getattr(body.state, name) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert not rows_of(frame[VECTORS], scene="flight").has_height


def test_a_rounded_file_of_another_world_is_a_rounded_file(healthy: Healthy) -> None:
    frame = pose(healthy("reference", 101, 0.1)["t"].tolist()).drop(columns=["x", "y", "z"])
    theirs = frame.rename(columns={"wy": "wz", "wz": "wy", "vcy": "vcz", "vcz": "vcy"})
    half = numpy.sqrt(0.5)
    w, x, y, z = (frame[name] for name in ("qw", "qx", "qy", "qz"))
    theirs[["wz", "vcz"]] *= -1
    theirs[["qw", "qx", "qy", "qz"]] = half * numpy.array([w + x, x - w, y + z, z - y]).T
    found = check(theirs.round(6), "reference", world="y-up")
    assert found.passed, str(found)
    assert found.written == "some 6 digits"
