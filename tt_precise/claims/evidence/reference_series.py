"""Quantities over a whole run, with no extremum and no change of sign lost between samples.

Local extrema and zeros are events (``evidence.turning_values``, ``evidence.zeros``); between two
extrema a quantity is monotonous, so that its rises and falls are found for certain. Quantities of
a claim's own are a function of named columns (NumPy arrays), and their extremes are closed in on
in the dense output.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.claims import evidence
from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.measured import Settled
from tt_precise.runtime.arithmetic import Array, Scalar

if TYPE_CHECKING:
    import pandas

    from tt_precise.integration import Trajectory

CLOSER = 16  # points that each closing-in compares
GAUSS = 6  # nodes in each piece; a nutation of 37 ms has 16 pieces


class Span(NamedTuple):
    """An interval of time in s."""

    begin: float
    end: float

    def has(self, t: float) -> bool:
        """Whether ``t`` lies in it, ends included."""
        return self.begin <= t <= self.end

    @property
    def length(self) -> float:
        """Its length in s."""
        return self.end - self.begin


def whole(scene: SceneLike = "reference") -> Span:
    """The run from start to end."""
    return Span(0.0, float(evidence.trajectory(scene).t_end))


def climb(scene: SceneLike = "reference") -> Span:
    """From initiation to ending time in definition A (signed perigee)."""
    times = evidence.trajectory(scene).inversion.A
    return Span(float(times.t_init), float(times.t_end))


def synchronisation(scene: SceneLike = "reference") -> Span:
    """From the start to the initiation time in definition A."""
    return Span(0.0, climb(scene).begin)


def columns(
    names: Iterable[str], times: Sequence[float], scene: SceneLike = "reference"
) -> dict[str, Array]:
    """Named columns at ``times`` as float arrays, from the dense output in double."""
    frame = evidence.trajectory(scene).frame(*names, times=times)
    return {str(name): frame[name].to_numpy(dtype=float) for name in frame}


def turning_times(scene: SceneLike = "reference") -> list[float]:
    """When theta turns."""
    return [float(t) for t in turning_points(scene)["t"]]


def turning_points(scene: SceneLike = "reference") -> pandas.DataFrame:
    """The events theta_min and theta_max with the state at each, in order of time."""
    return turning_points_of(evidence.trajectory(scene))


def turning_points_of(run: Trajectory) -> pandas.DataFrame:
    """The same of any trajectory that has these events."""
    events = run.events
    return events[events["name"].isin(("theta_min", "theta_max"))].reset_index(drop=True)


def extrema(
    name: str, scene: SceneLike = "reference", span: Span | None = None
) -> tuple[Array, Array]:
    """Times and values of a quantity's local extrema within ``span``, and at its ends."""
    import numpy

    turning = evidence.turning_values(name, scene)
    times = turning["t"].to_numpy(dtype=float)
    values = turning["value"].to_numpy(dtype=float)
    if span is None:
        return times, values
    inside = (times > span.begin) & (times < span.end)
    ends = columns([name], [span.begin, span.end], scene)[name]
    return (
        numpy.concatenate(([span.begin], times[inside], [span.end])),
        numpy.concatenate((ends[:1], values[inside], ends[1:])),
    )


def rises_and_falls(
    name: str, scene: SceneLike = "reference", span: Span | None = None
) -> tuple[float, float]:
    """The sum of all rises of a quantity, and that of all its falls (both positive)."""
    import numpy

    swings = numpy.diff(extrema(name, scene, span)[1])
    return float(swings[swings > 0].sum()), float(-swings[swings < 0].sum())


def zeros(name: str, scene: SceneLike = "reference", span: Span | None = None) -> list[float]:
    """When a quantity changes sign within ``span``."""
    found = evidence.zeros(name, scene)
    return [t for t in found if span is None or span.begin < t < span.end]


def share_below_zero(name: str, scene: SceneLike = "reference", span: Span | None = None) -> float:
    """The part of the time in which a quantity is negative."""
    span = span or whole(scene)
    edges = [span.begin, *zeros(name, scene, span), span.end]
    middles = [(a + b) / 2 for a, b in pairwise(edges)]
    signs = columns([name], middles, scene)[name]
    pieces = zip(pairwise(edges), signs, strict=True)
    return sum(b - a for (a, b), sign in pieces if sign < 0) / span.length


def mean(name: str, scene: SceneLike = "reference", span: Span | None = None) -> float:
    """The time average of a quantity, by Gauss's rule in monotonous pieces of 5 ms at most."""
    import numpy

    times = extrema(name, scene, span)[0]
    times = numpy.union1d(times, numpy.arange(times[0], times[-1], 5e-3))
    nodes, weights = numpy.polynomial.legendre.leggauss(GAUSS)
    half = numpy.diff(times)[:, None] / 2
    points = (times[:-1, None] + half) + half * nodes
    values = columns([name], list(points.ravel()), scene)[name].reshape(points.shape)
    return float((values * weights * half).sum() / (times[-1] - times[0]))


def extreme(
    name: str,
    scene: SceneLike = "reference",
    *,
    largest: bool,
    span: Span | None = None,
) -> Settled:
    """The largest or smallest value of a quantity, from quad, with the digits extended confirms.

    The event gives the time to about 1e-12 s; each of the two runs then moves to the vertex of
    its own parabola, where the value no longer depends on that error.
    """
    times, values = extrema(name, scene, span)
    at = int(values.argmax() if largest else values.argmin())
    if at in (0, len(values) - 1):
        return evidence.settled(lambda run: _value(run, name, times[at]), scene)
    return evidence.settled(lambda run: _vertex(run, name, times[at])[1], scene)


def extreme_of(
    function: Callable[[dict[str, Array]], Array],
    names: Sequence[str],
    scene: SceneLike = "reference",
    *,
    largest: bool,
    span: Span | None = None,
) -> tuple[float, float]:
    """Time and value where a function of columns is largest or smallest.

    The first look is every 0.5 ms and at all turning points of theta, where axis and speeds
    change fastest; from the best of these it closes in until the time is settled in double.
    """
    import numpy

    span = span or whole(scene)
    turns = [t for t in turning_times(scene) if span.has(t)]
    times = numpy.union1d(numpy.arange(span.begin, span.end, 5e-4), [*turns, span.end])
    while True:
        values = function(columns(names, list(times), scene))
        best = int(values.argmax() if largest else values.argmin())
        low, high = times[max(best - 1, 0)], times[min(best + 1, len(times) - 1)]
        if high - low < 1e-13:
            return float(times[best]), float(values[best])
        times = numpy.linspace(low, high, CLOSER)


def nutations(scene: SceneLike = "reference", span: Span | None = None) -> list[Span]:
    """The nutation periods within ``span``: from one maximum of theta to the next."""
    turns = turning_points(scene)
    tops = [float(t) for t in turns["t"][turns["name"] == "theta_max"]]
    span = span or whole(scene)
    return [Span(a, b) for a, b in pairwise(tops) if span.has(a) and span.has(b)]


def least_in(spans: Sequence[Span], name: str, scene: SceneLike = "reference") -> list[float]:
    """The smallest value of a quantity in each of ``spans`` (in order), extrema included."""
    times, values = extrema(name, scene)
    ends = columns([name], [t for span in spans for t in span], scene)[name].reshape(-1, 2)
    found = []
    for span, at_ends in zip(spans, ends, strict=True):
        inside = slice(bisect.bisect_left(times, span.begin), bisect.bisect(times, span.end))
        found.append(float(min(*at_ends, *values[inside])))
    return found


@cache
def course(
    names: tuple[str, ...],
    scene: SceneLike = "reference",
    every: float = 0.001,
    refined: tuple[str, ...] | None = None,
) -> pandas.DataFrame:
    """Columns over the whole run, at samples and at all extrema.

    The extrema are those of the ``refined`` quantities (by default of all ``names``) and of theta.
    """
    import numpy
    import pandas

    span = whole(scene)
    times = numpy.arange(span.begin, span.end, every)
    for name in names if refined is None else refined:
        times = numpy.union1d(times, extrema(name, scene)[0])
    times = numpy.union1d(times, [*turning_times(scene), span.end])
    return pandas.DataFrame(columns(names, list(times), scene))


def _value(run: Trajectory, name: str, t: Scalar) -> Scalar:
    return run.frame(name, times=[t])[name].iloc[0]


def _vertex(run: Trajectory, name: str, t: float) -> tuple[Scalar, Scalar]:
    """Time and value at the vertex of the parabola through three values around ``t``."""
    context = run.precision.context
    h = context.mpf(2) ** -30  # 1 ns: the third derivative no longer matters
    middle = context.mpf(t)
    before, here, after = run.frame(name, times=[middle - h, middle, middle + h])[name]
    slope, curvature = (after - before) / 2, after - 2 * here + before
    return middle - h * slope / curvature, here - slope * slope / (2 * curvature)
