"""``tt-precise events``: the catalogue, and the events of a scene."""

import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

from tt_precise import cli
from tt_precise.integration import EVENTS, TERMINAL, Trajectory, catalogue, integrate
from tt_precise.integration.events import JOINING, change
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene

SCHEMA = "tt_precise.events/1"


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return integrate("reference", events=catalogue("gliding"))


def test_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["events"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for name, event in EVENTS.items():
        assert f"{name:<20} {event.meaning}" in lines
    for of_any in ("extremum:QUANTITY ", "zero:QUANTITY "):
        assert any(line.startswith(of_any) for line in lines)
    start = lines.index("always recorded; they join two stretches of a trajectory:")
    assert [line.split()[0] for line in lines[start + 1 :]][: len(JOINING)] == list(JOINING)
    start = lines.index("always watched; they end a trajectory:")
    assert [line.split()[0] for line in lines[start + 1 :]] == list(TERMINAL)


def test_the_catalogue_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["events", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["schema"] == SCHEMA
    assert printed["events"] == {name: event.meaning for name, event in EVENTS.items()}
    assert printed["joining"] == JOINING
    assert printed["terminal"] == TERMINAL


def test_the_events_of_a_scene(capsys: pytest.CaptureFixture[str], trajectory: Trajectory) -> None:
    assert cli.main(["events", "reference"]) == 0
    lines = capsys.readouterr().out.splitlines()
    expected = [
        [f"{row['t']:.12f}", "s", row["name"], change(row["name"], row["direction"])]
        for row in trajectory.events.to_dict("records")
    ]
    assert [line.split()[:4] for line in lines[: len(expected)]] == expected
    climb = lines[len(trajectory.events) :]
    assert [line.split(":")[0].strip() for line in climb] == [
        "t_init_A", "t_end_A", "t_init_B", "t_end_B", "t_init_C", "t_end_C",
    ]  # fmt: skip
    assert climb[0] == f" t_init_A: {trajectory.inversion.A.t_init:.12f} s"


def test_the_events_of_a_scene_as_json(
    capsys: pytest.CaptureFixture[str], trajectory: Trajectory
) -> None:
    assert cli.main(["events", "reference", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert (printed["schema"], printed["scene"], printed["status"]) == (
        SCHEMA,
        "reference",
        "complete",
    )
    assert [event["name"] for event in printed["events"]] == list(trajectory.events["name"])
    assert [float(event["t"]) for event in printed["events"]] == list(trajectory.events["t"])
    for definition in "ABC":
        climb = getattr(trajectory.inversion, definition)
        assert float(printed["climb"][f"t_init_{definition}"]) == climb.t_init
        assert float(printed["climb"][f"t_end_{definition}"]) == climb.t_end


def test_only_some(capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        cli.main(["events", "upright", "--only", "equator,extremum:g_n", "--precision", "extended"])
        == 0
    )
    first, *climb = capsys.readouterr().out.splitlines()
    assert first.startswith("extremum:g_n: its function touches zero, stays there")
    assert climb == [
        f"{key:>9}: none"
        for key in ("t_init_A", "t_end_A", "t_init_B", "t_end_B", "t_init_C", "t_end_C")
    ]


def test_a_touch_is_said_once(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["events", "rolling", "--only", "phi_dot_zero,theta_max", "--until", "1"]
    assert cli.main(command) == 0
    said = capsys.readouterr().out
    assert said.count("phi_dot_zero") == 1
    assert (
        "phi_dot_zero: its function touches zero, stays there, or crosses it by less than" in said
    )
    assert cli.main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["touches"] == ["phi_dot_zero"]
    assert cli.main(["run", "rolling", "--until", "1", "--events", "phi_dot_zero", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["touches"] == ["phi_dot_zero"]


def test_a_rolling_scene_has_its_own_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["events", "rolling", "--precision", "extended", "--json"]) == 0
    names = {event["name"] for event in json.loads(capsys.readouterr().out)["events"]}
    assert {"theta_min", "theta_max"} <= names <= set(catalogue("rolling"))


def test_a_flight_has_no_climb(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["events", "flight"]) == 0
    out = capsys.readouterr().out
    assert "equator" in out
    assert "t_init" not in out
    assert cli.main(["events", "flight", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["climb"] is None


def test_an_extremum_stands_beside_its_own_value(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["events", "reference", "--only", "extremum:g_n,theta_max", "--until", "0.05"]
    assert cli.main([*asked, "--digits", "6"]) == 0
    found = [line.split() for line in capsys.readouterr().out.splitlines()[:3]]
    assert [line[3] for line in found] == ["maximum", "minimum", "maximum"]
    shown = float(found[0][found[0].index("g_n") + 1])
    scene = load_scene("reference")
    there = integrate(scene, digits=9).frame("g_n", times=[found[0][0]], numbers="float")
    assert shown == pytest.approx(float(there["g_n"].iloc[0]), rel=1e-8)
    assert found[2][2] == "theta_max"


def test_lost_contact_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["events", "contact-lost", "--only", "equator"]) == 0
    assert capsys.readouterr().out.splitlines()[-1].startswith("contact_lost at t = 1.33692")


@pytest.mark.parametrize("asked", ["theta_max", "theta_max,equator", "all", ("theta_max",)])
def test_events_are_asked_for_by_name(asked: str | tuple[str, ...]) -> None:
    scene = replace(load_scene("reference"), until=Fraction(1, 20))
    assert "theta_max" in set(integrate(scene, events=asked).events["name"])


@pytest.mark.parametrize("asked", [7, [7], "none_such"])
def test_what_names_no_event_is_refused(asked: Any) -> None:
    with pytest.raises(InputError, match="expected"):
        integrate("reference", events=asked)
