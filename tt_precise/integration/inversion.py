"""Initiation and ending time of the climb, by the three definitions that the paper's words admit.

A, signed perigee: at each local minimum of theta below pi/2 let b = sign(phi_dot) theta; t_init
is the zero of the straight line through the last negative b before the climb and the next b
(0 if none is negative). t_end likewise, at the maxima of theta above pi/2 after the climb with
b = sign(phi_dot)(pi - theta), at the first change from + to -. Smooth in the initial data.

B, algebraic: the last time before theta = pi/2 with L.k = L.z; the first after it with
L.k = -L.z. Exact events, but a staircase in the initial data.

C, literal: the ends of the maximal interval around the climb in which phi_dot > 0; there is none
where phi_dot < 0 at the climb.

The climb is the first crossing of theta = pi/2 from below. If the climb is under way from the
start, so that no such event comes before it, t_init is 0. A time that does not exist, because the
top does not climb or the horizon ends too early, is None. A top that spins in the other direction
(lambda < 0) is treated as its mirror image, which has -phi_dot for phi_dot.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy

from tt_precise.integration.errors import errors_of
from tt_precise.integration.reading import event_columns
from tt_precise.integration.solution import Solution
from tt_precise.mechanics.quantities import jellett
from tt_precise.runtime.values import Array, Scalar

NEEDED = ("theta_min", "theta_max", "phi_dot_zero", "equator", "Lk_equals_Lz", "Lk_equals_minus_Lz")


@dataclass(frozen=True)
class Climb:
    """Initiation and ending time in s by one definition; None for a time that does not exist."""

    t_init: Scalar
    t_end: Scalar

    @property
    def duration(self) -> Scalar:
        """Climbing time T_inv = t_end - t_init in s; section 2.1."""
        if self.t_init is None or self.t_end is None:
            return None
        return self.t_end - self.t_init


class TurningPoints(NamedTuple):
    """Turning points of theta in order of time: time, theta and phi_dot."""

    t: Sequence[Scalar]
    theta: Sequence[Scalar]
    phi_dot: Sequence[Scalar]


@dataclass(frozen=True)
class InversionEvents:
    """The events ``NEEDED``, each kind in order of time, in any arithmetic.

    ``equator`` has only the crossings of theta = pi/2 from below; ``backwards`` is true if
    phi_dot < 0 at the first crossing.
    """

    equator: Sequence[Scalar]
    minima: TurningPoints
    maxima: TurningPoints
    phi_dot_zero: Sequence[Scalar]
    aligned: Sequence[Scalar]
    opposed: Sequence[Scalar]
    backwards: bool = False


@dataclass(frozen=True, repr=False)
class InversionTimes:
    """The climb in the definitions A, B and C, and the first time theta crosses pi/2 (s)."""

    equator: Scalar
    A: Climb
    B: Climb
    C: Climb

    @property
    def times(self) -> dict[str, Scalar]:
        """Initiation and ending times by name, such as ``t_init_A``."""
        ends = ("t_init", "t_end")
        return {f"{end}_{d}": getattr(getattr(self, d), end) for d in "ABC" for end in ends}

    def __repr__(self) -> str:
        if self.equator is None:
            return "<InversionTimes: theta = pi/2 is not passed>"
        text = {n: "none" if t is None else f"{float(t):.6g} s" for n, t in self.times.items()}
        climbs = (f"{d} {text[f't_init_{d}']} to {text[f't_end_{d}']}" for d in "ABC")
        passed = f"theta = pi/2 at {float(self.equator):.6g} s"
        return f"<InversionTimes: {passed}; {', '.join(climbs)}>"


def with_climb(run: Solution) -> Solution:
    """The run with the events of the climb; integrated again if necessary."""
    complete = set(NEEDED) <= set(run.setup.watched)
    return run if complete else run.once(with_climb, lambda: run.again(events=NEEDED, record=()))


def times_of(run: Solution) -> InversionTimes:
    """The times of a solution."""
    return from_events(event_columns(with_climb(run), ("theta", "phi_dot")), *_pi_and_side(run))


def _pi_and_side(run: Solution) -> tuple[Scalar, bool]:
    """Return pi, and whether lambda < 0."""
    pi = math.pi if run.precision.is_float else +run.precision.context.pi
    return pi, bool(jellett(run.start.motion(run.precision.context)) < 0)


def from_events(events: Mapping[str, Array], pi: Scalar, mirrored: bool = False) -> InversionTimes:
    """Initiation and ending times from columns of the events ``NEEDED``, in order of time.

    The columns are name, t, direction, theta and phi_dot. ``mirrored``: lambda < 0.
    """
    name, t, direction, theta, phi_dot = (
        numpy.asarray(events[column]) for column in ("name", "t", "direction", "theta", "phi_dot")
    )
    # at a pole phi_dot is undefined, None in wide arithmetics: a number that has no sign
    phi_dot = numpy.array([math.nan if rate is None else rate for rate in phi_dot.tolist()])
    phi_dot = -phi_dot if mirrored else phi_dot

    def times(kind: str) -> list[Scalar]:
        return list(t[name == kind].tolist())

    def turning_points(kind: str) -> TurningPoints:
        return TurningPoints(*(column[name == kind].tolist() for column in (t, theta, phi_dot)))

    rises = (name == "equator") & (direction < 0)
    marks = InversionEvents(
        equator=t[rises].tolist(),
        minima=turning_points("theta_min"),
        maxima=turning_points("theta_max"),
        phi_dot_zero=times("phi_dot_zero"),
        aligned=times("Lk_equals_Lz"),
        opposed=times("Lk_equals_minus_Lz"),
        backwards=any(rate < 0 for rate in phi_dot[rises][:1].tolist()),
    )
    return from_inversion_events(marks, pi)


def errors_of_times(run: Solution) -> dict[str, float]:
    """Estimated errors (s) of the existing times of a solution, by name.

    The times are computed again with all events later by their errors; with every theta larger by
    its error; and with every second theta larger and the others smaller, on which the lines of
    definition A depend most. The changes are added.
    """
    errors = errors_of(with_climb(run)).events()
    events = event_columns(with_climb(run), ("theta", "phi_dot"))

    def shifted(name: str, by: Array) -> InversionTimes:
        column = [v if v is None else v + d for v, d in zip(events[name], by, strict=True)]
        return from_events({**events, name: column}, *_pi_and_side(run))

    tilts = 10.0 ** -errors["digits"]
    alternating = tilts * numpy.where(numpy.arange(len(tilts)) % 2, 1, -1)
    shifts = ("t", errors["t"]), ("theta", tilts), ("theta", alternating)
    changed = [shifted(name, by) for name, by in shifts]
    plain, errors = times_of(run), {}
    for name, t in {"equator": plain.equator, **plain.times}.items():
        others = [c.equator if name == "equator" else c.times[name] for c in changed]
        if t is not None:
            missing = any(other is None for other in others)
            errors[name] = math.inf if missing else float(sum(abs(x - t) for x in others))
    return errors


def from_inversion_events(marks: InversionEvents, pi: Scalar) -> InversionTimes:
    """Initiation and ending times by the three definitions."""
    if not marks.equator:
        none = Climb(None, None)
        return InversionTimes(None, none, none, none)
    climb = marks.equator[0]
    reversal = marks.phi_dot_zero
    literal = Climb(_last_before(reversal, climb), _first_after(reversal, climb))
    return InversionTimes(
        climb,
        Climb(_perigee(marks.minima, climb, pi), _apogee(marks.maxima, climb, pi)),
        Climb(_last_before(marks.aligned, climb), _first_after(marks.opposed, climb)),
        Climb(None, None) if marks.backwards else literal,
    )


def _perigee(minima: TurningPoints, climb: Scalar, pi: Scalar) -> Scalar:
    following = None
    for i in reversed(range(bisect.bisect_left(minima.t, climb))):
        if minima.theta[i] > pi / 2:
            continue
        b = minima.theta[i] if minima.phi_dot[i] > 0 else -minima.theta[i]
        if b < 0:
            return None if following is None else _line_zero((minima.t[i], b), following)
        following = (minima.t[i], b)
    return 0 * climb


def _apogee(maxima: TurningPoints, climb: Scalar, pi: Scalar) -> Scalar:
    before = None
    for i in range(bisect.bisect_right(maxima.t, climb), len(maxima.t)):
        if maxima.theta[i] > pi / 2:
            b = pi - maxima.theta[i] if maxima.phi_dot[i] > 0 else -(pi - maxima.theta[i])
            if before is not None and before[1] > 0 > b:
                return _line_zero(before, (maxima.t[i], b))
            before = (maxima.t[i], b)
    return None


def _line_zero(left: tuple[Scalar, Scalar], right: tuple[Scalar, Scalar]) -> Scalar:
    (t0, b0), (t1, b1) = left, right
    return t0 + (t1 - t0) * b0 / (b0 - b1)


def _last_before(times: Sequence[Scalar], limit: Scalar) -> Scalar:
    position = bisect.bisect_left(times, limit)
    return times[position - 1] if position else 0 * limit


def _first_after(times: Sequence[Scalar], limit: Scalar) -> Scalar:
    position = bisect.bisect_right(times, limit)
    return times[position] if position < len(times) else None
