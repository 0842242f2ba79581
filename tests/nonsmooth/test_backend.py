"""Motions in several segments: stick and slip, flight, elastic tables."""

import math
import pickle
import tomllib
from fractions import Fraction
from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tt_precise import golden
from tt_precise.integration import Trajectory
from tt_precise.mechanics import flight, friction
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import rotation, turned
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene, load_scene, parse_scene

AXIS = ("kx", "ky", "kz")
ELASTIC = ("elastic-linear", "elastic-hunt-crossley")
RECORDED = ("phi", "psi", "x", "y")
POSE = ("qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")


def edited(name: str, before: str, after: str) -> Scene:
    """A shipped scene with one place of its file changed."""
    text = load_scene(name).text
    assert before in text
    return parse_scene(text.replace(before, after, 1), name, f"{name}.toml")


def final(scene: Scene, *names: str) -> Any:
    state = tt.integrate(scene, events=()).state
    return numpy.array([float(getattr(state, name)) for name in names])


@pytest.fixture(scope="module")
def flies() -> Scene:
    return edited("contact-lost", "[start]", '[contact]\nlost = "fly"\n[start]')


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
        there = flight.flown(body, first, delay, mpmath.fp)
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
        for name, value in zip(AXIS, turned(turn, (k[0], k[1], k[2])), strict=True):
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
    assert bounced.suspect_events == ()
    assert float(bounced.drift["jellett"]) < 1e-14
    assert pickle.loads(pickle.dumps(bounced)).state == bounced.state


def test_the_other_form() -> None:
    """It glides in Euler angles and flies in vectors."""
    newton, euler = (  # extended compiles the Euler form in a fiftieth of the time of double
        tt.integrate("coulomb-flight", "extended", formulation=form).frame(numbers="float")
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
        ("elastic-linear", 'ing = "0.2"', 'ing = "-1"', "damping: got -1.*, expected at least 0"),
        ("coulomb-flight", '"fly"', '"hover"', "lost: got 'hover', expected one of: end, fly"),
        ("coulomb-flight", 'lost = "fly"', 'stiffness = "1"', r"unknown key contact\.stiffness"),
        ("flight", 'height = "0.01"', 'height = "-1"', "start.height: got -1 in a flight scene"),
        ("flight", 'g = "9.82"', 'g = "9.82"\nmu = "0.3"', "got flight with friction or a table"),
        ("flight", "[start]", '[contact]\nlost = "fly"\n[start]', "got flight with friction"),
        ("reference", "[start]", '[start]\nheight = "0.1"', "got one of them on a rigid table"),
        ("rolling", "[start]", '[start]\nrise = "0.1"', "got one of them on a rigid table"),
    ],
)
def test_scene_files_that_are_refused(name: str, before: str, after: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        edited(name, before, after)


def test_what_cannot_take_these_scenes_says_so(flies: Scene) -> None:
    pytest.importorskip("flint", reason="python-flint is not installed")
    from tt_precise.certify.balls import NotProved
    from tt_precise.certify.problem import problem_of
    from tt_precise.integration.variational import sensitivity

    with pytest.raises(NotProved, match="flight after contact changes them"):
        problem_of(flies)
    for lifting in (flies, load_scene("flight")):
        with pytest.raises(InputError, match=f"{lifting.name}: got a scene"):
            sensitivity(lifting)
    for pulled, said in ((flies, "for a scene with flight"), (scene(), "with Coulomb's friction")):
        with pytest.raises(InputError, match=f"got contact bilateral {said}"):
            tt.integrate(pulled, contact="bilateral")
    with pytest.raises(InputError, match="event: got stick, expected no such name"):
        tt.integrate(scene(), events=("stick",))
    glides, flown = tt.integrate(flies).pieces
    assert (glides.begin, flown.begin, flown.model) == (0, glides.end, "flight")


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
    ("name", "motion"), [("flight", "a flight"), ("elastic-linear", "an elastic table")]
)
def test_euler_angles_are_for_tops_that_touch_a_rigid_table(name: str, motion: str) -> None:
    with pytest.raises(InputError, match=f"got euler for {name}, expected newton for {motion}"):
        tt.integrate(name, formulation="euler")


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


def joints(run: Any) -> list[Any]:
    events = run.events
    with mpmath.workprec(200):
        return [mpmath.mpf(t) for t in events["t"][events["name"].isin(("stick", "slip"))]]


def test_the_pieces(trajectory: Trajectory) -> None:
    assert trajectory.status == "complete"
    pieces = trajectory.pieces
    assert [(one.status, one.model) for one in pieces] == [*JOINTS, ("complete", "gliding")]
    assert [one.begin for one in pieces[1:]] == [one.end for one in pieces[:-1]]
    assert [float(t) for t in joints(trajectory)] == [one.end for one in pieces[:-1]]
    counts = trajectory.event_counts
    assert (counts["stick"], counts["slip"]) == (1, 1)
    assert trajectory.suspect_events == ()


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
def test_the_speed_is_zero_while_it_sticks_and_continuous(quad: Trajectory) -> None:
    stick, slip = (Fraction(float(t)) for t in joints(quad))
    aside = Fraction(1, 10**9)
    times = [stick - aside, stick + aside, slip - aside, slip + aside]
    frame = quad.frame("gliding_speed", "g_n", times=times, numbers="exact")
    before, *sticking, after = frame["gliding_speed"]
    assert sticking == [0, 0]
    # at the joints force and state are one: v within 1 ns times the acceleration, some 10 m/s^2
    assert 0 < before < 1e-7
    assert 0 < after < 1e-15  # v begins with t^2
    assert abs(frame["g_n"][3] / frame["g_n"][2] - 1) < 1e-6


@pytest.mark.slow
def test_slipping_begins_on_the_cone(quad: Trajectory) -> None:
    _, slip = joints(quad)
    before = quad.motion(Fraction(float(slip)) - Fraction(1, 10**12))
    assert before.rolls
    margin = friction.cone_margin(before.body, before.state)
    # 1 ps before: the margin's rate is some 1e3 (m g)^2/s
    assert 0 < margin < 1e-8
    fx, fy, _ = before.force
    vx, vy = quad.motion(Fraction(float(slip)) + Fraction(1, 10**6)).state[-2:]
    along = -(fx * vx + fy * vy) / (mpmath.hypot(fx, fy) * mpmath.hypot(vx, vy))
    assert along == pytest.approx(1, abs=1e-4)


def test_sticking_in_the_other_form(trajectory: Trajectory) -> None:
    newton, euler = (
        tt.integrate(scene(), record=RECORDED, events=(), formulation=form)
        for form in ("newton", "euler")
    )
    slip = float(joints(newton)[1])
    near = newton.frame("phi", "phi_dot", times=[slip, slip + 1e-6])
    assert numpy.ptp(near["phi"]) == pytest.approx(1e-6 * abs(near["phi_dot"][0]), rel=1e-3)
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


def test_whatever_a_trajectory_does(trajectory: Trajectory) -> None:
    again = pickle.loads(pickle.dumps(trajectory))
    assert again.state == trajectory.state
    several = trajectory.at(["0.01", "0.045", "0.06"])
    assert several.theta.shape == (3,)
    assert several.vx[1] == 0
    assert trajectory.digits > 11
    assert trajectory.digits_throughout > 10
    assert tt.integrate(scene(until="0.05"), digits=9, events=()).digits_throughout > 9


def test_at_rest_it_rolls_or_begins_to_glide() -> None:
    rolls = tt.integrate(scene(nu_y="0", mu="0.3"), events=())
    assert [one.model for one in rolls.pieces] == ["rolling"]
    text = rolls.scene.text.replace('"gliding"', '"rolling"').replace('nu_y = "0.02"', "")
    plain = parse_scene(text, "r", "r")
    for name, value in tt.integrate(plain, until="0.06", events=()).state.values.items():
        assert rolls.state.values[name] == pytest.approx(value, rel=1e-11, abs=1e-15)
    glides = tt.integrate(scene(nu_y="0", mu="0.001", until="0.01"), events=())
    assert glides.pieces[0].model == "gliding"
    assert glides.frame("vx", numbers="text")["vx"][0] in ("0.0", "-0.0")
    assert float(glides.drift["jellett"]) < 1e-14


def test_plane_motion_stays_plane_after_a_rest() -> None:
    plane = {"omega_3": "0", "nu_x": "-0.09", "nu_y": "0", "mu": "0.001", "until": "0.2"}
    run = tt.integrate(scene(theta="0.63", **plane), events="all")
    assert not run.frame("vy", "omega_3", "phi_dot")[["vy", "omega_3", "phi_dot"]].any(axis=None)
    # where the top passes the vertical theta is least and its azimuth turns round
    assert [*run.events["name"]].count("stick") == 2
    assert {*run.events["name"]} == {"stick", "theta_min", "theta_max", "nu_x_zero", "nu_crossing"}


@pytest.mark.parametrize("formulation", ["newton", "euler"])
def test_events_just_after_slipping_begins(formulation: str) -> None:
    """What is constant, or falls from there on, has no extremum; the azimuth goes on from there."""
    slip, azimuth = 0.0479825367245346, -0.019887

    def aside(q: Motion) -> Scalar:
        return q.k[1] * math.cos(azimuth) - q.k[0] * math.sin(azimuth)

    names = ("extremum:lambda", "extremum:E", "extremum:E_tilde_main", aside)
    events = tt.integrate(scene(), formulation=formulation, events=names).events
    late = events[events["t"] >= slip - 1e-12]
    assert list(late["name"]) == ["slip", "aside", "extremum:E_tilde_main"]


@pytest.mark.parametrize("formulation", ["newton", "euler"])
def test_a_start_that_glides_by_less_than_rest_sticks_at_once(formulation: str) -> None:
    still, *tiny = (
        tt.integrate(
            scene(theta="0.3", omega_3="20", mu="0.3", nu_y=nu_y, until="0.01"),
            formulation=formulation, events=(),
        )
        for nu_y in ("0", "1e-20", "1e-300", "1e-15")
    )  # fmt: skip
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
def test_epsilon_to_zero(until: str, order: float, widths: tuple[float, ...]) -> None:
    # through sticking the error is the creeping, some epsilon; slipping has v' = t - (epsilon/v)^2,
    # which balances at v ~ epsilon^(4/5), and what is missed then stays
    laws = (f'law = "regularised"\nepsilon = "{width!r}"' for width in widths)
    softened = [edited(NAME, 'law = "coulomb"', law).varied(until=until) for law in laws]
    runs = [final(one, "nu_x", "nu_y") for one in (scene(until=until), *softened)]
    errors = numpy.array([numpy.abs(run - runs[0]).max() for run in runs[1:]])
    orders = numpy.log(errors[:-1] / errors[1:]) / numpy.log(widths[0] / widths[1])
    assert orders == pytest.approx([order, order], abs=0.1)
