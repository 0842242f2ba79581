"""Flight: after a rigid top has lost contact, and between contacts with an elastic table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from tt_precise.integration.setup import Setup
from tt_precise.integration.solution import Segment
from tt_precise.mechanics import compliant, flight
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import contact_terms
from tt_precise.mechanics.quantities import Motion
from tt_precise.nonsmooth.phases import MOST_SEGMENTS, SegmentStart, in_flight
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Functions, InputError, Scalar
from tt_precise.scene.scene import InitialState

ENDS = {"separation": "separation", "release": "separation",
        "landing": "landing", "sinking": "landing"}  # fmt: skip


def flying(setup: Setup, here: SegmentStart, begin: Scalar) -> Segment:
    """Return the flight from ``here`` at the time ``begin`` until the top comes down."""
    flight = here.segment(in_flight(setup), begin)
    landed = flight.run.status == "landing"
    return replace(flight, run=flight.run._replace(status="landed")) if landed else flight


def flying_on(segments: Sequence[Segment], setup: Setup, start: InitialState) -> list[Segment]:
    """Return the segments, and after a loss of contact the flight until the top comes down."""
    *former, last = segments
    if last.run.status != "contact_lost":
        return list(segments)
    joint = SegmentStart.of_run(setup, start)._replace(until=start.until - last.begin)
    begin = last.begin + last.end_time
    flown = flying(setup, joint.after(last), begin)
    return [*former, replace(last, ended="lift_off"), flown]


def pressed(start: InitialState, fn: Functions) -> InitialState:
    """Return the start on an elastic table, with a height.

    By default a table at rest exerts the normal force of a rigid table at this height.
    """
    vectors: Any = start.vectors
    if not isinstance(vectors, LiftedState):
        numerator, denominator = contact_terms("gliding", start.body, vectors, fn)
        height = compliant.resting_height(start.body, numerator / denominator, fn)
        vectors = LiftedState(*(*vectors, height, start.until * 0))
    return replace(start, vectors=vectors)


def bouncing(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[Segment]:
    """Return the segments of the motion on an elastic table: contact and flight alternate.

    It begins at the depth at which a table at rest exerts the normal force of the rigid table,
    unless the scene gives a height. A damped table loses contact before it has risen, and makes
    contact again where its force would push again.

    Raises ``InputError``: there are too many segments.
    """
    flight_setup = in_flight(setup, setup.formulation.spring)
    here = SegmentStart.of_run(setup, pressed(start, setup.precision.context))
    segments: list[Segment] = []
    begin, flies, zero = start.until * 0, _flies(here.q), here.q.fn.mpf(0)
    if here.q.state.height == here.q.state.rise == 0 and not flies and setup.phase.has_clock:
        fall = _first_fall(flight_setup, here, begin)
        segments.append(fall)
        begin, here = fall.end_time, here.after(fall)
        if not here.until:
            return segments
    while True:
        last = here.segment(flight_setup if flies else setup, begin)
        status = last.run.status
        joint = ENDS.get(status, "")
        segments.append(replace(last, ended=joint))
        if not joint:
            return segments
        if len(segments) == MOST_SEGMENTS:
            raise InputError(
                f"{name}: got more than {MOST_SEGMENTS} changes of contact, expected fewer: ask "
                "for a shorter time"
            )
        begin = begin + last.end_time
        here, flies = here.after(last), joint == "separation"
        if status == "landing" or (setup.phase.has_clock and status == "separation"):
            here = here.at(height=zero)
        if progress and start.until:
            progress(float(begin / start.until))


def _flies(q: Motion) -> bool:
    """Return whether the top begins off an elastic table, or where the table would pull.

    A top that touches the table at rest flies if it rises in free flight.
    """
    height, rise = q.state.height, q.state.rise
    if compliant.pull(q.body, height, rise) > 0 or height > 0:
        return True
    if height < 0 or rise:
        return bool(height == 0 < rise)
    return bool(flight.rates(q.body, q.state, q.fn).rise > 0)


def _first_fall(setup: Setup, here: SegmentStart, begin: Scalar) -> Segment:
    """The first moment of a top that sinks from rest into a table with a non-smooth force.

    In the regularised time it would stay at height 0. In t the force grows with the third power:
    the moment ends before it reaches eps of the weight that accelerates the top.
    """
    body, fn = here.q.body, here.q.fn
    falling = -flight.rates(body, here.q.state, fn).rise
    yielding = 1 + (1 + body.alpha) ** 2 / min(body.I1, body.I3)  # acceleration by a unit force
    force = yielding * body.stiffness * (falling / 2) ** fn.mpf("1.5")
    moment = fn.cbrt(setup.precision.eps / 16 * falling / force)
    return here.segment(setup, begin, min(moment, here.until))
