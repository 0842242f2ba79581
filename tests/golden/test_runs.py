"""Only digits on which all runs agree are published; no event is missing."""

from collections.abc import Callable
from dataclasses import replace
from decimal import Decimal

import pytest

from tests.golden.conftest import Small, shortened, with_table
from tests.golden.tables import other_digit, with_cell
from tt_precise.golden.runs import GoldenRun, in_order, perform, reconcile
from tt_precise.golden.store import EVENTS, TRAJECTORY
from tt_precise.golden.table import ZERO, Table, agreement, digits_of


def spoiled(run: GoldenRun, row: int, column: str, change: Callable[[str], str]) -> GoldenRun:
    return with_table(run, TRAJECTORY, with_cell(run.tables[TRAJECTORY], row, column, change))


def cut(run: GoldenRun, rows: int, events: int | None) -> GoldenRun:
    """The first rows and events of a run."""
    tables = {
        file: Table(run.tables[file].columns, run.tables[file].rows[:count])
        for file, count in ((TRAJECTORY, rows), (EVENTS, events))
    }
    return replace(run, tables=tables)


@pytest.mark.parametrize("index", [1, 2])
def test_a_deviating_run_costs_digits(small: Small, index: int) -> None:
    runs = list(small.runs)
    runs[index] = spoiled(runs[index], 2, "theta", lambda cell: other_digit(cell, 12))
    consensus = reconcile(small.scene, runs)
    assert not consensus.complete
    assert digits_of(consensus.tables[TRAJECTORY].column("theta")[2]) <= 11
    assert consensus.agreement < 12
    # without a common digit it is a contradiction
    other = spoiled(small.runs[index], 2, "theta", lambda _: "2.0e-1")
    consensus = reconcile(small.scene, [small.runs[0], other])
    assert consensus.contradictions == ("theta at t = 0.02 s",)
    assert not consensus.complete


def test_a_last_digit_that_agrees_by_chance_is_not_enough(small: Small) -> None:
    first, other, _ = small.runs
    first = spoiled(first, 2, "omega_3", lambda _: "1.5500000000000000000000000000000003")
    other = spoiled(other, 2, "omega_3", lambda _: "1.550000000000000000000000000000000")
    consensus = reconcile(small.scene, [first, other])
    assert digits_of(consensus.tables[TRAJECTORY].column("omega_3")[2]) == 34
    assert 33 < consensus.agreement < 35
    assert not consensus.complete


def other_direction(run: GoldenRun) -> GoldenRun:
    events = with_cell(run.tables[EVENTS], 0, "direction", lambda way: str(-int(way)))
    return with_table(run, EVENTS, events)


def other_name(run: GoldenRun) -> GoldenRun:
    return with_table(run, EVENTS, with_cell(run.tables[EVENTS], 0, "name", lambda _: "equator"))


def without_a_turn(run: GoldenRun) -> GoldenRun:
    """The run without its second turning point of theta."""
    columns, rows = run.tables[EVENTS].columns, run.tables[EVENTS].rows
    turns = [n for n, row in enumerate(rows) if row[0] in ("theta_min", "theta_max")]
    return with_table(run, EVENTS, Table(columns, rows[: turns[1]] + rows[turns[1] + 1 :]))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda run: cut(run, 7, -1), "no further event in newton 160"),
        (other_name, r"has theta_m\w+ \((1|-1)\) at .*, equator \((1|-1)\) at"),
        (lambda run: replace(run, status="contact_lost"), "ended"),
        (without_a_turn, "may have missed an event: turning points"),
    ],
)
def test_another_course_of_events_is_a_contradiction(
    small: Small, spoil: Callable[[GoldenRun], GoldenRun], words: str
) -> None:
    with pytest.raises(ArithmeticError, match=words):
        reconcile(small.scene, [small.runs[0], spoil(small.runs[1])])


def test_a_run_that_ends_at_a_pole_is_evidence_before_it(small: Small) -> None:
    ended = replace(cut(small.runs[2], 3, 1), status="pole")
    consensus = reconcile(small.scene, [*small.runs[:2], ended])
    assert consensus.complete
    rows = consensus.tables[TRAJECTORY].rows
    assert len(rows) == len(small.runs[0].tables[TRAJECTORY].rows)
    # an event that it does not have before the pole is a contradiction
    with pytest.raises(ArithmeticError, match="in euler 160"):
        reconcile(small.scene, [*small.runs[:2], other_direction(ended)])


def test_a_run_without_a_row_agrees_with_nothing(small: Small) -> None:
    newton, other, euler = small.runs
    silent = replace(cut(euler, 0, 0), status="pole")
    consensus = reconcile(small.scene, [newton, other, silent])
    assert consensus.complete
    for agreements in consensus.agreements.values():
        assert {label for runs in agreements.values() for label in runs} == {other.label}
    for runs in ([newton, silent], [newton]):
        with pytest.raises(ArithmeticError, match=f"to compare with {newton.label}"):
            reconcile(small.scene, runs)


def test_the_end_of_contact_is_a_computed_time(small: Small) -> None:
    lost = replace(small.runs[0], status="contact_lost")
    times = reconcile(small.scene, [lost, lost]).tables[TRAJECTORY].column("t")
    assert times[-2:] == ("0.05", "6." + "0" * 33 + "e-2")
    run = perform(shortened("contact-lost", "8"), "double")
    name, time, direction, *state = run.tables[EVENTS].rows[-1]
    assert (name, direction, run.status) == ("contact_lost", "-1", "contact_lost")
    assert (time, *state) == run.tables[TRAJECTORY].rows[-1]


def test_a_vertical_axis_has_no_tilt(small: Small) -> None:
    run = spoiled(small.runs[0], 1, "kx", lambda _: "1e-50")
    run = spoiled(run, 1, "ky", lambda _: "-1e-50")
    consensus = reconcile(small.scene, [run, run])
    table = consensus.tables[TRAJECTORY]
    assert (table.column("kx")[1], table.column("phi_dot")[1]) == (ZERO, "")
    assert table.column("omega_3")[1] != ""
    assert consensus.contradictions == ()


def test_simultaneous_events_keep_the_order_of_the_catalogue() -> None:
    rows = [("equator", "1e+0"), ("theta_max", "1e+0"), ("theta_max", "2e+0"), ("equator", "3e+0")]
    assert in_order(rows[::-1]) == [rows[1], rows[0], *rows[2:]]
    later = ("theta_max", "1.00000000000000000000000000001e+0")
    assert in_order([later, rows[0]]) == [rows[0], later]


@pytest.mark.parametrize("name", ["upright", "inverted"])
def test_a_steady_spin_has_its_closed_form(name: str) -> None:
    """L = I3 omega_3 k with k = z or -z; 28 digits are those of decimal's own context."""
    scene = shortened(name, "0.1")
    finer, coarser = perform(scene, bits=176), perform(scene, bits=160)
    consensus = reconcile(scene, [finer, coarser])
    assert consensus.complete
    table = consensus.tables[TRAJECTORY]
    spin = scene.body.I3 * scene.start.omega_3
    exact = Decimal(spin.numerator) / Decimal(spin.denominator)
    for cell in table.column("Lz"):
        assert agreement(exact if name == "upright" else -exact, Decimal(cell)) > 27
    zeros = {"kx", "ky", "Lx", "Ly", "vx", "vy"}
    assert {n for n in table.columns if set(table.column(n)) == {ZERO}} >= zeros
    faster = perform(scene.varied(omega_3="200"), bits=160)
    assert reconcile(scene, [finer, faster]).contradictions
