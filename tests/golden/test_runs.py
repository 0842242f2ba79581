"""Only what all runs agree on is published; events are changes of sign, and none is missing."""

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction

import pytest

from tests.conftest import Patch
from tests.golden.closed_form import closed_form
from tests.golden.conftest import Small, shortened
from tests.golden.tables import other_digit, with_cell
from tt_precise.golden.digits import EXACTLY, ZERO, agreement, digits_of
from tt_precise.golden.runs import (
    GoldenRun,
    Task,
    exact_decimal,
    ordered_events,
    perform,
    reconcile,
)
from tt_precise.golden.table import Table
from tt_precise.scene.scene import Scene, load_scene, parse_scene


def spoiled(run: GoldenRun, row: int, column: str, change: Callable[[str], str]) -> GoldenRun:
    return replace(run, trajectory=with_cell(run.trajectory, row, column, change))


@pytest.mark.parametrize("which", [1, 2])
def test_one_deviating_run_costs_digits(small: Small, which: int) -> None:
    runs = list(small.runs)
    runs[which] = spoiled(runs[which], 2, "theta", lambda cell: other_digit(cell, 12))
    consensus = reconcile(small.scene, runs)
    assert not consensus.complete
    assert digits_of(consensus.trajectory.column("theta")[2]) <= 11
    assert consensus.agreement < 12
    # without a common digit it is a contradiction
    other = spoiled(small.runs[which], 2, "theta", lambda _: "2.0e-1")
    consensus = reconcile(small.scene, [small.runs[0], other])
    assert consensus.contradictions == ("theta at t = 0.02 s",)
    assert not consensus.complete


def test_a_last_digit_that_agrees_by_luck_is_not_enough(small: Small) -> None:
    one, other, _ = small.runs
    one = spoiled(one, 2, "omega_3", lambda _: "1.5500000000000000000000000000000003")
    other = spoiled(other, 2, "omega_3", lambda _: "1.550000000000000000000000000000000")
    consensus = reconcile(small.scene, [one, other])
    assert digits_of(consensus.trajectory.column("omega_3")[2]) == 34
    assert 33 < consensus.agreement < 35
    assert not consensus.complete


def cut(run: GoldenRun, rows: int, events: int) -> GoldenRun:
    """The first rows and events of a run."""
    return replace(
        run,
        trajectory=Table(run.trajectory.columns, run.trajectory.rows[:rows]),
        events=Table(run.events.columns, run.events.rows[:events]),
    )


def other_direction(run: GoldenRun) -> GoldenRun:
    return replace(run, events=with_cell(run.events, 0, "direction", lambda way: str(-int(way))))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda run: cut(run, 7, -1), "number of events"),
        (other_direction, "where newton 160 has"),
        (lambda run: replace(run, status="contact_lost"), "ended"),
        (lambda run: replace(run, suspects=("theta_min",)), "missed"),
    ],
)
def test_what_happened_otherwise_is_a_contradiction(
    small: Small, spoil: Callable[[GoldenRun], GoldenRun], words: str
) -> None:
    with pytest.raises(ArithmeticError, match=words):
        reconcile(small.scene, [small.runs[0], spoil(small.runs[1])])


def test_a_run_that_ends_at_a_pole_testifies_before_it(small: Small) -> None:
    ended = replace(cut(small.runs[2], 3, 1), status="pole")
    consensus = reconcile(small.scene, [*small.runs[:2], ended])
    assert consensus.complete
    assert len(consensus.trajectory.rows) == len(small.runs[0].trajectory.rows)


def test_the_end_of_contact_is_the_last_event(small: Small) -> None:
    lost = replace(small.runs[0], status="contact_lost")
    assert ordered_events(lost)[-1][:2] == ("contact_lost", -1)
    times = reconcile(small.scene, [lost, lost]).trajectory.column("t")
    assert times[-2] == "0.05"
    assert times[-1] == "6." + "0" * 33 + "e-2"


def test_a_vertical_axis_has_no_tilt(small: Small) -> None:
    run = spoiled(small.runs[0], 1, "kx", lambda _: "1e-50")
    run = spoiled(run, 1, "ky", lambda _: "-1e-50")
    consensus = reconcile(small.scene, [run, run])
    kx, phi_dot, omega_3 = (consensus.trajectory.column(n)[1] for n in ("kx", "phi_dot", "omega_3"))
    assert (kx, phi_dot) == (ZERO, "")
    assert omega_3 != ""
    assert consensus.contradictions == ()


def test_simultaneous_events_keep_the_catalogue_order(small: Small) -> None:
    time, *state = small.runs[0].trajectory.rows[1]
    rows = tuple((name, time, "1", *state) for name in ("equator", "theta_max"))
    run = replace(small.runs[0], events=Table(small.runs[0].events.columns, rows))
    assert [event[0] for event in ordered_events(run)] == ["theta_max", "equator"]


@pytest.mark.parametrize(
    ("time", "text"),
    [("0.01", "0.01"), ("8", "8"), ("0", "0"), ("1/8", "0.125"), ("1/3", None), ("100", "100")],
)
def test_times_are_exact_decimals(time: str, text: str | None) -> None:
    assert exact_decimal(Fraction(time)) == text


def test_a_run_without_a_row_agrees_with_nothing(small: Small) -> None:
    newton, other, euler = small.runs
    silent = replace(cut(euler, 1, 0), status="pole")
    consensus = reconcile(small.scene, [newton, other, silent])
    assert consensus.complete
    for agreements in consensus.agreements.values():
        assert {label for runs in agreements.values() for label in runs} == {other.label}
    for runs in ([newton, silent], [newton]):
        with pytest.raises(ArithmeticError, match=f"to compare with {newton.label}"):
            reconcile(small.scene, runs)


def test_cusps_are_no_change_of_sign() -> None:
    # from phi_dot = 0 on ice, phi_dot comes back to 0 at each maximum of theta and turns there
    scene = shortened("frictionless", "0.2")
    run = perform(Task(scene.name, scene.text, "mp", 160, "newton"))
    names = Counter(run.events.column("name"))
    assert names["theta_max"] == 5
    assert "phi_dot_zero" not in names
    assert run.suspects == ()


def test_what_does_not_alternate_is_suspect(small: Small, monkeypatch: Patch) -> None:
    seen: list[tuple[str, int]] = []

    def suspected(found: Iterable[tuple[str, int]], _: object) -> tuple[str, ...]:
        seen.extend(found)
        return ("equator",)

    monkeypatch.setattr("tt_precise.golden.runs.not_alternating", suspected)
    run = perform(Task(small.scene.name, small.scene.text, "double", None, "newton"))
    assert run.suspects == ("equator",)
    assert seen == [(name, int(way)) for name, _, way, *_ in run.events.rows] != []


# Steady spins and flights are known without an integrator, and integration finds them again.


def known(scene: Scene) -> GoldenRun:
    """The closed form, of a scene that has one."""
    found = closed_form(scene)
    assert found is not None
    return found


def computed(scene: Scene) -> GoldenRun:
    return perform(Task(scene.name, scene.text, "mp", 160, "newton"))


@pytest.mark.parametrize("name", ["upright", "inverted"])
def test_integration_agrees_with_the_closed_form(name: str) -> None:
    scene = shortened(name, "0.1")
    consensus = reconcile(scene, [computed(scene), known(scene)])
    assert consensus.complete
    assert consensus.agreement > 45
    # L = I3 omega_3 k, k = z or -z; 28 digits are those of decimal's own context
    spin = scene.body.I3 * scene.start.omega_3
    printed = Decimal(consensus.trajectory.column("Lz")[-1])
    exact = Decimal(spin.numerator) / Decimal(spin.denominator)
    assert agreement(exact if name == "upright" else -exact, printed) > 27
    # a wrong steady state does not agree
    table = reconcile(scene, [known(scene), known(scene.varied(omega_3="200"))]).trajectory
    assert table.column("Lz")[-1] == ""


def test_a_flight_is_found_again_with_its_events_and_its_landing() -> None:
    scene = load_scene("flight")
    oracle = known(scene)
    run = computed(scene)
    consensus = reconcile(scene, [run, oracle])
    assert consensus.complete
    # the size of each column but for 256 eps of 160 bits; near a zero a row has fewer digits
    for name in run.trajectory.columns:
        rows = [[Decimal(x) for x in one.trajectory.column(name)] for one in (run, oracle)]
        apart = max(abs(EXACTLY.subtract(a, b)) for a, b in zip(*rows, strict=True))
        assert apart < Decimal(2.0**-151) * max(map(abs, rows[1])), name
    assert consensus.agreement > 43.5
    assert consensus.status == "landed"
    names = set(consensus.events.column("name"))
    assert names == {"theta_min", "theta_max", "equator", "phi_dot_zero", "landed"}
    higher = known(scene.varied(height="0.010000000000000000000000000000000001"))
    assert not reconcile(scene, [oracle, higher]).complete
    slower = known(scene.varied(omega_3="149.999"))
    assert reconcile(scene, [oracle, slower]).agreement < 6


@pytest.mark.parametrize(
    ("theta", "theta_dot", "phi_dot", "zeros"),
    [
        ("2", "0", "0", {"ky", "Ly", "theta_dot", "phi_dot"}),  # turns about its axis only
        ("2", "-60", "0", set()),  # begins with a zero of phi_dot
        ("pi/2", "0", "10", {"Ly"}),  # touches the equator at each turn
    ],
)
def test_zeros_of_a_flight_are_zero_up_to_rounding(
    theta: str, theta_dot: str, phi_dot: str, zeros: set[str]
) -> None:
    start = f'[start]\ntheta = "{theta}"\ntheta_dot = "{theta_dot}"\nphi_dot = "{phi_dot}"\n'
    text = load_scene("flight").text.split("[start]")[0] + start
    text += 'omega_3 = "150"\nheight = "0.01"\n[run]\nuntil = "0.03"\n'
    scene = parse_scene(text, "tossed", "tossed.toml")
    finer = perform(Task(scene.name, text, "mp", 176, "newton"))
    consensus = reconcile(scene, [computed(scene), finer, known(scene)])
    assert consensus.complete
    assert consensus.agreement > 43
    table = consensus.trajectory
    assert zeros <= {name for name in table.columns if set(table.column(name)) == {ZERO}}


def test_a_short_flight_does_not_land_and_a_plain_one_does_not_nutate() -> None:
    scene = load_scene("flight")
    short = known(scene.varied(until="0.1"))
    assert (short.status, len(short.trajectory.rows)) == ("complete", 11)
    assert known(scene.varied(theta_dot="0", phi_dot="0")).events.rows == ()
    assert closed_form(replace(scene, record=("phi",))) is None


@pytest.mark.parametrize(
    ("name", "pushed"),
    [
        ("reference", {}),
        ("beside-the-pole", {}),
        ("rolling", {}),
        ("flight", dict.fromkeys(("theta_dot", "phi_dot", "omega_3"), "0")),
        *(("upright", {push: "0.01"}) for push in ("theta_dot", "nu_x", "nu_y")),  # off the pole
    ],
)
def test_other_motions_have_none(name: str, pushed: dict[str, str]) -> None:
    assert closed_form(load_scene(name).varied(**pushed)) is None
