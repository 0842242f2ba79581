"""Stick and slip under Coulomb's law."""

import math
from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tests.conftest import Patch, more
from tests.integration.conftest import motion_at
from tests.nonsmooth.conftest import edited, final
from tt_precise import golden
from tt_precise.integration import Trajectory
from tt_precise.mechanics import friction
from tt_precise.mechanics.quantities import Motion
from tt_precise.nonsmooth import lifting, sticking
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import Scene, load_scene

NAME = "coulomb-stick-slip"
FORMS = pytest.mark.parametrize("formulation", ["newton", "euler"])


def scene(**changes: Any) -> Scene:
    return load_scene(NAME).varied(**{"until": "0.06", **changes})


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return tt.integrate(scene(), events=("theta_min", "theta_max"))


@pytest.fixture(scope="module")
def quad() -> Trajectory:
    return tt.integrate(scene(), "quad", events=("theta_min", "theta_max"))


def joints(run: Any) -> list[Any]:
    events = run.events
    with mpmath.workprec(200):
        return [mpmath.mpf(t) for t in events["t"][events["name"].isin(("stick", "slip"))]]


def test_a_top_that_friction_holds_from_the_start_says_so() -> None:
    """But not one whose centre of mass is at rest, nor one that rolls by its model."""
    held = load_scene("reference").varied(friction={"law": "coulomb", "mu": "0.3"}, until="0.05")
    assert "contact point at rest at t = 0, held by friction" in repr(tt.integrate(held))
    by_hand, rolling = held.varied(at_rest="centre of mass"), load_scene("rolling")
    for other in (by_hand, rolling.varied(until="0.05")):
        assert "held" not in repr(tt.integrate(other))


def test_the_top_sticks_once_and_slips_once(trajectory: Trajectory) -> None:
    pieces = trajectory.pieces
    assert [(one.status, one.model) for one in pieces] == [
        ("stick", "gliding"), ("slip", "rolling"), ("complete", "gliding"),
    ]  # fmt: skip
    assert [one.begin for one in pieces[1:]] == [one.end for one in pieces[:-1]]
    assert [float(t) for t in joints(trajectory)] == [one.end for one in pieces[:-1]]
    assert trajectory.at("0.045").vx == 0
    assert trajectory.digits_throughout > 10


@pytest.mark.parametrize("precision", ["double", "double-double", more("quad")])
def test_noise_where_slipping_begins_is_no_extremum(precision: str) -> None:
    """Right after rest rounding hides the direction of the slip, and no extremum."""
    names = ("extremum:g_n", "extremum:tau_x")
    run = tt.integrate(NAME, precision, events=names)
    assert [run.event_counts[name] for name in names] == [8, 5]
    assert run.unresolved == ()


# found 15.8 and 14.5 digits, in quad 32.4 and 32.2: slipping multiplies what sticking leaves
@pytest.mark.parametrize(
    ("run", "digits"), [("trajectory", 14), pytest.param("quad", 32, marks=pytest.mark.slow)]
)
def test_digits_of_the_instants(run: str, digits: int, request: pytest.FixtureRequest) -> None:
    times, true = joints(request.getfixturevalue(run)), joints(golden.load(NAME, "text"))
    with mpmath.workprec(200):
        errors = [abs(a / b - 1) for a, b in zip(times, true, strict=False)]
    assert len(errors) == 2
    assert max(errors) < 10**-digits


@pytest.mark.slow
def test_slipping_begins_on_the_cone_and_the_speed_is_continuous(quad: Trajectory) -> None:
    stick, slip = joints(quad)
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


def test_sticking_in_the_other_form() -> None:
    newton, euler = (
        tt.integrate(scene(), record=("phi", "psi", "x", "y"), events=(), formulation=form)
        for form in ("newton", "euler")
    )
    one, other = newton.frame(), euler.frame()
    for name in one.columns:
        size = max(abs(one[name]).max(), 1e-300)
        # 0.06 s from theta = 0.15; phi_dot is a quotient by sin theta
        assert abs(one[name] - other[name]).max() < 1e-11 * size, name
    poses = [run.frame("qw", "wx").to_numpy() for run in (newton, euler)]
    assert poses[0] == pytest.approx(poses[1], abs=1e-10)


def test_what_is_conserved_and_lost(trajectory: Trajectory) -> None:
    assert float(trajectory.drift["jellett"]) < 1e-14
    frame = trajectory.frame("E", "E_dot")
    energy = frame["E"].to_numpy()
    assert (numpy.diff(energy) <= 1e-13 * energy[0]).all()
    rolling = frame["t"].between(trajectory.pieces[1].begin, trajectory.pieces[1].end, "neither")
    assert rolling.sum() >= 3
    assert numpy.ptp(energy[rolling]) < 1e-13 * energy[0]
    assert (frame["E_dot"][rolling] == 0).all()


def test_at_rest_it_rolls_or_begins_to_glide() -> None:
    rolls = tt.integrate(scene(nu_y="0", mu="0.3"), events=())
    assert [one.model for one in rolls.pieces] == ["rolling"]
    plain = edited(NAME, '"gliding"', '"rolling"', 'nu_y = "0.02"', "")
    for name, value in tt.integrate(plain, until="0.06", events=()).state.values.items():
        assert rolls.state.values[name] == pytest.approx(value, rel=1e-11, abs=1e-15)
    glides = tt.integrate(scene(nu_y="0", mu="0.001", until="0.01"), events=())
    assert glides.pieces[0].model == "gliding"
    assert float(glides.drift["jellett"]) < 1e-14


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
            tt.integrate(scene(nu_y="0", mu="0.001", until="0.01"), events=())


def test_plane_motion_stays_plane_after_a_rest() -> None:
    plane = {"omega_3": "0", "nu_x": "-0.09", "nu_y": "0", "mu": "0.001", "until": "0.2"}
    run = tt.integrate(scene(theta="0.63", **plane), events="all")
    assert not run.frame("vy", "omega_3", "phi_dot").to_numpy()[:, 1:].any()
    # where the top passes the vertical theta is least and its azimuth turns round
    assert [*run.events["name"]].count("stick") == 2
    assert {*run.events["name"]} == {"stick", "theta_min", "theta_max", "nu_x_zero", "nu_crossing"}


@FORMS
def test_events_just_after_slipping_begins(formulation: str) -> None:
    """Quantities that are constant or fall from there on have no extremum; the azimuth goes on."""
    slip, azimuth = 0.0479825367245346, -0.019887

    def aside(q: Motion) -> Scalar:
        return q.k[1] * math.cos(azimuth) - q.k[0] * math.sin(azimuth)

    names = ("extremum:lambda", "extremum:E", "extremum:E_tilde_main", aside)
    events = tt.integrate(scene(), formulation=formulation, events=names).events
    late = events[events["t"] >= slip - 1e-12]
    assert list(late["name"]) == ["slip", "aside", "extremum:E_tilde_main"]


@FORMS
def test_a_start_that_glides_by_less_than_rest_sticks_at_once(formulation: str) -> None:
    start = {"theta": "0.3", "omega_3": "20", "mu": "0.3", "until": "0.01"}
    still, *tiny = (
        tt.integrate(scene(**start, nu_y=nu_y), formulation=formulation, events=())
        for nu_y in ("0", "1e-20", "1e-300", "1e-15")
    )
    assert [one.model for one in still.pieces] == ["rolling"]
    for run in tiny:
        assert run.pieces[-1].model == "rolling"
        assert run.state.theta == pytest.approx(still.state.theta, rel=1e-13)


def test_events_just_after_rest() -> None:
    """Even before the first place at which changes of sign are looked for, and with direction."""

    def gliding(q: Motion) -> Scalar:
        return q.state.vx**2 + q.state.vy**2 - 1e-12

    def resting(q: Motion) -> Scalar:
        return -gliding(q)

    run = tt.integrate(scene(nu_y="0", mu="0.001", until="0.01"), events=(gliding, resting))
    assert list(run.events["direction"]) == [1, -1]
    unit = math.sqrt(run.scene.body.R * run.scene.body.g)
    speed = numpy.hypot(run.events["vx"], run.events["vy"])
    assert list(speed) == pytest.approx([1e-6 * unit] * 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("until", "order", "widths"),
    [("0.046", 1.0, (1e-6, 2.5e-7, 6.25e-8)), ("0.055", 0.8, (1e-5, 1e-6, 1e-7))],
    ids=["sticking", "slipping"],
)
def test_the_regularised_law_tends_to_coulombs(
    until: str, order: float, widths: tuple[float, ...]
) -> None:
    # through sticking the error is the creeping, some epsilon; slipping has v' = t - (epsilon/v)^2,
    # which balances at v ~ epsilon^(4/5), and what is missed then stays
    laws = (f'law = "regularised"\nepsilon = "{width!r}"' for width in widths)
    softened = [edited(NAME, 'law = "coulomb"', law).varied(until=until) for law in laws]
    runs = [final(one, "nu_x", "nu_y") for one in (scene(until=until), *softened)]
    errors = numpy.array([numpy.abs(run - runs[0]).max() for run in runs[1:]])
    orders = numpy.log(errors[:-1] / errors[1:]) / numpy.log(widths[0] / widths[1])
    assert orders == pytest.approx([order, order], abs=0.1)
