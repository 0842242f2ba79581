"""Events are changes of sign: touching zero is none, and a missing one is noticed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import pytest

from tt_precise.golden.events import ROOT_ORDER, events_table, suspects
from tt_precise.golden.runs import Task, columns, perform
from tt_precise.golden.table import Table
from tt_precise.integration import catalogue, integrate
from tt_precise.integration.events import EVENTS
from tt_precise.scene.scene import Scene

Shorten = Callable[[str, str], Scene]


def test_cusps_are_no_change_of_sign(shorten: Shorten) -> None:
    # from phi_dot = 0 on ice, phi_dot comes back to 0 at each maximum of theta and turns there
    scene = shorten("frictionless", "0.2")
    raw = integrate(scene, "mp", bits=160, events=("phi_dot_zero", "theta_max")).events
    assert "phi_dot_zero" in set(raw["name"])
    run = perform(Task(scene.name, scene.text, "mp", 160, "newton"))
    names = Counter(run.events.column("name"))
    assert names["theta_max"] == 5
    assert "phi_dot_zero" not in names
    assert run.suspects == ()


def test_real_changes_of_sign_stay(shorten: Shorten) -> None:
    scene = shorten("reference", "0.2")
    raw = integrate(scene, "mp", bits=160, events=("phi_dot_zero",)).events
    run = perform(Task(scene.name, scene.text, "mp", 160, "newton"))
    assert len(raw) == run.events.column("name").count("phi_dot_zero") > 0


@pytest.mark.parametrize("precision", ["triple-double", "quad"])
def test_tables_are_those_of_mpmath_event_by_event(shorten: Shorten, precision: str) -> None:
    scene = shorten("frictionless", "0.2")  # with cusps
    run = integrate(scene, precision, events=catalogue(scene.model))
    names, context = columns(scene), run.precision.context
    width = run.start.units.time * context.ldexp(1, -run.precision.bits // ROOT_ORDER)
    expected = []
    for _, event in run.events.iterrows():
        function, t = EVENTS[event["name"]].function, event["t"]
        before, after = max(t - width, 0), min(t + width, run.t_end)
        if function(run.motion(before)) * function(run.motion(after)) < 0:
            cells = [run.precision.text(event[name]) for name in names]
            expected.append((event["name"], cells[0], str(event["direction"]), *cells[1:]))
    found = events_table(run, names)
    assert found.columns == ("name", "t", "direction", *names[1:])
    assert list(found.rows) == expected
    assert 0 < len(expected) < len(run.events)


@pytest.mark.parametrize(
    ("happened", "found"),
    [
        ([("theta_min", -1), ("theta_max", 1), ("theta_min", -1)], ()),
        ([("theta_min", -1), ("theta_min", -1)], ("turning points",)),
        ([("equator", 1), ("theta_max", 1), ("equator", 1)], ("equator",)),
        ([("equator", 1), ("equator", -1), ("equator", 1)], ()),
    ],
)
def test_directions_that_do_not_alternate_are_suspect(
    happened: list[tuple[str, int]], found: tuple[str, ...]
) -> None:
    rows = tuple((name, str(i), str(way)) for i, (name, way) in enumerate(happened))
    assert suspects(Table(("name", "t", "direction"), rows)) == found
