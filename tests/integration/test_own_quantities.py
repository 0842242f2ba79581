"""One's own functions of the motion, as columns and as events; and how numbers are shown."""

from fractions import Fraction
from functools import partial
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.conftest import more
from tt_precise.mechanics.quantities import QUANTITIES, E, Motion
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.scene import Scene


def named(name: str, function: Any, dimension: Any = None) -> Any:
    function.__name__ = name
    if dimension:
        function.dimension = dimension
    return function


def one(q: Motion) -> Scalar:
    """The number one, in the arithmetic of the motion."""
    return q.body.I3 / q.body.I3


half_up = named("half_up", lambda q: q.state.kz - one(q) / 2, "1")  # theta is 60 degrees
energy = named("energy", lambda q: E(q), QUANTITIES["E"].dimension)
slip = named("slip", lambda q: q.fn.sqrt(q.state.vx**2 + q.state.vy**2))


@pytest.mark.parametrize("digits", [5, 20])
def test_a_function_is_a_column_and_an_event(reference: Scene, digits: int) -> None:
    run = tt.integrate(reference.varied(until="6"), digits=digits, events=["theta_max", half_up])
    events = run.event_frame("theta", "digits").query("name == 'half_up'")
    assert len(events) > 2
    apart = abs(events["theta"] - run.precision.context.pi / 3)
    assert max(apart) < 10.0**-digits + (1e-15 if digits < 16 else 0)
    assert events["digits"].min() >= digits
    frame = run.frame([half_up, "kz"], energy, "E", "error:energy", "error:E")
    assert list(frame)[:5] == ["t", "half_up", "kz", "energy", "E"]
    assert frame["half_up"].to_numpy() == pytest.approx(frame["kz"].to_numpy() - 0.5)
    assert (frame["energy"] == frame["E"]).all()
    assert numpy.allclose(frame["error:energy"], frame["error:E"], rtol=0.1, atol=1e-17)
    assert 0 < frame["error:energy"].max() < 10.0**-digits
    assert run.plot(energy).axes[0].get_ylabel() == "energy / J"


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_unit_makes_it_si_and_no_unit_is_said(reference: Scene, precision: str) -> None:
    run = tt.integrate(reference.varied(until="1"), precision)
    frame = run.frame(tt.quantity(slip, "m/s"), "gliding_speed", slip)
    assert list(frame) == ["t", "slip", "gliding_speed", "slip [m = R = g = 1]"]
    speed, unit = frame["gliding_speed"].to_numpy(), float(reference.body.g * reference.body.R)
    assert frame["slip"].to_numpy() == pytest.approx(speed, rel=1e-14)
    assert frame["slip [m = R = g = 1]"].to_numpy() * unit**0.5 == pytest.approx(speed, rel=1e-14)


@pytest.mark.parametrize("precision", ["double-double", "quad", more("mp"), "triple-double"])
def test_divided_by_a_constant(reference: Scene, precision: str) -> None:
    """A tenth is no double: the zeros keep the digits of the arithmetic."""
    tenth = named("tenth", lambda q: q.state.kx / 10 + q.state.ky / 7)
    whole = named("whole", lambda q: q.state.kx * 7 + q.state.ky * 10)
    events = [tenth, whole, "extremum:g_n"]  # of a rate, by power series
    run = tt.integrate(reference.varied(until="0.6"), precision, events=events)
    first, second = (run.events["t"][run.events["name"] == n] for n in ("tenth", "whole"))
    assert len(first) == len(second) > 2
    # some eps of the function, over its slope at the zero
    assert max(abs(first.to_numpy() - second.to_numpy())) < 200 * float(run.precision.eps)


OWN: dict[str, tuple[Any, int]] = {
    "abs": (lambda q: abs(q.state.kx - 0.3) - 0.1, 126),
    "bend": (lambda q: q.fn.sqrt((q.state.kx - 0.3) ** 2) - 0.001, 124),
    "cube": (lambda q: (q.state.kx - 0.3) ** 3, 62),
    "fraction": (lambda q: q.state.kx - Fraction(3, 10), 62),
    "array": (lambda q: q.state.kx - numpy.array(0.3), 62),
    "log": (lambda q: q.fn.log(q.state.kx + q.body.alpha * 9) - q.fn.log(q.body.alpha * 10), 62),
    "atan": (lambda q: q.fn.atan(q.state.kx) - q.fn.atan(one(q) * 3 / 10), 62),
    "inverse": (lambda q: (q.state.kx + 2) ** -1 - one(q) / 2.3, 62),
    "power": (lambda q: (q.state.kx + 2) ** 0.5 - q.fn.sqrt(one(q) * 2.3), 62),
}


@pytest.mark.parametrize(
    ("name", "chosen"),
    [
        (name, chosen) if not chosen or name in ("atan", "bend") else more(name, chosen)
        for name in OWN
        for chosen in ({}, {"digits": 8}, {"digits": 20}, {"digits": 25})
    ],
)
def test_an_own_event_is_found_in_every_arithmetic(name: str, chosen: dict[str, Any]) -> None:
    function, count = OWN[name]
    run = tt.integrate("reference", until=6, events=[named(name, function)], **chosen)
    assert run.event_counts == {name: count}


@pytest.mark.parametrize("chosen", [{}, {"digits": 20}, {"precision": "quad"}])
def test_a_quantity_as_an_event_has_its_extrema(half: Scene, chosen: dict[str, Any]) -> None:
    """The angle of the axis with a direction that is 0.3 rad off the vertical."""

    def towards(q: Motion) -> Scalar:
        third = one(q) * 3 / 10
        return q.fn.acos(q.state.kx * q.fn.sin(third) + q.state.kz * q.fn.cos(third))

    angle = tt.quantity(towards, "1")
    run = tt.integrate(half, events=[angle, "theta_max"], **chosen)
    extrema = run.event_frame("error:t").query("name == 'extremum:towards'")
    assert len(extrema) > 10
    assert (extrema["error:t"] < 1e-12).all()
    for t, direction in zip(extrema["t"], extrema["direction"], strict=True):
        before, there, after = run.frame(angle, times=[t - 1e-4, t, t + 1e-4])["towards"]
        assert direction * (before - there) > 0 < direction * (after - there)


# ---- refused ------------------------------------------------------------------------------------

REFUSED: dict[str, tuple[Any, str]] = {
    "complex": (lambda q: q.state.kx * 1j, "got .* expected a real number"),
    "text": (lambda q: "x", "got 'x' from the function"),
    "none": (lambda q: None, "none: got None from the function"),
    "lacking": (lambda q: q.lam, "got AttributeError .*'lam'"),
    "branch": (lambda q: q.state.kx if q.state.kx > 0.1 else 0.1, "got .*Error .* expected a"),
    "jump": (lambda q: 1 / q.state.kz, r"jumps or is undefined at t = 5\.8797"),
    "turn": (lambda q: q.fn.atan2(q.state.ky, q.state.kx), r"jumps or is undefined at t = 2\.78"),
    "equator": (lambda q: q.state.kx, "events: got .* with other names"),
}


@pytest.mark.parametrize("chosen", [{}, {"digits": 20}], ids=["double", "20"])
@pytest.mark.parametrize("name", REFUSED)
def test_an_own_event_is_refused_in_one_line(name: str, chosen: dict[str, Any]) -> None:
    function, message = REFUSED[name]
    function = named(name, function)
    with pytest.raises(InputError, match=message) as refusal:
        tt.integrate("reference", until=6, events=[function], **chosen)
    assert str(refusal.value).count("\n") == 0
    if name in ("complex", "text"):
        with pytest.raises(InputError, match=message):
            tt.integrate("reference", until="0.1", **chosen).frame(function)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda q: q.omega,
        # the norm over all times, or NaN for all
        lambda q: q.omega[2] / numpy.linalg.norm(q.omega),
        lambda q: numpy.array(q.omega),
        lambda q: q.omega[2] - numpy.sum(numpy.sqrt(0.0995 - q.euler.theta)),
    ],
)
def test_a_column_that_is_a_vector_or_combines_times_is_refused(short: Scene, wrong: Any) -> None:
    run = tt.integrate(short)
    with pytest.raises(InputError, match="combine several times"):
        run.frame(tt.quantity(wrong, "rad/s"))
    right = tt.quantity(lambda q: q.g_n, "N", name="right")  # type: ignore[attr-defined]
    assert run.frame(right)["right"].equals(run.frame("g_n")["g_n"])


@pytest.mark.parametrize("asked", [3, [None], [1.5], partial(half_up)])
def test_what_is_neither_a_name_nor_a_function(short: Scene, asked: Any) -> None:
    with pytest.raises(InputError, match="events: got"):
        tt.integrate("reference", events=asked)
    with pytest.raises(InputError, match="column: got"):
        tt.integrate(short).frame(asked)


@pytest.mark.parametrize("unit", ["mm/s", "m/", "metre", "m**2", 7])
def test_units_with_a_prefix_or_no_meaning_are_refused(unit: Any) -> None:
    with pytest.raises(InputError, match=r"unit: got"):
        tt.quantity(slip, unit)


def test_other_functions_are_refused(short: Scene) -> None:
    name: Any = "theta"
    with pytest.raises(InputError, match="quantity: got 'theta'"):
        tt.quantity(name, "rad")
    with pytest.raises(InputError, match="sine: got TypeError"):
        tt.integrate(short, digits=20).frame(named("sine", lambda q: numpy.sin(q.state.kx)))
    two = [lambda q: q.state.kx, lambda q: q.state.ky]  # one of one name would be lost
    with pytest.raises(InputError, match="events: got two called <lambda>"):
        tt.integrate("reference", events=two)
    with pytest.raises(InputError, match="column: got two called <lambda>"):
        tt.integrate(short).frame(*two)
