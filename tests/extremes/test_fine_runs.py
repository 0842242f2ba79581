"""The runs in triple-double that cases are held against, beside heyoka's quad that they were."""

from dataclasses import replace

import pytest

from tt_precise.extremes.contact import LOSING, NAMES, _at_both_zeros, blowing_up, losing
from tt_precise.extremes.horizons import there_and_back
from tt_precise.extremes.parameters import FRICTIONS, ROUGH, SHORT_S
from tt_precise.extremes.sensitivity import NUDGE, VARIED, _nudged
from tt_precise.extremes.tops import distance, varied
from tt_precise.integration import integrate
from tt_precise.scene.scene import Scene, load_scene

SCENES = {
    **{f"contact lost, {name}": (losing(name), "unilateral") for name in LOSING},
    **{f"blow-up, {name}": (blowing_up(name), "bilateral") for name in NAMES},
    **{f"0/0 but for 1e-{k}": (_at_both_zeros(k), "unilateral") for k in (3, 5, 7, 9, 12)},
}


@pytest.mark.slow
@pytest.mark.parametrize("which", SCENES)
def test_they_end_as_quad_does(which: str) -> None:
    scene: Scene
    scene, contact = SCENES[which]
    quad, fine, rough = (
        integrate(scene, name, contact=contact, events=())
        for name in ("quad", "triple-double", "double")
    )
    number = fine.precision.context.mpf
    assert fine.status == quad.status
    assert abs(fine.t_end - number(quad.t_end)) < 1e-28
    # a state behind which the force blows up is as uncertain as the square root of the time
    apart = [fine.state.values[n] - number(quad.state.values[n]) for n in ("kx", "ky", "kz")]
    assert max(map(abs, apart)) < 1e-15
    assert abs(fine.t_end - number(rough.t_end)) > 1e-28  # which the first bound would not let pass


SENSITIVE = load_scene("reference").varied(until="3.2")  # about where it is most so
COMPLETE = {
    **{f"mu = {mu}": varied(mu=mu, until=SHORT_S) for mu in dict.fromkeys((*FRICTIONS, *ROUGH))},
    "mu for the slope": varied(mu="1e-5", until=SHORT_S),
    "rolling": replace(varied(until=SHORT_S), model="rolling"),
    **{
        f"{name}, {sign:+}": _nudged(SENSITIVE, name, sign * NUDGE)
        for name in VARIED
        for sign in (1, -1)
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("which", COMPLETE)
def test_they_have_the_states_that_quad_has(which: str) -> None:
    """Of friction from none to stiff, and of the differences that derivatives are held against."""
    quad, fine, rough = (
        integrate(COMPLETE[which], name, events=()) for name in ("quad", "triple-double", "double")
    )
    assert fine.status == quad.status == "complete"
    assert distance(quad, fine) < 1e-29 < distance(rough, fine)


@pytest.mark.slow
def test_eight_seconds_and_back_in_mp() -> None:
    observed = there_and_back("8", "mp")
    assert observed.holds
    # in 200 bits, more than double has in all
    assert float(observed.measured.split("; ")[1].split()[0]) > 20
