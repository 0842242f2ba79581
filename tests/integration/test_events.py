"""Events: complete, in the right places, with the states that belong to them."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import pandas
import pytest

from tests.conftest import more
from tt_precise import golden
from tt_precise.integration import Trajectory, catalogue, integrate
from tt_precise.integration.events import EVENTS, EXTREMUM, JOINING, TERMINAL, ZERO
from tt_precise.mechanics.quantities import QUANTITIES
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene, shipped

ALL = catalogue("gliding")


def spin_along_axis(row: Any) -> Any:
    return row.Lx * row.kx + row.Ly * row.ky + row.Lz * row.kz


# What each event means, in the columns of a trajectory and not with the event's function:
# the sign changes there, and to which sign when the event's direction is +1.
MEANINGS: dict[str, tuple[Callable[[Any], Any], int]] = {
    "theta_min": (lambda row: row.theta_dot, -1),
    "theta_max": (lambda row: row.theta_dot, -1),
    "phi_dot_zero": (lambda row: row.phi_dot, +1),
    "nu_x_zero": (lambda row: row.nu_x, +1),
    "nu_y_zero": (lambda row: row.nu_y, +1),
    "nu_crossing": (lambda row: row.nu_y - row.nu_x, +1),
    "equator": (lambda row: row.kz, +1),
    "omega_3_zero": (lambda row: row.omega_3, +1),
    "Lk_equals_Lz": (lambda row: spin_along_axis(row) - row.Lz, +1),
    "Lk_equals_minus_Lz": (lambda row: spin_along_axis(row) + row.Lz, +1),
}


def misplaced(trajectory: Trajectory, events: pandas.DataFrame, reach: Any) -> list[str]:
    """Events around which what they mean does not change its sign as it should within reach."""
    sides = [
        trajectory.frame(times=[t + side * reach for t in events["t"]], numbers="exact")
        for side in (-1, 1)
    ]
    before, after = (list(frame.itertuples()) for frame in sides)
    wrong = []
    for left, event, right in zip(before, events.to_dict("records"), after, strict=True):
        value, sense = MEANINGS[event["name"]]
        sign = sense * event["direction"]
        if not sign * value(left) < 0 < sign * value(right):
            wrong.append(f"{event['name']} at {float(event['t']):.6f} s")
    return wrong


def test_every_event_lies_where_its_meaning_says(fine: Trajectory) -> None:
    events = pandas.concat([rows.iloc[::9] for _, rows in fine.events.groupby("name")])
    assert set(events["name"]) == set(ALL) == set(EVENTS) == set(MEANINGS)
    for name, rising in (("theta_min", 1), ("theta_max", -1)):
        (direction,) = set(events["direction"][events["name"] == name])
        assert MEANINGS[name][1] * direction == rising
    reach = fine.precision.context.mpf("1e-28")  # s
    assert misplaced(fine, events, reach) == []
    late = events.assign(t=events["t"] + 3 * reach)
    assert len(misplaced(fine, late, reach)) == len(events)


def test_an_event_at_the_horizon_is_in_or_out(fine: Trajectory, reference: Scene) -> None:
    crossing = fine.events[fine.events["name"] == "equator"]["t"].iloc[0]
    at = Fraction(mpmath.nstr(crossing, 30))
    for aside, count in ((Fraction(1, 10**12), 1), (Fraction(-1, 10**12), 0)):
        short = integrate(reference, until=at + aside, events=ALL)
        assert (short.events["name"] == "equator").sum() == count
        assert (short.events["t"] <= short.t_end).all()


def alike(scene: Scene, asked: Any) -> Any:
    """Count the events in vectors; they are also those in Euler angles, or in doubles."""
    other: Any = {"precision": "double-double"} if scene.body.spring else {"formulation": "euler"}
    runs = [integrate(scene, events=asked), integrate(scene, events=asked, **other)]
    first, second = (run.events.sort_values(["name", "t"]) for run in runs)
    assert [*first["name"]] == [*second["name"]]
    assert [*first["t"]] == pytest.approx([*second["t"]], abs=1e-8)
    return runs[0].event_counts


@pytest.mark.parametrize(
    ("scene", "until", "extrema"),
    [("contact-lost", "2", 0), more("coulomb-flight", "2", 0), ("elastic-hunt-crossley", "0.1", 2)],
)
def test_a_force_that_ends_does_not_change_its_sign(scene: str, until: str, extrema: int) -> None:
    """Roundings made such zeros: at the loss of contact, and at both ends of an impact."""
    asked = "zero:g_n,zero:E_dot,extremum:theta,extremum:E,extremum:g_n"
    counts = alike(load_scene(scene).varied(until=until), asked)
    assert counts["zero:g_n"] == 0 < counts["extremum:theta"]
    assert counts["zero:E_dot"] == counts["extremum:E"] == extrema


def test_directions_in_the_euler_form(half: Scene) -> None:
    """The axis turns away from its first azimuth, and with it what is horizontal."""

    def heading(q: Any) -> Any:
        return q.s_dot[0] + q.body.alpha / 100

    # with the azimuth left at 0 the others too
    assert alike(half, ["zero:s_dot_x", "extremum:s_dot_x", heading]) == {"heading": 1}
    with pytest.raises(InputError, match="column: got 's_dot_x'"):
        integrate(half, formulation="euler").frame("s_dot_x")


def test_a_fall_through_the_pole_is_a_minimum_of_theta(toppling: Scene) -> None:
    falling = toppling.varied(until="0.15")
    vectors = integrate(falling, events=ALL)
    angles = integrate(falling, "double-double", formulation="euler")
    assert angles.status == "pole"
    # the direction of tilt turns round at the pole, and the gliding velocity with it
    assert set(vectors.events["name"]) == {"theta_min", "nu_x_zero", "nu_crossing"}
    # a few eps of 0.09 s in double
    assert max(abs(vectors.events["t"] - float(angles.t_end))) < 4 * 2.0**-53
    assert max(vectors.events["theta"]) < 1e-14


def test_rolling_scenes_have_no_gliding_events() -> None:
    assert set(ALL) - set(catalogue("rolling")) == {"nu_x_zero", "nu_y_zero", "nu_crossing"}
    with pytest.raises(InputError, match="no gliding event"):
        integrate("rolling", events=("nu_x_zero",))


@pytest.mark.parametrize("name", ["perigee", "g_n", "extremum:nothing", "", EXTREMUM, ZERO])
def test_unknown_names_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=f"event: got '?{name}"):
        integrate("reference", events=(name,))


@pytest.mark.parametrize("name", ["g_n", "E_pot", "phi_dot", "tau_x"])
def test_extrema_and_zeros_of_any_quantity(half: Scene, name: str) -> None:
    run = integrate(half, "double-double", events=(EXTREMUM + name, ZERO + name))
    assert run.event_counts[EXTREMUM + name] > 3
    assert name != "tau_x" or run.event_counts[ZERO + name] > 2
    times, aside = run.events["t"], run.precision.context.mpf("1e-6")
    here, before, after = (
        run.frame(name, times=times + side, numbers="exact")[name] for side in (0, -aside, aside)
    )
    sign, turns = run.events["direction"], run.events["name"] == EXTREMUM + name
    assert (sign * (before - here) > 0)[turns].all()
    assert (sign * (after - here) > 0)[turns].all()
    assert (sign * before < 0)[~turns].all()
    assert (sign * after > 0)[~turns].all()


# compiling so many functions takes seconds
QUICK = ("rolling", "rocking", "elastic-linear")


@pytest.mark.parametrize(
    "name",
    [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in shipped()],
)
def test_all_events_at_once(name: str) -> None:
    """Every event that can be named, on every shipped scene: all of them in one run a scene."""
    scene = load_scene(name).varied(until="0.02", sample_every="0.01")
    names = {*catalogue(scene.model), *(k + q for k in (EXTREMUM, ZERO) for q in QUANTITIES)}
    partial: set[str] = set()
    try:
        run = integrate(scene, events=names)
    except InputError as refusal:
        partial = set(str(refusal).partition("got ")[2].split(", which jumps")[0].split(", "))
        run = integrate(scene, events=names - partial)
    assert partial <= names
    assert run.status in ("complete", "contact_lost")
    assert set(run.events["name"]) <= {*names, *JOINING}
    quantities = {one.partition(":")[2] for one in partial}
    # what is undefined at the start: an axis that is vertical, or so nearly that sin^2 is 0
    if name in ("upright", "inverted"):
        assert quantities == {q.name for q in QUANTITIES.values() if not q.pole}
    else:
        assert bool(quantities) == (name in ("beside-the-pole", "rocking")), quantities
        assert quantities <= {"V", "E_tilde_main", "theta_dot_simplified"}


# s, of the time of an event: roundings, which decaying velocities magnify in below-threshold
REACH = {"double": 1e-12, "double-double": 0, "triple-double": 0, "quad": 0}
CHEAP = ("contact-lost", "rocking", "stays-upright")
GOLDEN = [pytest.param(n, marks=() if n in CHEAP else pytest.mark.slow) for n in shipped()]
Times = dict[str, list[float]]


def times_of(events: Any) -> Times:
    """Times by name, but for the events that switch a motion."""
    events = events[~events["name"].isin([*JOINING, *TERMINAL])]
    return {str(kind): [*map(float, rows["t"])] for kind, rows in events.groupby("name")}


def golden_events(name: str) -> Times:
    return times_of(golden.load(name, "text").events)


def assert_golden(run: Trajectory, expected: Times) -> None:
    found = times_of(run.events)
    assert {*found} == {*expected}
    reach = 1e-9 if run.scene.name == "below-threshold" else REACH[run.precision.name]
    for kind, times in expected.items():
        # the golden times as doubles are half an ulp off
        assert found[kind] == pytest.approx(times, rel=4e-16, abs=reach), kind
    assert run.unresolved == ()


@pytest.mark.parametrize("precision", [more(one) if one == "quad" else one for one in REACH])
@pytest.mark.parametrize("name", GOLDEN)
def test_all_events_are_the_golden_ones(name: str, precision: str) -> None:
    expected = golden_events(name)
    assert_golden(integrate(name, precision, events=tuple(expected) or "theta_max"), expected)


def test_those_of_the_reference_scene_and_a_lost_one_is_noticed(double: Trajectory) -> None:
    expected = golden_events("reference")
    assert_golden(double, expected)
    lost = {kind: times[1:] for kind, times in expected.items()}
    with pytest.raises(AssertionError):
        assert_golden(double, expected | {"nu_y_zero": lost["nu_y_zero"]})
