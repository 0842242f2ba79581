"""The effective potential V(z, D, lambda): its minima, and motion in it with D and E~ frozen."""

from __future__ import annotations

from typing import NamedTuple

from tt_precise.mechanics.quantities import effective_mass, effective_potential
from tt_precise.runtime.arithmetic import Functions, Scalar
from tt_precise.scene.body import Parameters

REACH = 40  # in u: 1 - |z| down to 1e-34, so the context needs some 60 digits
COARSE = 4  # eighths
NODES = 200  # of the period's quadrature, which converges geometrically


class Swing(NamedTuple):
    """Motion between two walls: theta at both (rad), and the time from one to the other (s)."""

    lowest: float
    highest: float
    time: float


def minimum(body: Parameters, D: Scalar, lambda_: Scalar, fn: Functions) -> Scalar:
    """cos theta at the lowest minimum of V, to the precision of the mpmath context ``fn``.

    Sought in u with z = tanh u, which spreads both poles out to infinity, and makes every well
    about 1 wide: steps of 1/2 see each of them, and the bottoms are told apart in steps of 1/8.
    """

    def V(u: Scalar) -> Scalar:
        return effective_potential(body, fn.tanh(u), D, lambda_, fn)

    coarse = {i: V(fn.mpf(i) / 8) for i in range(-REACH * 8, REACH * 8 + 1, COARSE)}
    wells = [i for i in list(coarse)[1:-1] if coarse[i - COARSE] >= coarse[i] <= coarse[i + COARSE]]
    near = {j for i in wells for j in range(i - COARSE + 1, i + COARSE)}
    lowest = min(near, key=lambda i: V(fn.mpf(i) / 8))
    bracket = fn.mpf(lowest - 1) / 8, fn.mpf(lowest + 1) / 8
    found = fn.findroot(lambda u: fn.diff(V, u), bracket, solver="anderson", verify=False)
    return fn.tanh(found)


def minima(body: Parameters, D: float, lambda_: float) -> list[float]:
    """theta (rad) at all minima of V in double, on a grid refined towards both poles.

    None is seen within 3e-4 rad of a pole, where 1 - z^2 has lost half of its digits.
    """
    import numpy

    u = numpy.linspace(-9.0, 9.0, 20_001)
    V = effective_potential(body, numpy.tanh(u), D, lambda_, numpy)
    inside = numpy.flatnonzero((V[1:-1] < V[:-2]) & (V[1:-1] <= V[2:])) + 1
    return [float(angle) for angle in numpy.arccos(numpy.tanh(u[inside]))]


def swing(body: Parameters, D: float, E_tilde: float, lambda_: float) -> Swing | None:
    """The motion that (D, E~) would make if they stayed as they are; None at rest in the minimum.

    The time is the integral of sqrt(g/(E~ - V)) over theta, smooth in the angle that turns the
    walls' inverse square roots into constants.
    """
    import math

    import numpy
    from scipy.optimize import brentq, minimize_scalar

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
    return Swing(walls[0], walls[1], float(slowness.sum() * math.pi / NODES))
