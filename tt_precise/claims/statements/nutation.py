"""Abstract, sections 1 and 2.1: theta(t) oscillates about a logistic curve."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.evidence.proved import count, proofs_of
from tt_precise.claims.measured import decimal
from tt_precise.claims.verdicts import Finding, all_of, judged, readings, statement
from tt_precise.runtime.arithmetic import Array

SECTION = "Sec. 2.1"
MANY = 10
BAND = (
    "the band at a turning point of theta: the distance from it to the straight line between the "
    "turning points before and after it"
)
PAUSE_S = 0.2  # twice the longest nutation; a longer gap between turning points is no nutation


class Belt(NamedTuple):
    """The band at one turning point: when, its middle and its width (rad)."""

    t: float
    middle: float
    width: float


@claim(
    "QUAL-01",
    quote="theta(t) oscillates (meaning that theta_dot(t) changes sign many times)",
    where="Abstract; Sec. 1; 2.1",
    definition=f"turning points of theta between 0.2 and pi - 0.2; many: at least {MANY}",
    control={"scene": "smoothest"},
)
def oscillation(scene: SceneLike = "reference") -> Finding:
    """During the inversion theta oscillates: theta_dot changes sign many times."""
    turns = series.turning_points(scene)
    near, far = 0.2, math.pi - 0.2
    inside = turns[(turns["theta"] > near) & (turns["theta"] < far)]
    times = [0.0, *turns["t"]]
    gap, begin = max((float(b - a), float(a)) for a, b in pairwise(times))
    known = proofs_of(scene)
    proved_turns = known.events("theta_min", "theta_max")
    surely = (
        None
        if proved_turns is None
        else count(proved_turns, "theta", Fraction(near), Fraction(far))
    )
    proved = surely is not None and all(number == len(inside) for number in surely)
    return judged(
        statement(
            len(inside) >= MANY,
            printed="theta_dot changes sign many times",
            measured=f"{len(inside)} times during the inversion, {len(turns)} times in all",
        ),
        f"The longest time without a turning point is {decimal(gap, 3)} s, from "
        f"{decimal(begin, 4)} s on."
        + known.sentence(
            proved, "there are exactly these turning points, all of them simple zeros"
        ),
        proved=proved,
    )


@claim(
    "QUAL-02",
    quote="a general form of a logistic type curve superposed with small amplitude oscillations",
    where=SECTION,
    definition="least-squares fit of pi/(1 + exp(-k (t - t0))) over the climb (definition A), "
    "which shall leave at most 1 % of the variance; the middle of the band rises throughout; "
    f"small: the band is narrower than pi/10; {BAND}",
    control={"name": "omega_3"},
)
def logistic_curve(name: str = "theta", scene: SceneLike = "reference") -> Finding:
    """theta(t) has the form of a logistic curve with small oscillations about it."""
    span = series.climb(scene)
    rate, centre, left = _logistic_fit(name, scene, span)
    belts = [belt for belt in _belts(scene) if span.has(belt.t)]
    falls = sum(b.middle < a.middle for a, b in pairwise(belts))
    width = max(belt.width for belt in belts)
    half = float(evidence.trajectory(scene).inversion.equator)
    return all_of(
        {
            "logistic": statement(
                left <= 0.01,
                printed="logistic type curve",
                measured=f"k = {rate:.2f} 1/s, t0 = {centre:.2f} s leave {100 * left:.2g} % of the "
                "variance",
            ),
            "middle of the band": statement(
                falls == 0, printed="rises", measured=f"falls {falls} of {len(belts) - 1} times"
            ),
            "oscillations": statement(
                width < math.pi / 10,
                printed="small amplitude",
                measured=f"the band is at most {decimal(width, 3)} rad wide",
            ),
        },
        f"The curve is not symmetric: theta needs {decimal(half - span.begin, 3)} s to pi/2 and "
        f"{decimal(span.end - half, 3)} s from there.",
    )


@claim(
    "QUAL-08",
    quote="widening of the nutational band when theta(t) is crossing pi/2",
    where=SECTION,
    definition=BAND + "; as in the text, large theta_dot stands for a wide band",
    control={"widest": 0.78},
)
def nutation_band(widest: float = math.pi / 2, scene: SceneLike = "reference") -> Finding:
    """The nutation band widens when theta crosses pi/2 and narrows near the south pole."""
    belts = _belts(scene)
    at = min(belts, key=lambda belt: abs(belt.middle - widest))
    start = min(belts, key=lambda belt: abs(belt.t - series.climb(scene).begin))
    last, widest_one = belts[-1], max(belts, key=lambda belt: belt.width)
    fastest = series.extreme("theta_dot", scene, largest=True)
    times, speeds = series.extrema("theta_dot", scene)
    when, half = float(times[speeds.argmax()]), evidence.trajectory(scene).inversion.equator
    return readings(
        {
            "wider than at t_init and at the end": statement(
                at.width > max(start.width, last.width),
                printed="widening, then narrowing",
                measured=f"{decimal(start.width, 3)} rad at t_init, {decimal(at.width, 3)} rad at "
                f"theta = {decimal(at.middle, 3)}, {decimal(last.width, 2)} rad at the end",
            ),
            "widest there": statement(
                abs(widest_one.middle - widest) < 0.1,
                printed=f"widest at theta = {decimal(widest, 3)}",
                measured=f"widest, {decimal(widest_one.width, 3)} rad, at theta = "
                f"{decimal(widest_one.middle, 3)} ({decimal(widest_one.t, 4)} s)",
            ),
        },
        f"The largest theta_dot, {decimal(fastest.value, 5)} rad/s, comes at "
        f"{decimal(when, 4)} s, and theta first passes pi/2 at {decimal(half, 4)} s.",
    )


def _belts(scene: SceneLike) -> list[Belt]:
    turns = series.turning_points(scene)
    points = [(float(t), float(theta)) for t, theta in zip(turns["t"], turns["theta"], strict=True)]
    belts = []
    for (t0, a), (t1, b), (t2, c) in zip(points, points[1:], points[2:], strict=False):
        if t2 - t0 < PAUSE_S:
            across = a + (c - a) * (t1 - t0) / (t2 - t0)
            belts.append(Belt(t1, (b + across) / 2, abs(b - across)))
    return belts


def _logistic_fit(name: str, scene: SceneLike, span: series.Span) -> tuple[float, float, float]:
    """Rate (1/s), centre (s), and the share of the variance that the fitted curve leaves."""
    import numpy
    from scipy.optimize import least_squares

    times = numpy.linspace(span.begin, span.end, 2000)
    values = series.columns([name], list(times), scene)[name]

    def rest(parameters: Array) -> Array:
        rate, centre = parameters
        # the logistic curve as a tanh, which cannot overflow
        return values - math.pi / 2 * (1 + numpy.tanh(rate * (times - centre) / 2))

    found = least_squares(rest, (2.0, span.begin + span.length / 2))
    rate, centre = (float(x) for x in found.x)
    return rate, centre, float((found.fun**2).mean() / values.var())
