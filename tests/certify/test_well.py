"""What holds a motion for ever by its energy, what denies it, and what is said of a run."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction

import flint
import pytest
import sympy
from flint import arb

import tt_precise as tt
from tt_precise.certify import NotProved, well
from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.problem import BALLS
from tt_precise.certify.well import (
    WELL_BITS,
    Outcome,
    _last_state,
    forever,
    outcome_of,
    trapping_region,
)
from tt_precise.golden import store
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, Units
from tt_precise.mechanics.thresholds import least_energy, tumbling_lambda_squared
from tt_precise.scene.scene import InitialState, Scene, load_scene


@pytest.fixture(autouse=True)
def precision() -> Iterator[None]:
    with flint.ctx.workprec(WELL_BITS):
        yield


def states(name: str) -> Callable[[Fraction], NewtonState]:
    """The printed states of a scene, dimensionless, as balls of a unit in their last place."""
    table, units = store.read_files(name).trajectory, Units.of(load_scene(name).body, Balls, ball)
    sizes = {entry: units.of_dimension(STATE_DIMENSIONS[entry]) for entry in NewtonState._fields}
    places = {Fraction(row[0]): row for row in table.rows}

    def state(time: Fraction) -> NewtonState:
        row = dict(zip(table.columns, places[time], strict=True))
        width = 1 + arb(0, 1e-33)
        return NewtonState(*(arb(row[entry]) * width / size for entry, size in sizes.items()))

    return state


def test_what_never_glides_keeps_its_inclination() -> None:
    # the bracket of the proof: B'(theta) - phi_dot R (1 - alpha cos theta)
    theta, alpha, R, I1, I3, Lz, spin = sympy.symbols(
        "theta alpha R I1 I3 Lz omega_3", positive=True
    )
    s, c = sympy.sin(theta), sympy.cos(theta)
    phi_dot = (Lz - I3 * spin * c) / (I1 * s**2)
    B = R * s * (spin + (alpha - c) * phi_dot)
    bracket = sympy.diff(B, theta) - phi_dot * R * (1 - alpha * c)
    assert sympy.simplify(bracket - spin * R * (c + (alpha - c) * I3 / I1)) == 0


def test_the_least_energy_is_stationary_where_the_top_tumbles() -> None:
    body = Parameters(*sympy.symbols("m R alpha I1 I3 g mu", positive=True))
    z, lambda_ = sympy.symbols("z lambda")
    slope = sympy.diff(least_energy(body, z, lambda_), z)
    there = slope.subs(lambda_, sympy.sqrt(tumbling_lambda_squared(body, z)))
    assert sympy.simplify(there) == 0


@pytest.mark.parametrize(
    ("name", "t", "why"),
    [
        *(("reference", too_early, "W") for too_early in ("3", "5", "6")),
        ("tippetopsim", "1", "W"),
        ("just-below-threshold", "60", "W1"),
        ("contact-lost", "1", "W"),
    ],
)
def test_states_without_a_trapping_region(name: str, t: str, why: str) -> None:
    with pytest.raises(NotProved, match=why):
        trapping_region(tt.load_scene(name), Fraction(t), states(name)(Fraction(t)))


@pytest.mark.parametrize(
    ("start", "speed", "why"),
    [
        ({"omega_3": "1/1000"}, None, "W2"),  # its spin may vanish
        ({"omega_3": 20, "nu_x": "0.07", "mu": 30}, None, "W2"),  # so fast the force may vanish
        ({"omega_3": 5, "nu_x": "0.04", "mu": 30}, "0.05", "W5"),  # it glides faster than that
        ({"omega_3": 5, "nu_x": "0.02", "mu": 30}, "0.05", ""),
    ],
)
def test_a_start_near_the_upright_spin(
    start: dict[str, object], speed: str | None, why: str
) -> None:
    scene = tt.load_scene("reference").varied(theta="0.1", theta_dot=0, phi_dot=0, **start)
    there = well._Well(scene, InitialState.of(scene, BALLS).vectors)
    if not why:
        assert there.bounds(arb(speed))[0] > 0
        return
    with pytest.raises(NotProved, match=why):
        there.bounds(None if speed is None else arb(speed))


def test_no_slice_lies_beyond_the_equator(monkeypatch: pytest.MonkeyPatch) -> None:
    """The energy is that of any inclination; with a force that never vanishes W3 denies it."""
    monkeypatch.setattr(well._Well, "_force", lambda self, z, budget, speed: arb(1))
    fast = {"omega_3": 5, "phi_dot": 0, "theta_dot": 300, "nu_x": 3}
    scene = tt.load_scene("reference").varied(theta="0.1", **fast)
    with pytest.raises(NotProved, match="W3"):
        trapping_region(scene, Fraction(0), InitialState.of(scene, BALLS).vectors)


def test_more_energy_than_there_is_is_noticed() -> None:
    # the same state with the contact point gliding at 0.5 m/s
    scene, state = tt.load_scene("reference"), states("reference")(Fraction(7))
    assert trapping_region(scene, Fraction(7), state).force > 0
    gliding = arb("0.5") / Units.of(scene.body, Balls, ball).of_dimension(STATE_DIMENSIONS["vx"])
    with pytest.raises(NotProved, match="W"):
        trapping_region(scene, Fraction(7), state._replace(vx=state.vx + gliding))


def test_the_reference_inverts_for_ever() -> None:
    scene = tt.load_scene("reference")
    found = forever(scene, scene.sample_times, states("reference"))
    first, last = found["held"], found["at_the_end"]
    assert first.pole == last.pole == -1
    assert 6 < first.since < 7 < last.since == 8
    assert 0 < first.force < 0.1
    assert last.force > 0.99
    # heyoka in double, to 16 s: theta against the bounds, D and E~ against their limits
    longer = tt.integrate(replace(scene, until=Fraction(16)))
    frame = longer.frame("theta", "D", "E_tilde", "g_n", numbers="float")
    weight = float(scene.body.m * scene.body.g)
    for one in (first, last):
        after = frame[frame["t"] >= float(one.since)]
        assert (after["theta"] > 3.14159265 - 1.01 * float(one.tilt)).all()
        assert (after["g_n"] >= float(one.force) * weight).all()
        for name in ("D", "E_tilde"):
            begin, end = (abs(after[name].iloc[i] / float(one.limits[name]) - 1) for i in (0, -1))
            assert end < min(1e-4, begin)


@pytest.mark.parametrize("name", ["frictionless", "rolling", "upright", "coulomb-gliding"])
def test_scenes_whose_limit_is_not_proved(name: str) -> None:
    scene = tt.load_scene(name)
    scene = scene.varied(mu="0.3") if scene.model == "rolling" else scene
    with pytest.raises(NotProved, match=r"friction|vertical from|no derivative"):
        forever(scene, [Fraction(0)], states("reference"))


def outcome(scene: str | Scene, precision: str = "double", **how: str) -> Outcome:
    run = integrate(scene, precision, **how)  # type: ignore[arg-type]
    return outcome_of(run, run.inversion.equator)


@pytest.mark.parametrize("how", ["double newton", "double euler", "double-double newton"])
def test_the_reference_top_approaches_the_inverted_spin(how: str) -> None:
    precision, formulation = how.split()
    found = outcome("reference", precision, formulation=formulation)
    assert (found.equator.verdict, found.end.verdict) == ("passed", "inverted")
    assert float(found.equator.t) == pytest.approx(5.87974951858, abs=1e-9)
    assert found.theorem.inverts is True


def test_a_top_in_the_other_direction_does_the_same() -> None:
    assert outcome(load_scene("reference").varied(omega_3="-155")).end.verdict == "inverted"


@pytest.mark.parametrize(
    ("name", "equator", "end", "reason"),
    [
        ("stays-upright", "never", "upright", "confine it"),
        ("below-threshold", "passed", "not_inverted", "too low"),
        ("frictionless", "not_passed", "undecided", "without friction"),
        ("rolling", "not_passed", "undecided", "without friction"),
        ("upright", "not_passed", "undecided", "vertical from the start"),
        ("contact-lost", "not_passed", "undecided", "the motion ended: contact_lost"),
        ("stribeck", "passed", "undecided", "the contact force, or the spin, may vanish"),
        ("coulomb-gliding", "not_passed", "undecided", "coulomb has no derivative"),
        ("elastic-linear", "not_passed", "undecided", "may leave the table"),
    ],
)
def test_equator_and_end_of_each_scene(name: str, equator: str, end: str, reason: str) -> None:
    scene = load_scene(name)
    # of a top that rolls, friction takes no energy
    found = outcome(scene.varied(mu="0.3") if name == "rolling" else scene)
    assert (found.equator.verdict, found.end.verdict) == (equator, end)
    assert reason in found.end.reason


def test_a_top_that_begins_below_the_equator_never_passes_it() -> None:
    assert outcome(load_scene("reference").varied(theta="3", until="4")).equator.verdict == "never"


def test_what_settles_inclined_is_not_inverted() -> None:
    """Just below the threshold: the axis passes the equator and settles at an inclination."""
    scene = load_scene("reference").varied(omega_3="75", until="40", sample_every="1")
    found = outcome(scene)
    assert (found.theorem.verdict, found.equator.verdict) == ("does_not_invert", "passed")
    assert found.end.verdict == "not_inverted"


def test_a_barrier_before_the_inverted_spin_is_named() -> None:
    """The energy is above that of the inverted spin, and below that of a top at 60 deg."""
    body = {"m": "0.015", "R": "0.015", "alpha": "0.1", "I1": "0.32", "g": "9.8"}
    scene = load_scene("reference").varied(**body, omega_3="300", until="1")
    end = outcome(scene).end
    assert end.verdict == "not_inverted"
    assert "theta = 60 deg" in end.reason
    # of a slow top the energy itself is too low
    slow = outcome(load_scene("reference").varied(omega_3="40", until="1")).end
    assert slow.reason == "its energy is too low for the inverted spin"


def test_nothing_is_stated_of_a_state_that_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """The control: with no right digit every end is within the error."""
    run = integrate("reference")
    monkeypatch.setattr(Trajectory, "digits", 0.0)
    assert outcome_of(run, None).end.verdict == "undecided"
    run = integrate("stays-upright")
    assert outcome_of(run, None)[1:] == (("not_passed", None), outcome_of(run, None).end)
    assert outcome_of(run, None).end.verdict == "undecided"


def test_a_component_is_as_wide_as_its_error_and_ten_times_that() -> None:
    """Also the velocity, which has decayed: its error is relative to sqrt(g R)."""
    run = integrate("stays-upright")
    last = _last_state(run)
    assert abs(last.vx) < 1e-3
    assert last.vx.rad() > 9.9 * 10.0 ** -int(run.digits)
