"""Every event that can be named, on every shipped scene: all of them in one run a scene."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from tt_precise.integration import catalogue, integrate
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import load_scene, shipped

EXTREMA = tuple(f"extremum:{name}" for name in QUANTITIES)
ZEROS = tuple(f"zero:{name}" for name in QUANTITIES)
# one of each kind; compiling so many functions takes seconds
KINDS = ("rolling", "rocking", "coulomb-flight", "elastic-linear")


@pytest.mark.parametrize(
    "name", [pytest.param(one, marks=() if one in KINDS else pytest.mark.slow) for one in shipped()]
)
def test_all_events_at_once(name: str) -> None:
    scene = load_scene(name)
    scene = replace(scene, until=Fraction(1, 50), sample_every=Fraction(1, 100))
    names = (*catalogue(scene.model), *EXTREMA, *ZEROS)
    partial: set[str] = set()
    try:
        run = integrate(scene, events=names)
    except InputError as refusal:
        partial = set(str(refusal).partition("got ")[2].split(", undefined")[0].split(", "))
        run = integrate(scene, events=[one for one in names if one not in partial])
    assert partial <= set(names)
    assert run.status in ("complete", "contact_lost")
    found = run.events
    assert set(found["name"]) <= {*names, "stick", "slip", "lift_off", "landing", "separation"}
    quantities = {one.partition(":")[2] for one in partial}
    # what is undefined at the start: an axis that is vertical, or so nearly that sin^2 is 0
    if name in ("upright", "inverted"):
        assert quantities == {q.name for q in QUANTITIES.values() if not q.pole}
    else:
        assert bool(quantities) == (name in ("beside-the-pole", "rocking")), quantities
        assert quantities <= {"V", "E_tilde_main", "theta_dot_simplified"}
