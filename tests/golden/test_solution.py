"""The distance of rows from the true solution: errors count by the size of their column.

A trajectory is as far from golden data as it was put there.
"""

import math
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.golden.conftest import Small
from tt_precise.golden import solution
from tt_precise.golden.solution import ComparedRows, TrueSolution, relative_errors
from tt_precise.golden.store import Stored, read_files
from tt_precise.golden.table import EXACTLY
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

VECTORS = NewtonState._fields
ERROR = 1e-6


def rows_of(stored: Stored, indices: list[int]) -> ComparedRows:
    """Golden rows in double, as a simulator writes them."""
    table = stored.trajectory
    values = {name: numpy.array(table.floats(name))[indices] for name in VECTORS}
    times = [table.column("t")[index] for index in indices]
    return ComparedRows(
        numpy.array(list(map(float, times))),
        values,
        lambda row, names: [repr(float(values[name][row])) for name in names],
        lambda row: Fraction(times[row]),
    )


@pytest.mark.parametrize("name", ["kz", "Lz", "Lx", "vy"])
def test_a_relative_error_is_found_as_it_was_made(name: str) -> None:
    stored = read_files("reference")
    rows = rows_of(stored, [40, 100, 250])
    units = sizes(stored.scene.body.numbers(float), {**rows.values}, numpy)
    rows.values[name][:] += ERROR * units[name]
    distance = TrueSolution(stored.scene).distance(rows)
    assert (distance.how, distance.ended, distance.last) == ("at golden times", "", 8)
    assert distance.compared.all()
    assert distance.errors[name] == pytest.approx([ERROR] * 3, rel=1e-3)
    assert (distance.worst() == distance.errors[name]).all()
    others = {*VECTORS} - {name}
    assert all((distance.errors[other] < 1e-15).all() for other in others)


def test_rows_at_other_times_are_compared_with_an_integration() -> None:
    scene = load_scene("reference").varied(until="0.2")
    times = numpy.array([0.0, 0.0123, 0.1])
    run = tt.integrate(scene, "quad")
    values = run.table(*VECTORS, times=times)
    true = TrueSolution(scene)
    distance = true.distance(ComparedRows(times, values), digits=10)
    assert distance.how.startswith("integrated in ")
    assert distance.compared.all()
    assert 10 <= min(distance.fewest().values()) < 20
    off = {**values, "Lz": values["Lz"] * (1 + 1e-9)}
    assert true.distance(ComparedRows(times, off), digits=10).fewest()["Lz"] < 9.1
    exactly: Any = run.table(*VECTORS, times=[Fraction(0), Fraction("0.0123")], numbers="text")
    rows = ComparedRows(
        times[:2],
        {name: column[:2] for name, column in values.items()},
        lambda row, names: [exactly[name][row] for name in names],
        lambda row: Fraction(0) if row == 0 else Fraction("0.0123"),
    )
    assert min(true.distance(rows, digits=20).fewest().values()) > 20
    beyond = ComparedRows(times + 1, values)
    with pytest.raises(InputError, match="expected at most 2 s, 10 times"):
        true.distance(ComparedRows(times + 3, values))
    assert true.distance(beyond).compared.all()


@pytest.mark.parametrize(("wrong", "digits"), [("0", 33), ("1e-25", 24)])
def test_whole_turns_of_an_angle_cost_no_digit(wrong: str, digits: int) -> None:
    stored = read_files("track")
    turns = EXACTLY.multiply(solution.REVOLUTION, 3)
    cells = [
        str(EXACTLY.add(EXACTLY.subtract(Decimal(cell), turns), Decimal(wrong)))
        for cell in stored.trajectory.column("phi")
    ]
    t = numpy.array(stored.trajectory.floats("t"))
    rows = ComparedRows(t, {"phi": numpy.array(cells, float)}, lambda row, names: [cells[row]])
    fewest = TrueSolution(stored.scene).distance(rows).fewest()["phi"]
    assert digits <= fewest < digits + 2


def at_the_end(delay: float, error: float, before: int = 3) -> ComparedRows:
    """The last rows of contact-lost; its end is late by ``delay`` and off by ``error``."""
    stored = read_files("contact-lost")
    count = len(stored.trajectory.rows)
    rows = rows_of(stored, list(range(count - before, count)))
    rows.t[-1] *= 1 + delay
    rows.values["Lz"][-1] *= 1 + error
    return rows


@pytest.mark.parametrize(
    ("digits", "delay", "error", "compared"),
    [
        (None, 1e-8, 1e-8, True),
        (None, 1e-6, 1e-8, False),
        (None, 1e-8, 1e-6, False),
        (8, 2e-9, 2e-9, True),
        (8, 2e-8, 0.0, False),  # a fixed tolerance of 1e-7 would compare this row
        (8, 2e-9, 2e-8, False),
        (12, 2e-9, 0.0, False),
        (8, 0.0, 1e-3, True),  # at the very time of the end every error counts
    ],
)
def test_the_tolerance_of_an_early_end_follows_the_digits(
    digits: int | None, delay: float, error: float, compared: bool
) -> None:
    rows, scene = at_the_end(delay, error), load_scene("contact-lost")
    distance = TrueSolution(scene).distance(rows, digits)
    assert distance.compared.tolist() == [True, True, compared]
    assert bool(numpy.isnan(distance.errors["Lz"][-1])) is not compared
    assert bool(distance.ended) is (delay > 0 and not compared)
    # and the same of an integration, where rows lie between golden rows
    rows.t[0] -= 1e-3
    distance = TrueSolution(scene).distance(rows, digits)
    assert distance.how.startswith("integrated")
    assert distance.compared.tolist() == [True, True, compared]


def test_golden_data_of_another_start_are_not_used() -> None:
    scene = load_scene("reference").varied(omega_3="154", until="0.05")
    assert TrueSolution(scene).golden is None
    TrueSolution(scene).require_golden()
    with pytest.raises(InputError, match=r"no golden data of a scene reference in .* this body"):
        TrueSolution(scene, solution.locate("reference").parent).require_golden()


def test_vectors_are_golden_integrated_or_none() -> None:
    true = TrueSolution(load_scene("contact-lost"))
    table = read_files("contact-lost").trajectory
    t = numpy.array(table.floats("t"))[[5, 2]]
    vectors: Any = true.vectors(t)
    assert vectors[5].tolist() == [table.floats("Lz")[5], table.floats("Lz")[2]]
    between: Any = true.vectors(numpy.array([0.5003]))
    assert 0 < abs(between[5][0] / table.floats("Lz")[50] - 1) < 1e-2
    assert true.vectors(numpy.array([2.0])) is None


def test_missing_numbers_are_infinitely_wrong_and_undefined_ones_are_not_compared() -> None:
    stored = read_files("reference")
    true = {name: list(stored.trajectory.column(name)[1:4]) for name in (*VECTORS, "theta_dot")}
    true["theta_dot"][1] = ""
    given = {"theta_dot": numpy.array([math.nan, 1.0, 2.0]), "kx": numpy.array([0.1] * 3)}
    errors = relative_errors(stored.scene, true, given)
    assert errors["theta_dot"][0] == math.inf
    assert math.isnan(errors["theta_dot"][1])
    assert 0 < errors["theta_dot"][2] < math.inf


def loaded(small: Small) -> pandas.DataFrame:
    return pandas.DataFrame(tt.golden.load("reference", folder=small.folder))


def compared(small: Small, frame: pandas.DataFrame) -> tt.golden.Comparison:
    return tt.golden.compare(frame, "reference", folder=small.folder)


def with_entry(frame: pandas.DataFrame, row: int, name: str, value: object) -> pandas.DataFrame:
    column = frame[name].to_list()
    column[row] = value
    return frame.assign(**{name: pandas.Series(column, dtype=object)})


@pytest.mark.parametrize("kind", ["text", "float", "exact"])
def test_rounded_numbers_agree_as_far_as_they_hold(small: Small, kind: Any) -> None:
    comparison = compared(small, tt.golden.load("reference", kind, folder=small.folder))
    # half an ulp of double is 1.1e-16 of its number
    least, most = (34, 34) if kind in ("exact", "text") else (15.9, 17.5)
    assert least <= comparison.worst <= most
    assert (len(comparison.over_time), comparison.unmatched) == (7, 0)


def test_an_error_shows_in_its_column_at_its_time(small: Small) -> None:
    frame = loaded(small)
    frame = with_entry(frame, 3, "omega_3", frame["omega_3"].to_list()[3] * (1 + 1e-7))
    comparison = compared(small, frame)
    assert comparison.digits["omega_3"] == pytest.approx(7, abs=1e-3)
    assert comparison.digits.drop("omega_3").min() > 15
    assert comparison.over_time["t"].to_list()[comparison.over_time["omega_3"].argmin()] == 0.03


@pytest.mark.parametrize(
    ("row", "name", "value", "digits"),
    [
        # exactly 0 is right, omega_3 = 155 rad/s
        (0, "theta_dot", 155e-9, 9),
        *((2, "theta", missing, 0) for missing in (math.nan, math.inf, None, "")),
    ],
)
def test_near_a_zero_the_angular_velocity_decides_and_what_is_missing_has_no_digits(
    small: Small, row: int, name: str, value: object, digits: int
) -> None:
    comparison = compared(small, with_entry(loaded(small), row, name, value)).digits[name]
    assert comparison == pytest.approx(digits, abs=1e-2 if digits else 0)


def test_a_trajectory_or_a_mapping_is_compared_as_its_table() -> None:
    run = tt.integrate("reference", "quad", until="0.05")
    assert tt.golden.compare(run, "reference").worst > 25
    columns = {"t": [0.0, 0.01], "omega_3": run.frame("omega_3")["omega_3"].to_list()[:2]}
    assert list(tt.golden.compare(columns, "reference").digits.index) == ["omega_3"]
    with pytest.raises(InputError, match="columns: got 0, expected t and any of: "):
        tt.golden.compare([1.0], "reference")


def test_rows_between_golden_times_are_compared_with_an_integration(small: Small) -> None:
    times = [0.0, 0.004, 0.0161, 0.05 + 1e-12, 0.07]
    frame = tt.integrate(small.scene, "quad").frame(times=times[:4], numbers="exact")
    beyond = frame.iloc[[3]].assign(t=times[4])
    comparison = compared(small, pandas.concat([frame, beyond]))
    assert (comparison.unmatched, len(comparison.over_time)) == (1, 4)
    assert comparison.worst > 8
    late = frame.assign(t=[0.0, 0.004, 0.0161 + 1e-6, 0.05])
    assert compared(small, late).worst < 7


@pytest.mark.parametrize(
    ("frame", "words"),
    [
        ({"time": [0.0], "theta": [0.1]}, "expected t and any of: kx, ky"),
        ({"t": [0.1], "theta": [0.1]}, "expected times between 0 and 0.06 s"),
        ({"t": [0.0], "theta": ["one"]}, "got 'one', expected a number"),
    ],
)
def test_what_cannot_be_compared_is_refused(
    small: Small, frame: dict[str, list[object]], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        compared(small, pandas.DataFrame(frame))
