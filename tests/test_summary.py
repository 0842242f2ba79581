"""The flat record of a trajectory, and its text."""

import re

import mpmath
import pytest

import tt_precise as tt
from tt_precise.summary import with_error


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        ("3.1340209458534383", "1.7e-15", "3.1340209458534383 +- 1.7e-15"),
        ("3.1340209458534383", "2e-5", "3.134021 +- 2e-05"),
        ("-1.25e-40", "1e-43", "-1.25e-40 +- 1e-43"), ("155", "5e-18", "155 +- 5e-18"),
        ("0.345054108", None, "0.345054108"), (None, None, "undefined"),
    ],
)  # fmt: skip
def test_a_number_has_the_digits_that_its_error_leaves(
    value: str | None, error: str | None, text: str
) -> None:
    assert with_error(value, error) == text


def test_the_times_and_forces_are_those_of_the_trajectory() -> None:
    run = tt.integrate("reference")
    summary = tt.summarise(tt.integrate("reference", "double-double"))
    times = {name: None if t is None else float(t) for name, t in summary.times.items()}
    assert summary.equator == "passed"
    assert times["equator"] == run.inversion.equator
    assert {name: times[name] for name in run.inversion.times} == run.inversion.times
    # between the samples at 5.37 and 5.38 s, of which the smaller has 0.0577 N
    assert times["t_min_g_n"] == pytest.approx(5.37676848807, rel=1e-11)
    least, most = (float(summary.forces[name] or 0) for name in ("min_g_n", "max_g_n"))
    assert least == pytest.approx(0.0563416061168, rel=1e-11)
    force = run.frame("g_n")["g_n"]
    assert least < force.min()
    assert force.max() < most < 1.01 * force.max()
    assert summary.errors == {}
    assert [part["model"] for part in summary.segments] == ["gliding"]


@pytest.mark.evidence
def test_times_and_forces_of_requested_digits_have_them() -> None:
    run, fine = (tt.integrate("reference", digits=n, events="all, extremum:g_n") for n in (25, 40))
    summary = tt.summarise(run, exactly=True)
    values = {name: t for name, t in fine.inversion.times.items() if t is not None}
    values |= {"min_g_n": min(fine.event_table(["g_n"])["g_n"])}
    for name, value in values.items():
        with mpmath.workdps(50):
            apart = abs(mpmath.mpf((summary.times | summary.forces)[name]) - value)
        assert apart < 3 * float(summary.errors[name] or 0) < 1e-21  # an estimate, not a bound
    line = r"min_g_n: 0\.0563416061168171\d+ \+- [\d.]+e-\d\d N, at 5\.3767\d+ \+-"
    assert re.search(line, str(summary))


@pytest.mark.parametrize(
    ("scene", "until", "equator", "climbs"),
    [
        ("regularised-1e-2", None, "passed", True), ("inverted", "0.1", "not_passed", False),
        ("flight", None, "passed", False), ("stays-upright", None, "never", False),
    ],
)  # fmt: skip
def test_the_equator_and_the_climb(
    scene: str, until: str | None, equator: str, climbs: bool
) -> None:
    summary = tt.summarise(tt.integrate(scene, until=until))
    assert summary.equator == equator
    assert ("equator" in summary.times) == (equator == "passed")
    assert ("t_init_A" in summary.times) == climbs
    assert f"  equator: {equator.replace('_', ' ')}" in str(summary)
    assert sum(line.startswith("  climb ") for line in summary.lines()) == 3 * climbs


@pytest.mark.parametrize(
    ("scene", "until", "columns", "at_rest", "warning"),
    [
        ("reference", "0.1", [], "contact point", ""),
        ("tippetopsim", "0.1", [], "centre of mass", ""),
        ("from-initiation", "0.1", [], "", ""),
        ("regularised-1e-2", "0.03", [], "", ""),
        ("regularised-1e-2", "1.5", [], "", "at 20 of 151 samples, first at 0.04 s: "),
        ("reference", "0.1", ["drift:E"], "contact point", "note: drift:E: changes since"),
    ],
)
def test_the_point_at_rest_and_warnings(
    scene: str, until: str, columns: list[str], at_rest: str, warning: str
) -> None:
    summary = tt.summarise(tt.integrate(scene, until=until), columns)
    assert summary.at_rest == at_rest
    assert bool(summary.warnings) == bool(warning)
    assert (f"start: {at_rest} at rest" in str(summary)) == bool(at_rest)
    assert warning in str(summary)


def test_each_segment_of_a_motion_is_named() -> None:
    summary = tt.summarise(tt.integrate("coulomb-small-top"))
    glides, rolls = summary.segments
    assert (glides["model"], glides["status"]) == ("gliding", "stick")
    assert (rolls["model"], rolls["status"]) == ("rolling", "complete")
    assert glides["end"] == rolls["begin"]
    assert re.search(r"\n  rolls 0\.\d+ s to 0\.1 s \(complete\)\n", str(summary))


def test_events_have_their_state_and_columns() -> None:
    run = tt.integrate("reference", until="0.1", events=["theta_min", "nu_y_zero"])
    events = tt.summarise(run, ["E", "drift:E"]).events
    assert [float(event["t"]) for event in events] == list(run.events["t"])
    assert all([*event["columns"]] == ["E"] for event in events)
    turning = next(event for event in events if event["name"] == "theta_min")
    assert (turning["change"], turning["error"]) == ("minimum", None)
    assert abs(float(turning["state"]["theta_dot"])) < 1e-13
