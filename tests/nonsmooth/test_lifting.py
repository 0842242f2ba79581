"""Flight and elastic tables."""

import math
from fractions import Fraction
from typing import Any

import numpy
import pytest
from scipy.integrate import solve_ivp

import tt_precise as tt
from benchmarks.witness import witness
from tests.integration.conftest import motion_at
from tests.nonsmooth.conftest import FLIES, edited, orders
from tt_precise.integration import Trajectory
from tt_precise.mechanics import flight
from tt_precise.mechanics.vectors import RigidBodyState
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene, load_scene

ELASTIC = ("elastic-linear", "elastic-hunt-crossley")
POSE = ("qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")


@pytest.fixture(scope="module")
def flown() -> Trajectory:
    return tt.integrate("coulomb-flight", "quad", record=("phi", "psi", "x", "y"), events=())


def test_a_top_that_lost_contact_flies_until_it_lands(flown: Trajectory) -> None:
    gliding, flying = flown.pieces
    assert (gliding.begin, gliding.status) == (0, "lift_off")
    assert (flying.begin, flying.status, flown.status) == (gliding.end, "landed", "landed")
    frame = flown.frame("height", "rise")
    air = frame["t"] > float(flying.begin)
    assert (frame["height"][~air] == 0).all()
    assert (frame["height"][air][:-1] > 0).all()
    assert abs(frame["height"].iloc[-1]) < 1e-15 > frame["rise"].iloc[-1]
    ended = tt.integrate(edited("coulomb-flight", 'lost = "fly"', 'lost = "end"'), "quad")
    assert (ended.status, ended.t_end) == ("contact_lost", gliding.end)


def test_flight_is_its_closed_form(flown: Trajectory) -> None:
    context, begin = flown.precision.context, flown.pieces[1].begin
    times = [begin + context.mpf(k) / 1000 for k in (0.1, 1, 5, 10)]
    rows = flown.frame(*POSE, "z", times=times, numbers="exact").to_dict("records")
    body = flown.scene.body.numbers(lambda number: to_mpmath(number, context))
    first = RigidBodyState(*(rows[0][name] for name in POSE))
    for row in rows[1:]:
        delay = row["t"] - rows[0]["t"]
        there = flight.fly(body, first, delay, context)
        apart = [abs(x - row[name]) for x, name in zip(there, POSE, strict=True)]
        # 10 ms at 180 rad/s from numbers of 34 digits
        assert max(apart) < 1e-29
        z = flight.height(body, rows[0]["z"], first.vcz, delay)
        assert abs(row["z"] - z) < 1e-31


@pytest.mark.parametrize("name", ["coulomb-flight", *ELASTIC])
def test_in_contact_and_in_flight_in_turn(name: str) -> None:
    run = tt.integrate(name, events=())
    statuses = {one.status for one in run.pieces[:-1]}
    assert statuses in ({"lift_off"}, {"separation", "landing"})
    models, frame = [one.model for one in run.pieces], run.frame("g_n")
    assert models == ([models[0], "flight"] * len(models))[: len(models)]
    for one in run.pieces:
        pushed = frame["g_n"][(frame["t"] > one.begin) & (frame["t"] < one.end)]
        assert (pushed == 0).all() if one.model == "flight" else (pushed > 0).all()
    assert run.status == ("complete" if name in ELASTIC else "landed")
    assert name not in ELASTIC or float(run.drift["jellett"]) < 1e-14


@pytest.mark.slow
@pytest.mark.parametrize(("spring", "power"), [("linear", 1.0), ("hunt-crossley", 2 / 3)])
def test_a_stiff_table_is_the_rigid_one(spring: str, power: float) -> None:
    # the depth under a given force is (g_n/k)^(1/n)
    table = f'[contact]\nlaw = "compliant"\nforce = "{spring}"\nstiffness = 1\ndamping = 1\n[start]'
    soft = edited("regularised-1e-2", "[start]", table).varied(until="0.1")
    rigid = load_scene("regularised-1e-2").varied(until="0.1")
    sizes = (64e3, 256e3, 1024e3)
    tables = [
        (k, 2 * math.sqrt(0.006 * k)) if spring == "linear" else (100 * k**1.5, 1) for k in sizes
    ]
    stiff = [soft.varied(stiffness=k, damping=damping) for k, damping in tables]
    found = orders(rigid, stiff, "theta theta_dot nu_x nu_y", 4.0 if spring == "linear" else 8.0)
    assert found == pytest.approx([power, power], abs=0.1)


@pytest.mark.parametrize("name", ELASTIC)
def test_an_elastic_table_may_be_met_at_any_height(name: str) -> None:
    for height, rise, model in (
        ("0.001", "-0.1", "flight"), ("0", "0.1", "flight"), ("0", "-0.1", "contact"),
        ("0", "0", "contact"), ("-0.0001", "5", "flight"), ("-0.0001", "-0.05", "contact"),
    ):  # fmt: skip
        scene = load_scene(name).varied(until="0.002", height=height, rise=rise)
        run = tt.integrate(scene, events=())
        assert run.pieces[0].model == model
        assert float(run.at(0).height) == pytest.approx(float(height), rel=1e-15)
        assert run.state.height < -1e-6 or (height, rise) != ("0", "0")


# from next to nothing the lowest point falls freely; 3e-4 of the weight holds the tilted axis up
TINY = load_scene("flight").varied(
    theta="0.01", theta_dot="0", phi_dot="0", omega_3="100", rise="0", height="1e-15"
)
FALL_S, QUAD = math.sqrt(2e-15 / 9.82), {"precision": "quad"}
# half a millisecond; the landing is as slow as the take-off was soft
HOP = edited("reference", *FLIES).varied(
    theta="1.2", omega_3="100", phi_dot="14.80873035476", until="0.5"
)


@pytest.mark.parametrize(
    ("scene", "chosen", "t_end", "rise"),
    [
        *((TINY, chosen, FALL_S, -9.82 * FALL_S) for chosen in ({}, QUAD)),
        *((HOP, x, 0.236818547372, -3.52527e-7) for x in ({}, QUAD, {"formulation": "euler"})),
    ],
)
def test_a_short_flight_lands(scene: Scene, chosen: Any, t_end: float, rise: float) -> None:
    run = tt.integrate(scene, events=(), **chosen)
    assert run.status == "landed"
    assert float(run.t_end) == pytest.approx(t_end, rel=1e-3 if scene is TINY else 1e-9)
    assert float(run.state.rise) == pytest.approx(rise, rel=1e-3)


def followed(scene: Scene, damping: float) -> Any:
    """Axis, L, velocity of the lowest point and height at the end by SciPy, with m = R = g = 1."""
    height = Fraction(tt.integrate(scene, until=0).state.height)
    other = scene.varied(height=height, rise=0, damping=scene.body.damping * Fraction(damping))
    top, start, until, _ = witness(other, float)
    end = solve_ivp(
        lambda t, y: top.rates(y[:, None])[:, 0],
        (0, until), start, "DOP853", rtol=1e-12, atol=1e-15,
    ).y[:, -1:]  # fmt: skip
    k, L, _, _, v = top.contact(end)
    return numpy.concatenate([k, L, v, end[9:]])[:, 0]


def test_a_bounce_on_hunt_and_crossleys_table_is_that_of_a_witness() -> None:
    """Through contact, flight and contact; a damping off by 0.1 % is the control."""
    run = tt.integrate("elastic-hunt-crossley", events=())
    assert [piece.model for piece in run.pieces] == ["contact", "flight", "contact"]
    s = motion_at(run, run.t_end).state
    own = numpy.array([*s[:6], s.vx, s.vy, s.rise, s.height], dtype=float)
    scale = [*numpy.repeat(abs(own[:9].reshape(3, 3)).max(axis=1), 3), abs(own[9])]
    right, wrong = (max(abs(followed(run.scene, size) - own) / scale) for size in (1.0, 1.001))
    assert right < 1e-9 < 1e-5 < wrong
