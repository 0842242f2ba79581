"""Stick and slip under Coulomb's law, and the steps of slow gliding."""

import math
from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tests.conftest import Patch, more
from tests.integration.conftest import motion_at
from tests.nonsmooth.conftest import edited, orders
from tt_precise import golden
from tt_precise.integration.equations import RIGID_CONTACT, longest_step
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics import friction, rolling
from tt_precise.mechanics.laws import COULOMB
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.nonsmooth import lifting, sticking
from tt_precise.nonsmooth.phases import SLOW_GLIDING, SLOW_SPEED
from tt_precise.nonsmooth.sticking import OnsetSeries
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import InitialState, Scene, load_scene

NAME = "coulomb-stick-slip"


def scene(**changes: Any) -> Scene:
    return load_scene(NAME).varied(**{"until": "0.06", **changes})


LOOSE = scene(nu_y="0", mu="0.001", until="0.01")  # at rest, which friction does not hold


def test_a_top_that_friction_holds_from_the_start_says_so() -> None:
    """But not one whose centre of mass is at rest, nor one that rolls by its model."""
    held = load_scene("reference").varied(friction={"law": "coulomb", "mu": "0.3"}, until="0.05")
    assert "contact point at rest at t = 0, held by friction" in repr(tt.integrate(held))
    by_hand, rolling = held.varied(at_rest="centre of mass"), load_scene("rolling")
    for other in (by_hand, rolling.varied(until="0.05")):
        assert "held" not in repr(tt.integrate(other))


# found 15.8 and 14.5 digits, in quad 32.4 and 32.2: slipping multiplies what sticking leaves
@pytest.mark.parametrize(
    ("precision", "digits"), [("double", 14), pytest.param("quad", 32, marks=pytest.mark.slow)]
)
def test_the_top_sticks_once_and_slips_once(precision: str, digits: int) -> None:
    run = tt.integrate(scene(), precision, events=())
    pieces = run.pieces
    assert [(one.status, one.model) for one in pieces] == [
        ("stick", "gliding"), ("slip", "rolling"), ("complete", "gliding"),
    ]  # fmt: skip
    ends = [one.end for one in pieces[:-1]]
    assert [one.begin for one in pieces[1:]] == ends == [*run.events["t"]]
    true = golden.load(NAME, "text").events
    true = true[true["name"].isin(("stick", "slip"))]
    for end, t in zip(ends, true["t"][:2], strict=True):
        assert abs(end / run.precision.context.mpf(t) - 1) < 10**-digits
    assert run.at("0.045").vx == 0
    assert run.digits_throughout > 10


@pytest.mark.parametrize("precision", ["double", "double-double", more("quad")])
def test_noise_where_slipping_begins_is_no_extremum(precision: str) -> None:
    """Right after rest rounding hides the direction of the slip; the azimuth goes on."""

    def aside(q: Motion) -> Scalar:
        return q.k[1] * math.cos(-0.019887) - q.k[0] * math.sin(-0.019887)

    extrema = [f"extremum:{name}" for name in ("g_n", "tau_x", "lambda", "E", "E_tilde_main")]
    run = tt.integrate(NAME, precision, events=(*extrema, aside))
    assert [run.event_counts[name] for name in extrema] == [8, 5, 0, 0, 7]
    assert run.unresolved == ("extremum:E",)  # constant while it rolls
    names = [*run.events["name"]]
    slip = names.index("slip")
    assert names[slip : slip + 4] == ["slip", "aside", "extremum:E_tilde_main", "extremum:g_n"]


@pytest.mark.slow
def test_slipping_begins_on_the_cone_and_the_speed_is_continuous() -> None:
    quad = tt.integrate(scene(), "quad", events=())
    stick, slip = quad.events["t"]
    times = [stick - 1e-9, stick + 1e-9, slip - 1e-9, slip + 1e-9]
    frame = quad.frame("gliding_speed", "g_n", times=times, numbers="exact")
    before, *held, after = frame["gliding_speed"]
    # v within 1 ns times the acceleration, some 10 m/s^2; after the slip it begins with t^2
    assert held == [0, 0]
    assert 0 < before < 1e-7
    assert 0 < after < 1e-15
    assert abs(frame["g_n"][3] / frame["g_n"][2] - 1) < 1e-6
    motion = motion_at(quad, slip - 1e-12)
    assert motion.rolls
    # 1 ps before: the margin's rate is some 1e3 (m g)^2/s
    assert 0 < friction.cone_margin(motion.body, motion.state) < 1e-8
    fx, fy, _ = motion.force
    vx, vy = motion_at(quad, slip + 1e-6).state[-2:]
    along = -(fx * vx + fy * vy) / (mpmath.hypot(fx, fy) * mpmath.hypot(vx, vy))
    assert along == pytest.approx(1, abs=1e-4)


def test_what_is_conserved_and_lost() -> None:
    trajectory = tt.integrate(scene(), events=())
    assert float(trajectory.drift["jellett"]) < 1e-14
    frame = trajectory.frame("E", "E_dot")
    energy = frame["E"].to_numpy()
    assert (numpy.diff(energy) <= 1e-13 * energy[0]).all()
    rolling = frame["t"].between(trajectory.pieces[1].begin, trajectory.pieces[1].end, "neither")
    assert rolling.sum() >= 3
    assert numpy.ptp(energy[rolling]) < 1e-13 * energy[0]
    assert (frame["E_dot"][rolling] == 0).all()


@pytest.mark.parametrize("nu_y", ["0", "1e-20", "1e-300", "1e-15"])
def test_from_rest_or_next_to_it_a_top_that_friction_holds_rolls(nu_y: str) -> None:
    plain = edited(NAME, '"gliding"', '"rolling"', 'nu_y = "0.02"', "")
    true = tt.integrate(plain, until="0.06", events=()).state.values
    run = tt.integrate(scene(nu_y=nu_y, mu="0.3"), events=())
    assert run.pieces[-1].model == "rolling"
    for name, value in run.state.values.items():
        assert value == pytest.approx(true[name], rel=1e-11, abs=1e-15), name


@pytest.mark.parametrize(("module", "name"), [(sticking, NAME), (lifting, "elastic-hunt-crossley")])
def test_more_changes_than_fit_are_refused(module: Any, name: str, monkeypatch: Patch) -> None:
    count = len(tt.integrate(name, events=()).run.segments)
    monkeypatch.setattr(module, "MOST_SEGMENTS", count)
    assert tt.integrate(name, events=()).status == "complete"
    monkeypatch.setattr(module, "MOST_SEGMENTS", count - 1)
    with pytest.raises(tt.InputError, match=f"got more than {count - 1} changes"):
        tt.integrate(name, events=())


def test_a_rest_from_which_gliding_is_not_determined_is_refused(monkeypatch: Patch) -> None:
    for count in (0, 2):
        monkeypatch.setattr(sticking, "directions_from_rest", lambda *_, n=count: [(1, 0)] * n)
        with pytest.raises(tt.InputError, match=f"got {count} directions in which gliding could"):
            tt.integrate(LOOSE, events=())


def test_plane_motion_stays_plane_after_a_rest() -> None:
    plane = {"omega_3": "0", "nu_x": "-0.09", "nu_y": "0", "mu": "0.001", "until": "0.2"}
    run = tt.integrate(scene(theta="0.63", **plane), events="all")
    assert not run.frame("vy", "omega_3", "phi_dot").to_numpy()[:, 1:].any()
    # where the top passes the vertical theta is least and its azimuth turns round
    assert [*run.events["name"]].count("stick") == 2
    assert {*run.events["name"]} == {"stick", "theta_min", "theta_max", "nu_x_zero", "nu_crossing"}


def test_events_just_after_rest() -> None:
    """Even before the first place at which changes of sign are looked for, and with direction."""

    def gliding(q: Motion) -> Scalar:
        return q.state.vx**2 + q.state.vy**2 - 1e-12

    def resting(q: Motion) -> Scalar:
        return -gliding(q)

    run = tt.integrate(LOOSE, events=(gliding, resting))
    assert run.pieces[0].model == "gliding"
    assert float(run.drift["jellett"]) < 1e-14
    assert list(run.events["direction"]) == [1, -1]
    unit = math.sqrt(run.scene.body.R * run.scene.body.g)
    speed = numpy.hypot(run.events["vx"], run.events["vy"])
    assert list(speed) == pytest.approx([1e-6 * unit] * 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("until", "order", "width", "ratio"), [("0.046", 1.0, 1e-6, 4), ("0.055", 0.8, 1e-5, 10)]
)
def test_the_regularised_law_tends_to_coulombs(
    until: str, order: float, width: float, ratio: int
) -> None:
    # through sticking the error is the creeping, some epsilon; slipping has v' = t - (epsilon/v)^2,
    # which balances at v ~ epsilon^(4/5), and what is missed then stays
    laws = (f'law = "regularised"\nepsilon = "{width / ratio**k!r}"' for k in range(3))
    softened = [edited(NAME, 'law = "coulomb"', law).varied(until=until) for law in laws]
    found = orders(scene(until=until), softened, "nu_x nu_y", ratio)
    assert found == pytest.approx([order, order], abs=0.1)


def test_in_a_time_of_its_own_a_step_is_as_many_times_longer_as_rates_are_smaller() -> None:
    """Without friction: a rate is v times as large, and v is twice the slow speed at most."""
    double = precision_named("double")
    top = InitialState.of(load_scene("frictionless").varied(theta="1e-9"), double.arithmetic)
    plain, own = (
        longest_step(top.body, top.vectors, 20, double, phase)
        for phase in (RIGID_CONTACT, SLOW_GLIDING)
    )
    assert plain is not None
    assert own / plain == pytest.approx(1 / (2 * SLOW_SPEED), rel=1e-12)


mp = mpmath.MPContext()
mp.dps = 60
EPS = mp.mpf("1e-16")
STATE = NewtonState(*map(mp.mpf, ("0.6", "0", "0.8", "0.1", "-0.05", "0.8", "0", "0")))


def body(mu: Any) -> Parameters:
    m, R, alpha, I1, I3, g = map(mp.mpf, (1, 1, "0.3", "0.375", "0.4", 1))
    return Parameters(m, R, alpha, I1, I3, g, mu, friction=COULOMB)


def ratio() -> Any:
    """mu for which the force of rolling is on the cone."""
    x, y, z = rolling.constraint_force(body(mp.mpf(1)), STATE)
    return mp.hypot(x, y) / z


def residual(top: Parameters, series: OnsetSeries, t: Any) -> Any:
    """Return the residual of the series in v_A_dot = the acceleration, at one time."""
    *turning, _, ex, ey = series.at(t, mp)
    rate = friction.along_direction(top, NewtonState(*(*turning, ex, ey)))
    slopes = [mp.diff(lambda s, i=i: series.at(s, mp)[6] * series.at(s, mp)[i], t) for i in (7, 8)]
    return max(abs(slopes[0] - rate.vx), abs(slopes[1] - rate.vy))


def test_on_the_cone_speed_begins_with_the_square_of_time() -> None:
    top = body(ratio())
    assert abs(friction.cone_margin(top, STATE)) < mp.mpf("1e-40")
    e = sticking.direction_on_the_cone(top, STATE, mp)
    series = sticking.onset(top, STATE, e, 16, EPS, mp, on_the_cone=True)
    v = series.coefficients[6]
    assert v[0] == v[1] == 0 != v[2]
    # relative to v, which is v_2 t^2; the last terms bound what is left out
    t = series.until
    assert residual(top, series, t) < EPS * abs(v[2]) * t
    # negative control: one coefficient of the direction off by 1e-6
    series.coefficients[7][1] *= 1 + mp.mpf("1e-6")
    assert residual(top, series, t) > 1000 * EPS * abs(v[2]) * t


def test_outside_the_cone_gliding_begins_at_once_and_within_it_never() -> None:
    top = body(ratio() / 2)
    (e,) = sticking.directions_from_rest(top, STATE, mp)
    series, longer = (
        sticking.onset(top, STATE, e, n, EPS, mp, on_the_cone=False) for n in (16, 32)
    )
    assert series.coefficients[6][1] > 0
    assert residual(top, series, series.until) < EPS
    assert longer.until > series.until  # more terms reach further
    assert sticking.directions_from_rest(body(2 * ratio()), STATE, mp) == []
