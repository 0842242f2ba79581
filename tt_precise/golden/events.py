"""The events of a run as text, without those that only touch zero.

An event is a change of sign. Where its function only touches zero (phi_dot at the cusps of a top
on ice that starts with phi_dot = 0), rounding splits the double root into two beside each other,
or none, or hides one of them behind the end of a Taylor step; so each hit is asked again whether
the function changes sign around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from tt_precise.golden.table import Table
from tt_precise.integration.events import EVENTS, JOINING, not_alternating
from tt_precise.runtime.arithmetic import Scalar

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

# Rounding splits a double root by about eps^(1/2), a triple one by eps^(1/3).
ROOT_ORDER = 4


def events_table(trajectory: Trajectory, names: Sequence[str]) -> Table:
    """Columns name, t, direction and the state ``names[1:]`` of each change of sign."""
    precision, found = trajectory.precision, trajectory.event_table(names[1:])
    real = _changes(trajectory, found["name"], found["t"])
    wide = precision.wide
    with wide.precision():
        texts = [
            ["" if text is None else text for text in wide.texts(column, precision.decimals)]
            for column in (wide.array(found[name]) for name in names)
        ]
    rows = zip(found["name"], texts[0], found["direction"], *texts[1:], strict=True)
    return Table(
        ("name", "t", "direction", *names[1:]),
        tuple(
            (name, t, str(int(direction)), *cells)
            for kept, (name, t, direction, *cells) in zip(real, rows, strict=True)
            if kept
        ),
    )


def suspects(events: Table) -> tuple[str, ...]:
    """Events whose directions do not alternate, so that one must be missing.

    Minima and maxima of theta are zeros of one function and count together.
    """
    found = ((name, int(direction)) for name, _, direction, *_ in events.rows)
    return not_alternating(found, EVENTS)


def _changes(trajectory: Trajectory, names: Sequence[str], times: Sequence[Scalar]) -> list[bool]:
    """Of each event whether its function changes sign around its time, by the dense output."""
    context, unit = trajectory.precision.context, trajectory.start.units.time
    width = unit * context.ldexp(1, -trajectory.precision.bits // ROOT_ORDER)
    first, last = context.mpf(0), context.mpf(trajectory.t_end)
    kinds: dict[str, list[int]] = {}
    for place, name in enumerate(names):
        if name not in JOINING:
            kinds.setdefault(name, []).append(place)
    found = [True] * len(names)
    for name, places in kinds.items():
        around = [
            [max(times[i] - width, first) for i in places],
            [min(times[i] + width, last) for i in places],
        ]
        signs = (trajectory.evaluated(EVENTS[name].function, side) for side in around)
        for place, before, after in zip(places, *signs, strict=True):
            found[place] = bool(before * after < 0)
    return found
