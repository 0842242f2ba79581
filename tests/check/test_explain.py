"""Causes of failures: conventions, one number, precision; nothing where none explains."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy
import pandas
import pytest

import tt_precise as tt
from tests.check.conftest import EULER, VECTORS, Engine, Healthy, check
from tests.check.test_cases import CASES
from tests.check.test_force_free import POSE
from tests.conftest import more, of_each_kind
from tt_precise.check.columns import COLUMN_SETS, CheckSetup
from tt_precise.check.explain import FailedFile, _force, _precision
from tt_precise.check.sources import open_source
from tt_precise.golden import store
from tt_precise.runtime.values import Check, Verdict
from tt_precise.scene.scene import Scene, parse_scene

RATES = ["theta_dot", "phi_dot", "omega_3"]
DEGREE = 180 / numpy.pi


def scaled(frame: pandas.DataFrame, factor: float, *names: str) -> pandas.DataFrame:
    return frame.assign(**{name: factor * frame[name] for name in names})


def causes(
    frame: pandas.DataFrame, scene: str | Scene = "reference", friction: str = "scene"
) -> str:
    """The causes of a file that does not pass, in one line."""
    found = check(frame, scene, friction=friction)
    assert found.verdict != "pass"
    return " | ".join(f"{cause.kind}: {cause.text}" for cause in found.causes)


# With the scene's friction each convention is also judged under its equations, which takes longer.
SLOW_IN_SCENE = [pytest.param("scene", marks=pytest.mark.slow), "other"]


@pytest.mark.parametrize("rows", [201, pytest.param(1001, marks=pytest.mark.slow)])
@pytest.mark.parametrize(
    ("columns", "factor", "names", "convention"),
    [
        more(VECTORS, 1e3, ["t"], "the time is in ms"),
        (EULER, 1e3, ["t"], "the time is in ms"),
        more(EULER, DEGREE, RATES, "the angular velocities are in degrees per second"),
        (EULER, 1 / (2 * numpy.pi), RATES, "the angular velocities are in revolutions per second"),
        (EULER, DEGREE, ["theta"], "theta is in degrees"),
        (VECTORS, 1e6, ["Lx", "Ly", "Lz"], "the angular momentum is in kg mm^2/s"),
        more(VECTORS, 1e3, ["vx", "vy"], "the velocities are in mm/s"),
    ],
)
def test_other_units_are_named(
    healthy: Healthy,
    rows: int,
    columns: list[str],
    factor: float,
    names: list[str],
    convention: str,
) -> None:
    frame = healthy("reference", rows, 2)[columns]
    assert causes(scaled(frame, factor, *names)) == f"convention: {convention}"


@pytest.mark.parametrize(("until", "named"), [(9.0, True), (0.7, False)])
def test_a_unit_of_angles_holds_in_all_rows(healthy: Healthy, until: float, named: bool) -> None:
    frame = healthy("reference", 401, 0.8)[EULER]
    given = frame.assign(theta=frame["theta"].where(frame["t"] > until, DEGREE * frame["theta"]))
    found = check(given, "reference", friction="other", start="other")
    assert found.verdict == "fail"
    assert ("theta is in degrees" in str(found.causes)) == named


def turn(frame: pandas.DataFrame, vectors: numpy.ndarray, sign: int) -> numpy.ndarray:
    """Vectors turned by each row's quaternion, or by its inverse (``sign`` -1)."""
    q = sign * frame[["qx", "qy", "qz"]].to_numpy()
    half = numpy.cross(q, vectors)
    return vectors + 2 * frame[["qw"]].to_numpy() * half + 2 * numpy.cross(q, half)


def body_frame(frame: pandas.DataFrame) -> pandas.DataFrame:
    return with_vectors(frame, OMEGA, turn(frame, frame[OMEGA].to_numpy(), -1))


def with_vectors(
    frame: pandas.DataFrame, names: list[str], vectors: numpy.ndarray
) -> pandas.DataFrame:
    return frame.assign(**dict(zip(names, vectors.T, strict=True)))


def scalar_last(frame: pandas.DataFrame) -> pandas.DataFrame:
    return frame.assign(qw=frame.qx, qx=frame.qy, qy=frame.qz, qz=frame.qw)


def inverse(frame: pandas.DataFrame) -> pandas.DataFrame:
    return scaled(frame, -1, "qx", "qy", "qz")


def centre_of_the_sphere(frame: pandas.DataFrame) -> pandas.DataFrame:
    lever = numpy.broadcast_to([0, 0, 0.3 * 0.02], (len(frame), 3))
    moved = numpy.cross(frame[OMEGA].to_numpy(), turn(frame, lever, 1))
    return with_vectors(frame, CENTRE, frame[CENTRE].to_numpy() + moved)


def y_up(frame: pandas.DataFrame) -> pandas.DataFrame:
    half = numpy.sqrt(0.5)
    w, x, y, z = (frame[name] for name in ("qw", "qx", "qy", "qz"))
    return frame.assign(
        qw=half * (w + x),
        qx=half * (x - w),
        qy=half * (y + z),
        qz=half * (z - y),
        wy=frame.wz,
        wz=-frame.wy,
        vcy=frame.vcz,
        vcz=-frame.vcy,
    )


OMEGA, CENTRE = ["wx", "wy", "wz"], ["vcx", "vcy", "vcz"]
CONVENTIONS: dict[str, Callable[[pandas.DataFrame], pandas.DataFrame]] = {
    "the angular velocity is in the body frame": body_frame,
    "the quaternion has its scalar last": scalar_last,
    "the quaternion is the inverse one, from the inertial to the body frame": inverse,
    "the angular velocity has the other sign": lambda f: scaled(f, -1, *OMEGA),
    "the angular velocity is in degrees per second": lambda f: scaled(f, DEGREE, *OMEGA),
    "the angular velocity is in revolutions per minute": (
        lambda f: scaled(f, 30 / numpy.pi, *OMEGA)
    ),
    "the time is in ms": lambda f: scaled(f, 1e3, "t"),
    "the time is in microseconds": lambda f: scaled(f, 1e6, "t"),
    "the time is in ns": lambda f: scaled(f, 1e9, "t"),
    "the time is in minutes": lambda f: scaled(f, 1 / 60, "t"),
    'the world is y up: add world="y-up"': y_up,
    "the velocity is that of the sphere's centre": centre_of_the_sphere,
    "lengths are in mm": lambda f: scaled(f, 1e3, *CENTRE),
    "lengths are in cm": lambda f: scaled(f, 1e2, *CENTRE),
    "the quaternion has its scalar last; the angular velocity is in the body frame": (
        lambda f: scalar_last(body_frame(f))
    ),
}


# Of a family of units one member is in the default run.
MORE_UNITS = (
    "the angular velocity is in revolutions per minute", "the time is in microseconds",
    "the time is in ns", "the time is in minutes", "lengths are in cm",
)  # fmt: skip


# The last convention has both of these.
PARTS = (
    "the angular velocity is in the body frame", "the quaternion has its scalar last",
    "the angular velocity has the other sign", "lengths are in mm", "the time is in ms",
    "the angular velocity is in degrees per second",
)  # fmt: skip
WITH_VELOCITY = ("the world", "the velocity", "lengths")  # beginnings of what has no other
COMBINED = "the quaternion has its scalar last; the angular velocity is in the body frame"


@pytest.mark.parametrize("friction", SLOW_IN_SCENE)
@pytest.mark.parametrize(
    ("convention", "velocity"),
    [
        pytest.param(
            one, velocity,
            marks=[pytest.mark.slow] * (one in MORE_UNITS or (not velocity and one != COMBINED))
            or [pytest.mark.evidence] * (one in PARTS or (velocity and one == COMBINED)),
        )
        for one in CONVENTIONS
        for velocity in (True, False)
        if velocity or not one.startswith(WITH_VELOCITY)
    ],
)  # fmt: skip
def test_other_conventions_are_named(
    healthy: Healthy, rigid_body: Healthy, convention: str, velocity: bool, friction: str
) -> None:
    given = CONVENTIONS[convention](rigid_body(healthy("reference", 801)))
    if not velocity:
        given = given.drop(columns=CENTRE)
    assert causes(given, friction=friction) == f"convention: {convention}"


@pytest.mark.parametrize("friction", SLOW_IN_SCENE)
@pytest.mark.parametrize("columns", [VECTORS, more(EULER), more("rigid body")])
# finely resolved, and as sampled
@pytest.mark.parametrize(("rows", "until", "rate"), [more(201, 0.4, 500), (401, 4, 100)])
def test_rows_that_are_counted_instead_of_timed_are_named(
    healthy: Healthy,
    rigid_body: Healthy,
    rows: int,
    until: float,
    rate: int,
    columns: Any,
    friction: str,
) -> None:
    frame = healthy("reference", rows, until)
    given = rigid_body(frame) if columns == "rigid body" else frame[columns]
    found = causes(given.assign(t=numpy.arange(float(rows))), friction=friction)
    # inclination alone does not tell the rates of coarse rows apart
    likely = friction == "other" and "theta" in given and rate == 100
    assert found.split(", or ")[0] == f"convention: t counts rows at {rate} Hz"
    assert likely or ", or" not in found


def test_a_convention_is_named_under_a_force_that_is_not_the_scenes(engine: Engine) -> None:
    found = causes(body_frame(engine(500, 0.1, law="regularised")))
    assert found == "convention: the angular velocity is in the body frame"


@pytest.mark.evidence
def test_another_force_does_not_hide_a_convention() -> None:
    """A top with dry friction, checked as if it were the reference's."""
    lines = tt.load_scene("reference").text.splitlines()
    text = "\n".join(line for line in lines if not line.startswith("mu"))
    dry = '[friction]\nlaw = "regularised"\nmu = "0.3"\nepsilon = "0.01"\n'
    scene = parse_scene(f"{text}\n{dry}", "dry", "dry.toml")
    run = tt.integrate(scene, events=(), record=("phi", "psi", "x", "y"))
    mine = run.frame(*POSE, times=[0.005 * i for i in range(170)], numbers="float")
    for friction in ("scene", "other"):
        found = causes(body_frame(mine), friction=friction)
        assert found == "convention: the angular velocity is in the body frame"


@pytest.mark.parametrize(
    ("columns", "changed", "cause"),
    [
        more("state", {"I3": "8/25"}, "parameter: I3 is 1.25 times the scene's"),
        more("rigid body", {"alpha": "0.5"}, "parameter: alpha is 0.60 times the scene's"),
    ],
)
def test_another_body_is_named(
    healthy: Healthy, rigid_body: Healthy, columns: str, changed: dict[str, str], cause: str
) -> None:
    rows = healthy("reference", 201, 2)
    given = rigid_body(rows) if columns == "rigid body" else rows
    assert causes(given, tt.load_scene("reference").varied(**changed)) == cause


@pytest.mark.parametrize(
    ("changed", "cause"),
    [
        ({"omega_3": "155.155"}, "start: omega starts at 1.00100 times the scene's"),
        ({"omega_3": "155.155", "mu": "0.33"}, "parameter: mu is 1.100 times the scene's"),
        ({"omega_3": "155.155", "theta": "0.101"}, ""),
    ],
)
def test_another_spin_at_the_start_is_named_alone(changed: dict[str, str], cause: str) -> None:
    scene = tt.load_scene("reference").varied(until="0.3", **changed)
    assert causes(tt.integrate(scene).frame(*VECTORS[1:])) == cause


ROUNDED = (
    "precision: the numbers are rounded (kx ky kz Lx Ly Lz vx vy: {} decimals): write 17 digits"
)


@pytest.mark.parametrize(
    ("hertz", "decimals", "unit", "changed", "cause"),
    [
        (500, 5, 1, {}, ROUNDED.format(5)),
        more(500, 6, 1, {}, ROUNDED.format(6)),
        # what has a bound that contains the rounding fails for another reason
        (500, 9, 1, {"mu": "0.33"}, "parameter: mu is 1.10 times the scene's"),
        more(500, 6, 1, {"I3": "0.48"}, ""),
        # and what is open for the spacing of the rows is open for another reason
        more(500, 9, 1000, {}, "convention: the time is in ms"),
        (5, 9, 1, {}, ""),
    ],
)
def test_rounding_is_named_where_it_alone_is_in_the_way(
    hertz: int, decimals: int, unit: int, changed: dict[str, str], cause: str
) -> None:
    until = "1" if hertz == 500 else "2"
    scene = tt.load_scene("reference").varied(until=until, sample_every=f"1/{hertz}", **changed)
    frame = scaled(tt.integrate(scene).frame(*VECTORS[1:]), unit, "t")
    frame[VECTORS[1:]] = frame[VECTORS[1:]].round(decimals)
    assert causes(frame, friction="other" if hertz == 5 else "scene") == cause


def test_a_length_that_no_rounding_explains_is_not_rounded(healthy: Healthy) -> None:
    rows = healthy("reference", 201, 0.4)[VECTORS].round(9)
    rows[["kx", "ky", "kz"]] *= 1 + 1e-5
    assert "precision" not in causes(rows.round(9))


@pytest.mark.parametrize(
    ("name", "verdict", "named"),
    [
        ("axis_norm", "fail", True), ("jellett", "fail", False),
        ("equations", "open", True), ("start", "open", False),
    ],
)  # fmt: skip
def test_only_a_check_without_the_rounding_in_its_bound_or_a_deciding_one_suffers_from_it(
    healthy: Healthy, name: str, verdict: Verdict, named: bool
) -> None:
    rows = healthy("reference", 101, 1)[VECTORS].round(5)
    setup = CheckSetup(tt.load_scene("reference"), COLUMN_SETS["vectors"], True)
    samples = setup.samples(open_source(rows).load(("t", *setup.columns.names)))
    seen = [Check("equations", "pass", 0.0)]
    found = [Check(name, verdict, 1e-6)]
    file = FailedFile(samples, found, lambda _: seen, {}, lambda t: None)
    assert bool([*_precision(file)]) == named


@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize(
    "rows", [41, more(401), *(pytest.param(rows, marks=pytest.mark.slow) for rows in (101, 12001))]
)
def test_no_sampling_makes_a_healthy_trajectory_suspicious(
    healthy: Healthy, rigid_body: Healthy, rows: int
) -> None:
    frame = healthy("reference", rows)
    for given in (frame[VECTORS], frame[EULER], rigid_body(frame)):
        for friction in ("scene", "other"):
            assert not check(given, "reference", friction=friction).failures


@pytest.mark.parametrize(("scene", "step"), [("frictionless", "1/5"), more("rolling", "4/25")])
@pytest.mark.evidence
def test_rows_near_a_multiple_of_the_nutation_are_right(scene: str, step: str) -> None:
    """Euler angles look then as if they moved slowly, in other units."""
    frame = tt.integrate(tt.load_scene(scene).varied(sample_every=step)).frame(*EULER[1:])
    for friction in ("scene", "other"):
        found = check(frame, scene, friction=friction)
        assert (found.failures, found.causes) == ((), ())


# With the scene's friction all rows pass in tests/check/test_golden.py.
@pytest.mark.usefixtures("no_cause")
@pytest.mark.parametrize("friction", SLOW_IN_SCENE)
@pytest.mark.parametrize(
    ("rows", "every"),
    [
        (401, 1),
        pytest.param(None, 1, marks=pytest.mark.slow),
        pytest.param(None, 10, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("scene", of_each_kind(store.scenes()))
def test_no_check_of_golden_rows_fails(
    scene: str, rows: int | None, every: int, friction: str
) -> None:
    golden = pandas.DataFrame(tt.golden.load(scene))[:rows:every]
    for columns in (VECTORS, EULER):
        if not golden[columns].isna().any(axis=None):
            found = check(golden[columns], scene, friction=friction)
            assert not found.failures, str(found)
            assert rows or friction == "other" or found.passed, str(found)


def healthy_files(seed: int, count: int) -> list[str]:
    """Return the failing ones of ``count`` right files of all scenes on the table, 20 to 960 Hz."""
    rng, failing = numpy.random.default_rng(seed), []
    scenes = [name for name in store.scenes() if not tt.load_scene(name).lifts]
    for number in range(count):
        name = scenes[number % len(scenes)]
        scene = tt.load_scene(name)
        hertz = round(10 ** rng.uniform(numpy.log10(20), numpy.log10(960)))
        until = min(Fraction(600, hertz), scene.until)
        times = [Fraction(i, hertz) for i in range(int(until * hertz) + 1)]
        run = tt.integrate(scene, events=())
        frame = run.frame(*VECTORS[1:], times=[t for t in times if t <= run.t_end])
        for friction in ("scene", "other"):
            found = check(frame, scene, friction=friction)
            failing += [f"{name} {hertz} Hz {friction}: {one}" for one in found.failures]
    return failing


@pytest.mark.parametrize(("seed", "count"), [(3, 2), pytest.param(4, 200, marks=pytest.mark.slow)])
def test_no_healthy_file_fails(seed: int, count: int) -> None:
    assert healthy_files(seed, count) == []


@pytest.mark.usefixtures("no_cause")
def test_a_wrong_simulator_is_checked_not_refused(healthy: Healthy) -> None:
    frame = healthy("reference", 401)[VECTORS]
    for name in ("Lz", "vx", "kz"):
        assert not check(scaled(frame, 1.05, name), "reference").passed


def test_friction_that_pushes_is_named(engine: Engine) -> None:
    rows = engine(500, 0.5, fault="friction pushes")
    assert "mu is -1.0 times the scene's" in causes(rows)
    found = check(rows, "reference", friction="other")["friction_power"]
    assert found.verdict == "fail"
    assert "friction seen: -0.3" in found.note
    assert "as viscous, but along the motion" in found.note


def test_another_friction_is_named_only_where_it_is_seen(engine: Engine) -> None:
    found = causes(engine(1000, 0.5, law="coulomb", mu=0.02))
    assert found.startswith("force: the contact force is another one than the scene's (friction")
    assert found.endswith('as Coulomb\'s): if that is meant, add friction="other"')
    for fault in ("I1 a hundredth more", "torsional friction", "mu a tenth more"):
        assert 'friction="other"' not in str(check(engine(fault=fault), "reference"))


SEEN = "detects 1e-4; friction seen: 0.1 to 0.2 of F_z"


@pytest.mark.parametrize(
    ("failed", "power", "note", "height", "named"),
    [
        ("equations", "pass", SEEN, False, True),
        ("equations", "open", SEEN, False, False),
        ("equations", "pass", "detects 1e-4", False, False),
        ("start", "pass", SEEN, False, False),
        ("equations jellett", "pass", SEEN, False, False),
        ("equations jellett", "pass", SEEN, True, True),  # a table that gives way
    ],
)
def test_another_force_is_named_where_all_laws_are_seen_to_hold(
    healthy: Healthy, failed: str, power: Verdict, note: str, height: bool, named: bool
) -> None:
    setup = CheckSetup(tt.load_scene("regularised-1e-2"), COLUMN_SETS["vectors"], True)
    frame = healthy("reference", 17, 0.1)[VECTORS].assign(z=0.02)
    also = ("z",) * height
    rows = setup.samples(open_source(frame).load(("t", *setup.columns.names, *also)))
    laws = [Check(name, "pass") for name in ("kinematics", "contact_momentum", "jellett")]
    found = [*laws, Check("friction_power", power, note=note)]
    failures = [Check(name, "fail", 1.0) for name in failed.split()]
    file = FailedFile(rows, failures, lambda _: found, {}, lambda t: None)
    assert bool([*_force(file)]) == named


def test_no_mu_is_named_of_a_scene_without_friction(healthy: Healthy) -> None:
    smooth = tt.load_scene("reference").varied(mu="0")
    assert causes(healthy("reference", 101, 0.2)[VECTORS], smooth).startswith("force: ")


@pytest.mark.parametrize("fault", ["normal force is the weight", more("friction pushes")])
def test_what_is_no_number_is_not_named(engine: Engine, fault: str) -> None:
    found = check(engine(500, 0.5, fault=fault), "reference", friction="other")
    assert (found.verdict, found.causes) == ("fail", ())


@pytest.mark.parametrize(
    ("names", "factor", "cause"),
    [
        more(["t"], 1.001, "t runs 1.00100 times as fast as the motion"),
        (["Lx", "Ly", "Lz"], 1.0001, ""),
        (["vx", "vy"], 1.001, ""),
    ],
)
def test_a_number_is_named_only_if_with_it_all_that_failed_passes(
    names: list[str], factor: float, cause: str
) -> None:
    times = [Fraction(i, 1000) for i in range(2001)]
    frame = tt.integrate("reference").frame(*VECTORS[1:], times=times)
    frame[names] *= factor
    for friction in ("scene", "other"):
        causes = check(frame, "reference", friction=friction).causes
        # rows that are wrong from some time on are no cause
        kinds = ("parameter", "clock", "force")
        assert "; ".join(c.text for c in causes if c.kind in kinds) == cause
        assert "alone" not in str(causes)
        assert "jumps" not in str(causes)


@pytest.mark.parametrize(
    ("case", "world"), [("unity_left_handed", "left-handed-y-up"), ("yup_body_axis_y", "y-up")]
)
@pytest.mark.parametrize("friction", [more("scene"), "other"])
def test_a_world_is_named_and_the_file_passes_in_it(case: str, world: str, friction: str) -> None:
    file = CASES / case / "top.csv"
    found = check(file, "reference", friction=friction)
    assert found.verdict == "fail"
    assert {cause.kind for cause in found.causes} == {"convention"}
    text = "; ".join(cause.text for cause in found.causes)
    assert f'world="{world}"' in text
    assert 'axis="y"' in text
    # digits that nobody asked for are not listed as passed
    assert "golden" not in str(found).split("passed:")[1].split("\nopen")[0]
    found = check(file, "reference", friction=friction, world=world, axis="y")
    assert found.failures == ()


@pytest.mark.parametrize(
    ("drift", "start", "named"),
    [(1e-4, "scene", True), (1e-2, "scene", False), (1e-4, "other", False)],
)
def test_a_mirrored_world_is_named_with_errors_as_engines_leave(
    engine: Engine, drift: float, start: str, named: bool
) -> None:
    """Jellett's integral, of the other sign, drifts by a part of 5e-5, or of 5e-3."""
    frame = engine(500, 0.5, start=(0.1, 0.0, 0.0, -155.0))
    frame[OMEGA] *= (1 + drift * frame[["t"]]).to_numpy()
    found = check(frame, "reference", friction="other", start=start)
    assert "jellett" in {one.name for one in found.failures}
    assert ("left-handed" in str(found.causes)) == named


@pytest.mark.parametrize("friction", SLOW_IN_SCENE)
def test_a_unit_and_a_wrong_column_are_both_named(healthy: Healthy, friction: str) -> None:
    """The first rows are too far apart to be judged as given, not right."""
    rows = healthy("reference", 401, 4)[VECTORS]
    wrong = rows.assign(t=1000 * rows["t"], vx=1.01 * rows["vx"])
    unit = "convention: the time is in ms"
    column = "columns: vx is 1.010 times the solution's; every other column is right to"
    assert causes(wrong, friction=friction).startswith(f"{unit} | {column} 1")
    rest = rows.assign(t=1000 * rows["t"], Lz=rows["Lz"].where(rows.index < 300, 1.01 * rows["Lz"]))
    found = causes(rest, friction=friction)
    assert found.startswith(f"{unit} | columns: from t = 3 s on Lz is 1.010 times the solution's;")


@pytest.mark.parametrize("friction", SLOW_IN_SCENE)
@pytest.mark.parametrize("also", [more("clock"), "Lz"])
def test_a_unit_is_named_only_if_other_columns_follow(
    healthy: Healthy, friction: str, also: str
) -> None:
    """Three faults: times in ms, a wrong vx, and a clock or Lz 1 % off."""
    rows = healthy("reference", 401, 4)[VECTORS]
    wrong = scaled(scaled(rows, 1000, "t"), 1.01, "vx", "t" if also == "clock" else "Lz")
    found = check(wrong, "reference", friction=friction)
    assert (found.verdict, found.causes) == ("fail", ())
    assert "cause" in str(found)


def test_a_number_that_is_not_finite_needs_no_cause(healthy: Healthy) -> None:
    rows = healthy("reference", 801)[VECTORS]
    for numbers in (rows, rows.round(9)):
        given = numbers.assign(vx=numbers["vx"].where(rows.index != 500))
        found = check(given, "reference")
        assert [one.name for one in found.failures] == ["finite"]
        assert found.causes == ()
        assert "not explained" not in str(found)


@pytest.mark.parametrize("fault", [more("clock"), "alpha", more("finite")])
def test_no_mu_is_named_where_only_digits_are_missing(fault: str) -> None:
    """The observed mu always differs from the scene's in some digit."""
    scene = tt.load_scene("reference")
    longer = scene.varied(alpha="0.3000000003") if fault == "alpha" else scene
    frame = tt.integrate(longer).frame(*VECTORS[1:])
    frame["t"] *= 1 + 1e-9 * (fault != "alpha")
    if fault == "finite":
        frame["vx"] = frame["vx"].where(frame.index != 790)
    found = check(frame, "reference", digits=9.5)
    assert {one.name for one in found.failures} - {"finite"} == {"golden"}
    assert found.causes == ()


@pytest.mark.parametrize("drift", [0.0, more(1e-4)])
def test_an_end_is_named_only_if_the_rows_before_pass_and_no_mu(drift: float) -> None:
    """With the observed mu the table pulls as much."""
    run = tt.integrate("contact-lost", contact="bilateral", until="1.345", events=())
    frame = run.frame(*VECTORS[1:], times=numpy.arange(0.0, 1.345, 0.01).tolist())
    moment = {name: (1 + drift * frame.t) * frame[name] for name in ("Lx", "Ly", "Lz")}
    found = causes(frame.assign(**moment), "contact-lost")
    assert found.startswith("end: the solution leaves the table at 1.33692 s; ") == (not drift)
    assert "mu is" not in found


@pytest.mark.parametrize("scene", ["reference", more("coulomb-gliding")])
def test_no_mu_is_named_that_leaves_more_than_a_tenth(scene: str) -> None:
    """A clock that is off: another mu would leave a half."""
    frame = tt.integrate(scene).frame(*VECTORS[1:])
    assert "mu is" not in causes(scaled(frame, 1.0001, "t"), scene)


def test_a_small_error_of_mu_is_named_as_far_as_its_check_fails() -> None:
    for mu, said in (("0.300003", "1.0000100"), ("0.30003", "1.000100")):
        rubbed = tt.load_scene("reference").varied(mu=mu, until="4")
        frame = tt.integrate(rubbed).frame(*VECTORS[1:])
        assert causes(frame) == f"parameter: mu is {said} times the scene's"


@pytest.mark.parametrize(
    ("scene", "mu", "said"),
    [
        ("regularised-1e-4", "0.33", "1.100"),  # as well as g, which friction shows alike
        ("regularised-1e-2", "0.3003", "1.0010"),
        more("stribeck", "0.33", "1.32"),
        more("coulomb-gliding", "0.055", "1.10"),
    ],
)
def test_mu_is_named_under_every_law(scene: str, mu: str, said: str) -> None:
    slippery = tt.load_scene(scene).varied(mu=mu, until="0.5", sample_every="1/200")
    frame = tt.integrate(slippery).frame(*VECTORS[1:])
    assert causes(frame, scene) == f"parameter: mu is {said} times the scene's"


@pytest.mark.parametrize(
    ("number", "said"),
    [
        ("g", "parameter: g is 1.000100 times the scene's"),
        ("R", "parameter: R is 1.000100 times the scene's"),
        ("t", "clock: t runs 1.000100 times as fast as the motion"),
    ],
)
def test_a_number_that_only_the_scenes_own_force_shows_is_named(number: str, said: str) -> None:
    """A part of 1e-4 at 10 ms, below the limits of what every force obeys."""
    more, scene = Fraction("1.0001"), tt.load_scene("reference")
    changed: dict[str, dict[str, object]] = {
        "g": {"g": more * Fraction("9.82")},
        "R": {"R": more / 50, "I1": Fraction(131, 350) / more**2, "I3": Fraction(2, 5) / more**2},
        "t": {},
    }
    words = {name: str(value) for name, value in changed[number].items()}
    frame = tt.integrate(scene.varied(**words, until="2")).frame(*VECTORS[1:])
    given = scaled(frame, float(more), "t") if number == "t" else frame
    assert causes(given) == said


Judged = dict[str, tuple[Verdict, float]]
FAILED: Judged = {"jellett": ("fail", 5e-3), "energy": ("fail", 1.0), "kinematics": ("open", 0.0)}
OPEN = {"kinematics": ("open", 0.0)}


@pytest.mark.parametrize(
    ("then", "nearer", "as_engines", "obeyed"),
    [
        ({"jellett": ("fail", 4e-4), "energy": ("fail", 0.09)}, True, True, False),
        ({"jellett": ("fail", 6e-4), "energy": ("pass", 0.0)}, False, True, False),
        ({"jellett": ("fail", 1.1e-3), "energy": ("pass", 0.0)}, False, False, False),
        ({"jellett": ("pass", 0.0), "energy": ("fail", 0.11)}, False, False, False),
        ({"jellett": ("pass", 0.0), "energy": ("pass", 0.0)}, True, True, True),
        ({"jellett": ("fail", 6e-4), **OPEN}, False, False, False),
        (OPEN, False, False, False),
        ({"kinematics": ("pass", 0.0)}, False, True, True),
        ({"kinematics": ("fail", 0.2)}, False, True, False),
        ({"kinematics": ("fail", 0.4)}, False, False, False),
    ],
)
def test_what_a_cause_has_to_leave(
    healthy: Healthy, then: Judged, nearer: bool, as_engines: bool, obeyed: bool
) -> None:
    """A tenth, or what engines leave; all laws of every force only if they are seen to hold."""
    setup = CheckSetup(tt.load_scene("reference"), COLUMN_SETS["vectors"], True)
    rows = setup.samples(open_source(healthy()[VECTORS]).load(("t", *setup.columns.names)))

    def checks(of: Judged) -> list[Check]:
        return [Check(name, verdict, value) for name, (verdict, value) in of.items()]

    seen = {"kinematics": ("pass", 0.0), **then} if "jellett" in then else then
    file = FailedFile(rows, checks(FAILED), lambda _: checks(seen), {}, lambda t: None)
    assert (file.nearer(rows), file.as_engines(rows), file.obeyed(rows)) == (
        nearer, as_engines, obeyed,
    )  # fmt: skip
