"""Exchanged, mirrored and scaled columns of vectors are named for a motion of any force."""

from collections.abc import Callable

import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import VECTORS, Healthy, check
from tests.check.test_departures import holding, late, times
from tests.conftest import more
from tt_precise.check.vector_conventions import OURS, arrangements
from tt_precise.scene.scene import parse_scene

L, K = ("Lx", "Ly", "Lz"), ("kx", "ky", "kz")
SPOILT: dict[str, Callable[[pandas.DataFrame], pandas.DataFrame]] = {
    "vx, vy hold vy, vx": holding(vx="vy", vy="vx"),
    "kx, ky hold ky, kx": holding(kx="ky", ky="kx"),
    "Lx, Ly hold Ly, Lx": holding(Lx="Ly", Ly="Lx"),
    "vx, vy have the other sign": times(-1, "vx", "vy"),
    "kz has the other sign": times(-1, "kz"),
    "Lz has the other sign": times(-1, "Lz"),
    "the axis points from the other end": times(-1, *K),
    "Lx, Ly, Lz have the other sign": times(-1, *L),
    "kx, ky, kz hold ky, kz, kx; Lx, Ly, Lz hold Ly, Lz, Lx": holding(
        kx="ky", ky="kz", kz="kx", Lx="Ly", Ly="Lz", Lz="Lx"
    ),
    "the world is left-handed, or the top spins the other way": times(-1, "kx", "vx", "Ly", "Lz"),
    "the time is in 1/60 s": times(60, "t"),
    "the time is in ms": times(1e3, "t"),
    "the time is in minutes": times(1 / 60, "t"),
    "the velocities are in cm/s": times(100, "vx", "vy"),
    "the angular momentum is in kg mm^2/s; the velocities are in mm/s": (
        lambda frame: times(1e6, *L)(times(1e3, "vx", "vy")(frame))
    ),
    # what is no convention
    "": late("vx", "vy"),
    "-": times(1.001, "kx"),
    "--": times(1.05, "vx"),
}


@pytest.fixture(scope="module")
def dry() -> pandas.DataFrame:
    """A motion with dry friction, which is not the scene's."""
    lines = tt.load_scene("reference").text.splitlines()
    text = "\n".join(line for line in lines if not line.startswith("mu"))
    friction = '[friction]\nlaw = "regularised"\nmu = "0.3"\nepsilon = "0.01"\n'
    scene = parse_scene(f"{text}\n{friction}", "dry", "dry.toml")
    run = tt.integrate(scene, events=())
    return run.frame(*VECTORS[1:], times=[0.005 * i for i in range(174)], numbers="float")


# Of a family one member is in the default run.
ALIKE = (
    "kx, ky hold ky, kx", "Lx, Ly hold Ly, Lx", "kz has the other sign", "the time is in 1/60 s",
    "the time is in minutes", "-", "--", "the velocities are in cm/s",
    "the world is left-handed, or the top spins the other way",
    "the angular momentum is in kg mm^2/s; the velocities are in mm/s",
)  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [more(one) if one in ALIKE else one for one in SPOILT],
)
def test_conventions_of_another_motion_are_named(dry: pandas.DataFrame, text: str) -> None:
    given = SPOILT[text](dry)
    found = check(given, "reference", friction="other")
    assert found.verdict == "fail"
    named = [cause.text for cause in found.causes if cause.kind == "convention"]
    assert named == ([text] if text.strip("-") else [])


@pytest.mark.parametrize("since", [9.0, 0.7])
def test_a_convention_holds_in_all_rows(healthy: Healthy, since: float) -> None:
    """Exchanged columns of a part, longer than what the search looks at, are no convention."""
    rows = healthy("reference", 601, 1.2)[VECTORS]
    right = rows["t"] >= since
    given = rows.assign(
        vx=rows["vx"].where(right, rows["vy"]), vy=rows["vy"].where(right, rows["vx"])
    )
    found = check(given, "reference", friction="other", start="other")
    named = [cause.text for cause in found.causes if cause.kind == "convention"]
    assert found.verdict == "fail"
    assert named == (["vx, vy hold vy, vx"] if since > 2 else [])


def test_another_motion_has_no_convention(dry: pandas.DataFrame) -> None:
    assert check(dry, "reference", friction="other").passed
    assert {cause.kind for cause in check(dry, "reference").causes} <= {"force", "rows"}


@pytest.mark.parametrize("columns", [more(VECTORS), VECTORS[:-2]], ids=["v_A", "no v_A"])
def test_rows_too_far_apart_are_incomplete(healthy: Healthy, columns: list[str]) -> None:
    wide = healthy("reference", 41)[columns]
    assert check(wide, "reference", friction="other").verdict == "incomplete"


@pytest.mark.parametrize("unit", [60, more(1e3)])
def test_rows_of_another_clock_fail_by_kinematics(healthy: Healthy, unit: float) -> None:
    found = check(times(unit, "t")(healthy()[VECTORS]), "reference", friction="other")
    assert [one.name for one in found.failures] == ["kinematics"]
    assert "the time is in" in found["kinematics"].note


@pytest.mark.parametrize("scene", ["upright", more("inverted")])
def test_a_top_that_spins_upright_tells_no_clock(healthy: Healthy, scene: str) -> None:
    wide = healthy(scene, 41)[VECTORS]
    found = check(wide, scene, friction="other")
    assert (found.failures, found.causes) == ((), ())


def test_arrangements_are_those_of_a_cube() -> None:
    assert len(arrangements(3)) == 47
    assert len(arrangements(2)) == 7
    assert OURS.words == []
    assert OURS._replace(k=(-2, 1, 3), v=(2, 1)).words == [
        "kx, ky hold ky, -kx",
        "vx, vy hold vy, vx",
    ]
