"""Passing the pole at every distance, and through it: Newton's form, and where Euler's ends.

The top is frictionless, so that everything is known in closed form. It falls towards the upright
pole with L.z and L.k almost equal; their difference keeps it away from the pole.
"""

from __future__ import annotations

import math
from functools import cache

from tt_precise.exact.arithmetic import own_context
from tt_precise.extremes import perturbed, theory
from tt_precise.extremes.case import Observation, case, finite, same, together, within
from tt_precise.extremes.perturbed import Integrate
from tt_precise.extremes.tilt import exact_start
from tt_precise.extremes.toy import varied
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics.newton import NewtonState
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

THETA, THETA_DOT, OMEGA_3 = "0.5", "-10", "20"  # rad, rad/s, rad/s
AFTER_S = "0.1"  # well behind the passage, which is at 0.04 s
ENERGY = "the energy of the frictionless top, a function of theta with L.z and L.k as constants"
DISTANCES = tuple(range(1, 14))
QUADRATURE_DIGITS = 30  # for a comparison in double
LARGEST_DOUBLE = math.log10(2) * 1024  # its decimal exponent


@cache
def passage(k: int) -> Scene:
    """A frictionless top whose L.z - L.k makes it pass the pole at about 1e-k rad."""
    scene = varied(
        theta=THETA, theta_dot=THETA_DOT, omega_3=OMEGA_3, mu="0", until=AFTER_S,
    )  # fmt: skip
    fn = own_context(80)
    theta, omega_3 = fn.mpf(THETA), fn.mpf(OMEGA_3)
    ratio = fn.mpf(scene.body.I3.numerator * scene.body.I1.denominator) / (
        scene.body.I3.denominator * scene.body.I1.numerator
    )
    missed = -fn.mpf(THETA_DOT) * fn.mpf(10) ** -k
    phi_dot = (missed + ratio * omega_3 * (1 - fn.cos(theta))) / fn.sin(theta) ** 2
    return scene.varied(phi_dot=fn.nstr(phi_dot, 70))


@cache
def nearest(k: int) -> tuple[Scalar, Scalar]:
    """Least theta of ``passage(k)``, and the rate of theta just before (dimensionless), in theory.

    mpmath numbers of 80 digits.
    """
    start, fn = exact_start(passage(k))
    body = start.body.map(fn.convert)
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
    least = theory.frictionless_turn(body, spin, vertical, energy, fn)
    return least, fn.sqrt(2 * theory.missing_energy(body, spin, energy) / body.I1)


@case(
    "passing the pole at 1e-{k} rad in double",
    expected="the least theta is the turning point that the energy allows",
    source=ENERGY,
    over={"k": DISTANCES},
    quick=True,
    control={"integrate": perturbed.integrating(phi_dot="1e-13")},
)
def passing(k: int, precision: str = "double", integrate: Integrate = integrate) -> Observation:
    """The axis keeps an absolute accuracy of some eps, at every distance."""
    run = integrate(passage(k), precision, events=("theta_min",))
    fn = run.precision.context
    (found,) = finite(run.events["theta"])
    error = abs(fn.mpf(found) - fn.convert(nearest(k)[0])) / run.precision.eps
    return together(within(error, 10, "eps"), same(run.status, "complete"))


@case(
    "passing the pole at 1e-{k} rad in quad",
    expected="the least theta is the turning point that the energy allows",
    source=ENERGY,
    over={"k": (12, 20, 30)},
    quick=lambda k: k == 20,
    control={"integrate": perturbed.integrating(phi_dot="1e-31")},
)
def passing_in_quad(k: int, integrate: Integrate = integrate) -> Observation:
    """The same with 34 digits."""
    return passing(k, "quad", integrate)


@case(
    "Euler form past the pole at 1e-{k} rad",
    expected="no digit of the state is lost; the price is steps, in proportion to the decades",
    source="the state from Newton's form in quad; steps of e^-2 times the distance from the spike "
    "(the rule of Jorba and Zou) make 34 a decade, fewer where its height loosens the tolerance",
    over={"k": (2, 4, 6, 8, 10, 12)},
    quick=lambda k: k in (6, 12),
    control={"integrate": perturbed.integrating(omega_3="1e-13")},
)
def euler_passing(k: int, integrate: Integrate = integrate) -> Observation:
    """Steps against the distance, and the error behind the passage."""
    euler = integrate(passage(k), formulation="euler", record=("phi",))
    newton = _integrated(k, "quad")
    if euler.status != "complete":
        return Observation(f"{euler.status} at {euler.t_end} s", False)
    # the first 15 steps are those before the approach, as many as Newton's form takes in all
    a_decade = (euler.steps - 15) / k
    return together(
        within(vector_distance(euler, newton) / euler.precision.eps, 50, "eps"),
        Observation(
            f"{a_decade:.0f} steps a decade", 24 < a_decade < 38,
            data={"steps": euler.steps, "decades": k},
        ),
    )  # fmt: skip


@case(
    "Euler form past the pole at 1e-{k} rad, where double ends",
    expected="it ends as failed within 1e-12 s of the passage, with the numbers before it; the "
    "Taylor coefficients of phi_dot, about (rate/theta)^order, have no double",
    source="2^1024, the order of the method, and the time of the least theta in quad",
    over={"k": (15, 20, 30)},
    quick=lambda k: k == 20,
    control={"k": 13},
)
def euler_overflowing(k: int) -> Observation:
    """Where the Euler form stops in double, which quad does not."""
    euler = _euler(k)
    quad = integrate(passage(k), "quad", events=("theta_min",))
    (passed,) = quad.events["t"]
    least, rate = nearest(k)
    size = (euler.order + 1) * math.log10(float(rate / least))
    finite(euler.state.values.values())
    return together(
        same(euler.status, "failed"),
        within(abs(float(passed) - euler.t_end), 1e-12, "s before the passage"),
        Observation(f"coefficients about 1e{size:.0f}", size > LARGEST_DOUBLE),
    )


@case(
    "Newton's form straight through the pole, from theta(0) = {theta} without spin",
    expected="the axis reaches half that tilt on the other side when the plane motion does",
    source="the plane motion, whose time is an integral over theta",
    over={"theta": ("1e-3", "0.1", "1", "2", "3")},
    quick=lambda theta: theta == "1",
    control={"integrate": perturbed.integrating(g="1e-12")},
)
def through_the_pole(theta: str, integrate: Integrate = integrate) -> Observation:
    """A top that does not spin falls in a plane, through the pole and up again."""
    run = integrate(falling(theta, until=2 * _fall(theta, 0.0) - _fall(theta, 0.5)))
    angle = float(theta) / 2
    errors = (run.state.kx + math.sin(angle), run.state.ky, run.state.kz - math.cos(angle))
    worst = max(map(abs, errors)) / float(run.precision.eps)
    return together(same(run.status, "complete"), within(worst, 40, "eps"))


@case(
    "Euler form straight into the pole, from theta(0) = {theta} without spin",
    expected="it ends as pole, at the time of the fall",
    source="the plane motion, whose time is an integral over theta",
    over={"theta": ("1e-3", "0.1", "1", "2", "3")},
    quick=lambda theta: theta == "1",
    control={"integrate": perturbed.integrating(g="1e-12")},
)
def into_the_pole(theta: str, integrate: Integrate = integrate) -> Observation:
    """Where the paper's equations stop, and Newton's go on."""
    fall = _fall(theta, 0.0)
    run = integrate(falling(theta, until=2 * fall), formulation="euler")
    eps = float(run.precision.eps)
    error = abs(run.t_end / float(fall) - 1) / eps
    return together(same(run.status, "pole"), within(error, 40, "eps of the time"))


def falling(theta: str, until: Scalar) -> Scene:
    """A frictionless top at rest, tilted by ``theta``; ``until`` in s, an mpmath number."""
    return varied(
        theta=theta, omega_3="0", mu="0", until=own_context(60).nstr(until, 50), sample_every="1"
    )


@cache
def _fall(theta: str, part: float) -> Scalar:
    """Seconds from ``theta`` down to this part of it, from theory."""
    start, _ = exact_start(falling(theta, own_context(60).mpf(1)))
    fn = own_context(QUADRATURE_DIGITS)
    body = start.body.map(lambda x: +fn.convert(x))
    angle = fn.mpf(theta)
    return theory.fall_time(body, angle, part * angle, fn) * fn.convert(start.units.time)


@cache
def _integrated(k: int, precision: str) -> Trajectory:
    return integrate(passage(k), precision)


@cache
def _euler(k: int) -> Trajectory:
    return integrate(passage(k), formulation="euler")


def vector_distance(run: Trajectory, reference: Trajectory) -> Scalar:
    """Largest difference of k, L and v at the end, each relative to the size of its vector.

    v, which may be nearly nothing, relative to the speed of the rim at least.
    """
    fn = reference.precision.context
    rim = abs(reference.state.omega_3) * fn.convert(float(reference.scene.body.R))
    worst = fn.mpf(0)
    for vector in "kLv":
        names = [name for name in NewtonState._fields if name.startswith(vector)]
        mine = finite(getattr(run.state, name) for name in names)
        better = finite(getattr(reference.state, name) for name in names)
        scale = max([*map(abs, better), rim] if vector == "v" else map(abs, better)) or 1
        worst = max(
            [worst, *(abs(fn.mpf(a) - b) / scale for a, b in zip(mine, better, strict=True))]
        )
    return worst
