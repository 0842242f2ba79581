"""A scene's solution as evidence: values with their digits, extrema, zeros, phases of the climb.

A process integrates a scene once in each arithmetic. Local extrema and zeros are events, so none
is missed between samples, and between two extrema a quantity is monotonic. Enclosures come from
the committed proofs of golden digits (``golden certify``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import count, pairwise, takewhile
from typing import Any, NamedTuple, TypeAlias

import numpy
import pandas

from tt_precise.claims.part import Value
from tt_precise.exact.stability import rounding_to
from tt_precise.exact.thresholds import Thresholds, lambda_at_start, thresholds
from tt_precise.golden import proofs
from tt_precise.golden.proofs import Established, Interval
from tt_precise.integration import Trajectory, catalogue, integrate
from tt_precise.integration.events import Event
from tt_precise.integration.inversion import InversionTimes, times_of
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Quantity
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.scene import Scene, load_scene

# The arithmetic of values, and the finer one that confirms their digits.
FINE, CONFIRMING = "double-double", "triple-double"
GAUSS = 6  # Nodes of Gauss's rule in an interval; a nutation of 37 ms has 16 intervals.
PAUSE_S = 0.2  # Twice the longest nutation in s; a longer gap between turning points is none.
MANY = 10  # "many times"
SceneLike: TypeAlias = str | Scene
Observable: TypeAlias = str | Quantity  # a quantity by its name, or one made for a claim
DEFINITIONS = {"A": "A, signed perigee", "B": "B, algebraic", "C": "C, literal"}


class Span(NamedTuple):
    """An interval of time in s."""

    begin: float
    end: float

    def has(self, t: float) -> bool:
        return self.begin <= t <= self.end

    @property
    def length(self) -> float:
        return self.end - self.begin

    @property
    def middle(self) -> float:
        return self.begin + self.length / 2


def rising(values: Sequence[float]) -> bool:
    """True if each value is larger than the one before."""
    return all(b > a for a, b in pairwise(values))


class BandPoint(NamedTuple):
    """A turning point of theta: time (s), and middle and width of the band (rad).

    The band reaches from the turning point to the straight line between its neighbours.
    """

    t: float
    middle: float
    width: float


@dataclass(frozen=True)
class Run:
    """The solution of a scene, shipped or varied; see ``variant``."""

    scene: SceneLike = "reference"

    # ---- the runs, and single values ---------------------------------------------------------

    def trajectory(self, precision: str = "double") -> Trajectory:
        """The solution with all events recorded."""
        return _integrate(self.scene, precision)

    def confirm(self, value: Callable[[Trajectory], Scalar]) -> Value:
        """A value from the fine trajectory, with the digits that the confirming run shares."""
        return Value.of(*(value(self.trajectory(name)) for name in (FINE, CONFIRMING)))

    def at(self, name: str, t: str) -> Value:
        """A quantity or state component at time ``t`` (exact, s), in SI, with its enclosure."""
        enclosure = self.proofs.potential_energy(t) if name == "E_pot" else self.proofs.at(name, t)
        return self.confirm(lambda run: exact(run, name, t)[0]).within(enclosure)

    def moment(self, definition: str, which: str) -> Value:
        """``t_init``, ``t_end`` or ``duration`` of the inversion in s, with its enclosure."""
        value = self.confirm(lambda run: getattr(getattr(climb_of(run), definition), which))
        return value.within(self.proofs.moment(definition, which))

    @property
    def proofs(self) -> Established:
        """The statements about the scene that its golden data prove."""
        return proofs_of(self.scene)

    def columns(self, names: Iterable[str], times: Iterable[float]) -> dict[str, Array]:
        """Named columns at ``times`` as float arrays, from the dense output in double."""
        frame = self.trajectory().frame(*names, times=list(times), numbers="exact")
        return {str(name): frame[name].to_numpy(dtype=float) for name in frame}

    def column(self, name: Observable, times: Iterable[float]) -> Array:
        """One quantity at ``times``, in double."""
        return numpy.array(exact(self.trajectory(), name, *times), float)

    def value(self, name: Observable, t: float) -> float:
        """One quantity at one time, in double."""
        return float(self.column(name, [t])[0])

    def sampled(self, names: Iterable[str], every: str = "0.001") -> pandas.DataFrame:
        """A float table of quantities over the whole run, every ``every`` seconds (exact)."""
        times = (float(i * Fraction(every)) for i in count())
        return pandas.DataFrame(self.columns(names, takewhile(self.whole.has, times)))

    # ---- body and thresholds -----------------------------------------------------------------

    @property
    def loaded(self) -> Scene:
        return load_scene(self.scene)

    @property
    def weight(self) -> Fraction:
        """m g in N, exact."""
        return self.loaded.body.m * self.loaded.body.g

    def body(self, fn: Functions) -> Parameters:
        return self.loaded.body.numbers(rounding_to(fn))

    @property
    def lambda_(self) -> Scalar:
        """lambda of the start in kg m^3/s, from ``thresholds``."""
        return lambda_at_start(self.loaded)

    @cached_property
    def thresholds(self) -> Thresholds:
        """lambda, the thresholds and the asymptotic values, each determined twice."""
        return thresholds(self.loaded, 50)

    # ---- phases and turning points -----------------------------------------------------------

    @property
    def whole(self) -> Span:
        return Span(0.0, float(self.trajectory().t_end))

    @property
    def climb(self) -> Span:
        """The interval from initiation to ending time in definition A (signed perigee)."""
        times = self.inversion.A
        return Span(float(times.t_init), float(times.t_end))

    @property
    def synchronisation(self) -> Span:
        """The interval from the start to the initiation time in definition A."""
        return Span(0.0, self.climb.begin)

    @property
    def inversion(self) -> InversionTimes:
        """The times of the climb by the definitions A, B and C, in double."""
        return self.trajectory().inversion

    @property
    def equator(self) -> float:
        """The first time at which theta passes pi/2."""
        return float(self.inversion.equator)

    def events(self, *names: str) -> pandas.DataFrame:
        """The rows of the table of events that have one of these names, in order of time."""
        return rows_of(self.trajectory(), *names)

    @property
    def turning_points(self) -> pandas.DataFrame:
        """The events theta_min and theta_max with the state at each, in order of time."""
        return self.events("theta_min", "theta_max")

    @cached_property
    def band(self) -> list[BandPoint]:
        """The nutation band at each turning point of theta, except next to a pause of nutation."""
        turns = [(float(t), float(x)) for t, x in self.turning_points[["t", "theta"]].to_numpy()]
        belts = []
        for (t0, a), (t1, b), (t2, c) in zip(turns, turns[1:], turns[2:], strict=False):
            if t2 - t0 < PAUSE_S:
                across = a + (c - a) * (t1 - t0) / (t2 - t0)
                belts.append(BandPoint(t1, (b + across) / 2, abs(b - across)))
        return belts

    def nutations(self, span: Span | None = None) -> list[Span]:
        """The nutation periods within ``span``: from one maximum of theta to the next."""
        tops = [float(t) for t in self.events("theta_max")["t"]]
        span = span or self.whole
        return [Span(a, b) for a, b in pairwise(tops) if span.has(a) and span.has(b)]

    # ---- extrema, zeros, averages of a quantity ----------------------------------------------

    def extrema(self, name: Observable, span: Span | None = None) -> tuple[Array, Array]:
        """Times and values of a quantity's local extrema within ``span``, and at its ends."""
        times, values = (numpy.array(column, float) for column in _extrema(self.scene, name))
        if span is None:
            return times, values
        inside = (times > span.begin) & (times < span.end)
        first, last = self.column(name, span)
        return (
            numpy.array([span.begin, *times[inside], span.end]),
            numpy.array([first, *values[inside], last]),
        )

    def rises_and_falls(self, name: Observable, span: Span | None = None) -> tuple[float, float]:
        """The sum of all rises of a quantity, and the sum of all its falls (both positive)."""
        swings = numpy.diff(self.extrema(name, span)[1])
        return float(swings[swings > 0].sum()), float(-swings[swings < 0].sum())

    def largest_swing(self, name: str, span: Span | None = None) -> float:
        """The largest distance of consecutive extrema."""
        return max(abs(float(b - a)) for a, b in pairwise(self.extrema(name, span)[1]))

    def oscillation(self, name: str) -> tuple[float, float]:
        """The largest oscillation of a quantity about its course, and its time (s).

        The oscillation at an extremum is the smaller one of the distances to its neighbours.
        """
        times, values = self.extrema(name)
        swings = [abs(float(b - a)) for a, b in pairwise(values)]
        return max(zip(map(min, pairwise(swings)), times[1:-1].tolist(), strict=True))

    def zeros(self, name: Observable, span: Span | None = None) -> list[float]:
        """The times in ``span`` at which a quantity changes sign, found as events."""
        zeros = _zeros(self.scene, name)
        return [t for t in zeros if span is None or span.begin < t < span.end]

    def share_below_zero(self, name: Observable, span: Span | None = None) -> float:
        """The part of the time in which a quantity is negative."""
        span = span or self.whole
        edges = [span.begin, *self.zeros(name, span), span.end]
        signs = self.column(name, [(a + b) / 2 for a, b in pairwise(edges)])
        intervals = zip(pairwise(edges), signs, strict=True)
        return sum(b - a for (a, b), sign in intervals if sign < 0) / span.length

    def mean(self, name: Observable, span: Span | None = None) -> float:
        """The time average of a quantity, by Gauss's rule on monotonic intervals up to 5 ms."""
        times = self.extrema(name, span)[0]
        times = numpy.union1d(times, numpy.arange(times[0], times[-1], 5e-3))
        nodes, weights = numpy.polynomial.legendre.leggauss(GAUSS)
        half = numpy.diff(times)[:, None] / 2
        points = (times[:-1, None] + half) + half * nodes
        values = self.column(name, points.ravel()).reshape(points.shape)
        return float((values * weights * half).sum() / (times[-1] - times[0]))

    def extremum(
        self, name: Observable, *, largest: bool, span: Span | None = None
    ) -> tuple[float, float]:
        """Time (s) and value of the largest or smallest extremum of a quantity, ends included."""
        times, values = self.extrema(name, span)
        at = int(values.argmax() if largest else values.argmin())
        return float(times[at]), float(values[at])

    def extreme(self, name: str, *, largest: bool, span: Span | None = None) -> Value:
        """The largest or smallest value of a quantity, with its digits.

        The event gives the time to about 1e-12 s; each run moves on to the vertex of its parabola.
        """
        t, _ = self.extremum(name, largest=largest, span=span)
        if t in tuple(span or self.whole):  # it equals an end, which is no vertex
            return self.confirm(lambda run: exact(run, name, t)[0])
        return self.confirm(lambda run: _vertex(run, name, t))

    def least(self, name: str) -> Value:
        """The smallest value of a quantity over the run, with the digits double confirms."""
        return Value.of(*(min(_extrema(self.scene, name, each)[1]) for each in (FINE, "double")))

    def least_in(self, spans: Sequence[Span], name: str) -> list[float]:
        """The smallest value of a quantity in each of ``spans`` (in order), extrema included."""
        times, values = self.extrema(name)
        ends = self.column(name, [t for span in spans for t in span]).reshape(-1, 2)
        least = []
        for span, at_ends in zip(spans, ends, strict=True):
            inside = (times >= span.begin) & (times <= span.end)
            least.append(float(min(*at_ends, *values[inside])))
        return least


def variant(scene: SceneLike = "reference", **changes: Any) -> Scene:
    """``Scene.varied`` of a scene or of a shipped one by name, in the units of scene files."""
    return load_scene(scene).varied(**changes)


def climb_of(run: Trajectory) -> InversionTimes:
    """The times of the climb without their estimated errors, which take reference runs."""
    return times_of(run.run)


def exact(run: Trajectory, name: Observable, *times: Scalar) -> list[Scalar]:
    """A quantity at some times, in the run's own arithmetic."""
    return list(run.frame(name, times=times, numbers="exact").iloc[:, -1])


def rows_of(run: Trajectory, *names: str) -> pandas.DataFrame:
    """The rows of a trajectory's table of events that have one of these names; without errors."""
    events = pandas.DataFrame(run.event_table())
    return events[events["name"].isin(names)].reset_index(drop=True)


@cache
def _integrate(scene: SceneLike, precision: str) -> Trajectory:
    loaded = load_scene(scene)
    return integrate(loaded, precision, events=catalogue(loaded.model))


@cache
def _extrema(
    scene: SceneLike, name: Observable, precision: str = "double"
) -> tuple[list[Scalar], list[Scalar]]:
    """Times and values of all local extrema of a quantity, and at both ends."""
    event = f"extremum:{getattr(name, 'name', name)}"
    run = integrate(load_scene(scene), precision, events=[event if name in QUANTITIES else name])
    times = [0, *rows_of(run, event)["t"], run.t_end]
    return times, exact(run, name, *times)


@cache
def _zeros(scene: SceneLike, name: Observable) -> list[float]:
    if isinstance(name, Quantity):
        zero = Event(name.name, name.evaluate, "its zero", azimuth=True)
        run = integrate(load_scene(scene), events=[zero])
    else:
        run = integrate(load_scene(scene), events=[f"zero:{name}"])
    return [float(t) for t in run.events["t"]]


def _vertex(run: Trajectory, name: str, t: float) -> Scalar:
    """The value at the vertex of the parabola through three values around ``t``."""
    context = run.precision.context
    h = context.mpf(2) ** -30  # 1 ns: the third derivative no longer matters
    middle = context.mpf(t)
    before, here, after = exact(run, name, middle - h, middle, middle + h)
    slope, curvature = (after - before) / 2, after - 2 * here + before
    return here - slope * slope / (2 * curvature)


REFERENCE = Run()


# ---- proofs --------------------------------------------------------------------------------------


@cache
def proofs_of(scene: SceneLike) -> Established:
    """The statements about ``scene`` that the files of its golden data prove."""
    try:
        return proofs.established(load_scene(scene))
    except InputError as error:  # the note names unusable golden data, like missing ones
        return Established(why=str(error))


def number_between(
    events: Iterable[dict[str, Interval]], column: str, low: Fraction, high: Fraction
) -> Interval:
    """Count events with a column between two numbers: surely, and possibly."""
    values = [event[column] for event in events if column in event]
    surely = sum(low < value.low and value.high < high for value in values)
    possibly = sum(low <= value.high and value.low <= high for value in values)
    return Interval(Fraction(surely), Fraction(possibly))


# ---- phi_dot around the climb: rad/s, None or 0 where nothing is proved --------------------------


def reversal(scene: SceneLike, extremum: str, which: str) -> list[Interval | None]:
    """phi_dot at the turning points before and after ``t_init`` or ``t_end`` (definition A)."""
    statements = proofs_of(scene)
    turns, moment = statements.events(extremum), statements.moment("A", which)
    if not turns or moment is None:
        return [None, None]
    before = [event for event in turns if event["t"].high < moment.low]
    after = [event for event in turns if event["t"].low > moment.high]
    if len(before) + len(after) < len(turns) or not (before and after):
        return [None, None]
    return [before[-1].get("phi_dot"), after[0].get("phi_dot")]


def precession(scene: SceneLike) -> list[Interval | None]:
    """phi_dot where L.k = L.z for the last time, and at the maxima before and after t_init (A)."""
    statements = proofs_of(scene)
    aligned, moment = statements.events("Lk_equals_Lz"), statements.moment("B", "t_init")
    there: list[Interval | None] = [None]
    if aligned and moment:
        met = [event for event in aligned if _overlap(event["t"], moment)]
        there = [met[0].get("phi_dot")] if len(met) == 1 else [None]
    return there + reversal(scene, "theta_max", "t_init")


def sign_of_precession(scene: SceneLike) -> int:
    """The sign of phi_dot throughout the climb (definition A) where it has no zero; else 0.

    It is the sign at the equator then.
    """
    statements = proofs_of(scene)
    zeros, middle = statements.events("phi_dot_zero"), statements.events("equator")
    begin, end = (statements.moment("A", which) for which in ("t_init", "t_end"))
    if zeros is None or not middle or begin is None or end is None:
        return 0
    if any(_overlap(zero["t"], Interval(begin.low, end.high)) for zero in zeros):
        return 0
    there, phi_dot = middle[0]["t"], middle[0]["phi_dot"]
    if not begin.high < there.low <= there.high < end.low:
        return 0
    return int(phi_dot.low > 0) - int(phi_dot.high < 0)


def _overlap(a: Interval, b: Interval) -> bool:
    return a.low <= b.high and b.low <= a.high
