"""Zeros that are no events, and those beside t = 0, in every backend."""

from __future__ import annotations

from typing import Any

import numpy
import pytest

from tests.conftest import Patch, more
from tt_precise.integration import catalogue, integrate, zeros
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

ALL = catalogue("gliding")
ARITHMETICS = ("double", "double-double", "triple-double", "quad")
BOTH = pytest.mark.parametrize("precision", ARITHMETICS[:2])


def varied(name: str, entries: str) -> Scene:
    changes = dict(entry.split("=") for entry in entries.replace(", ", ",").split(","))
    return load_scene(name).varied(**changes)


START = varied("reference", "theta=1e-5, theta_dot=-20, phi_dot=-50, omega_3=-20, until=0.001")
# by a run of 200 bits; nu_x and nu_y vanish at t = 0 too
BESIDE_ZERO = {
    "theta_min": 4.999999997816468928366634180292e-07,
    "nu_y_zero": 4.999999998377930106879733312578e-07,
    "nu_crossing": 5.000098281374849866916416321625e-07,
    "nu_x_zero": 1.308254925798173776258025790349e-06,
}


@pytest.mark.parametrize("precision", ARITHMETICS)
def test_zeros_beside_one_at_the_start_are_found(precision: str) -> None:
    """A start a hundred times nearer to the pole has them within the first step, or says so."""
    for theta, nearer, bound in (("1e-5", 1, 1e-7), ("1e-7", 100, 3e-5)):
        run = integrate(START.varied(theta=theta), precision, events=ALL)
        events = run.events
        times = dict(zip(events["name"], events["t"].astype(float) * nearer, strict=True))
        expected = {name: t for name, t in BESIDE_ZERO.items() if name not in run.unresolved}
        assert times == pytest.approx(expected, rel=bound)
        assert {"theta_min", "nu_y_zero", "nu_crossing"} <= {*times}


# L lies flat, beside the pole, and the motion is a plane one within 6e-6
LYING = varied(
    "reference", "alpha=0.7757, I1=0.8583, I3=1.2540, g=9.8, mu=15.1938, theta=2.196819e-06, "
    "theta_dot=-12.8152, phi_dot=-35.8928, omega_3=0, until=0.02",
)  # fmt: skip
TABLE = "m=0.02, R=0.02, g=9.8, nu_x=0, nu_y=0, height=-0.0002, rise=0, "
COARSE = tuple({"digits": n} for n in (1, 4, 6, 9))
DOUBLE = ({"precision": "double"},)
# a scene; an event and its first times in s, by triple-double; a bound; ways to run
EARLY: dict[str, tuple[Scene, str, tuple[float, ...], float, tuple[dict[str, Any], ...]]] = {
    # omega_3 begins with t^3: rounding makes it cross zero at 4e-8 s
    "the rounding of a zero at the start": (
        varied("elastic-linear", TABLE + "alpha=0.8584, I1=0.8712, I3=1.3503, mu=0.09525331, "
        "theta=pi - 1.282219e-06, phi_dot=11.4524, omega_3=0, theta_dot=0, stiffness=5742.883, "
        "damping=0.0629295, until=0.003"),
        "omega_3_zero", (), 0, DOUBLE,
    ),
    # nu_x is lost in its summands, which grow, somewhat longer than its first term says
    "a shallow lobe": (
        varied("elastic-linear", TABLE + "alpha=0.5196, I1=0.7315, I3=0.3560, mu=0.6456611, "
        "epsilon=10, theta=pi - 1.494801e-07, theta_dot=7.5528, phi_dot=23.2212, omega_3=36.3989, "
        "stiffness=167.5019, damping=0, until=1e-4"),
        "nu_x_zero", (1.29895194008e-7,), 1e-9,
        tuple({"tolerance": size} for size in (1e-10, 1e-12, 9.3e-14, 1e-15, 0.0)),
    ),
    # where the functions are below the tolerance of their summands
    "below the tolerance": (
        LYING, "nu_x_zero", (1.71422920e-7, 3.42841949e-7, 7.14226777e-3), 1e-7, COARSE,
    ),
    # 1 + cos theta of L.k = L.z is 3e-10 there, and was known to six digits
    "beside the opposite pole": (
        varied("regularised-1e-2", "m=0.02, R=0.02, alpha=0.1111, I1=0.4565, I3=0.2501, g=9.8, "
        "mu=0.01358408, theta=pi - 2.567711e-05, phi_dot=39.2246, omega_3=0, nu_x=0.3289, nu_y=0, "
        "until=0.01"),
        "Lk_equals_Lz", (1.990953186810724e-3,), 1e-13, DOUBLE + COARSE[3:],
    ),
    # theta_min is at 4.27e-8 s, where a factor 1 - cos theta would have a double zero
    "a passage of the pole": (
        varied("coulomb-flight", "m=0.02, R=0.02, alpha=0.305, I1=0.9493, I3=0.988, g=9.8, "
        "mu=0.1622182, theta=5.316879e-07, theta_dot=-12.4428, phi_dot=0, omega_3=0, nu_x=0.4063, "
        "nu_y=0.2083, until=0.01"),
        "Lk_equals_minus_Lz", (8.546113561450657e-08,), 1e-12, DOUBLE,
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    ("place", "chosen"), [(place, way) for place, (*_, ways) in EARLY.items() for way in ways]
)
def test_a_crossing_beside_the_start_is_an_event(place: str, chosen: dict[str, Any]) -> None:
    """A crossing that the arithmetic does not resolve is named; those behind it are found."""
    scene, event, times, bound, _ = EARLY[place]
    run = integrate(scene, events=(event,), **chosen)
    found = run.events["t"][run.events["name"] == event].astype(float).tolist()
    expected = times[len(times) - len(found) :] if event in run.unresolved else times
    assert found == pytest.approx(list(expected), rel=bound)
    assert run.unresolved == (() if len(found) == len(times) else (event,))


@pytest.mark.parametrize("precision", ARITHMETICS)
@pytest.mark.parametrize("name", ["rolling", "frictionless"])
def test_what_touches_zero_is_no_event(name: str, precision: str) -> None:
    names = ("phi_dot_zero", "theta_max")
    run = integrate(name, precision, until="1", events=names)
    assert set(run.events["name"]) == {"theta_max"}
    assert run.touches == ("phi_dot_zero",)


@BOTH
def test_what_almost_touches_zero_crosses_it(precision: str) -> None:
    """Two zeros a millionth of a radian deep."""
    loops = load_scene("rolling").varied(until="1", phi_dot="1e-6")
    signs = integrate(loops, precision, events="phi_dot_zero").events["direction"].to_numpy()
    assert len(signs) >= 60
    assert (signs[:-1] * signs[1:] == -1).all()


@pytest.mark.parametrize("precision", ARITHMETICS[:3])
def test_what_vanishes_identically_is_no_event(precision: str) -> None:
    ice = load_scene("frictionless").varied(until="1", omega_3="0")
    names = ("omega_3_zero", "extremum:E", "extremum:lambda", "zero:omega_3", "extremum:omega_3")
    still = integrate(ice, precision, events=names)
    assert still.events.empty
    assert still.touches == names
    assert integrate(ice.varied(omega_3="1"), precision, events=names).events.empty


def test_what_is_undefined_at_the_start_or_on_the_way_is_refused(reference: Scene) -> None:
    """A top that rocks in a plane goes through the pole."""
    with pytest.raises(InputError, match=r"extremum:phi_dot, which .* undefined at t = 0 s"):
        integrate(reference.varied(theta="0"), events=("extremum:phi_dot", "theta_max"))
    with pytest.raises(InputError, match=r"extremum:theta_dot.* undefined at t = 0\.086"):
        integrate("rocking", events=("extremum:theta_dot",))
    assert integrate("rocking", events=("zero:theta_dot", "theta_max")).status == "complete"


@pytest.mark.parametrize(("name", "minima"), [("rolling", 316), ("frictionless", 271)])
def test_tangencies_of_a_coarse_run_are_named_once(name: str, minima: int) -> None:
    """Until 10 s there were 310 and 358 zeros of phi_dot that do not exist."""
    run = integrate(name, digits=6, until=10, events=("phi_dot_zero", "theta_min"))
    assert run.event_counts == {"theta_min": minima}
    assert (run.touches, run.unresolved) == (("phi_dot_zero",), ())


@pytest.mark.parametrize("precision", ARITHMETICS[:3])
def test_events_of_a_velocity_that_decays_are_all_found_or_named(precision: str) -> None:
    """Wide runs lost a third of them; double resolves fewer, and says so."""
    names = ("theta_max", "nu_x_zero")
    run = integrate("below-threshold", precision, until=40, events=names)
    if precision == "double":
        assert run.unresolved == run.touches == names
        assert 170 < run.event_counts["theta_max"] < 212
        assert integrate("below-threshold", until=8, events=names).unresolved == ()
    else:
        assert run.event_counts == {"theta_max": 212, "nu_x_zero": 362}
        assert run.touches == run.unresolved == ()


@pytest.mark.parametrize(
    ("precision", "tolerance"), [("double", 1e-6), ("double-double", 1e-12)], ids=["double", "dd"]
)
def test_the_noise_of_a_component_that_decays_is_no_event(precision: str, tolerance: float) -> None:
    """The errors of k and L carry into the velocity, whose own errors decay with it."""
    names = ("zero:s_dot_x", "zero:s_dot_y")
    runs = (("double-double", 0.0), (precision, tolerance))
    fine, run = (
        integrate("below-threshold", one, until=40, events=names, tolerance=x) for one, x in runs
    )
    times = numpy.array(fine.events["t"], dtype=float)
    assert run.unresolved == names
    assert 100 < len(run.events) < len(times) == 147
    assert all(abs(times - t).min() < 1e-3 for t in run.events["t"].astype(float))


@pytest.mark.parametrize("precision", ["double", more("double-double")])
def test_a_tilt_beyond_the_squares_of_doubles_has_events(reference: Scene, precision: str) -> None:
    """The squares of its parts are 0 in double."""
    steep = reference.varied(theta="1e-200", until="0.5")
    run = integrate(steep, precision, events=("theta_min",))
    assert (run.status, run.touches) == ("complete", ("theta_min",))
    run = integrate(steep.varied(mu="1000"), precision, events=("extremum:nu_x",))
    assert run.event_counts == {"extremum:nu_x": 31}


@BOTH
def test_the_error_within_a_step_near_the_pole_counts(precision: str, monkeypatch: Patch) -> None:
    """At 0.018 s theta is 2.5e-3: the rate of V has noise that the ends of the step have not."""
    monkeypatch.setattr(zeros, "MOST_EVENTS", 3000)
    scene = load_scene("phi-dot-83").varied(until="0.02", sample_every="0.01")
    run = integrate(scene, precision, events=["extremum:V"])
    times = [0.018178830178816, 0.018283072001454, 0.018387288453764]
    assert run.events["t"].astype(float).tolist() == pytest.approx(times, abs=1e-13)
    assert run.events["direction"].tolist() == [1, -1, 1]
    assert run.unresolved == ()


@pytest.mark.parametrize("precision", ["quad", "double-double"])
def test_a_horizon_below_the_resolution_has_no_zero_inside(precision: str) -> None:
    """Quad did not end: functions that vanish at the start were divided for ever."""
    names = ("theta_min", "theta_max", "nu_x_zero")
    run = integrate("reference", precision, until="1e-300", events=names)
    assert (run.status, len(run.events)) == ("complete", 0)
