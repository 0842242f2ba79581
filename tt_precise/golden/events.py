"""The events of a run as text, without those that only touch zero.

An event is a change of sign. Where its function only touches zero (phi_dot at the cusps of a top
on ice that starts with phi_dot = 0), rounding splits the double root into two beside each other,
or none, or hides one of them behind the end of a Taylor step; so each hit is asked again whether
the function changes sign around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tt_precise.arithmetic import Scalar
from tt_precise.golden.table import Table
from tt_precise.integrate.events import EVENTS, JOINING, not_alternating

if TYPE_CHECKING:
    from tt_precise.integrate import Trajectory

# Rounding splits a double root by about eps^(1/2), a triple one by eps^(1/3).
ROOT_ORDER = 4


def events_table(trajectory: Trajectory, names: Sequence[str]) -> Table:
    """Columns name, t, direction and the state ``names[1:]`` of each change of sign."""
    text, context = trajectory.precision.text, trajectory.precision.context
    changes = _Changes(trajectory)
    rows = []
    for _, event in trajectory.events.iterrows():
        if event["name"] in JOINING or changes.sign_at(str(event["name"]), event["t"]):
            values = [event[name] for name in names]
            cells = ["" if value is None else text(context.mpf(value)) for value in values]
            rows.append((str(event["name"]), cells[0], str(int(event["direction"])), *cells[1:]))
    return Table(("name", "t", "direction", *names[1:]), tuple(rows))


def suspects(events: Table) -> tuple[str, ...]:
    """Events whose directions do not alternate, so that one must be missing.

    Minima and maxima of theta are zeros of one function and count together.
    """
    found = ((name, int(direction)) for name, _, direction, *_ in events.rows)
    return not_alternating(found, EVENTS)


class _Changes:
    """Whether an event's function changes sign around a time, by the dense output."""

    def __init__(self, trajectory: Trajectory):
        self.trajectory = trajectory
        self.context = trajectory.precision.context
        unit = trajectory.start.units.time
        self.width = unit * self.context.ldexp(1, -trajectory.precision.bits // ROOT_ORDER)

    def sign_at(self, name: str, time: Scalar) -> bool:
        before = max(time - self.width, self.context.mpf(0))
        after = min(time + self.width, self.context.mpf(self.trajectory.t_end))
        return bool(self._value(name, before) * self._value(name, after) < 0)

    def _value(self, name: str, time: Scalar) -> Scalar:
        return EVENTS[name].function(self.trajectory.motion(time))
