"""``tt-precise events``: the catalogue, and the events of a scene."""

import re
from typing import Any

import mpmath
import pytest

from tests.conftest import Printed, Said
from tt_precise.integration import EVENTS, TERMINAL, Trajectory, catalogue, integrate
from tt_precise.integration.events import JOINING, change
from tt_precise.runtime.values import InputError

CLIMB = [f"t_{end}_{definition}" for definition in "ABC" for end in ("init", "end")]


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return integrate("reference", events=catalogue("gliding"))


def test_the_catalogue(said: Said, printed: Printed) -> None:
    lines = said("events").splitlines()
    assert {f"{name:<20} {event.meaning}" for name, event in EVENTS.items()} <= set(lines)
    for of_any in ("extremum:QUANTITY ", "zero:QUANTITY "):
        assert any(line.startswith(of_any) for line in lines)
    start = lines.index("always recorded; they join two stretches of a trajectory:")
    assert [line.split()[0] for line in lines[start + 1 :]][: len(JOINING)] == list(JOINING)
    start = lines.index("always watched; they end a trajectory:")
    assert [line.split()[0] for line in lines[start + 1 :]] == list(TERMINAL)
    document = printed("events")
    assert document["schema"] == "tt_precise.events/1"
    assert document["events"] == {name: event.meaning for name, event in EVENTS.items()}
    assert (document["joining"], document["terminal"]) == (JOINING, TERMINAL)


def test_the_events_of_a_scene(said: Said, printed: Printed, trajectory: Trajectory) -> None:
    lines = said("events reference").splitlines()
    events = trajectory.events
    assert [line.split()[:4] for line in lines[: len(events)]] == [
        [f"{row['t']:.12f}", "s", row["name"], change(row["name"], row["direction"])]
        for row in events.to_dict("records")
    ]
    climb = lines[len(events) :]
    assert [line.split(":")[0].strip() for line in climb] == CLIMB
    assert climb[0] == f" t_init_A: {trajectory.inversion.A.t_init:.12f} s"
    document = printed("events reference")
    assert (document["scene"], document["status"]) == ("reference", "complete")
    assert [event["name"] for event in document["events"]] == list(events["name"])
    assert [float(event["t"]) for event in document["events"]] == list(events["t"])
    for definition in "ABC":
        found = getattr(trajectory.inversion, definition)
        times = [float(document["climb"][f"t_{end}_{definition}"]) for end in ("init", "end")]
        assert times == [found.t_init, found.t_end]


def test_events_are_chosen_by_name(said: Said) -> None:
    asked = "events upright --only equator,extremum:g_n,climb --precision extended"
    first, *climb = said(asked).splitlines()
    assert first.startswith("extremum:g_n: its function touches zero, stays there")
    assert climb == [f"{key:>9}: none" for key in CLIMB]
    assert (
        said("events contact-lost --only equator")
        .splitlines()[-1]
        .startswith("contact_lost at t = 1.33692")
    )


def test_the_equator_goes_up_where_theta_rises(printed: Printed) -> None:
    found = printed("events reference --only equator")["events"]
    assert [event["change"] for event in found] == ["up", "down", "up"]
    assert [float(event["state"]["theta_dot"]) > 0 for event in found] == [True, False, True]


def test_what_every_run_records_can_be_asked_for_alone(said: Said, printed: Printed) -> None:
    found = printed("events coulomb-small-top --only stick")["events"]
    assert [event["name"] for event in found] == ["stick"]
    assert printed("events coulomb-small-top --only equator")["events"] == []
    assert said("events coulomb-small-top --only stick").count("\n") == 1
    assert said("events coulomb-small-top --only equator") == "none of: equator\n"
    lines = said("events reference --only climb").splitlines()
    assert [line.split(":")[0].strip() for line in lines] == CLIMB
    lost = said("events contact-lost --only contact_lost").splitlines()
    assert lost[-1].startswith("contact_lost at t = 1.33692")
    assert "expected one of" in said("events reference --only climbs", status=2)


def test_a_touch_is_said_once(said: Said, printed: Printed) -> None:
    command = "events rolling --only phi_dot_zero,theta_max --until 1"
    text = said(command)
    assert text.count("phi_dot_zero") == 1
    assert "phi_dot_zero: its function touches zero, stays there, or crosses it by" in text
    for words in (command, "run rolling --until 1 --events phi_dot_zero"):
        assert printed(words)["touches"] == ["phi_dot_zero"]


def test_a_rolling_scene_has_its_own_catalogue(printed: Printed) -> None:
    names = {
        event["name"]
        for event in printed("events rolling --until 2 --precision extended")["events"]
    }
    assert {"theta_min", "theta_max"} <= names <= set(catalogue("rolling"))


def test_a_flight_has_no_climb(said: Said, printed: Printed) -> None:
    text = said("events flight")
    assert "equator" in text
    assert "t_init" not in text
    assert printed("events flight")["climb"] is None


def test_an_extremum_stands_beside_its_own_value(said: Said) -> None:
    asked = "events reference --only extremum:g_n,theta_max --until 0.05 --digits 6"
    found = [line.split() for line in said(asked).splitlines()[:3]]
    assert [line[3] for line in found] == ["maximum", "minimum", "maximum"]
    shown = float(found[0][found[0].index("g_n") + 1])
    there = integrate("reference", digits=9).frame("g_n", times=[found[0][0]], numbers="float")
    assert shown == pytest.approx(float(there["g_n"].iloc[0]), rel=1e-8)
    assert found[2][2] == "theta_max"


def test_columns_at_events_have_their_errors(said: Said, printed: Printed) -> None:
    words = "events reference --until 0.1 --only theta_max --columns E,g_n"
    plain = said(words).splitlines()[0]
    assert re.search(r"  E 0\.042\d+ J  g_n 0\.19\d+ N$", plain)
    exact = said(words, "--digits 12").splitlines()[0]
    assert re.search(r"  E 0\.042\d+ \+- \S+ J  g_n 0\.19\d+ \+- \S+ N  t \+- \S+ s$", exact)
    asked = said("events reference --until 0.1 --only theta_max --columns error:E,digits")
    assert re.search(r"  E \S+ \+- \S+ J  digits 1\d\.\d$", asked.splitlines()[0])
    (event, *_) = printed(words, "--digits 12")["events"]
    assert list(event["columns"]) == ["E", "error:E", "g_n", "error:g_n"]
    run = "run reference --until 0.1 --events theta_max --columns E,drift:E,g_n --digits 12"
    assert printed(run)["events"][0] == event
    for refused in ("drift:E", "pose", "lean"):
        assert f"--columns: got {refused!r}, " in said(
            f"events reference --columns {refused}", status=2
        )


def test_times_of_asked_digits_have_their_errors(said: Said, printed: Printed) -> None:
    words = "events reference --until 0.2 --only theta_max --digits 20"
    found = printed(words)["events"]
    fine = integrate("reference", digits=30, until="0.2", events=["theta_max"]).events
    assert len(found) == len(fine) > 2
    for event, t in zip(found, fine["t"], strict=True):
        with mpmath.workdps(50):
            apart = abs(mpmath.mpf(event["t"]) - t)
        assert apart <= 2 * float(event["error"]) < 1e-18
    lines = said(words).splitlines()
    assert all(re.search(r" t \+- \S+e-\d\d s$", line) for line in lines[: len(found)])
    assert len(lines[0].split()[0]) > 20
    plain = printed("events reference --until 0.2 --only theta_max")
    assert {event["error"] for event in plain["events"]} == {None}


@pytest.mark.parametrize("asked", [7, [7], "none_such"])
def test_an_unknown_event_is_refused(asked: Any) -> None:
    with pytest.raises(InputError, match="expected"):
        integrate("reference", events=asked)
