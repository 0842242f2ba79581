"""One's own functions of the motion, as columns and as events."""

from fractions import Fraction
from typing import Any

import numpy
import pytest

import tt_precise as tt
from tests.conftest import more
from tt_precise.mechanics.quantities import QUANTITIES, E, Motion
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.scene import Scene


def half_up(q: Motion) -> Scalar:
    """The function that vanishes where the axis is 60 degrees away from the vertical."""
    return q.state.kz - q.fn.sqrt(q.body.I3 / q.body.I3 / 4)


half_up.dimension = "1"  # type: ignore[attr-defined]


def energy(q: Motion) -> Scalar:
    """The energy again, under another name."""
    return E(q)


energy.dimension = QUANTITIES["E"].dimension  # type: ignore[attr-defined]


def slip(q: Motion) -> Scalar:
    """The gliding speed."""
    return q.fn.sqrt(q.state.vx**2 + q.state.vy**2)


@pytest.mark.parametrize("digits", [5, 20])
def test_a_function_is_a_column_and_an_event(reference: Scene, digits: int) -> None:
    run = tt.integrate(reference.varied(until="6"), digits=digits, events=["theta_max", half_up])
    events = run.events[run.events["name"] == "half_up"]
    assert len(events) > 2
    apart = abs(events["theta"] - run.precision.context.pi / 3)
    assert max(apart) < 10.0**-digits + (1e-15 if digits < 16 else 0)
    assert run.event_frame("digits").query("name == 'half_up'")["digits"].min() >= digits
    frame = run.frame([half_up, "kz"], energy, "E", "error:energy", "error:E")
    assert list(frame)[:5] == ["t", "half_up", "kz", "energy", "E"]
    assert {one.kind for one in frame.dtypes} == {"f"}
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
    assert frame["slip"].to_numpy() == pytest.approx(frame["gliding_speed"].to_numpy(), rel=1e-14)
    unit = float(reference.body.g * reference.body.R) ** 0.5
    dimensionless = frame["slip [m = R = g = 1]"].to_numpy()
    assert dimensionless * unit == pytest.approx(frame["slip"].to_numpy(), rel=1e-14)


def test_what_is_no_number_is_refused(reference: Scene) -> None:
    run = tt.integrate(reference.varied(until="0.1"))
    with pytest.raises(InputError, match="column: got a tuple from omega, expected one number"):
        run.frame(tt.quantity(lambda q: q.omega, "rad/s", name="omega"))
    for unit in ("mm/s", "m/", "metre", "m**2", 7):
        with pytest.raises(InputError, match=r"unit: got .*, expected an SI unit without prefix"):
            tt.quantity(slip, unit)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="quantity: got 'theta', expected a function"):
        tt.quantity("theta", "rad")  # type: ignore[arg-type]


@pytest.mark.parametrize("precision", ["double-double", "quad", more("mp"), "triple-double"])
def test_divided_by_a_constant(reference: Scene, precision: str) -> None:
    """A tenth is no double: the zeros keep the digits of the arithmetic."""

    def tenth(q: Motion) -> Scalar:
        return q.state.kx / 10 + q.state.ky / 7

    def whole(q: Motion) -> Scalar:
        return q.state.kx * 7 + q.state.ky * 10

    run = tt.integrate(reference.varied(until="0.6"), precision, events=[tenth, whole])
    first, second = (run.events["t"][run.events["name"] == n] for n in ("tenth", "whole"))
    assert len(first) == len(second) > 2
    # some eps of the function, over its slope at the zero
    assert max(abs(first.to_numpy() - second.to_numpy())) < 200 * float(run.precision.eps)


def test_two_of_one_name_are_refused() -> None:
    """One of them would be lost."""
    two = [lambda q: q.state.kx, lambda q: q.state.ky]
    with pytest.raises(InputError, match="events: got two called <lambda>"):
        tt.integrate("reference", events=two)
    run = tt.integrate("reference", until="0.1", events=[half_up, half_up])
    with pytest.raises(InputError, match="column: got two called <lambda>"):
        run.frame(*two)
    assert list(run.frame("E", "theta", "E", half_up, half_up)) == ["t", "E", "theta", "half_up"]


OWN: dict[str, tuple[Any, int]] = {
    "abs": (lambda q: abs(q.state.kx - 0.3) - 0.1, 126),
    "bend": (lambda q: q.fn.sqrt((q.state.kx - 0.3) ** 2) - 0.001, 124),
    "cube": (lambda q: (q.state.kx - 0.3) ** 3, 62),
    "fraction": (lambda q: q.state.kx - Fraction(3, 10), 62),
    "float32": (lambda q: q.state.kx - numpy.float32(0.3), 62),
    "array": (lambda q: q.state.kx - numpy.array(0.3), 62),
    "log": (lambda q: q.fn.log(q.state.kx + q.body.alpha * 9) - q.fn.log(q.body.alpha * 10), 62),
    "atan": (lambda q: q.fn.atan(q.state.kx) - q.fn.atan(q.body.alpha / q.body.alpha * 3 / 10), 62),
    "power": (lambda q: (q.state.kx + 2) ** 0.5 - q.fn.sqrt(q.body.alpha / q.body.alpha * 2.3), 62),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "chosen"),
    [
        (name, chosen) if not chosen or (name, len(chosen)) == ("bend", 1) else more(name, chosen)
        for name in OWN
        for chosen in ({}, {"digits": 8}, {"digits": 20}, {"digits": 25})
    ],
)
def test_an_own_event_is_found_in_every_arithmetic(name: str, chosen: dict[str, Any]) -> None:
    function, count = OWN[name]
    function.__name__ = name
    run = tt.integrate("reference", until=6, events=[function], **chosen)
    assert run.event_counts == {name: count}


REFUSED: dict[str, tuple[Any, str]] = {
    "complex": (lambda q: q.state.kx * 1j, "got .* expected a real number"),
    "text": (lambda q: "x", "got 'x' from the function"),
    "nothing": (lambda q: None, "got None from the function"),
    "branch": (
        lambda q: q.state.kx if q.state.kx > 0.1 else 0.1,
        "got .*Error .* expected a",
    ),
    "lam": (lambda q: q.lam, "got AttributeError .*'lam'"),
    "jump": (lambda q: 1 / q.state.kz, r"jumps or is undefined at t = 5\.8797"),
    "turn": (lambda q: q.fn.atan2(q.state.ky, q.state.kx), r"jumps or is undefined at t = 2\.78"),
}


@pytest.mark.parametrize("chosen", [{}, {"digits": 20}], ids=["double", "20"])
@pytest.mark.parametrize("name", REFUSED)
def test_an_own_event_is_refused_in_one_line(name: str, chosen: dict[str, Any]) -> None:
    function, message = REFUSED[name]
    function.__name__ = name
    with pytest.raises(InputError, match=message) as refusal:
        tt.integrate("reference", until=6, events=[function], **chosen)
    assert str(refusal.value).count("\n") == 0
    if name in ("complex", "text"):
        run = tt.integrate("reference", until="0.1", **chosen)
        with pytest.raises(InputError, match=message):
            run.frame(function)


@pytest.mark.parametrize("chosen", [{}, {"digits": 20}, {"precision": "quad"}])
def test_a_quantity_as_an_event_has_its_extrema(half: Scene, chosen: dict[str, Any]) -> None:
    """The angle of the axis with a direction that is 0.3 rad off the vertical."""

    def towards(q: Motion) -> Scalar:
        """The angle to a mark on the wall."""
        third = q.body.I3 / q.body.I3 * 3 / 10
        return q.fn.acos(q.state.kx * q.fn.sin(third) + q.state.kz * q.fn.cos(third))

    angle = tt.quantity(towards, "1")
    run = tt.integrate(half, events=[angle, "theta_max"], **chosen)
    events = run.event_frame("error:t").query("name == 'extremum:towards'")
    assert len(events) > 10
    assert (events["error:t"] < 1e-12).all()
    for t, direction in zip(events["t"], events["direction"], strict=True):
        before, there, after = run.frame(angle, times=[t - 1e-4, t, t + 1e-4])["towards"]
        assert (there < min(before, after)) if direction > 0 else (there > max(before, after))


@pytest.mark.parametrize("words", [{}, {"digits": 20}], ids=["double", "20 digits"])
def test_an_own_value_at_an_event_has_its_error(reference: Scene, words: dict[str, Any]) -> None:
    run = tt.integrate(reference.varied(until="0.1"), events=["extremum:g_n"], **words)
    found = run.event_frame(energy, "error:energy", "E", "error:E", "error:t", slip, "error:slip")
    assert (found["energy"] == found["E"]).all()
    assert numpy.allclose(found["error:energy"], found["error:E"], rtol=0.1, atol=1e-17)
    assert (found["error:slip"] < 1e-14).all()
    with pytest.raises(InputError, match="column: got 'drift:E', expected one of") as refused:
        run.event_frame("drift:E")
    assert str(refused.value).endswith("digits or error:NAME; frame(...) has drifts")


def test_a_function_that_combines_rows_is_refused(reference: Scene) -> None:
    """``numpy.linalg.norm`` of a vector of columns is the norm over all times, or NaN for all."""
    run = tt.integrate(reference, until="0.05")
    for wrong in (
        lambda q: numpy.linalg.norm(q.omega),
        lambda q: q.omega[2] / numpy.linalg.norm(q.omega),
        lambda q: numpy.array(q.omega),
        lambda q: 1e-12 * numpy.linalg.norm(q.omega),
        lambda q: q.omega[2] - numpy.sum(numpy.sqrt(0.0995 - q.euler.theta)),
    ):
        with pytest.raises(InputError, match="combine several times"):
            run.frame(tt.quantity(wrong, "rad/s"))
    mu = tt.quantity(lambda q: q.body.mu, "s/m", name="mu")
    weight = tt.quantity(lambda q: q.g_n, "N", name="weight")  # type: ignore[attr-defined]
    table = run.frame(mu, weight, "g_n")
    assert set(table["mu"]) == {0.3}
    assert list(table["weight"]) == list(table["g_n"])
