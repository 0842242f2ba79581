"""Which scenes the backend takes, in which arithmetic and form, and what it refuses."""

import pytest

import tt_precise as tt
from tests.nonsmooth.conftest import FLIES, edited
from tt_precise.integration.solution import backends
from tt_precise.runtime.cache import SOURCES
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene, shipped


def test_scenes_ask_by_what_they_can_do() -> None:
    """Cached results rest on these modules, to which no import leads."""
    for scene in map(load_scene, shipped()):
        folders = [module.__name__.split(".")[1] for module in backends(scene)]
        assert ("nonsmooth" in folders) == scene.in_pieces, scene.name
        assert {*folders} <= {*SOURCES}


def test_what_cannot_take_these_scenes_says_so() -> None:
    pytest.importorskip("flint", reason="python-flint is not installed")
    from tt_precise.certify.balls import NotProved
    from tt_precise.certify.problem import problem_of

    flies, sticks = edited("contact-lost", *FLIES), load_scene("coulomb-stick-slip")
    with pytest.raises(NotProved, match="flight after contact changes them"):
        problem_of(flies)
    for pulled in (flies, sticks):
        with pytest.raises(InputError, match="got contact bilateral, expected unilateral"):
            tt.integrate(pulled, contact="bilateral")
    with pytest.raises(InputError, match="event: got stick"):
        tt.integrate(sticks, events=("stick",))
    for name in ("flight", "elastic-linear"):
        with pytest.raises(InputError, match=f"got euler for {name}, expected newton"):
            tt.integrate(name, formulation="euler")


def test_a_scene_may_begin_in_flight() -> None:
    tossed = tt.integrate("flight")
    assert (tossed.status, [one.model for one in tossed.pieces]) == ("landed", ["flight"])
    kept = "energy rotational_energy spin vertical_angular_momentum momentum_x angular_momentum_x"
    assert {*kept.split(), "momentum_y", "angular_momentum_y"} <= tossed.drift.keys()
    assert max(float(value) for value in tossed.drift.values()) < 1e-14
    frame = tossed.frame("height", "rise", "g_n")
    assert frame.iloc[0].tolist() == pytest.approx([0, 0.01, 1, 0], rel=1e-15)
    assert tt.integrate(tossed.scene.varied(height="0"), events=()).status == "landed"
    with pytest.raises(InputError, match="got 0 in a flight scene, expected the height"):
        tossed.scene.varied(height="0", rise="0")


@pytest.mark.parametrize(
    "scene", [load_scene("coulomb-flight"), load_scene("coulomb-stick-slip").varied(nu_y="0.06")]
)
def test_euler_angles_and_vectors_agree(scene: Scene) -> None:
    """It glides fast in Euler angles; slow gliding, rolling and flight are in vectors."""
    recorded = scene.varied(until="0.14", record=["phi", "psi", "x", "y"])
    euler, newton = (
        tt.integrate(recorded, "double-double", formulation=form, events=())
        for form in ("euler", "newton")
    )
    assert len(newton.pieces) > 1
    assert [one.model for one in euler.pieces] == [one.model for one in newton.pieces]
    names = [*euler.frame().columns, "qw", "wx"]
    one, other = (run.frame(*names[1:], numbers="exact") for run in (euler, newton))
    apart = [max(abs(one[n] - other[n])) / max(*abs(other[n]), 1e-300) for n in names]
    assert 0 < max(apart) < 1e-27
