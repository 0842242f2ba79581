"""Judges of extreme cases: each compares a run with an independent expectation.

A judge integrates a case with ``integrate``, which the controls replace by wrong code; reference
runs call ``reference``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any, NamedTuple

import mpmath
import numpy

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.runtime.values import Functions, InputError, Scalar
from tt_precise.scene.scene import InitialState, Scene, load_scene

reference = integrate
DIGITS = 80  # Digits of the linear theory.
WIDE_BITS = 300  # Bits of the numbers that enter it.
BEFORE_S = "1e-12"  # Largest time between the end of a run and the blow-up of g_n.


class Measurement(NamedTuple):
    """The outcome of a case: verdict, measured value in the unit of the limit, and a text."""

    passes: bool
    value: float | None
    text: str


@dataclass(frozen=True)
class EdgeCase:
    """A scene at an edge: ``changes`` of the shipped scene ``base``, judged by ``judge``.

    ``limit`` is in the unit of the judge, which is the size of the expected roundings; it is larger
    where errors grow beside a singularity or contact ends at a shallow zero. ``options`` are
    arguments of ``integrate``; ``status`` is the expected end.
    """

    topic: str
    name: str
    judge: Callable[[EdgeCase], Measurement]
    changes: Mapping[str, Any] = field(default_factory=dict)
    limit: float = 10
    options: Mapping[str, Any] = field(default_factory=dict)
    status: str = "complete"
    base: str = "reference"

    @cached_property
    def scene(self) -> Scene:
        """The scene with the changes."""
        return load_scene(self.base).varied(**self.changes)


def judge_value(value: Scalar, case: EdgeCase, unit: str, run: Trajectory) -> Measurement:
    """Compare a value with the limit, and the status of the run with that of the case.

    NaN and infinity fail.
    """
    number = float(value)
    text = f"{number:.2g} {unit} (at most {case.limit:g}), {run.status}"
    return Measurement(0 <= number <= case.limit and run.status == case.status, number, text)


def random_walk(run: Trajectory) -> float:
    """Return eps sqrt(steps): the size of the sum of the roundings of all steps."""
    return float(run.precision.eps) * max(1, run.steps) ** 0.5


def is_refused(case: EdgeCase) -> Measurement:
    """The start is refused, because it does not hold at t = 0."""
    try:
        status = integrate(case.scene, **case.options).status
    except InputError as error:
        return Measurement("at t = 0, expected" in str(error), None, f"refused: {error}")
    return Measurement(False, None, f"accepted: {status}")


def conserves(case: EdgeCase) -> Measurement:
    """The conserved quantities drift by roundings alone."""
    run = integrate(case.scene, **case.options)
    drift = float(numpy.max([float(change) for change in run.drift.values()]))
    return judge_value(drift / random_walk(run), case, "eps sqrt(steps) of drift", run)


def matches_triple_double(case: EdgeCase) -> Measurement:
    """State and time at the end are those of the other integrator in triple-double."""
    run, fine = integrate(case.scene, **case.options), triple_double(case)
    fn = fine.precision.context
    late = abs(fn.mpf(run.t_end) - fine.t_end) / fine.t_end
    # after a loss of contact at another time the states are not comparable
    error = numpy.max([float(late), distance(run, fine)]) if run.status == fine.status else fn.inf
    unit = "eps sqrt(steps) from triple-double"
    return judge_value(error / random_walk(run), case, unit, run)


def blows_up(case: EdgeCase) -> Measurement:
    """The motion ends less than 1e-12 s before the denominator of g_n vanishes.

    The denominator falls as the square root of the remaining time: its square, by hand from states
    in triple-double (eq (7)), is extrapolated to zero.
    """
    run, fine = integrate(case.scene, **case.options), triple_double(case)
    fn = fine.precision.context
    first, second = (fine.t_end - fn.mpf(span) for span in (BEFORE_S, "1e-14"))
    a, b = (_denominator(fine, t) ** 2 for t in (first, second))
    remaining = second + (second - first) * b / (a - b) - fn.mpf(run.t_end)
    return judge_value(abs(remaining) / fn.mpf(BEFORE_S), case, f"{BEFORE_S} s before it", run)


def _denominator(run: Trajectory, t: Scalar) -> Scalar:
    """Return the denominator of eq (7) over I1, in units m = R = g = 1."""
    fn, state, start = run.precision.context, run.at(t), run.start
    body, speed = start.body, start.units.length / start.units.time
    s, c, alpha = fn.sin(state.theta), fn.cos(state.theta), body.alpha
    friction = alpha * s * (1 - alpha * c) * body.mu * state.nu_x / speed
    return 1 + (alpha**2 * s**2 - friction) / body.I1


def tilts_linearly(case: EdgeCase) -> Measurement:
    """Beside a pole k, L, v and phi_dot are those of linear equations, up to eps and theta^2."""
    run, scene, fn = integrate(case.scene, **case.options), case.scene, mpmath.MPContext()
    fn.dps = DIGITS
    start = InitialState.of(scene, precision_named("mp", WIDE_BITS).arithmetic)
    body, units, state = start.body.numbers(fn.convert), run.start.units, run.state
    side = -1 if scene.start.theta.from_pi else 1
    omega_3, t = fn.convert(start.euler.omega_3), fn.convert(start.until)
    matrix = tilt_matrix(body, side, omega_3, fn)
    expected = fn.expm(t * matrix) * fn.matrix([1, body.I3 * omega_3, 0])
    offset = scene.start.theta.offset
    tilt = fn.sin(fn.mpf(offset.numerator) / offset.denominator)
    speed = units.length / units.time
    horizontal = (
        (state.kx, state.ky, 1),
        (state.Lx, state.Ly, units.mass * units.length * speed),
        (state.vx, state.vy, speed),
    )
    computed = [fn.mpc(x, y) / fn.convert(unit) / tilt for x, y, unit in horizontal]
    scales = [abs(expected[0]), abs(expected[1]), max(abs(expected[2]), abs(omega_3))]
    errors = [float(abs(a - b) / s) for a, b, s in zip(computed, expected, scales, strict=True)]
    # k = |k| exp(i phi): phi_dot is the imaginary part of k'/k
    rate = (matrix * expected)[0] / expected[0]
    phi_dot = fn.convert(state.phi_dot) * fn.convert(units.time)
    errors.append(float(abs(phi_dot - rate.imag) / max(abs(rate), abs(omega_3))))
    allowed = random_walk(run) + float(offset) ** 2
    return judge_value(numpy.max(errors) / allowed, case, "(eps sqrt(steps) + theta^2)", run)


def tilt_matrix(body: Parameters, side: int, omega_3: Scalar, fn: Functions) -> Scalar:
    """Return the matrix A of (k, L, v)' = A (k, L, v) beside the spin k = side z.

    k, L and v are horizontal parts as complex numbers, in units m = R = g = 1. To first order
    g_n = 1 and a = alpha k - z, so that eq (1) is k' = L x k/I1, L' = a x F with F = z - mu v, and
    v' = -mu v + (omega x a)'. Nothing here comes from the equations under test.
    """
    alpha, I1, I3, mu = body.alpha, body.I1, body.I3, body.mu
    spin, height = side * I3 * omega_3, 1 - side * alpha
    k = [1j * spin / I1, -1j * side / I1, fn.mpf(0)]
    L = [-1j * alpha, fn.mpf(0), 1j * height * mu]
    c = side * spin * (1 / I3 - 1 / I1)  # omega = L/I1 + c k
    v: list[Any] = [
        1j * height * (L_dot / I1 + c * k_dot) + 1j * alpha * spin / I3 * k_dot
        for k_dot, L_dot in zip(k, L, strict=True)
    ]
    return fn.matrix([k, L, [v[0], v[1], v[2] - mu]])


def repeats_in_other_units(case: EdgeCase) -> Measurement:
    """The state is that of the same top in units of powers of two, to the last bit."""
    run, scene = integrate(case.scene, **case.options), case.scene
    body, start = scene.body, scene.start
    mass, length, time = Fraction(1, 64), Fraction(256), Fraction(16)  # g keeps its value
    scaled = replace(
        scene,
        body=replace(body, m=body.m * mass, R=body.R * length, mu=body.mu / time,
                     I1=body.I1 * mass * length**2, I3=body.I3 * mass * length**2),
        start=replace(start, theta_dot=start.theta_dot / time, omega_3=start.omega_3 / time),
        until=scene.until * time,
        text="",
    )  # fmt: skip
    other = reference(scaled, **case.options)
    equal = [getattr(run.state, n) == getattr(other.state, n) for n in ("kx", "ky", "kz", "theta")]
    passes = all(equal) and run.steps == other.steps and run.status == case.status
    return Measurement(passes, None, f"{sum(equal)} of 4 components equal, {run.status}")


def distance(run: Trajectory, fine: Trajectory) -> float:
    """Return the largest difference of k, L and v at the end, relative to each vector's size.

    v, which may nearly vanish, is relative to the speed of the rim at least.
    """
    fn, state = fine.precision.context, fine.state
    rim = abs(state.omega_3) * fn.convert(float(fine.scene.body.R))
    errors = []
    for vector in "kLv":
        names = [name for name in NewtonState._fields if name.startswith(vector)]
        pairs = [(fn.mpf(getattr(run.state, n)), getattr(state, n)) for n in names]
        size = max([*(abs(b) for _, b in pairs), rim if vector == "v" else 0]) or 1
        errors += [float(abs(a - b) / size) for a, b in pairs]
    return float(numpy.max(errors))


def triple_double(case: EdgeCase) -> Trajectory:
    """Return the reference run of a case, cached for its scene and contact."""
    return _triple_double(case.scene, case.options.get("contact", "unilateral"))


@cache
def _triple_double(scene: Scene, contact: str) -> Trajectory:
    return reference(scene, "triple-double", contact=contact)
