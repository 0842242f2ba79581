"""Flight and elastic tables: closed form, two forms, energy, limits, and what refuses them."""

import math
import pickle
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import mpmath
import numpy
import pytest

import tt_precise as tt
from tt_precise import golden
from tt_precise.integration import Trajectory
from tt_precise.integration.hybrid import _flies
from tt_precise.mechanics import flight
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.runtime.errors import InputError
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene, load_scene, parse_scene

ELASTIC = ("elastic-linear", "elastic-hunt-crossley")
POSE = ("qw", "qx", "qy", "qz", "wx", "wy", "wz", "vcx", "vcy", "vcz")


def text(name: str, **entries: str) -> str:
    found = load_scene(name).text
    for key, value in entries.items():
        lines = (
            f'{key} = "{value}"' if line.startswith(f"{key} =") else line
            for line in found.splitlines()
        )
        found = "\n".join(lines)
    return found


def changed(name: str, **entries: str) -> Scene:
    return parse_scene(text(name, **entries), name, f"{name}.toml")


@pytest.fixture(scope="module")
def flown() -> Trajectory:
    return tt.integrate("coulomb-flight", record=("phi", "psi", "x", "y"), events=("theta_min",))


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
    assert abs(frame["height"].iloc[-1]) < 1e-15
    assert frame["rise"].iloc[-1] < 0
    assert (frame["g_n"][air] == 0).all()
    plain = parse_scene(text("coulomb-flight", lost="end"), "ends", "ends.toml")
    ended = tt.integrate(plain, events=())
    assert (ended.status, ended.t_end) == ("contact_lost", gliding.end)


def test_flight_is_its_closed_form(flown: Trajectory) -> None:
    begin = Fraction(flown.pieces[1].begin)
    times = [begin + Fraction(k, 1000) for k in (1, 5, 10)]
    rows = flown.frame(*POSE, "z", times=[begin + Fraction(1, 10**12), *times]).to_dict("records")
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
    body_of = load_scene("coulomb-flight").body
    context = mpmath.MPContext()
    context.dps = 50
    body = body_of.numbers(lambda x: to_mpmath(x, context))
    events = stored.events
    off = events[events["name"] == "lift_off"].iloc[0]
    L = [context.mpf(off[name]) for name in ("Lx", "Ly", "Lz")]
    k = [context.mpf(off[name]) for name in ("kx", "ky", "kz")]
    rate = context.sqrt(sum(x * x for x in L)) / body.I1
    n = [x / (rate * body.I1) for x in L]
    rows = [row for _, row in stored.iterrows() if float(row["t"]) > float(off["t"])]
    assert len(rows) >= 5
    for row in rows:
        angle = rate * (context.mpf(row["t"]) - context.mpf(off["t"]))
        c, s = context.cos(angle), context.sin(angle)
        along = sum(a * b for a, b in zip(n, k, strict=True))
        turned = [
            c * k[i] + s * (n[i - 2] * k[i - 1] - n[i - 1] * k[i - 2]) + (1 - c) * along * n[i]
            for i in range(3)
        ]
        for name, value in zip(("kx", "ky", "kz"), turned, strict=True):
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


@pytest.mark.parametrize("name", ["coulomb-flight", *ELASTIC])
def test_the_other_form(name: str) -> None:
    newton, euler = (tt.integrate(name, formulation=form).frame() for form in ("newton", "euler"))
    for column in euler.columns:
        size = max(abs(newton[column]).max(), 1e-300)
        # 0.1 s at 180 rad/s; the end is where the top lands
        assert abs(newton[column] - euler[column])[:-1].max() < 1e-10 * size, column


@pytest.mark.slow
@pytest.mark.parametrize(("spring", "power"), [("linear", 1.0), ("hunt-crossley", 2 / 3)])
def test_a_stiff_table_is_the_rigid_one(spring: str, power: float) -> None:
    # the depth under a given force is (g_n/k)^(1/n)
    def final(scene: Scene) -> Any:
        state = tt.integrate(scene, events=()).state
        names = ("theta", "theta_dot", "nu_x", "nu_y")
        return numpy.array([float(getattr(state, n)) for n in names])

    base = load_scene("regularised-1e-2").text.replace('until = "2"', 'until = "0.1"')
    limit = final(parse_scene(base, "rigid", "rigid.toml"))
    hardness = [4.0**k * 1e3 for k in (3, 4, 5)]
    errors = []
    for k in hardness:
        linear = spring == "linear"
        stiffness, damping = (k, 2 * math.sqrt(0.006 * k)) if linear else (100 * k**1.5, 1.0)
        contact = (
            f'\n[contact]\nlaw = "compliant"\nforce = "{spring}"\n'
            f'stiffness = "{stiffness!r}"\ndamping = "{damping!r}"\n'
        )
        errors.append(numpy.abs(final(parse_scene(base + contact, "c", "c.toml")) - limit).max())
    ratio = 4.0 if spring == "linear" else 8.0
    orders = numpy.log(numpy.array(errors[:-1]) / errors[1:]) / math.log(ratio)
    print(f"{spring}: orders in 1/stiffness {orders}, theory {power:.3f}")
    assert orders == pytest.approx([power, power], abs=0.1)


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"force": "wood"}, "contact.force: got 'wood', expected one of: linear, hunt-crossley"),
        ({"stiffness": "0"}, "contact.stiffness: got 0, expected a number above 0"),
        ({"damping": "-1"}, "contact.damping: got -1, expected at least 0"),
    ],
)
def test_refused_tables(entries: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        changed("elastic-linear", **entries)


def test_what_cannot_take_these_scenes_says_so() -> None:
    from tt_precise.integration.streaming import Stream
    from tt_precise.integration.variational import sensitivity
    from tt_precise.sweeps.specification import Specification

    with pytest.raises(InputError, match="got compliant with coulomb friction"):
        parse_scene(
            text("coulomb-flight").replace(
                'lost = "fly"',
                'law = "compliant"\nforce = "linear"\nstiffness = "1"\ndamping = "0"',
            ),
            "c",
            "c",
        )
    with pytest.raises(InputError, match=r"contact\.lost: got 'hover', expected one of: end, fly"):
        changed("coulomb-flight", lost="hover")
    with pytest.raises(InputError, match=r"unknown key contact\.stiffness"):
        parse_scene(text("coulomb-flight").replace('lost = "fly"', 'stiffness = "1"'), "x", "x")
    viscous = load_scene("contact-lost").text + '\n[contact]\nlost = "fly"\n'
    flies = parse_scene(viscous, "flies", "flies.toml")
    for scene in (flies, load_scene("flight")):
        for refused in (Specification, Stream, sensitivity):
            with pytest.raises(InputError, match=f"{scene.name}: got a scene"):
                refused(scene)
    with pytest.raises(InputError, match="got contact bilateral for a scene with flight"):
        tt.integrate(flies, contact="bilateral")


def test_a_scene_may_begin_in_flight() -> None:
    tossed = tt.integrate("flight")
    assert (tossed.status, [one.model for one in tossed.pieces]) == ("landed", ["flight"])
    kept = {"energy", "rotational_energy", "spin", "vertical_angular_momentum", "momentum_x",
            "momentum_y", "angular_momentum_x", "angular_momentum_y"}  # fmt: skip
    assert kept <= tossed.drift.keys()
    assert max(float(value) for value in tossed.drift.values()) < 1e-14
    frame = tossed.frame("height", "rise", "g_n")
    assert frame.iloc[0].tolist() == pytest.approx([0, 0.01, 1, 0], rel=1e-15)
    other = tt.integrate("flight", formulation="euler")
    # 0.24 s at 30 rad/s in double
    assert float(other.t_end) == pytest.approx(float(tossed.t_end), abs=1e-15)
    assert float(other.state.theta) == pytest.approx(float(tossed.state.theta), abs=1e-13)


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

    dropped, pressed, pulled = (
        begun(height="0.001", rise="-0.1"), begun(height="-0.0001", rise="-0.05"),
        begun(height="-0.0001", rise="5"),
    )  # fmt: skip
    models = [trajectory.pieces[0].model for trajectory in (dropped, pressed, pulled)]
    assert models == ["flight", "contact", "flight"]
    assert pressed.frame("height").iloc[0]["height"] == pytest.approx(-1e-4, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "changed_to", "message"),
    [
        ("flight", ('height = "0.01"', 'height = "-1"'), "start.height: got -1 in a flight scene"),
        ("flight", ('g = "9.82"', 'g = "9.82"\nmu = "0.3"'), "got flight with friction or a table"),
        ("flight", ("[start]", '[contact]\nlost = "fly"\n[start]'), "got flight with friction"),
        ("reference", ('omega_3 = "155"', 'omega_3 = "155"\nheight = "0.1"'),
         "got one of them on a rigid table"),
        ("rolling", ('omega_3 = "155"', 'omega_3 = "155"\nrise = "0.1"'),
         "got one of them on a rigid table"),
    ],
)  # fmt: skip
def test_heights_that_are_refused(name: str, changed_to: tuple[str, str], message: str) -> None:
    before = load_scene(name).text
    assert changed_to[0] in before
    with pytest.raises(InputError, match=message):
        parse_scene(before.replace(changed_to[0], changed_to[1], 1), name, f"{name}.toml")


def test_a_flight_begins_above_the_table_or_leaves_it() -> None:
    scene = load_scene("flight")
    assert tt.integrate(scene.varied(height="0"), events=()).status == "landed"
    with pytest.raises(InputError, match="got 0 in a flight scene, expected the height"):
        scene.varied(height="0", rise="0")


@pytest.mark.parametrize(
    ("height", "rise", "flies"),
    [(1, -1, True), (0, 1, True), (0, 0, True), (0, -1, False), (-1, 0, False)],
)
def test_what_leaves_or_stands_off_the_table_flies(height: int, rise: int, flies: bool) -> None:
    """At the table's height it is pressed in only where it comes down."""
    body = load_scene("elastic-linear").body.numbers(float)
    here: Any = SimpleNamespace(body=body, vectors=SimpleNamespace(height=height, rise=rise))
    assert _flies(here) == flies


def test_proofs_refuse_flight() -> None:
    pytest.importorskip("flint", reason="python-flint is not installed")
    from tt_precise.certify.problem import problem_of
    from tt_precise.certify.verdict import NotProved

    viscous = load_scene("contact-lost").text + '\n[contact]\nlost = "fly"\n'
    with pytest.raises(NotProved, match="flight and elastic tables change them on the way"):
        problem_of(parse_scene(viscous, "flies", "flies.toml"))
