"""Initiation and ending time of the climb, in the three definitions that the paper's words admit.

A, signed perigee: at each local minimum of theta below pi/2 let b = sign(phi_dot) theta; t_init
is the zero of the straight line through the last negative b before the climb and the next b
(0 if none is negative). t_end likewise, at the maxima of theta above pi/2 after the climb with
b = sign(phi_dot)(pi - theta), at the first change from + to -. Smooth in the initial data.

B, algebraic: the last time before theta = pi/2 with L.k = L.z; the first after it with
L.k = -L.z. Exact events, but a staircase in the initial data.

C, literal: the ends of the maximal interval around the climb in which phi_dot > 0.

The climb is the first crossing of theta = pi/2 from below. A time that does not exist, because
the top does not climb or the horizon ends too early, is None.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

    from tt_precise.integrate.trajectory import Trajectory

NEEDED = ("theta_min", "theta_max", "phi_dot_zero", "equator", "Lk_equals_Lz", "Lk_equals_minus_Lz")


@dataclass(frozen=True)
class Climb:
    """Initiation and ending time in s (None where there is none) in one definition."""

    t_init: Any
    t_end: Any

    @property
    def duration(self) -> Any:
        """Climbing time T_inv = t_end - t_init in s; section 2.1."""
        if self.t_init is None or self.t_end is None:
            return None
        return self.t_end - self.t_init


@dataclass(frozen=True)
class InversionTimes:
    """The climb in the definitions A, B and C, and when theta first crosses pi/2 (s)."""

    equator: Any
    A: Climb
    B: Climb
    C: Climb


def inversion_times(trajectory: Trajectory) -> InversionTimes:
    """Initiation and ending times of a trajectory; integrates again if it lacks the events."""
    if not set(NEEDED) <= set(trajectory.key.events):
        from tt_precise.integrate.run import integrate

        mp = trajectory.precision.name == "mp"
        trajectory = integrate(
            trajectory.scene,
            trajectory.precision.name,
            bits=trajectory.precision.bits if mp else None,
            formulation=trajectory.formulation,
            events=NEEDED,
            record=(),
        )
    double = trajectory.precision.name == "double"
    return from_events(trajectory.events, math.pi if double else +trajectory.precision.context.pi)


def from_events(events: pandas.DataFrame, pi: Any) -> InversionTimes:
    """Initiation and ending times from a table of the events ``NEEDED``, in order of time."""
    crossings = events[(events["name"] == "equator") & (events["direction"] < 0)]
    if crossings.empty:
        none = Climb(None, None)
        return InversionTimes(None, none, none, none)
    climb = crossings["t"].iloc[0]
    before, after = events[events["t"] < climb], events[events["t"] > climb]
    return InversionTimes(
        climb,
        Climb(_perigee(before), _apogee(after, pi)),
        Climb(
            _last(before[before["name"] == "Lk_equals_Lz"]),
            _first(after[after["name"] == "Lk_equals_minus_Lz"]),
        ),
        Climb(
            _last(before[before["name"] == "phi_dot_zero"]),
            _first(after[after["name"] == "phi_dot_zero"]),
        ),
    )


def _perigee(before: pandas.DataFrame) -> Any:
    minima = before[before["name"] == "theta_min"]
    signed = [
        (t, theta if phi_dot > 0 else -theta)
        for t, theta, phi_dot in zip(minima["t"], minima["theta"], minima["phi_dot"], strict=True)
    ]
    negative = [i for i, (_, b) in enumerate(signed) if b < 0]
    if not negative:
        return 0 * minima["t"].iloc[0] if len(minima) else 0.0
    last = negative[-1]
    return _line_zero(signed[last], signed[last + 1]) if last + 1 < len(signed) else None


def _apogee(after: pandas.DataFrame, pi: Any) -> Any:
    maxima = after[(after["name"] == "theta_max") & (after["theta"] > float(pi) / 2)]
    signed = [
        (t, (pi - theta) if phi_dot > 0 else -(pi - theta))
        for t, theta, phi_dot in zip(maxima["t"], maxima["theta"], maxima["phi_dot"], strict=True)
    ]
    for left, right in itertools.pairwise(signed):
        if left[1] > 0 > right[1]:
            return _line_zero(left, right)
    return None


def _line_zero(left: tuple[Any, Any], right: tuple[Any, Any]) -> Any:
    (t0, b0), (t1, b1) = left, right
    return t0 + (t1 - t0) * b0 / (b0 - b1)


def _last(rows: pandas.DataFrame) -> Any:
    return None if rows.empty else rows["t"].iloc[-1]


def _first(rows: pandas.DataFrame) -> Any:
    return None if rows.empty else rows["t"].iloc[0]
