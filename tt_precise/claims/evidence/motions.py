"""Motions beyond the runs of this package.

These are motions in the effective potential V(z, D, lambda) with frozen D and E~; steady motions
with their stability; a solution continued to negative times; the paper's own computation with
odeint.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import NamedTuple

import numpy
from scipy.integrate import odeint, solve_ivp
from scipy.optimize import brentq, minimize_scalar

from tt_precise.claims.evidence.run import Run, SceneLike, variant
from tt_precise.exact.stability import is_stable, linearised, own_context, rounding_to
from tt_precise.mechanics import euler, newton
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion, effective_mass, effective_potential
from tt_precise.mechanics.thresholds import lambda_thres, lambda_up, tumbling_lambda_squared
from tt_precise.runtime.values import Array, Functions, Scalar

LARGEST_U = 40  # Largest u: 1 - |z| falls to 1e-34, so the context needs some 60 digits.
COARSE = 4  # Width of the coarse grid in eighths.
NODES = 200  # Nodes of the period's quadrature, which converges geometrically.
SEED = 1871
DIGITS = 50  # Central differences with a step of 1e-25 leave half of these digits.
SLICES = 400  # Tumbling motions are sought in so many slices of cos theta.
TOLERANCE = 1e-12
OUTPUT_S = "0.01"  # Seconds between the output times of odeint.
HORIZON = 1000.0  # Time in units of sqrt(R/g): some 45 s for the toy.


# ---- the effective potential -------------------------------------------------------------------


def minimum(body: Parameters, D: Scalar, lambda_: Scalar, fn: Functions) -> Scalar:
    """cos theta at the lowest minimum of V, to the precision of the mpmath context ``fn``.

    Searched in u with z = tanh u, which moves both poles to infinity and makes every well about 1
    wide: steps of 1/2 find each well, and steps of 1/8 separate their minima.
    """

    def V(u: Scalar) -> Scalar:
        return effective_potential(body, fn.tanh(u), D, lambda_, fn)

    coarse = {i: V(fn.mpf(i) / 8) for i in range(-LARGEST_U * 8, LARGEST_U * 8 + 1, COARSE)}
    wells = [i for i in list(coarse)[1:-1] if coarse[i - COARSE] >= coarse[i] <= coarse[i + COARSE]]
    near = {j for i in wells for j in range(i - COARSE + 1, i + COARSE)}
    lowest = min(near, key=lambda i: V(fn.mpf(i) / 8))
    bracket = fn.mpf(lowest - 1) / 8, fn.mpf(lowest + 1) / 8
    lowest_u = fn.findroot(lambda u: fn.diff(V, u), bracket, solver="anderson", verify=False)
    return fn.tanh(lowest_u)


def minima(body: Parameters, D: float, lambda_: float) -> list[float]:
    """theta (rad) at all minima of V in double: vertices of parabolas on a grid.

    Minima within 3e-4 rad of a pole are not found: there 1 - z^2 has lost half of its digits.
    """
    u = numpy.linspace(-9.0, 9.0, 20_001)
    V = effective_potential(body, numpy.tanh(u), D, lambda_, numpy)
    inside = numpy.flatnonzero((V[1:-1] < V[:-2]) & (V[1:-1] <= V[2:])) + 1
    before, here, after = V[inside - 1], V[inside], V[inside + 1]
    vertex = u[inside] + (u[1] - u[0]) / 2 * (before - after) / (before - 2 * here + after)
    return [float(angle) for angle in numpy.arccos(numpy.tanh(vertex))]


def swing_time(body: Parameters, D: float, E_tilde: float, lambda_: float) -> float | None:
    """Seconds from wall to wall for constant (D, E~); None at rest in the minimum.

    The time is the integral of sqrt(g/(E~ - V)) over theta, smooth in the angle that turns the
    walls' inverse square roots into constants.
    """

    def V(theta: float) -> float:
        return float(effective_potential(body, math.cos(theta), D, lambda_, math))

    near, far = 1e-6, math.pi - 1e-6  # nearer to a pole 1 - cos^2 has no digits left
    middle = minimize_scalar(V, bounds=(near, far), method="bounded", options={"xatol": 1e-12}).x
    if V(middle) >= E_tilde:
        return None
    walls = [brentq(lambda t: V(t) - E_tilde, end, middle, xtol=1e-15) for end in (near, far)]
    half = (walls[1] - walls[0]) / 2
    angle = (numpy.arange(NODES) + 0.5) / NODES * math.pi - math.pi / 2
    z = numpy.cos(sum(walls) / 2 + half * numpy.sin(angle))
    depth = E_tilde - effective_potential(body, z, D, lambda_, numpy)
    slowness = numpy.sqrt(effective_mass(body, z) / depth) * half * numpy.cos(angle)
    return float(slowness.sum() * math.pi / NODES)


# ---- steady motions ----------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A body with m = R = 1 (exact), and lambda as a multiple of a threshold."""

    alpha: Fraction
    gamma: Fraction
    I3: Fraction
    mu: Fraction
    multiple: Fraction

    def body(self, fn: Functions, gravity: Scalar = 1) -> Parameters:
        """The body in the mpmath context ``fn``."""
        convert = rounding_to(fn)
        return Parameters(
            m=fn.mpf(1), R=fn.mpf(1), alpha=convert(self.alpha),
            I1=convert(self.gamma * self.I3), I3=convert(self.I3), g=gravity, mu=convert(self.mu),
        )  # fmt: skip


def cases(count: int, multiples: tuple[str, str] = ("1.001", "3")) -> list[Case]:
    """Random bodies with 1 - alpha < gamma < 1 + alpha and I3 <= 2 I1, seeded.

    ``multiples`` are the ends of the range of lambda.
    """
    draw = random.Random(SEED)

    def between(a: Fraction, b: Fraction) -> Fraction:
        return a + (b - a) * Fraction(draw.randrange(1, 10**6), 10**6)

    drawn = []
    for _ in range(count):
        alpha = between(Fraction(1, 20), Fraction(19, 20))
        drawn.append(
            Case(
                alpha=alpha,
                gamma=between(max(1 - alpha, Fraction(1, 2)), 1 + alpha),
                I3=between(Fraction(1, 5), Fraction(2, 3)),
                mu=between(Fraction(1, 100), Fraction(1)),
                multiple=between(*map(Fraction, multiples)),
            )
        )
    return drawn


def growth(case: Case, side: int) -> int:
    """Return +1 if the upright (+1) or inverted (-1) spin is unstable, -1 if it is stable.

    From the equations of motion, linearised; lambda is the case's multiple of
    max(lambda_thres, lambda_up).
    """
    fn = own_context(DIGITS)
    body = case.body(fn)
    lambda_ = rounding_to(fn)(case.multiple) * largest_threshold(body, fn)
    rate = lambda_ / (body.I3 * body.R * (1 - side * body.alpha))
    return -1 if is_stable(linearised(body, side, rate)) else 1


def largest_threshold(body: Parameters, fn: Functions) -> Scalar:
    """max(lambda_thres, lambda_up)."""
    return max(lambda_thres(body, fn), lambda_up(body, fn))


def tumbles(case: Case) -> bool:
    """True if a tumbling motion has the case's lambda or a larger lambda."""
    fn = own_context(DIGITS)
    body = case.body(fn)
    limit = (rounding_to(fn)(case.multiple) * largest_threshold(body, fn)) ** 2
    inside = (fn.mpf(2 * i + 1) / SLICES - 1 for i in range(SLICES))
    return any(tumbling_lambda_squared(body, z) >= limit for z in inside)


# ---- the past of a solution --------------------------------------------------------------------


class Past(NamedTuple):
    """The end of a solution's past: at a loss of contact, or at the horizon.

    ``t`` in s, theta in rad, the energy there in units of the start's.
    """

    contact_lost: bool
    t: float
    theta: float
    energy_ratio: float


@cache
def past(scene: SceneLike = "reference", tolerance: float = TOLERANCE) -> Past:
    """Follow a scene's start back to the horizon, or to the begin of contact."""
    start = Run(scene).trajectory().start
    exact = start.body
    body = exact.numbers(float)

    def rates(_: float, y: Array) -> Array:
        return newton.rates(body, NewtonState(*y))

    def normal_force(_: float, y: Array) -> Array:
        return newton.contact_terms(body, NewtonState(*y))[0]

    normal_force.terminal = True  # type: ignore[attr-defined]
    begin = [float(component) for component in start.vectors]
    solution = solve_ivp(
        rates, (0, -HORIZON), begin, method="DOP853", rtol=tolerance, atol=tolerance / 100,
        events=normal_force,
    )  # fmt: skip
    if solution.status < 0:
        raise ArithmeticError(f"the past of {scene}: SciPy's DOP853 gave up: {solution.message}")
    ends = (NewtonState(*solution.y[:, column].tolist()) for column in (0, -1))
    first, last = (Motion(body, state, math) for state in ends)
    energies = [QUANTITIES["E"].evaluate(q) for q in (first, last)]
    return Past(
        contact_lost=solution.status == 1,
        t=float(solution.t[-1]) * float(start.units.time),
        theta=QUANTITIES["theta"].evaluate(last),
        energy_ratio=energies[1] / energies[0],
    )


# ---- the paper's own computation ---------------------------------------------------------------


@cache
def paper_odeint(scene: SceneLike = "reference") -> tuple[EulerState, float]:
    """A scene integrated by the paper's method, with output every 0.01 s.

    The columns of the Euler state (SI), and the largest relative change of lambda.
    """
    loaded = variant(scene, sample_every=OUTPUT_S)
    body = loaded.body.numbers(float)
    begin = [loaded.start.theta.radians(math, float)]
    begin += [float(getattr(loaded.start, name)) for name in EulerState._fields[1:]]
    times = numpy.array([float(t) for t in loaded.sample_times])
    rows, info = odeint(
        lambda y, _: euler.rates(body, EulerState(*y), math), begin, times, full_output=True
    )
    if info["message"] != "Integration successful.":
        raise ArithmeticError(f"odeint gave {scene} up: {info['message']}")
    state = EulerState(*rows.T)
    jellett = euler.jellett(body, state, numpy)
    return state, float(abs(jellett / jellett[0] - 1).max())


def state_errors(scene: SceneLike = "reference") -> dict[str, float]:
    """Largest error of each entry of the odeint solution at its output times (SI)."""
    truth = Run(scene).sampled(EulerState._fields, OUTPUT_S)
    return {
        name: float(abs(column - truth[name].to_numpy()).max())
        for name, column in paper_odeint(scene)[0]._asdict().items()
    }
