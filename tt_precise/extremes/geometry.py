"""The poles: starts at every distance from them, passages near them, and conversions there."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.extremes import theory
from tt_precise.extremes.case import CaseOutcome, Findings, case, equal, finite, within
from tt_precise.extremes.runs import (
    Integrate,
    distance,
    exact_start,
    integrating,
    tilt_error,
    triple_double,
    varied,
)
from tt_precise.integration import integrate
from tt_precise.integration.precision import KINDS
from tt_precise.mechanics.euler import EulerState, euler_from_vectors, vectors_from_euler
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Functions, Scalar
from tt_precise.scene.scene import Scene, load_scene

POLES = ("", "pi - ")
PRECISIONS = ("double", "extended", "quad", "mp")
DECADES = tuple(f"{first} to {first + 9}" for first in range(1, 300, 10))
PROBE_S = "0.1"
THETA, THETA_DOT, OMEGA_3 = "0.5", "-10", "20"  # rad, rad/s, rad/s
AFTER_S = "0.1"  # Horizon in s, well after the passage at 0.04 s.
QUADRATURE_DIGITS = 30  # Digits of a quadrature that is compared with double.
LARGEST_DOUBLE = math.log10(2) * 1024  # Decimal exponent of the largest double.
RATES = {"theta_dot": "0.7", "phi_dot": "-1.9", "omega_3": "12.3", "nu_x": "0.11", "nu_y": "-0.23"}
FN = own_context(700)  # Arithmetic in which pi - 1e-300 has some digits to spare.
Convert = Callable[..., Scalar]


@case(
    "theta(0) = {pole}1e-k, k = {decades}, in {precision}",
    source="the equations linearised at the pole, whose exponential is taken with 80 digits",
    over=[
        *({"pole": pole, "decades": decades, "precision": "double"}
          for pole in POLES for decades in DECADES),
        *({"pole": pole, "decades": "300 to 300", "precision": precision}
          for precision in PRECISIONS for pole in POLES),
    ],
    control={"integrate": integrating(mu="1e-9")},
)  # fmt: skip
def start_near_a_pole(
    pole: str, decades: str, precision: str, integrate: Integrate = integrate
) -> Findings:
    """After 0.1 s k, L and v per unit of tilt are those of linear equations, but for theta(0)^2."""
    first, last = map(int, decades.split(" to "))
    errors = []
    for k in range(first, last + 1):
        scene = varied(theta=f"{pole}1e-{k}", until=PROBE_S)
        run = integrate(scene, precision)
        neglected = 10.0 ** (-2 * k)
        errors.append(tilt_error(run, scene) * run.precision.eps / (run.precision.eps + neglected))
    # 24 steps of about 1 eps each; the coefficient of theta^2 is about 1
    return within(max(errors), 30, "(eps + theta^2)")


@case(
    "theta(0) = {pole} exactly, in {precision}",
    source="by symmetry nothing can push the axis to any side",
    over={"pole": ("0", "pi"), "precision": PRECISIONS},
    control={"moved": "1e-300"},
)
def start_at_a_pole(pole: str, precision: str, moved: str = "") -> Findings:
    """The axis and L stay where they are, to the last bit, for 2 s."""
    upright = pole == "0"
    theta = (moved if upright else f"pi - {moved}") if moved else pole
    run = integrate(varied(theta=theta, until="2"), precision)
    state, earlier = run.state, run.at(1)
    names = ("kx", "ky", "Lx", "Ly", "vx", "vy")
    sideways = max(map(abs, finite(getattr(state, name) for name in names)))
    unchanged = state.kz == (1 if upright else -1) and state.Lz == earlier.Lz
    fn = run.precision.context
    expected = rounding_to(fn)(varied().body.I3) * 155 * state.kz
    return (
        equal(run.status, "complete"),
        equal(f"moved sideways by {float(sideways):g}", "moved sideways by 0", float(sideways)),
        equal("vertical as before" if unchanged else "changed", "vertical as before"),
        within(abs(fn.mpf(state.Lz) / expected - 1) / run.precision.eps, 2, "eps in L.z"),
    )


@case(
    "climb from theta(0) = 1e-{k} against the climb from its square",
    source="the growing mode of the linear equations, from their characteristic polynomial",
    over={"k": (16, 25, 50, 100, 150)},
    control={"integrate": integrating(alpha="1e-9")},
)
def climb_is_delayed(k: int, integrate: Integrate = integrate) -> Findings:
    """The equator is reached later by k ln 10/(growth rate of the tilt)."""
    start, fn = exact_start(varied(theta="1e-9"))
    growth = fn.re(theory.tilt_modes(start.body, 1, start.euler.omega_3, fn)[0])
    delay = k * fn.log(10) / growth * start.units.time
    times = []
    for power in (k, 2 * k):
        until = str(int(power * fn.log(10) / growth * start.units.time) + 5)
        run = integrate(varied(theta=f"1e-{power}", until=until), events=("equator",))
        if not len(run.events):
            return CaseOutcome(f"no equator before {until} s ({run.status})", False)
        times.append(run.events["t"][0])
    # a random walk: every step moves the logarithm of the tilt by about 1 eps
    walk = float(run.precision.eps / growth * start.units.time) * run.steps**0.5
    return within(abs(times[1] - times[0] - float(delay)) / walk, 10, "roundings of the steps")


@cache
def passage(k: int) -> Scene:
    """A frictionless top whose L.z - L.k makes it pass the pole at about 1e-k rad."""
    scene = varied(theta=THETA, theta_dot=THETA_DOT, omega_3=OMEGA_3, mu="0", until=AFTER_S)
    fn = own_context(80)
    theta, omega_3 = fn.mpf(THETA), fn.mpf(OMEGA_3)
    ratio = rounding_to(fn)(scene.body.I3 / scene.body.I1)
    missed = -fn.mpf(THETA_DOT) * fn.mpf(10) ** -k
    phi_dot = (missed + ratio * omega_3 * (1 - fn.cos(theta))) / fn.sin(theta) ** 2
    return scene.varied(phi_dot=fn.nstr(phi_dot, 70))


@cache
def nearest(k: int) -> tuple[Scalar, Scalar]:
    """Least theta of ``passage(k)``, and the rate of theta just before (dimensionless), in theory.

    mpmath numbers of 80 digits.
    """
    start, fn = exact_start(passage(k))
    body = start.body.numbers(fn.convert)
    theta, theta_dot, phi_dot, omega_3 = (fn.convert(x) for x in start.euler[:4])
    s, c = fn.sin(theta), fn.cos(theta)
    spin = body.I3 * omega_3
    vertical = body.I1 * phi_dot * s * s + spin * c
    energy = (
        (body.I1 + body.alpha**2 * s * s) * theta_dot**2 / 2
        + (vertical - spin * c) ** 2 / (2 * body.I1 * s * s)
        + spin**2 / (2 * body.I3)
        + 1 - body.alpha * c
    )  # fmt: skip
    least = theory.frictionless_turning_point(body, spin, vertical, energy, fn)
    return least, fn.sqrt(2 * theory.missing_energy(body, spin, energy) / body.I1)


@case(
    "passing the pole at 1e-{k} rad in quad",
    over={"k": (12, 20, 30), "precision": ("quad",)},
    control={"integrate": integrating(phi_dot="1e-31")},
    source="the energy of the frictionless top, in which L.z and L.k are constants",
)
@case(
    "passing the pole at 1e-{k} rad in double",
    over={"k": range(1, 14), "precision": ("double",)},
    control={"integrate": integrating(phi_dot="1e-13")},
    source="the energy of the frictionless top, in which L.z and L.k are constants",
)
def passing(k: int, precision: str, integrate: Integrate = integrate) -> Findings:
    """The least theta is the turning point that the energy allows."""
    run = integrate(passage(k), precision, events=("theta_min",))
    (least,) = finite(run.events["theta"])
    fn = run.precision.context
    error = abs(fn.mpf(least) - fn.convert(nearest(k)[0])) / run.precision.eps
    return (within(error, 10, "eps"), equal(run.status, "complete"))


@case(
    "Euler form past the pole at 1e-{k} rad",
    source="the state from Newton's form in triple-double; steps of e^-2 times the distance from "
    "the spike (the rule of Jorba and Zou) make 34 a decade, fewer where its height loosens the "
    "tolerance",
    over={"k": (2, 4, 6, 8, 10, 12)},
    control={"integrate": integrating(omega_3="1e-13")},
)
def euler_passing(k: int, integrate: Integrate = integrate) -> Findings:
    """No digit of the state is lost; the price is steps, in proportion to the decades."""
    euler = integrate(passage(k), formulation="euler", record=("phi",))
    newton = triple_double(passage(k))
    if euler.status != "complete":
        return CaseOutcome(f"{euler.status} at {euler.t_end} s", False)
    # the first 15 steps are those before the approach, as many as Newton's form takes in all
    a_decade = (euler.steps - 15) / k
    return (
        within(distance(euler, newton) / euler.precision.eps, 50, "eps"),
        CaseOutcome(f"{a_decade:.0f} steps a decade", 24 < a_decade < 38),
    )


@case(
    "Euler form past the pole at 1e-{k} rad, where double ends",
    source="2^1024, the order of the method, and the time of the least theta in quad",
    over={"k": (15, 20, 30)},
    control={"k": 13},
)
def euler_overflowing(k: int) -> Findings:
    """It ends as failed within 1e-12 s of the passage, with the numbers before it.

    The Taylor coefficients of phi_dot, about (rate/theta)^order, have no double.
    """
    euler = integrate(passage(k), formulation="euler")
    (passed,) = integrate(passage(k), "quad", events=("theta_min",)).events["t"]
    least, rate = nearest(k)
    size = (euler.order + 1) * math.log10(float(rate / least))
    finite(euler.state.values.values())
    return (
        equal(euler.status, "failed"),
        within(abs(float(passed) - euler.t_end), 1e-12, "s before the passage"),
        CaseOutcome(f"coefficients about 1e{size:.0f}", size > LARGEST_DOUBLE),
    )


@case(
    "Newton's form straight through the pole, from theta(0) = {theta} without spin",
    source="the plane motion, whose time is an integral over theta",
    over={"theta": ("1", "1e-3", "0.1", "2", "3")},
    control={"integrate": integrating(g="1e-12")},
)
def through_the_pole(theta: str, integrate: Integrate = integrate) -> Findings:
    """The axis reaches half that tilt on the other side when the plane motion does."""
    run = integrate(falling(theta, until=2 * _fall(theta, 0.0) - _fall(theta, 0.5)))
    angle = float(theta) / 2
    errors = (run.state.kx + math.sin(angle), run.state.ky, run.state.kz - math.cos(angle))
    worst = max(map(abs, errors)) / float(run.precision.eps)
    return (equal(run.status, "complete"), within(worst, 40, "eps"))


@case(
    "Euler form straight into the pole, from theta(0) = {theta} without spin",
    source="the plane motion, whose time is an integral over theta",
    over={"theta": ("1", "1e-3", "0.1", "2", "3")},
    control={"integrate": integrating(g="1e-12")},
)
def into_the_pole(theta: str, integrate: Integrate = integrate) -> Findings:
    """It ends as pole, at the time of the fall."""
    fall = _fall(theta, 0.0)
    run = integrate(falling(theta, until=2 * fall), formulation="euler")
    eps = float(run.precision.eps)
    error = abs(run.t_end / float(fall) - 1) / eps
    return (equal(run.status, "pole"), within(error, 40, "eps of the time"))


def falling(theta: str, until: Scalar) -> Scene:
    """A frictionless top at rest, tilted by ``theta``; ``until`` in s, an mpmath number."""
    return varied(
        theta=theta, omega_3="0", mu="0", until=own_context(60).nstr(until, 50), sample_every="1"
    )


@cache
def _fall(theta: str, part: float) -> Scalar:
    """Seconds from ``theta`` down to this part of it, from theory."""
    fn = own_context(QUADRATURE_DIGITS)
    start, _ = exact_start(falling(theta, fn.mpf(1)))
    body = start.body.numbers(lambda x: +fn.convert(x))
    angle = fn.mpf(theta)
    return theory.fall_time(body, angle, part * angle, fn) * fn.convert(start.units.time)


class RoundTripArithmetic(NamedTuple):
    """A module of functions, numbers rounded into it and taken out exactly, and its eps."""

    fn: Functions
    into: Callable[[Scalar], Scalar]
    out: Callable[[Scalar], Scalar]
    eps: Scalar


class Trip(NamedTuple):
    """Relative errors in eps: of the tilt on the way there, of the worst rate on the way back."""

    tilt: Scalar
    rate: Scalar


def arithmetic(precision: str) -> RoundTripArithmetic:
    """The arithmetic that quantities of this precision are computed in."""
    bits = KINDS[precision].bits
    eps = FN.ldexp(1, 1 - bits)
    if precision in ("quad", "mp"):
        context = own_context(15)
        context.prec = bits
        # converting keeps all digits of a number from a finer context; adding nothing rounds it
        return RoundTripArithmetic(context, lambda x: +context.convert(x), FN.convert, eps)

    if precision == "double":
        return RoundTripArithmetic(numpy, lambda x: numpy.float64(float(x)), FN.mpf, eps)

    def exactly(x: Scalar) -> Scalar:
        return FN.mpf(int(x.as_integer_ratio()[0])) / int(x.as_integer_ratio()[1])

    return RoundTripArithmetic(numpy, lambda x: numpy.longdouble(FN.nstr(x, 30)), exactly, eps)


def round_trip(
    precision: str, k: int, inverted: bool, exact_sine: bool, back: Convert = euler_from_vectors
) -> Trip:
    """Convert a state 1e-k from a pole to vectors and ``back``.

    ``exact_sine`` hands over sine and cosine with full digits, as a scene does; else theta alone.
    """
    fn, into, out, eps = arithmetic(precision)
    body = _body(precision)
    offset = FN.mpf(10) ** -k
    theta = FN.pi - offset if inverted else offset
    sine, cosine = FN.sin(offset), FN.cos(offset) * (-1 if inverted else 1)
    euler = EulerState(into(theta), *(into(FN.mpf(x)) for x in RATES.values()))
    sine_cosine = (into(sine), into(cosine)) if exact_sine else None
    vectors = vectors_from_euler(body, euler, fn, sine_cosine=sine_cosine)
    finite([out(x) for x in vectors], "vectors")
    again = back(body, vectors, fn)
    finite([out(x) for x in again], "Euler state")
    tilted = FN.sqrt(out(vectors.kx) ** 2 + out(vectors.ky) ** 2)
    # beyond the rounding of pi itself x-hat may point the other way, and with it these signs
    changes = [
        abs(abs(out(getattr(again, name))) - abs(out(getattr(euler, name)))) / abs(FN.mpf(size))
        for name, size in RATES.items()
    ]
    return Trip(abs(tilted / sine - 1) / eps, max(changes) / eps)


def digits_of_the_tilt(precision: str, k: int, exact_sine: bool) -> float:
    """Decimal digits of the tilt that are right 1e-k rad from the inverted pole."""
    trip = round_trip(precision, k, True, exact_sine)
    eps = arithmetic(precision).eps
    # half an eps is what rounding leaves of a tilt that is exact
    return max(0.0, float(-FN.log10(max(trip.tilt, FN.mpf(1) / 2) * eps)))


def _printed_back(body: Parameters, state: NewtonState, fn: Functions) -> EulerState:
    """The textbook's phi_dot = (Lz - cos L.k)/(I1 sin^2), which cancels near the poles."""
    right = euler_from_vectors(body, state, fn)
    sine_squared = state.kx * state.kx + state.ky * state.ky
    along = body.I3 * right.omega_3
    numerator = state.Lz - state.kz * along
    return right._replace(phi_dot=numerator / (body.I1 * sine_squared) if sine_squared else along)


@case(
    "Euler to vectors and back, 1e-k rad from the {side} pole, in {precision}",
    source="theta and sin theta have the same relative error at 0; beside pi a scene stores the "
    "distance from it; some ten roundings",
    over={"side": ("upright", "inverted"), "precision": PRECISIONS},
    control={"back": _printed_back},
)
def near_a_pole(side: str, precision: str, back: Convert = euler_from_vectors) -> Findings:
    """No digit is lost at any k from 0 to 300, where the distance from pi is what is given."""
    inverted = side == "inverted"
    trips = [round_trip(precision, k, inverted, inverted, back) for k in range(0, 301)]
    return (
        within(max(trip.tilt for trip in trips), 4, "eps of the tilt"),
        within(max(trip.rate for trip in trips), 40, "eps of the rates"),
    )


@case(
    "theta alone, 1e-k rad from the inverted pole, in {precision}",
    source="numbers near pi are 2 eps apart",
    over={"precision": PRECISIONS},
    control={"exact_sine": True},
)
def digits_of_theta_near_pi(precision: str, exact_sine: bool = False) -> Findings:
    """The tilt is off by up to eps 10^k, and by no more; the rates keep their digits."""
    last = int(KINDS[precision].bits * 0.30103) - 1
    trips = {k: round_trip(precision, k, True, exact_sine) for k in range(1, last + 1)}
    share = max(trip.tilt * FN.mpf(10) ** -k for k, trip in trips.items())
    return (
        within(share, 1.5, "eps 10^k"),
        CaseOutcome("reached in part" if share > 0.3 else "never reached", bool(share > 0.3)),
        within(max(trip.rate for trip in trips.values()), 40, "eps of the rates"),
    )


@case(
    "theta = 1e-{k} in double, where numbers have fewer digits",
    source="subnormal numbers are 2^-1074 apart",
    over={"k": (308, 312, 318, 323)},
    control={"fewer": 100.0},
)
def subnormal_theta(k: int, fewer: float = 1.0) -> Findings:
    """The tilt keeps the digits that the number theta has."""
    trip = round_trip("double", k, False, False)
    spacing = FN.ldexp(1, -1074) * FN.mpf(10) ** k * FN.ldexp(1, 52)
    return within(fewer * (trip.tilt / (spacing + 1)), 1, "spacings of the numbers")


@case(
    "Euler form from theta(0) = {pole}1e-k",
    source="the linear equations of the tilt, and the spacing of numbers near pi",
    over={"pole": ("", "pi - ")},
    control={"pole_of_the_law": "other"},
)
def euler_against_newton(pole: str, pole_of_the_law: str = "") -> Findings:
    """Beside the upright pole it is as good as Newton's form.

    Beside the inverted pole it is off by eps 10^k: digits are lost in proportion to the decades.
    """
    scenes = {k: varied(theta=f"{pole}1e-{k}", until="0.1") for k in range(8, 16)}
    errors = {
        k: tilt_error(integrate(scene, formulation="euler", record=("phi",)), scene)
        for k, scene in scenes.items()
    }
    lost = bool(pole) != bool(pole_of_the_law)
    share = max(error * (10.0**-k if lost else 1) for k, error in errors.items())
    visible = share > (0.1 if lost else 0)
    # each of 25 steps rounds theta again
    return (
        within(share, 30, "eps 10^k" if lost else "eps"),
        CaseOutcome("the law is reached in part" if visible else "the law is not reached", visible),
    )


@cache
def _body(precision: str) -> Parameters:
    top = load_scene("reference").body.dimensionless(FN, rounding_to(FN))
    into = arithmetic(precision).into
    return top.numbers(lambda x: into(FN.convert(x)))
