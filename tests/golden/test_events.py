"""Events are changes of sign: touching zero is none, and a missing one is noticed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import pytest

from tt_precise.golden.events import suspects
from tt_precise.golden.runs import Task, perform
from tt_precise.golden.table import Table
from tt_precise.integrate import integrate
from tt_precise.scene import Scene

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
