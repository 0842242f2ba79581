"""``tt-precise events`` and ``thresholds``: events, and numbers that are determined twice."""

import re

import mpmath
import pytest

from tests.conftest import Printed, Said, SceneFile
from tt_precise.exact.stability import MarginalMomentum
from tt_precise.integration import EVENTS, TERMINAL, catalogue, integrate
from tt_precise.integration.events import JOINING, change
from tt_precise.mechanics import thresholds as formulas

CLIMB = [f"t_{end}_{definition}" for definition in "ABC" for end in ("init", "end")]


def test_the_catalogue(said: Said, printed: Printed) -> None:
    lines = said("events").splitlines()
    assert {f"{name:<20} {event.meaning}" for name, event in EVENTS.items()} <= set(lines)
    assert {"extremum:QUANTITY", "zero:QUANTITY", "climb"} <= {line.split()[0] for line in lines}
    document = printed("events")
    assert document["schema"] == "tt_precise.events/1"
    assert document["events"] == {name: event.meaning for name, event in EVENTS.items()}
    assert (document["joining"], document["terminal"]) == (JOINING, TERMINAL)


def test_the_events_of_a_scene(said: Said, printed: Printed) -> None:
    run = integrate("reference", events=catalogue("gliding"))
    lines, events = said("events reference").splitlines(), run.events
    assert [line.split()[:4] for line in lines[: len(events)]] == [
        [f"{row['t']:.12f}", "s", row["name"], change(row["name"], row["direction"])]
        for row in events.to_dict("records")
    ]
    climb = lines[len(events) :]
    assert [line.split(":")[0].strip() for line in climb] == CLIMB
    assert climb[0] == f" t_init_A: {run.inversion.A.t_init:.12f} s"
    document = printed("events reference")
    assert (document["scene"], document["status"]) == ("reference", "complete")
    assert [event["name"] for event in document["events"]] == list(events["name"])
    assert [float(event["t"]) for event in document["events"]] == list(events["t"])
    times = {name: float(time) for name, time in document["climb"].items()}
    assert times == run.inversion.times


@pytest.mark.parametrize(
    ("words", "names", "last"),
    [
        ("reference --only equator", ["equator"] * 3, "equator"),
        ("reference --only climb", [], "t_end_C: 7.88"),
        ("coulomb-small-top --only stick", ["stick"], "stick"),
        ("coulomb-small-top --only equator", [], "none of: equator"),
        ("contact-lost --only contact_lost", [], "contact_lost at t = 1.33692"),
        ("flight --only equator", ["equator"] * 8, "landed at t = 0.15298"),
        ("rolling --only phi_dot_zero --until 1", [], "phi_dot_zero: its function touches zero"),
    ],
)
def test_events_are_chosen_by_name(
    said: Said, printed: Printed, words: str, names: list[str], last: str
) -> None:
    document = printed("events", words)
    assert [event["name"] for event in document["events"]] == names
    assert last in said("events", words).splitlines()[-1]
    assert document["touches"] == (["phi_dot_zero"] if "rolling" in words else [])
    assert (document["climb"] is None) == ("flight" in words)


def test_the_equator_goes_up_where_theta_rises(printed: Printed) -> None:
    events = printed("events reference --only equator")["events"]
    assert [event["change"] for event in events] == ["up", "down", "up"]
    assert [float(event["state"]["theta_dot"]) > 0 for event in events] == [True, False, True]


def test_an_extremum_stands_beside_its_own_value(said: Said) -> None:
    lines = said("events reference --only extremum:g_n,theta_max --until 0.05 --digits 6")
    maximum, _, other = (line.split() for line in lines.splitlines()[:3])
    value = float(maximum[maximum.index("g_n") + 1])
    row = integrate("reference", digits=9).frame("g_n", times=[maximum[0]], numbers="float")
    assert value == pytest.approx(float(row["g_n"].iloc[0]), rel=1e-8)
    assert "g_n" not in other


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        ("--columns E,g_n", r"  E 0\.042\d+ J  g_n 0\.19\d+ N$"),
        ("--columns E,g_n --digits 12", r"  E 0\.042\d+ \+- \S+ J  g_n 0\.19\d+ \+- \S+ N$"),
        ("--columns error:E,digits", r"  E \S+ \+- \S+ J  digits 1\d\.\d$"),
    ],
)
def test_columns_at_events_have_their_errors(said: Said, options: str, pattern: str) -> None:
    line = said("events reference --until 0.1 --only theta_max", options).splitlines()[0]
    assert re.search(pattern, line), line


def test_columns_of_events_are_those_of_a_run(said: Said, printed: Printed) -> None:
    words = "reference --until 0.1 --digits 12 --columns E,g_n"
    event = printed("events --only theta_max", words)["events"][0]
    assert list(event["columns"]) == ["E", "error:E", "g_n", "error:g_n"]
    assert printed("run --events theta_max", words)["events"][0] == event
    for name in ("drift:E", "lean"):
        text = said(f"events reference --columns {name}", status=2)
        assert f"--columns: got {name!r}, " in text


def test_times_of_requested_digits_have_their_errors(said: Said, printed: Printed) -> None:
    words = "events reference --until 0.2 --only theta_max --digits 20"
    events = printed(words)["events"]
    fine = integrate("reference", digits=30, until="0.2", events=["theta_max"]).events
    assert len(events) == len(fine) > 2
    for event, t in zip(events, fine["t"], strict=True):
        with mpmath.workdps(50):
            apart = abs(mpmath.mpf(event["t"]) - t)
        assert apart <= 2 * float(event["error"]) < 1e-18
    assert re.match(r"0\.0368\d{18,} \+- \S+e-\d\d s  theta_max", said(words))
    assert printed("events reference --until 0.2 --only theta_max")["events"][0]["error"] is None


NAMES = ["lambda", "lambda_thres", "lambda_up", "D0", "D1", "E0", "E1", "gamma", "sigma"]


def test_the_screen_lists_twenty_digits_and_the_theorem(said: Said) -> None:
    *lines, last = said("thresholds reference --digits 20").splitlines()
    assert [line.split()[0] for line in lines] == NAMES
    assert lines[7].split()[:2] == ["gamma", "0.93571428571428571429"]
    assert all(line.endswith("20 digits agree") for line in lines)
    assert last.split()[:2] == ["theorem", "inverts,"]


def test_digits_that_do_not_agree_fail(
    printed: Printed, said: Said, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = formulas.lambda_thres
    monkeypatch.setattr(
        formulas, "lambda_thres", lambda body, fn: right(body, fn) * (1 + fn.mpf("2e-48"))
    )
    found = printed("thresholds reference", status=1)["quantities"]
    agreed = [found[name]["digits_agreed"] for name in ("lambda_thres", "lambda_up")]
    assert agreed == [47, 50]
    assert "ONLY 47 digits agree" in said("thresholds reference", status=1)
    said("thresholds reference --digits 45")


def test_a_threshold_that_does_not_exist_is_no_failure(
    printed: Printed, said: Said, scene_file: SceneFile
) -> None:
    """gamma = 3/2 > 1 + alpha: the inverted spin is never stable, as both ways find."""
    file = scene_file(I1="3/5")
    found = printed("thresholds", file, "--digits 10")
    absent = found["quantities"]["lambda_thres"]
    assert (absent["value"], absent["independent"], absent["digits_agreed"]) == (None, None, None)
    assert (found["inverts"], found["theorem"]["verdict"]) == (False, "does_not_invert")
    assert "does not exist" in said("thresholds", file, "--digits 10")


def test_a_threshold_that_one_method_alone_finds_fails(
    printed: Printed, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = MarginalMomentum(reason="spoiled")
    monkeypatch.setattr("tt_precise.exact.thresholds.marginal_momentum", lambda *_, **__: nothing)
    one = printed("thresholds reference --digits 10", status=1)["quantities"]["lambda_thres"]
    assert (one["independent"], one["digits_agreed"]) == (None, 0)
