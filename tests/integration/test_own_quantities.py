"""One's own functions of the motion, as columns and as events; and how numbers are shown."""

from fractions import Fraction
from functools import partial
from typing import Any

import numpy
import pytest
import scipy.optimize

import tt_precise as tt
from tests.conftest import more
from tt_precise.mechanics.quantities import ENERGY, E, Motion
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.scene import Scene


def half_up(q: Motion) -> Scalar:
    """The function that vanishes where the axis is 60 degrees away from the vertical."""
    return q.state.kz - q.fn.sqrt(q.body.I3 / q.body.I3 / 4)


half_up.dimension = "1"  # type: ignore[attr-defined]


def energy(q: Motion) -> Scalar:
    """The energy again, under another name."""
    return E(q)


energy.dimension = ENERGY  # type: ignore[attr-defined]


@pytest.mark.parametrize("digits", [5, 20])
def test_a_function_is_a_column_and_an_event(reference: Scene, digits: int) -> None:
    run = tt.integrate(reference.varied(until="6"), digits=digits, events=["theta_max", half_up])
    events = run.events[run.events["name"] == "half_up"]
    assert len(events) > 2
    apart = abs(events["theta"] - run.precision.context.pi / 3)
    assert max(apart) < 10.0**-digits + (1e-15 if digits < 16 else 0)
    errors = run.event_errors().query("name == 'half_up'")
    assert (errors["digits"] >= digits).all()
    frame = run.frame([half_up, "kz"], energy, "E")
    assert list(frame) == ["t", "half_up", "kz", "energy", "E"]
    assert {one.kind for one in frame.dtypes} == {"f"}
    assert frame["half_up"].to_numpy() == pytest.approx(frame["kz"].to_numpy() - 0.5)
    assert (frame["energy"] == frame["E"]).all()
    own = run.error_over_time(energy, "E")
    assert (run.frame(energy, "error:energy")["error:energy"] == own["energy"]).all()
    assert numpy.allclose(own["energy"], own["E"], rtol=0.1, atol=1e-17)
    assert 0 < own["energy"].max() < 10.0**-digits
    assert run.plot(energy).axes[0].get_ylabel() == "energy / J"


def slip(q: Motion) -> Scalar:
    """The gliding speed."""
    return q.fn.sqrt(q.state.vx**2 + q.state.vy**2)


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_a_unit_makes_it_si_and_no_unit_is_said(reference: Scene, precision: str) -> None:
    run = tt.integrate(reference.varied(until="1"), precision)
    frame = run.frame(tt.quantity(slip, "m/s"), "gliding_speed", slip)
    assert list(frame) == ["t", "slip", "gliding_speed", "slip [m = R = g = 1]"]
    assert frame["slip"].to_numpy() == pytest.approx(frame["gliding_speed"].to_numpy(), rel=1e-14)
    unit = float(reference.body.g * reference.body.R) ** 0.5
    dimensionless = frame["slip [m = R = g = 1]"].to_numpy()
    assert dimensionless * unit == pytest.approx(frame["slip"].to_numpy(), rel=1e-14)
    assert run.plot(tt.quantity(slip, "m/s")).axes[0].get_ylabel() == "slip / m/s"


def test_what_is_no_number_is_refused(reference: Scene) -> None:
    run = tt.integrate(reference.varied(until="0.1"))

    def omega(q: Motion) -> Any:
        return q.omega

    with pytest.raises(InputError, match="column: got a tuple from omega, expected one number"):
        run.frame(tt.quantity(omega, "rad/s"))
    for unit in ("mm/s", "m/", "metre", "m**2", 7):
        with pytest.raises(InputError, match=r"unit: got .*, expected an SI unit without prefix"):
            tt.quantity(slip, unit)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="quantity: got 'theta', expected a function"):
        tt.quantity("theta", "rad")  # type: ignore[arg-type]


def test_digits_of_an_event_with_an_arc_tangent(reference: Scene) -> None:
    """An event's function is only evaluated, so that every arithmetic has all functions."""

    def azimuth(q: Motion) -> Scalar:
        return q.fn.atan2(q.state.ky, q.state.kx) + q.body.alpha / 8

    run = tt.integrate(reference.varied(until="0.05"), digits=12, events=[azimuth])
    assert run.precision.name == "double-double"
    assert run.digits_throughout >= 12
    (t,) = run.events["t"]
    state = run.at(t)
    assert float(state.ky / state.kx) == pytest.approx(numpy.tan(-0.3 / 8), rel=1e-14)
    finer = tt.integrate(run.scene, digits=20, events=[azimuth])
    assert finer.precision.name == "double-double"
    assert float(finer.events["t"][0]) == pytest.approx(float(t), rel=1e-12)


@pytest.mark.parametrize("precision", ["double-double", "quad", more("mp"), "triple-double"])
def test_divided_by_a_constant(reference: Scene, precision: str) -> None:
    """A tenth is no double: the zeros keep the digits of the arithmetic."""

    def tenth(q: Motion) -> Scalar:
        return q.state.kx / 10 + q.state.ky / 7

    def whole(q: Motion) -> Scalar:
        return q.state.kx * 7 + q.state.ky * 10

    events: list[Any] = [tenth, whole, "extremum:g_n"]  # of a rate, by power series
    run = tt.integrate(reference.varied(until="0.6"), precision, events=events)
    first, second = (run.events["t"][run.events["name"] == n] for n in ("tenth", "whole"))
    assert len(first) == len(second) > 2
    # some eps of the function, over its slope at the zero
    assert max(abs(first.to_numpy() - second.to_numpy())) < 200 * float(run.precision.eps)


@pytest.mark.parametrize("precision", ["double", "double-double"])
def test_powers(reference: Scene, precision: str) -> None:
    def cube(q: Motion) -> Scalar:
        return q.state.kx**3 - q.body.alpha**2 * q.state.kx / 10

    def inverse(q: Motion) -> Scalar:
        return q.state.kz**-1 - 1.0049

    scene = reference.varied(until="0.2")
    times = tt.integrate(scene, precision, events=[cube, "extremum:E_tilde_main"]).events
    crossings = times["t"][times["name"] == "cube"]
    assert len(crossings) > 0
    for state in map(tt.integrate(scene, precision).at, crossings):
        assert float(state.kx) == pytest.approx(0.009**0.5, rel=1e-12)
    inverses = tt.integrate(scene, precision, events=inverse).events
    assert len(inverses) > 0
    assert list(inverses["kz"].astype(float)) == pytest.approx([1 / 1.0049] * len(inverses))


def test_of_a_motion_in_segments() -> None:
    run = tt.integrate("coulomb-gliding", until="0.2", events=half_up)
    assert run.frame(half_up)["half_up"].iloc[0] == pytest.approx(run.at(0).kz - 0.5)


def test_two_of_one_name_are_refused() -> None:
    """One of them would be lost."""
    two = [lambda q: q.state.kx, lambda q: q.state.ky]
    with pytest.raises(InputError, match="events: got two called <lambda>"):
        tt.integrate("reference", events=two)
    run = tt.integrate("reference", until="0.1", events=[half_up, half_up])
    with pytest.raises(InputError, match="column: got two called <lambda>"):
        run.frame(*two)
    assert list(run.frame("E", "theta", "E", half_up, half_up)) == ["t", "E", "theta", "half_up"]


@pytest.mark.parametrize("asked", [3, [None], partial(half_up)])
def test_what_is_neither_a_name_nor_a_function(asked: Any) -> None:
    with pytest.raises(InputError, match="events: got"):
        tt.integrate("reference", events=asked)
    with pytest.raises(InputError, match="column: got"):
        tt.integrate("reference", until="0.1").frame(asked)


def test_constants() -> None:
    def nothing(q: Motion) -> None:
        q.fn.sqrt(q.state.kz)

    names = {"one": lambda q: 1, "none": lambda q: 0 * q.body.mu}
    for name, function in names.items():
        function.__name__ = name
    run = tt.integrate("reference", until="0.1", events=["all", *names.values()])
    assert run.touches == ("none",)
    assert {"theta_max", "phi_dot_zero"} < {*run.event_counts}
    with pytest.raises(InputError, match="nothing: got None from the function"):
        tt.integrate("reference", until="0.1", events=nothing)


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
    "branch": (
        lambda q: q.state.kx if q.state.kx > 0.1 else 0.1,
        "got .*Error .* expected a",
    ),
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


def test_numpys_functions_are_refused_where_numbers_are_wide(half: Scene) -> None:
    def sine(q: Motion) -> Scalar:
        return numpy.sin(q.state.kx)

    assert len(tt.integrate(half).frame(sine)) > 1
    with pytest.raises(InputError, match=r"sine: got TypeError .* functions of motion\.fn"):
        tt.integrate(half, digits=20).frame(sine)


@pytest.mark.parametrize("chosen", [{}, {"digits": 20}, {"precision": "quad"}])
def test_a_quantity_as_an_event_has_its_extrema(half: Scene, chosen: dict[str, Any]) -> None:
    """The angle of the axis with a direction that is 0.3 rad off the vertical."""

    def towards(q: Motion) -> Scalar:
        """The angle to a mark on the wall."""
        third = q.body.I3 / q.body.I3 * 3 / 10
        return q.fn.acos(q.state.kx * q.fn.sin(third) + q.state.kz * q.fn.cos(third))

    angle = tt.quantity(towards, "1")
    run = tt.integrate(half, events=[angle, "theta_max"], **chosen)
    events = run.events[run.events["name"] == "extremum:towards"]
    assert len(events) > 10
    for t, direction in zip(events["t"], events["direction"], strict=True):
        before, there, after = run.frame(angle, times=[t - 1e-4, t, t + 1e-4])["towards"]
        assert (there < min(before, after)) if direction > 0 else (there > max(before, after))
    errors = run.event_errors()
    mine = errors[errors["name"] == "extremum:towards"]
    assert len(mine) == len(events)
    assert (mine["error"] < 1e-12).all()
    with pytest.raises(InputError, match=r"got a float, expected|got 1.5, expected names"):
        tt.integrate(half, events=[1.5])  # type: ignore[list-item]


def test_a_motion_has_the_numbers_of_its_run(half: Scene) -> None:
    """SciPy's root finders take floats only."""
    double, wide = (tt.integrate(half, precision) for precision in ("double", "double-double"))
    q, fine = double.motion(0.4), wide.motion(0.4)
    assert all(type(x) is float for x in (*q.state, *q.omega, q.euler.theta, q.body.alpha))
    assert all(hasattr(x, "_mpf_") for x in (*fine.state, fine.euler.theta))
    assert q.euler.theta == pytest.approx(float(fine.euler.theta), rel=1e-13)
    found = scipy.optimize.brentq(lambda t: double.motion(t).state.ky + 0.03, 0.1, 0.3)
    assert double.at(found).ky == pytest.approx(-0.03, rel=1e-10)


@pytest.mark.parametrize(
    ("function", "name"),
    [(lambda q: q.lam, "lam"), (lambda q: q.state.theta, "theta"), (lambda q: q.k.z, "z")],
)
def test_an_attribute_that_a_motion_lacks_is_named(function: Any, name: str) -> None:
    with pytest.raises(InputError, match=f"got AttributeError .*'{name}'"):
        tt.integrate("reference", until="0.1", events=[function])


@pytest.mark.parametrize("words", [{}, {"digits": 20}], ids=["double", "20 digits"])
def test_an_own_value_at_an_event_has_its_error(reference: Scene, words: dict[str, Any]) -> None:
    run = tt.integrate(reference.varied(until="0.1"), events=["extremum:g_n", energy], **words)
    found = run.event_frame(energy, "error:energy", "E", "error:E", "error:t", slip, "error:slip")
    assert (found["energy"] == found["E"]).all()
    assert numpy.allclose(found["error:energy"], found["error:E"], rtol=0.1, atol=1e-17)
    assert (found["error:t"] == run.event_errors()["error"]).all()
    assert (found["error:slip"] < 1e-14).all()
    as_float, text = (run.event_frame(energy, "error:t", numbers=n) for n in ("float", "text"))
    assert as_float[["t", "energy", "error:t"]].dtypes.unique().tolist() == [float]
    assert as_float["energy"].tolist() == found["energy"].astype(float).tolist()
    assert text["error:t"].astype(float).tolist() == found["error:t"].tolist()
    written = run.precision.text if words else repr
    assert text["energy"].tolist() == [written(x) for x in found["energy"]]
    assert text["name"].equals(found["name"])
    with pytest.raises(InputError, match="numbers: got 'mpf', expected one of: float"):
        run.event_frame(energy, numbers="mpf")  # type: ignore[arg-type]
    for of in (run, run.again(events=())):
        with pytest.raises(InputError, match="column: got 'drift:E', expected one of") as refused:
            of.event_frame("drift:E")
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
    assert set(run.frame(mu)["mu"]) == {0.3}


def test_quantities_of_the_catalogue_are_attributes_of_a_motion(reference: Scene) -> None:
    run = tt.integrate(reference, until="0.05")
    weight = tt.quantity(lambda q: q.g_n, "N", name="weight")  # type: ignore[attr-defined]
    table = run.frame(weight, "g_n")
    assert list(table["weight"]) == list(table["g_n"])
    motion: Any = run.motion(0)
    assert motion.jellett == getattr(motion, "lambda")
