"""Events of random scenes against an integrator of other make: ``python -m benchmarks.witness``.

Only a scene's numbers are the package's.

Newton's equations of a sphere with an axis, from the laws of linear and angular momentum, with the
contact force solved for numerically from what it has to achieve, in numbers of 113 bits. Each step
is a polynomial through Chebyshev's points, found by Picard's iteration; events are sign changes of
functions along it, between the zeros of their derivatives. In units of m = R = g = 1. Vectors and
states have axes (entry, point).
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import gmpy2
import numpy
from numpy.polynomial import chebyshev

from tt_precise.integration import catalogue, integrate
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene

BITS, POINTS = 113, 28
TAIL = 1e-22  # Relative size of the last three coefficients of a step's polynomials.
FIRST, LONGEST, SHORTEST = 1e-12, 0.25, 1e-14
MOST_ITERATIONS = 80
UNITS = numpy.eye(3)[:, :, None]
UNTIL_S = "0.090351"  # 2 sqrt(R/g)
SEEN = 1e-11  # s; earlier zeros are lost beside one at the start itself
# Relative distance in time of two zeros: the square root of the witness's error.
TOUCH = 1e-9
# how a scene is integrated; relative and absolute bounds of times in s
WAYS: tuple[tuple[dict[str, Any], tuple[float, float]], ...] = (
    ({"digits": 9}, (1e-6, 1e-9)),
    ({"precision": "double"}, (1e-4, 1e-7)),
    ({"precision": "double-double"}, (1e-6, 1e-9)),
)


def cross(a: Any, b: Any) -> Any:
    """The cross product, ten times as fast as NumPy's for few vectors."""
    return numpy.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def dot(a: Any, b: Any) -> Any:
    """The scalar product."""
    return (a * b).sum(axis=0)


@dataclass(frozen=True)
class Top:
    """A body and what acts at its lowest point; the state: k, L, velocity of the centre, height.

    ``kind`` is "gliding", "rolling", "flight" or "spring"; ``coefficient`` is that of friction, a
    function of v_A^2; ``spring`` gives the push of the table by height and rise.
    """

    alpha: Any
    I1: Any
    I3: Any
    kind: str
    coefficient: Callable[[Any], Any]
    spring: Callable[[Any, Any], Any]

    def contact(self, y: Any) -> tuple[Any, Any, Any, Any, Any]:
        """k, L, omega, a, and the velocity of the lowest point."""
        k, L, s = y[:3], y[3:6], y[6:9]
        omega = L / self.I1 + (1 / self.I3 - 1 / self.I1) * dot(L, k) * k
        a = self.alpha * k - UNITS[2]
        return k, L, omega, a, s + cross(omega, a)

    def acceleration(self, y: Any, force: Any) -> Any:
        """That of the lowest point, as a point of the body that follows it, under ``force``."""
        k, L, omega, a, _ = self.contact(y)
        torque, moving = cross(a, force), cross(omega, k)
        along = (dot(torque, k) + dot(L, moving)) * k + dot(L, k) * moving
        turning = torque / self.I1 + (1 / self.I3 - 1 / self.I1) * along
        return force + cross(turning, a) + cross(omega, self.alpha * moving) - UNITS[2]

    def force(self, y: Any) -> Any:
        v, none = self.contact(y)[4], 0 * y[:3]
        if self.kind == "flight":
            return none
        slant = UNITS[2] - self.coefficient(v[0] * v[0] + v[1] * v[1]) * v * [[1], [1], [0]]
        if self.kind == "spring":
            return self.spring(y[9], v[2]) * slant
        without = self.acceleration(y, none)
        if self.kind == "rolling":  # the lowest point is not accelerated; Cramer's rule
            a, b, c = (self.acceleration(y, none + unit) - without for unit in UNITS)
            parts = (cross(b, c), cross(c, a), cross(a, b))
            return -numpy.array([dot(without, part) for part in parts]) / dot(a, parts[0])
        return -without[2] / (self.acceleration(y, slant) - without)[2] * slant

    def rates(self, y: Any) -> Any:
        k, _, omega, a, v = self.contact(y)
        force = self.force(y)
        height = v[2:] if self.kind in ("flight", "spring") else 0 * v[2:]
        return numpy.concatenate((cross(omega, k), cross(a, force), force - UNITS[2], height))

    def functions(self, y: Any) -> dict[str, Any]:
        """Return the functions whose zeros are events; minima and maxima of theta have one."""
        k, L, omega, _, v = self.contact(y)
        moving = cross(omega, k)
        spin, towards = dot(L, k), v[0] * k[0] + v[1] * k[1]
        across = v[1] * k[0] - v[0] * k[1]
        named = {
            "turning": moving[2],
            "phi_dot_zero": k[0] * moving[1] - k[1] * moving[0],
            "equator": k[2],
            "omega_3_zero": spin,
            "Lk_equals_Lz": spin - L[2],
            "Lk_equals_minus_Lz": spin + L[2],
        }
        if self.kind not in ("rolling", "flight"):
            named |= {"nu_x_zero": towards, "nu_y_zero": across, "nu_crossing": across - towards}
        return named | {"end": y[9] if self.kind == "flight" else self.force(y)[2]}


def exactly(number: Any) -> Any:
    """The number in the arithmetic of the context."""
    return gmpy2.mpfr(gmpy2.mpq(number))


def witness(scene: Scene, number: Any = exactly) -> tuple[Top, list[Any], float, Any]:
    """The top, its start, its horizon, and the unit of time in s."""
    body, start = scene.body, scene.start
    m, R, g, alpha, mu = (number(getattr(body, name)) for name in ("m", "R", "g", "alpha", "mu"))
    I1, I3 = (number(x) / (m * R * R) for x in (body.I1, body.I3))
    second, speed = (g / R) ** 0.5, (g * R) ** 0.5
    epsilon = number(body.numbers_by_name.get("epsilon", 0)) / speed
    coefficient = {
        "viscous": lambda square: mu * speed + 0 * square,
        "regularised": lambda square: mu / (square + epsilon * epsilon) ** 0.5,
        "coulomb": lambda square: mu / square**0.5,
    }[body.law]
    stiffness, damping = number(body.stiffness) / (m * g), number(body.damping) * speed

    def spring(height: Any, rise: Any) -> Any:
        if body.spring == "linear":
            return -stiffness * R * height - damping / (m * g) * rise
        return stiffness * numpy.maximum(-height * R, 0) ** 1.5 * (1 - damping * rise)

    kind = "spring" if body.spring else scene.model
    sine, cosine = map(number, gmpy2.sin_cos(exactly(start.theta.offset)))
    k = numpy.array((sine, number(0), -cosine if start.theta.from_pi else cosine))
    across = numpy.array((k[2], 0, -sine))
    theta_dot, phi_dot, omega_3, nu_x, nu_y, height, rise = (
        number(getattr(start, name, 0))
        for name in ("theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y", "height", "rise")
    )
    turning = omega_3 * k - phi_dot * sine * across + theta_dot * numpy.array((0, 1, 0))
    omega = turning / second
    L = I1 * omega + (I3 - I1) * dot(omega, k) * k
    s = numpy.array((nu_x, nu_y, rise)) / speed - cross(omega, alpha * k - UNITS[2][:, 0])
    top = Top(alpha, I1, I3, kind, coefficient, spring)
    return top, [*k, *L, *s, height / R], float(number(scene.until) * second), 1 / second


@cache
def _tables() -> tuple[Any, Any]:
    """The matrix of integrals from 0 to Chebyshev's points on 0 to 1, that of coefficients."""
    n = POINTS - 1
    angles = [gmpy2.const_pi() * (n - i) / n for i in range(POINTS)]
    ends = [gmpy2.mpfr(1 if 0 < j < n else 0.5) for j in range(POINTS)]
    to_c = numpy.array(
        [
            [2 * a * b * gmpy2.cos(j * angle) / n for a, angle in zip(ends, angles, strict=True)]
            for j, b in enumerate(ends)
        ]
    )
    x = numpy.array([gmpy2.cos(angle) for angle in angles])
    return chebyshev.chebval(x, chebyshev.chebint(to_c, lbnd=-1)).T / 2, to_c


def _step(top: Top, y: Any, h: Any) -> Any | None:
    """The states at the points of a step, or None where it is too long."""
    integral, to_c = _tables()
    states, before = y + numpy.zeros(POINTS, dtype=int), numpy.inf
    for _ in range(MOST_ITERATIONS):
        after = y + h * top.rates(states).dot(integral.T)
        moved, states = float(abs(after - states).max()), after
        if not moved < 1e6:
            return None
        if moved < 1e-30 or (moved >= before and moved < 1e-26):
            tail = abs(to_c[-3:].dot(states.T)).max()
            return states if tail < TAIL * max(1, abs(states).max()) else None
        before = moved
    return None


def _zeros(values: Any) -> Iterator[tuple[Any, int]]:
    """Places in 0 to 1 where the interpolant of ``values`` changes sign, and how."""
    c = _tables()[1].dot(values)
    size = abs(c).max()
    if size < 1e-25:  # rounding of what vanishes identically
        return
    slope = chebyshev.chebder((c / size).astype(float))
    turns = chebyshev.chebroots(numpy.trim_zeros(slope, "b"))
    inner = sorted(t.real for t in turns if abs(t.imag) < 1e-6 and -1 < t.real < 1)
    ends = [gmpy2.mpfr(x) for x in (-1, *inner, 1)]
    heights = [chebyshev.chebval(x, c) for x in ends]
    for low, high, a, b in zip(ends, ends[1:], heights, heights[1:], strict=False):
        if (a > 0) == (b > 0) or not a or not b:
            continue
        for _ in range(BITS):
            middle = (low + high) / 2
            beyond = (chebyshev.chebval(middle, c) > 0) == (b > 0)
            low, high = (low, middle) if beyond else (middle, high)
        yield (1 + (low + high) / 2) / 2, 1 if b > a else -1


def follow(top: Top, start: Any, until: float) -> tuple[list[tuple[str, Any, int]], Any, bool]:
    """Events (name, time, direction), the time of the end, or up to which it could be followed.

    And whether that is the end.
    """
    y = numpy.array([[gmpy2.mpfr(entry)] for entry in start])
    t, h = gmpy2.mpfr(0), gmpy2.mpfr(FIRST)
    events: list[tuple[str, Any, int]] = []
    silent = {name for name, value in top.functions(y).items() if abs(value[0]) < 1e-28}
    while t < until:
        h = min(h, gmpy2.mpfr(until) - t)
        states = _step(top, y, h)
        if states is None:
            h = h / 2
            if h < max(SHORTEST, t / 1000):  # as where Coulomb's friction comes to rest
                break
            continue
        zeros = []
        for name, values in top.functions(states).items():
            if t or name not in silent:  # its zero at the start; there is none other so soon
                zeros += [(name, t + u * h, sign) for u, sign in _zeros(values)]
        for name, time, sign in sorted(zeros, key=lambda zero: zero[1]):
            if name == "end" and sign < 0:
                return events, time, True
            if name != "end":
                events.append((name, time, sign))
        t, y, h = t + h, states[:, -1:], min(2 * h, gmpy2.mpfr(LONGEST))
    return events, t, t >= until


def drawn(seed: int, elastic: bool = False) -> Scene:
    """A random scene; on an elastic table only where ``elastic``."""
    r = random.Random(seed)

    def log(low: float, high: float) -> str:
        return f"{10 ** r.uniform(low, high):.6e}"

    def some(size: float) -> str:
        return r.choice(("0", f"{r.uniform(-size, size):.4f}"))

    model = r.choice(("gliding",) * 6 + ("rolling", "flight"))
    law = r.choice(("viscous", "regularised", "coulomb")) if model == "gliding" else "viscous"
    body = {"m": "0.02", "R": "0.02", "g": "9.8"}
    body |= {"alpha": f"{r.uniform(0.01, 0.99):.4f}", "I1": f"{r.uniform(0.1, 1):.4f}"}
    body["I3"] = f"{float(body['I1']) * r.uniform(0.3, 1.9):.4f}"
    mu = r.choice(("0", log(-2, 2))) if law == "viscous" else log(-2, 0)
    offset = r.choice((log(-7, -1), f"{r.uniform(0.1, 1.5):.4f}"))
    start = {"theta": f"pi - {offset}" if r.random() < 0.3 else offset}
    spin = r.choice((5, 50, 200))
    start |= {"theta_dot": some(20), "phi_dot": some(60), "omega_3": some(spin)}
    gliding = {"nu_x": some(0.5), "nu_y": some(0.5)}
    if law == "coulomb":
        gliding["nu_x"] = f"{r.uniform(0.1, 0.5):.4f}"  # at rest it would roll
    if model != "rolling":
        start |= gliding
    table = {"stiffness": log(2, 4), "damping": r.choice(("0", log(-3, 0)))}
    more: dict[str, Any] = {}
    if elastic:
        model, law, mu = "gliding", "viscous", log(-2, 1)
        start |= {"height": "-0.0002", "rise": "0"}
        more["contact"] = {"law": "compliant", "force": "linear", **table}
    elif model == "flight":
        start |= {"height": "0.02", "rise": "0.3"}
    if law != "viscous":
        more["friction"] = {"law": law, "mu": mu}
        more["friction"] |= {"epsilon": "0.01"} if law == "regularised" else {}
    elif model != "flight":
        body["mu"] = mu
    run = {"until": UNTIL_S, "sample_every": "0.01"}
    return Scene.of(name=f"case-{seed}", model=model, body=body, start=start, run=run, **more)


def apart(zeros: list[tuple[Any, int]]) -> list[tuple[Any, int]]:
    """Without pairs so near that the witness cannot tell them from a touch of zero."""
    kept: list[tuple[Any, int]] = []
    for time, sign in zeros:
        if kept and time - kept[-1][0] < TOUCH * time:
            kept.pop()
        else:
            kept.append((time, sign))
    return kept


def compared(scene: Scene, witnessed: Scene | None = None) -> str:
    """Return what was compared, or why nothing was; raise where the two disagree."""
    runs, refused = [], ""
    for chosen, bounds in WAYS:
        try:
            run = integrate(scene, events=catalogue(scene.model), **chosen)
            runs.append((run, () if "digits" in chosen else run.unresolved, bounds))
        except InputError as refusal:
            refused = str(refusal)
    if not runs:
        assert "g_n is" in refused, f"{refused}\n{scene}"
        return "refused"
    with gmpy2.context(precision=BITS):
        top, start, until, second = witness(witnessed or scene)
        events, end, ended = follow(top, start, until)
        events = [(name, t * second, sign) for name, t, sign in events]
        last = float(end * second) * (1 if ended else 0.99)
        for run, hidden, bounds in runs:
            assert_agree(run, hidden, events, last, ended, bounds)
    return "no digits" if "digits" in refused else f"{len(events)} events"


def assert_agree(
    run: Any, hidden: Sequence[str], events: list[Any], last: float, ended: bool, bounds: Any
) -> None:
    """Compare a run's events up to the time ``last``, and its end there if it has ``ended``.

    Not those that are ``hidden``: a run in a chosen precision says which its rounding hides.
    """
    kinds, table = {"theta_min": -1, "theta_max": 1}, run.events
    for name in (name for name in run.setup.events if name not in hidden):
        function = "turning" if name in kinds else name
        zeros = apart([(t, sign) for n, t, sign in events if n == function])
        true = [float(t) for t, sign in zeros if sign == kinds.get(name, sign)]
        true = [t for t in true if SEEN < t <= last]
        times = [float(t) for t in table["t"][table["name"] == name] if SEEN < t <= last]
        said = f"{name}, {run!r}, followed to {last}\n{times}\n{true}\n{run.scene}"
        assert alike(times, true, *bounds), said
    if ended:
        end = float([*table["t"][table["name"] == "separation"], run.t_end][0])
        assert alike([end], [last], 1e-9, 1e-12), f"{run!r}\n{run.scene}"


def alike(times: list[float], true: list[float], relative: float, absolute: float) -> bool:
    """Return whether there are as many times as true ones, each within one of the bounds."""
    pairs = zip(times, true, strict=False)
    near = all(abs(t - x) <= max(relative * abs(x), absolute) for t, x in pairs)
    return near and len(times) == len(true)


def main(first: str = "0", last: str = "300") -> None:
    """Compare the scenes of a range of seeds, and print what was compared."""
    for seed in range(int(first), int(last)):
        try:
            print(seed, compared(drawn(seed)), flush=True)
        except AssertionError as difference:
            print(seed, "DIFFERENT", difference, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
