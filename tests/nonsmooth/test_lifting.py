"""Flight and elastic tables."""

import math
import pickle
from fractions import Fraction

import mpmath
import numpy
import pytest
from scipy.integrate import solve_ivp

import tt_precise as tt
from tests.nonsmooth.conftest import edited
from tt_precise import golden
from tt_precise.integration import Trajectory
from tt_precise.mechanics import flight
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.vectors import rotate, rotation
from tt_precise.runtime.values import Array
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene, load_scene

AXIS = ("kx", "ky", "kz")
ELASTIC = ("elastic-linear", "elastic-hunt-crossley")
RECORDED = ("phi", "psi", "x", "y")
POSE = ("qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")


@pytest.fixture(scope="module")
def flown() -> Trajectory:
    return tt.integrate("coulomb-flight", record=RECORDED, events=("theta_min",))


@pytest.fixture(scope="module", params=ELASTIC)
def bounced(request: pytest.FixtureRequest) -> Trajectory:
    return tt.integrate(request.param, events=("theta_min", "theta_max"))


def test_a_top_that_lost_contact_flies_until_it_lands(flown: Trajectory) -> None:
    assert flown.status == "landed"
    gliding, flying = flown.pieces
    assert (gliding.model, gliding.status) == ("gliding", "lift_off")
    assert (flying.model, flying.status) == ("flight", "landed")
    frame = flown.frame("height", "rise", "g_n")
    air = frame["t"] > flying.begin
    assert (frame["height"][~air] == 0).all()
    assert (frame["height"][air][:-1] > 0).all()
    assert abs(frame["height"].iloc[-1]) < 1e-15 > frame["rise"].iloc[-1]
    assert (frame["g_n"][air] == 0).all()
    ended = tt.integrate(edited("coulomb-flight", 'lost = "fly"', 'lost = "end"'), events=())
    assert (ended.status, ended.t_end) == ("contact_lost", gliding.end)


def test_flight_is_its_closed_form(flown: Trajectory) -> None:
    begin = Fraction(flown.pieces[1].begin)
    times = [begin + Fraction(1, 10**12), *(begin + Fraction(k, 1000) for k in (1, 5, 10))]
    rows = flown.frame(*POSE, "z", times=times, numbers="exact").to_dict("records")
    body = flown.scene.body.numbers(float)
    first = RigidBodyState(*(rows[0][name] for name in POSE))
    for row in rows[1:]:
        delay = row["t"] - rows[0]["t"]
        there = flight.fly(body, first, delay, mpmath.fp)
        # 10 ms at 180 rad/s from numbers of 16 digits
        assert [float(x) for x in there] == pytest.approx([row[n] for n in POSE], abs=1e-11)
        z = flight.height(body, rows[0]["z"], first.vcz, delay)
        assert row["z"] == pytest.approx(z, rel=1e-13)


def test_committed_flight_is_its_closed_form_to_30_digits() -> None:
    stored = golden.load("coulomb-flight", "text")
    context = mpmath.MPContext()
    context.dps = 50
    I1 = to_mpmath(load_scene("coulomb-flight").body.I1, context)
    (off,) = stored.events[stored.events["name"] == "lift_off"].to_dict("records")
    t, Lx, Ly, Lz, *k = (context.mpf(off[name]) for name in ("t", "Lx", "Ly", "Lz", *AXIS))
    rows = [row for _, row in stored.iterrows() if float(row["t"]) > t]
    assert len(rows) >= 5
    for row in rows:
        turn = rotation((Lx / I1, Ly / I1, Lz / I1), context.mpf(row["t"]) - t, context)
        for name, value in zip(AXIS, rotate(turn, (k[0], k[1], k[2])), strict=True):
            assert abs(context.mpf(row[name]) - value) < context.mpf(10) ** -30


def test_in_contact_and_in_flight_in_turn(bounced: Trajectory) -> None:
    assert bounced.status == "complete"
    models = [one.model for one in bounced.pieces]
    assert models == ["contact", "flight"] * (len(models) // 2) + ["contact"] * (len(models) % 2)
    assert {one.status for one in bounced.pieces[:-1]} == {"separation", "landing"}
    frame = bounced.frame("height", "rise", "g_n")
    for one in bounced.pieces:
        inside = (frame["t"] > one.begin) & (frame["t"] < one.end)
        pushed = frame["g_n"][inside]
        assert (pushed > 0).all() if one.model == "contact" else (pushed == 0).all()
    assert float(bounced.drift["jellett"]) < 1e-14
    assert pickle.loads(pickle.dumps(bounced)).state == bounced.state


@pytest.mark.parametrize(
    ("force", "stiffness", "depth"),
    [("linear", "1000", 7.11514056e-05), ("hunt-crossley", "1e5", 1.130960243e-4)],
)
def test_a_top_that_touches_an_elastic_table_sinks_into_it(
    force: str, stiffness: str, depth: float
) -> None:
    """The depth lies between those from starts a little deeper and a little higher."""
    pressed = load_scene(f"elastic-{force}").varied(
        stiffness=stiffness, damping="0.2", theta="0.5", phi_dot="0", omega_3="100", nu_y="0",
        mu="0.3", epsilon="0.01", height="0", rise="0", until="0.02", sample_every="0.001",
    )  # fmt: skip
    if force == "hunt-crossley":
        pressed = pressed.varied(damping="0.1")
    runs = [
        tt.integrate(pressed.varied(height=height), events=()) for height in ("0", "-1e-9", "1e-9")
    ]
    heights = [float(run.state.height) for run in runs]
    assert heights[0] == pytest.approx(-depth, rel=1e-8)
    assert min(heights[1:]) < heights[0] < max(heights[1:])
    assert [one.model for one in runs[0].pieces] == ["contact"]


def test_a_flight_from_next_to_nothing_lands() -> None:
    """Free fall of the lowest point: its acceleration is that at the start."""
    scene = load_scene("flight").varied(
        theta="0.01", theta_dot="0", phi_dot="0", omega_3="100", rise="0", height="1e-15"
    )
    for precision in ("double", "quad"):
        run = tt.integrate(scene, events=(), precision=precision)
        assert run.status == "landed"
        # 3e-4 of the weight holds the tilted axis up
        assert float(run.t_end) == pytest.approx(math.sqrt(2e-15 / 9.82), rel=1e-3)
        assert float(run.state.rise) == pytest.approx(-9.82 * float(run.t_end), rel=1e-3)


def test_a_hop_of_half_a_millisecond_lands() -> None:
    hop = edited("reference", "[start]", '[contact]\nlost = "fly"\n[start]').varied(
        theta="1.2", omega_3="100", phi_dot="14.80873035476", until="0.5"
    )
    for chosen in ({}, {"precision": "quad"}, {"formulation": "euler"}, {"tolerance": 1e-10}):
        run = tt.integrate(hop, events=(), **chosen)
        assert run.status == "landed"
        assert float(run.t_end) == pytest.approx(0.236818547372, abs=1e-10)
        # the landing is as slow as the take-off was soft
        assert float(run.state.rise) == pytest.approx(-3.52527e-7, rel=1e-4)


UP = numpy.array([0.0, 0.0, 1.0])


def cross(a: Array, b: Array) -> Array:
    """The cross product, ten times as fast as NumPy's for one pair of vectors."""
    return numpy.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def followed(scene: Scene, first: dict[str, float], damping: float) -> dict[str, float]:
    """The end of a motion on Hunt and Crossley's table by SciPy, in SI and in t.

    From the laws of linear and angular momentum of the centre of mass; contact is where the height
    of the lowest point is negative. Nothing of the package is used but the numbers of the scene.
    """
    m, R, alpha, I1, I3, g, mu = (
        float(getattr(scene.body, name)) for name in ("m", "R", "alpha", "I1", "I3", "g", "mu")
    )
    epsilon, stiffness = (float(scene.body.numbers_by_name[n]) for n in ("epsilon", "stiffness"))

    def moving(k: Array, L: Array) -> tuple[Array, Array]:
        """The angular velocity, and the vector from the centre of mass to the lowest point."""
        return L / I1 + (1 / I3 - 1 / I1) * (L @ k) * k, R * (alpha * k - UP)

    def rates(t: float, y: Array) -> Array:
        k, L = y[:3], y[3:6]
        omega, arm = moving(k, L)
        v = y[6:9] + cross(omega, arm)
        height = y[9] + R * alpha * k[2] - R
        pressure = stiffness * max(-height, 0.0) ** 1.5 * (1 - damping * v[2])
        slide = mu / math.sqrt(v[0] ** 2 + v[1] ** 2 + epsilon**2)
        force = pressure * numpy.array([-slide * v[0], -slide * v[1], 1.0])
        return numpy.concatenate([cross(omega, k), cross(arm, force), force / m - g * UP, y[8:9]])

    k, L, v = (numpy.array([first[n] for n in names]) for names in PARTS)
    omega, arm = moving(k, L)
    centre = first["height"] + R - R * alpha * k[2]
    start = numpy.concatenate([k, L, v - cross(omega, arm), [centre]])
    absolute = 1e-15 * numpy.repeat([1.0, 1e-5, 0.1, 1e-4], [3, 3, 3, 1])
    y = solve_ivp(rates, (0, float(scene.until)), start, "DOP853", rtol=1e-12, atol=absolute).y
    k, L = y[:3, -1], y[3:6, -1]
    omega, arm = moving(k, L)
    v = y[6:9, -1] + cross(omega, arm)
    ends = (*k, *L, *v, y[9, -1] + R * alpha * k[2] - R)
    return dict(zip([*sum(PARTS, ()), "height"], map(float, ends), strict=True))


PARTS = (AXIS, ("Lx", "Ly", "Lz"), ("vx", "vy", "rise"))


def test_a_bounce_on_hunt_and_crossleys_table_is_that_of_a_witness() -> None:
    """Through contact, flight and contact; a damping off by 0.1 % is the control."""
    run = tt.integrate("elastic-hunt-crossley", events=())
    assert [piece.model for piece in run.pieces] == ["contact", "flight", "contact"]
    own = {name: float(value) for name, value in run.state.values.items()}
    first = {name: float(value) for name, value in run.at(0).values.items()}
    distances = []
    for damping in (1.0, 1.001):
        other = followed(run.scene, first, damping)
        distances.append(
            max(
                abs(own[n] - other[n]) / max(abs(own[name]) for name in names)
                for names in (*PARTS, ("height",))
                for n in names
            )
        )
    assert distances[0] < 1e-9 < 1e-5 < distances[1]
