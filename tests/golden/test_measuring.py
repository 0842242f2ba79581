"""Rows against the true ones, at golden times and between: errors count by the entry's size."""

import random
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import cycle
from typing import Any

import numpy
import pytest

from tests.conftest import Patch
from tt_precise.check.golden import DigitsOverTime
from tt_precise.golden import measuring
from tt_precise.golden.digits import EXACT
from tt_precise.golden.measuring import EPS, Carried, Carrier, FewestDigits, Measured, TrueRows
from tt_precise.golden.store import read
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState
from tt_precise.scene.scene import Scene

ROWS = numpy.array([40, 100, 250])
ERROR = 1e-6
VECTORS = NewtonState._fields


def golden_rows(scene: str) -> tuple[Scene, list[numpy.ndarray]]:
    """The scene and the vectors of its golden rows."""
    stored = read(scene)
    names = [name for name in VECTORS if name in stored.trajectory.columns]
    return stored.scene, [numpy.array(stored.trajectory.floats(name)) for name in names]


@pytest.mark.parametrize("delay", [0.0, 0.003])
@pytest.mark.parametrize("name", ["kz", "Lz", "Lx", "vy"])
def test_a_relative_error_is_found_as_it_was_made(delay: float, name: str) -> None:
    stored = read("reference")
    true = TrueRows(stored.scene, stored.trajectory)
    _, columns = golden_rows("reference")
    delays = numpy.full(len(ROWS), delay)
    carried = Carrier(stored.scene, columns).carry(ROWS, delays, 0 * delays).values
    values: dict[str, Any] = {one: carried[one].copy() for one in VECTORS}
    rows = dict(zip(VECTORS, (column[ROWS] for column in columns), strict=True))
    values[name] += ERROR * sizes(stored.scene.body.numbers(float), rows, numpy)[name]
    found = true.measure(
        true.times[ROWS] + delay,
        values,
        lambda row, names: [repr(float(values[one][row])) for one in names],
    )
    assert found.compared.all()
    assert not found.start.any()
    # between golden times the size is that of the nearest golden row
    assert found.errors[name] == pytest.approx([ERROR] * len(ROWS), rel=1e-3)
    assert (found.worst() == found.errors[name]).all()
    for other in set(values) - {name}:
        assert (found.errors[other] <= numpy.fmax(found.bounds[other], 1e-15)).all()
    assert ((found.bounds[name] == 0) == (delay == 0)).all()


@pytest.mark.parametrize(("wrong", "digits"), [("0", 33), ("1e-25", 24)])
def test_whole_turns_of_an_angle_cost_no_digit(wrong: str, digits: int) -> None:
    stored = read("track")
    true = TrueRows(stored.scene, stored.trajectory)
    turns = EXACT.multiply(measuring.TURN, 3)
    cells = [
        str(EXACT.add(EXACT.subtract(Decimal(cell), turns), Decimal(wrong)))
        for cell in stored.trajectory.column("phi")
    ]
    values = {"phi": numpy.array(cells, float)}
    measured = true.measure(true.times, values, lambda row, names: [cells[row]])
    assert digits <= measured.digits()["phi"].min() < digits + 2


def spoiled(cell: str, error: float, digits: int) -> str:
    """A printed number with a relative error, written with so many digits."""
    factor = EXACT.add(1, Decimal(f"{error:.20e}"))
    return f"{EXACT.multiply(Decimal(cell), factor):.{digits - 1}e}" if cell else ""


def found_of(true: TrueRows, cells: dict[str, list[str]], **how: bool) -> tuple[int, object]:
    """At how many entries decimals were looked at, and what the checks make of the errors."""
    looked = 0

    def exactly(row: int, names: Sequence[str]) -> list[str]:
        nonlocal looked
        looked += len(names)
        return [cells[name][row] for name in names]

    values = {n: numpy.array([float(one or "nan") for one in c]) for n, c in cells.items()}
    over_time = DigitsOverTime()
    found = true.measure(true.times, values, exactly, **how)
    fewest = taken(found)
    over_time.add(found)
    return looked, (fewest.digits, fewest.at, fewest.rows, fewest.exactly, str(over_time))


@pytest.mark.parametrize("scene", ["reference", "upright", "contact-lost", "flight"])
def test_sparing_decimals_changes_no_figure(scene: str, monkeypatch: Patch) -> None:
    stored = read(scene)
    true = TrueRows(stored.scene, stored.trajectory)
    seed = random.Random(scene)
    spared = differing = 0
    errors = (0, 1e-33, 1e-17, 3e-16, 1e-15, 1e-14, 1e-13, 3e-13, 1e-11)
    for largest, digits in zip(errors, cycle((16, 34, 17, 18, 17)), strict=False):
        cells = {
            name: [
                spoiled(cell, seed.uniform(-1, 1) * largest, digits)
                for cell in stored.trajectory.column(name)
            ]
            for name in true.names
        }
        every, expected = found_of(true, cells)
        some, figures = found_of(true, cells, largest_only=True)
        assert figures == expected, (largest, digits)
        spared += every - some
        with monkeypatch.context() as without:  # the control: doubles alone
            without.setattr(measuring, "FIGURES", -1.0)
            differing += found_of(true, cells, largest_only=True)[1] != expected
    assert spared > 0
    assert differing > 0


NAN = numpy.nan


def measured(t: list[float], **columns: list[tuple[float, float]]) -> Measured:
    """Columns as (error, bound) for each row; what is NaN in all of them was not compared."""
    errors = {name: numpy.array([e for e, _ in rows]) for name, rows in columns.items()}
    bounds = {name: numpy.array([b for _, b in rows]) for name, rows in columns.items()}
    compared = ~numpy.all([numpy.isnan(one) for one in errors.values()], axis=0)
    times = numpy.array(t)
    return Measured(times, errors, bounds, compared, times == 0)


def taken(*blocks: Measured) -> FewestDigits:
    found = FewestDigits()
    for block in blocks:
        found.add(block)
    return found


START = (0.0, 0.0)


@pytest.mark.parametrize("cut", range(6))
def test_the_largest_error_that_is_not_within_its_bound_counts(cut: int) -> None:
    t = [0.0, 1.0, 2.0, 3.0, 4.0]
    rows = [START, (1e-3, 0.0), (NAN, NAN), (1e-5, 1e-4), (1e-7, 0.0)]
    other = [START, (1e-6, 0.0), (NAN, NAN), (1e-9, 1e-4), (1e-8, 0.0)]
    found = taken(
        measured(t[:cut], kx=rows[:cut], ky=other[:cut]),
        measured(t[cut:], kx=rows[cut:], ky=other[cut:]),
    )
    assert found.digits == {"kx": pytest.approx(3), "ky": pytest.approx(6)}
    assert found.worst == pytest.approx(3)
    assert found.at == 1.0
    assert (found.rows, found.exactly) == (4, 2)


def test_where_most_rows_lie_between_there_are_at_least_so_many() -> None:
    """What the comparison itself cannot resolve limits what it can vouch for."""
    between = [(1e-9, 1e-5)] * 3
    few = measured([0.0, 1.0, 1.5, 1.6], kx=[START, (1e-7, 0.0), *between[:2]])
    assert (few.compared.sum(), taken(few).exactly) == (4, 1)
    assert taken(few).digits == {"kx": pytest.approx(5)}  # 4 rows, of which 2 at golden times
    exact = measured([0.0, 1.0, 2.0], kx=[START, (1e-7, 0.0), (1e-8, 0.0)])
    one = measured([2.5], kx=between[:1])
    assert taken(exact, one).digits == {"kx": pytest.approx(7)}  # most are: the bound is no matter
    assert taken(exact, one, measured([2.6, 2.7, 2.8], kx=between)).digits["kx"] == pytest.approx(5)


def test_what_counts_and_as_what() -> None:
    none, coarse, fine = (NAN, NAN), (1e-3, 0.0), (1e-7, 0.0)
    # a row is exact if any of its columns is
    found = taken(measured([1.0, 2.0], kx=[fine, none], ky=[none, fine]))
    assert (found.rows, found.exactly) == (2, 2)
    # the start is a row and no evidence
    found = taken(measured([0.0], kx=[START]))
    assert (found.rows, found.exactly, found.at) == (1, 0, 0.0)
    assert found.digits == {"kx": 34}
    # of equal errors the first is named
    assert taken(measured([1.0, 2.0], kx=[coarse] * 2), measured([3.0], kx=[coarse])).at == 1.0
    # a column without a number has no digits
    assert list(taken(measured([1.0], kx=[coarse], phi_dot=[none])).digits) == ["kx"]
    assert taken(measured([1.0], kx=[none])).at is None


CARRIED = numpy.array([1, 100, 314, 318, 330, 500, 799])  # 314 to 330: about the climb's beginning


def carried(scene: str, by: float) -> Carried:
    return carry(*golden_rows(scene), by)


def carry(scene: Scene, vectors: list[numpy.ndarray], by: float) -> Carried:
    delays = numpy.full(len(CARRIED), by)
    return Carrier(scene, vectors).carry(CARRIED, delays, EPS * abs(delays))


@pytest.mark.parametrize(("scene", "columns"), [("reference", 14), ("rolling", 12)])
@pytest.mark.parametrize("way", [1, -1])
def test_a_row_carried_to_the_next_is_the_next_within_its_bound(
    scene: str, columns: int, way: int
) -> None:
    found, table = carried(scene, way * 0.01), read(scene).trajectory
    assert read(scene).scene.sample_every == Fraction(1, 100)
    assert len(found.values) == columns
    for name in found.values:
        true = numpy.array(table.floats(name))
        error = abs(found.values[name] - true[CARRIED + way])
        assert (error <= found.bounds[name]).all(), name
        # it resolves something
        assert numpy.median(found.bounds[name]) <= 1e-9 * abs(true).max(), name


def test_the_bounds_have_the_units_of_what_they_bound() -> None:
    """In units of 4 kg, 4 m and 2 s everything is the same, to the bit: they are powers of two."""
    scene, vectors = golden_rows("reference")
    body = scene.body
    larger = replace(
        body, m=4 * body.m, R=4 * body.R, I1=64 * body.I1, I3=64 * body.I3, mu=body.mu / 2
    )
    factors = dict(zip(VECTORS, [1.0] * 3 + [32.0] * 3 + [2.0] * 2, strict=True))
    enlarged = [x * factor for x, factor in zip(vectors, factors.values(), strict=True)]
    for by in (1e-4, 0.005, 0.01):
        one = carry(scene, vectors, by)
        other = carry(replace(scene, body=larger), enlarged, 2 * by)
        for name, factor in factors.items():
            assert (other.values[name] == factor * one.values[name]).all(), name
            assert (other.bounds[name] == factor * one.bounds[name]).all(), (name, by)


@pytest.mark.parametrize("scene", ["reference", "coulomb-stick-slip"])
@pytest.mark.parametrize("by", [1e-4, 0.005])
def test_a_quarter_turn_turns_what_is_carried(scene: str, by: float) -> None:
    """The bounds too, which end where a gliding may come to rest."""
    known, (kx, ky, kz, Lx, Ly, Lz, vx, vy) = golden_rows(scene)
    rows, delays = numpy.arange(len(kx)), numpy.full(len(kx), by)
    first, turned = (
        Carrier(known, vectors).carry(rows, delays, EPS * delays)
        for vectors in ([kx, ky, kz, Lx, Ly, Lz, vx, vy], [-ky, kx, kz, -Ly, Lx, Lz, -vy, vx])
    )
    for x, y in (("kx", "ky"), ("Lx", "Ly"), ("vx", "vy")):
        for here, there in ((x, y), (y, x)):
            # at rest, where Coulomb's law has no direction, they are no numbers
            expected = [
                pytest.approx(abs(x[here]), rel=1e-9, abs=1e-15, nan_ok=True)
                for x in (first.bounds, first.values)
            ]
            assert [abs(x[there]) for x in (turned.bounds, turned.values)] == expected


def test_the_remedy_for_rows_beyond_an_early_end_is_a_time_before_it() -> None:
    assert "--until 1.33," in measuring.ending("contact_lost", 1.33692)
    assert measuring.ending("landed", 0.0099999).endswith("--until 0.00999")
    assert measuring.ending("landed", 0.0).endswith("--until 0")


def test_far_away_and_from_nowhere_nothing_is_claimed() -> None:
    assert not numpy.isfinite(carried("reference", 0.5).bounds["kx"]).any()
    scene, vectors = golden_rows("reference")
    vectors[3][CARRIED[2]] = numpy.nan
    found = carry(scene, vectors, 0.001).values["kx"]
    assert numpy.isnan(found[2])
    assert numpy.isfinite(numpy.delete(found, 2)).all()


def test_each_row_is_carried_by_its_own_delay() -> None:
    scene, vectors = golden_rows("reference")
    rows, delays = numpy.array([5, 5, 5, 9]), numpy.array([-1e-3, 0.0, 2e-3, 1e-3])
    carrier = Carrier(scene, vectors)
    together = carrier.carry(rows, delays, numpy.zeros(4))
    for i in range(4):
        alone = carrier.carry(rows[i : i + 1], delays[i : i + 1], numpy.zeros(1))
        for name in VECTORS:
            assert alone.values[name][0] == pytest.approx(together.values[name][i], rel=4 * EPS)
    assert together.values["kx"][1] == vectors[0][5]
    late = carrier.carry(rows, delays, numpy.full(4, 1e-6))
    assert (late.bounds["kx"] > 1e3 * together.bounds["kx"]).all()  # a time known to 1 us


def test_beside_a_pole_the_tilt_keeps_its_digits() -> None:
    """There k_xy and L_xy are 1e-9 of the vertical entries, and are resolved by their own size."""
    found = carried("beside-the-pole", 0.002)
    for x, y in (("kx", "ky"), ("Lx", "Ly")):
        size = numpy.hypot(found.values[x], found.values[y])[:2]
        assert (size < 1e-7 * abs(found.values[f"{x[0]}z"][:2])).all()
        assert (found.bounds[x][:2] < 1e-9 * size).all()
