"""Stick and slip in one trajectory: against theory, the other form, wider numbers, limits."""

import pickle
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tt_precise.integration import Trajectory, catalogue
from tt_precise.mechanics import friction
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Scene, load_scene, parse_scene

NAME = "coulomb-stick-slip"
JOINTS = [("stick", "gliding"), ("slip", "rolling")]


def scene(**changes: Any) -> Scene:
    return load_scene(NAME).varied(**{"until": "0.06", **changes})


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return tt.integrate(scene(), events=("theta_min", "theta_max"))


@pytest.fixture(scope="module")
def quad() -> Trajectory:
    return tt.integrate(scene(), "quad", events=("theta_min", "theta_max"))


def joints(run: Trajectory) -> list[Any]:
    events = run.events
    with mpmath.workprec(200):
        return [mpmath.mpf(t) for t in events[events["name"].isin(("stick", "slip"))]["t"]]


def test_the_pieces(trajectory: Trajectory) -> None:
    assert trajectory.status == "complete"
    pieces = trajectory.pieces
    assert [(one.status, one.model) for one in pieces] == [*JOINTS, ("complete", "gliding")]
    assert [one.begin for one in pieces[1:]] == [one.end for one in pieces[:-1]]
    assert [float(t) for t in joints(trajectory)] == [one.end for one in pieces[:-1]]
    counts = trajectory.event_counts
    assert (counts["stick"], counts["slip"]) == (1, 1)
    assert trajectory.suspect_events == ()


@pytest.mark.slow
def test_the_instants_have_the_digits_of_the_arithmetic(
    trajectory: Trajectory, quad: Trajectory
) -> None:
    finer = joints(tt.integrate(scene(), "mp", bits=140, events=()))
    # found 15.8 and 14.5 digits, in quad 32.4 and 32.2: slipping multiplies what sticking leaves
    for run, digits in ((trajectory, 14), (quad, 32)):
        with mpmath.workprec(200):
            errors = [abs(a / b - 1) for a, b in zip(joints(run), finer, strict=True)]
        found = [-float(mpmath.log10(error)) for error in errors]
        print(f"{run.precision.name}: digits of stick and slip {found}")
        assert max(errors) < 10**-digits


@pytest.mark.slow
def test_the_speed_is_zero_while_it_sticks_and_continuous(quad: Trajectory) -> None:
    stick, slip = joints(quad)
    glide, roll = ("gliding_speed", "g_n")
    inside = Fraction(1, 10**9)
    times = [Fraction(float(stick)) + inside, Fraction(float(slip)) - inside]
    frame = quad.frame(glide, roll, times=times)
    assert all(v == 0 for v in frame[glide])
    # at the joints force and state are one: v within 1 ns times the acceleration, some 10 m/s^2
    around = quad.frame(glide, roll, times=[times[0] - 2 * inside, times[1] + 2 * inside])
    assert 0 < around[glide][0] < 1e-7
    assert 0 < around[glide][1] < 1e-15  # v begins with t^2
    assert abs(around[roll][1] / frame[roll][1] - 1) < 1e-6


def test_energy_falls_as_the_law_says(trajectory: Trajectory) -> None:
    # the integral of v_A.F over 30 ms of gliding, by Gauss's rule on 10 intervals
    end, parts = 0.03, 10
    nodes, weights = numpy.polynomial.legendre.leggauss(16)
    places = [(part + (x + 1) / 2) * end / parts for part in range(parts) for x in nodes]
    rates = trajectory.frame("E_dot", times=places)["E_dot"].to_numpy().reshape(parts, -1)
    first, last = trajectory.frame("E", times=[0, end])["E"]
    assert first > last
    assert last - first == pytest.approx(
        (rates @ weights).sum() * end / parts / 2, abs=1e-13 * first
    )


@pytest.mark.slow
def test_slipping_begins_on_the_cone(quad: Trajectory) -> None:
    _, slip = joints(quad)
    before = quad.motion(Fraction(float(slip)) - Fraction(1, 10**12))
    assert before.rolls
    margin = friction.cone_margin(before.body, before.state)
    # 1 ps before: the margin's rate is some 1e3 (m g)^2/s
    assert 0 < margin < 1e-8
    force = before.force
    size = mpmath.hypot(force[0], force[1])
    after = quad.motion(Fraction(float(slip)) + Fraction(1, 10**6))
    v = (after.state.vx, after.state.vy)
    along = -(force[0] * v[0] + force[1] * v[1]) / (size * mpmath.hypot(*v))
    assert along == pytest.approx(1, abs=1e-4)


def test_the_other_form(trajectory: Trajectory) -> None:
    record = ("phi", "psi", "x", "y")
    newton = tt.integrate(scene(), record=record, events=())
    euler = tt.integrate(scene(), record=record, events=(), formulation="euler")
    one, other = newton.frame(), euler.frame()
    for name in one.columns:
        size = max(abs(one[name]).max(), 1e-300)
        # 0.06 s from theta = 0.15; phi_dot is a quotient by sin theta
        assert abs(one[name] - other[name]).max() < 1e-11 * size, name
    assert newton.frame("qw", "wx").to_numpy() == pytest.approx(
        euler.frame("qw", "wx").to_numpy(), abs=1e-10
    )


def test_what_is_conserved_and_lost(trajectory: Trajectory) -> None:
    assert float(trajectory.drift["jellett"]) < 1e-14
    frame = trajectory.frame("E", "E_dot")
    energy = frame["E"].to_numpy()
    assert (numpy.diff(energy) <= 1e-13 * energy[0]).all()
    first, last = (trajectory.pieces[1].begin, trajectory.pieces[1].end)
    rolling = (frame["t"] > first) & (frame["t"] < last)
    assert rolling.sum() >= 3
    assert numpy.ptp(energy[rolling]) < 1e-13 * energy[0]
    assert (frame["E_dot"][rolling] == 0).all()


def test_check_takes_it(trajectory: Trajectory) -> None:
    found = tt.check.conservation(trajectory.frame(), scene())
    assert found.passed
    off = trajectory.frame()
    off.loc[off.index[-5:], "vx"] += 1e-3
    assert not tt.check.conservation(off, scene()).passed


def test_whatever_a_trajectory_does(trajectory: Trajectory) -> None:
    again = pickle.loads(pickle.dumps(trajectory))
    assert again.state == trajectory.state
    text = trajectory.frame("theta", numbers="text")
    assert [float(x) for x in text["theta"]] == pytest.approx(
        list(trajectory.frame("theta")["theta"]), rel=1e-15
    )
    several = trajectory.at(["0.01", "0.045", "0.06"])
    assert several.theta.shape == (3,)
    assert several.vx[1] == 0
    assert trajectory.digits > 11
    assert trajectory.digits_throughout > 10
    assert tt.integrate(scene(until="0.05"), digits=9, events=()).digits_throughout > 9


def test_at_rest_it_rolls_or_begins_to_glide() -> None:
    rolls = tt.integrate(scene(nu_y="0", mu="0.3"), events=())
    assert [one.model for one in rolls.pieces] == ["rolling"]
    model = scene(nu_y="0", mu="0.3")
    plain = parse_scene(
        model.text.replace('"gliding"', '"rolling"').replace('nu_y = "0.02"', ""), "r", "r"
    )
    plain = plain.varied(until="0.06")
    for name, value in tt.integrate(plain, events=()).state.values.items():
        assert rolls.state.values[name] == pytest.approx(value, rel=1e-11, abs=1e-15)
    glides = tt.integrate(scene(nu_y="0", mu="0.001", until="0.01"), events=())
    assert glides.pieces[0].model == "gliding"
    assert glides.frame("vx", numbers="text")["vx"][0] in ("0.0", "-0.0")
    assert float(glides.drift["jellett"]) < 1e-14


def regularised(epsilon: float, until: str) -> Scene:
    law = f'law = "regularised"\nepsilon = "{epsilon!r}"'
    text = load_scene(NAME).text.replace('law = "coulomb"', law)
    return parse_scene(text, "dry", "dry.toml").varied(until=until)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("until", "order", "widths"),
    [("0.046", 1.0, (1e-6, 2.5e-7, 6.25e-8)), ("0.055", 0.8, (1e-5, 1e-6, 1e-7))],
    ids=["sticking", "slipping"],
)
def test_epsilon_to_zero(until: str, order: float, widths: tuple[float, ...]) -> None:
    # through sticking the error is the creeping, some epsilon; slipping has v' = t - (epsilon/v)^2,
    # which balances at v ~ epsilon^(4/5), and what is missed then stays
    def final(of: Scene) -> Any:
        state = tt.integrate(of, events=()).state
        return numpy.array([float(getattr(state, n)) for n in ("nu_x", "nu_y")])

    limit = final(scene(until=until))
    errors = numpy.array([numpy.abs(final(regularised(w, until)) - limit).max() for w in widths])
    orders = numpy.log(errors[:-1] / errors[1:]) / numpy.log(widths[0] / widths[1])
    print(f"orders in epsilon, until {until} s: {orders}, theory {order}")
    assert orders == pytest.approx([order, order], abs=0.1)


def test_what_is_refused() -> None:
    with pytest.raises(InputError, match="got contact bilateral with Coulomb's friction"):
        tt.integrate(scene(), contact="bilateral")
    with pytest.raises(InputError, match="event: got stick, expected no such name"):
        tt.integrate(scene(), events=("stick",))
    assert "stick" not in catalogue("gliding")
    from tt_precise.integration.streaming import Stream

    with pytest.raises(InputError, match="got Coulomb's friction, expected another law"):
        Stream(scene())
