"""Flight and elastic tables."""

import math
import pickle
import tomllib
from fractions import Fraction

import mpmath
import numpy
import pytest
from scipy.integrate import solve_ivp

import tt_precise as tt
from tests.nonsmooth.conftest import edited, final
from tt_precise import golden
from tt_precise.integration import Trajectory
from tt_precise.mechanics import flight
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.vectors import rotate, rotation
from tt_precise.runtime.values import Array, InputError
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


def test_euler_angles_and_vectors_fly_alike() -> None:
    """It glides in Euler angles and flies in vectors."""
    newton, euler = (  # double-double compiles the Euler form faster than double
        tt.integrate("coulomb-flight", "double-double", formulation=form).frame(numbers="float")
        for form in ("newton", "euler")
    )
    for column in newton.columns:
        size = max(abs(newton[column]).max(), 1e-300)
        # 0.1 s at 180 rad/s; the end is where the top lands
        assert abs(newton[column] - euler[column])[:-1].max() < 1e-14 * size, column


@pytest.mark.slow
@pytest.mark.parametrize(("spring", "power"), [("linear", 1.0), ("hunt-crossley", 2 / 3)])
def test_a_stiff_table_is_the_rigid_one(spring: str, power: float) -> None:
    # the depth under a given force is (g_n/k)^(1/n)
    tables = tomllib.loads(load_scene("regularised-1e-2").text)
    tables["run"] = {"until": "0.1"}
    names = ("theta", "theta_dot", "nu_x", "nu_y")
    limit = final(Scene.of(**tables), *names)
    errors = []
    for k in (64e3, 256e3, 1024e3):
        stiff = (k, 2 * math.sqrt(0.006 * k)) if spring == "linear" else (100 * k**1.5, 1.0)
        contact = {"force": spring, **dict(zip(("stiffness", "damping"), stiff, strict=True))}
        soft = final(Scene.of(**tables, contact={"law": "compliant", **contact}), *names)
        errors.append(numpy.abs(soft - limit).max())
    ratio = 4.0 if spring == "linear" else 8.0
    orders = numpy.log(numpy.array(errors[:-1]) / errors[1:]) / math.log(ratio)
    assert orders == pytest.approx([power, power], abs=0.1)


@pytest.mark.parametrize(
    ("name", "before", "after", "message"),
    [
        ("elastic-linear", '"linear"', '"wood"', "got 'wood', expected one of: linear, hunt"),
        ("elastic-linear", '"1000"', '"0"', "stiffness: got 0.*, expected a number above 0"),
        ("elastic-linear", 'ing = "0.2"', 'ing = "-1"', "damping: got -1.*, expected .*at least 0"),
        ("coulomb-flight", '"fly"', '"hover"', "lost: got 'hover', expected one of: end, fly"),
        ("coulomb-flight", 'lost = "fly"', 'stiffness = "1"', r"unknown key contact\.stiffness"),
        ("flight", 'height = "0.01"', 'height = "-1"', "start.height: got -1 in a flight scene"),
        ("flight", 'g = "9.82"', 'g = "9.82"\nmu = "0.3"', "got flight with friction or a table"),
        ("flight", "[start]", '[contact]\nlost = "fly"\n[start]', "got flight with friction"),
        (
            "reference",
            "[start]",
            '[start]\nheight = "0.1"',
            "got one of these keys on a rigid table",
        ),
        ("rolling", "[start]", '[start]\nrise = "0.1"', "got one of these keys on a rigid table"),
    ],
)
def test_scene_files_that_are_refused(name: str, before: str, after: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        edited(name, before, after)


@pytest.mark.usefixtures("no_cause")
def test_flight_is_checked_for_all_that_it_conserves() -> None:
    tossed = tt.integrate("flight", record=("phi", "psi"))
    rows = tossed.frame()
    found = tt.check.conservation(rows, "flight")
    assert found.passed
    done = {one.name for one in found.checks if one.verdict == "pass"}
    assert done >= {"rotational_energy", "angular_momentum_x", "momentum_x", "equations", "golden"}
    for column, caught in (("vx", "momentum_x"), ("Lx", "angular_momentum_x"), ("ky", "equations")):
        spoiled = rows.copy()
        spoiled.loc[spoiled.index[5:], column] += 1e-4 * abs(rows[column]).max()
        assert caught in {one.name for one in tt.check.conservation(spoiled, "flight").failures}
    poses = tossed.frame(*POSE)
    assert tt.check.conservation(poses, "flight")["fall"].verdict == "pass"
    lighter = tt.load_scene("flight").varied(g="9.8201")
    failures = tt.check.conservation(poses, lighter).failures
    assert [one.name for one in failures] == ["fall"]
    elsewhere = tt.check.conservation(tt.integrate("rolling").frame(), "rolling")
    assert "angular_momentum_x" not in {one.name for one in elsewhere.checks}


@pytest.mark.parametrize("name", ELASTIC)
def test_an_elastic_table_may_be_met_at_any_height(name: str) -> None:
    def begun(**start: str) -> Trajectory:
        return tt.integrate(load_scene(name).varied(until="0.002", **start), events=())

    places = (("0.001", "-0.1"), ("0", "0.1"), ("0", "-0.1"), ("-0.0001", "5"))
    runs = [begun(height=height, rise=rise) for height, rise in places]
    assert [run.pieces[0].model for run in runs] == ["flight", "flight", "contact", "flight"]
    pressed = begun(height="-0.0001", rise="-0.05")
    assert pressed.pieces[0].model == "contact"
    assert pressed.frame("height").iloc[0]["height"] == pytest.approx(-1e-4, rel=1e-15)


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
