"""Motions with Coulomb friction: gliding, sticking and slipping.

Below a small gliding speed the state has polar form, and a regularised time in which the contact
approaches rest asymptotically and reaches v = 0 to the last bit. The top then rolls if the force
required for rolling lies within the cone |F_f| <= mu g_n ("stick"), until this force reaches the
cone ("slip"). Gliding then begins again with a power series, as from a rest at which rolling is
impossible. The Euler form integrates only fast gliding in Euler angles, all else in vectors.
"""

from __future__ import annotations

from dataclasses import replace

from tt_precise.integration.segment import Segment
from tt_precise.integration.setup import Setup
from tt_precise.mechanics import friction, rolling
from tt_precise.mechanics.quantities import Motion
from tt_precise.nonsmooth.onset import (
    OnsetSegment,
    direction_on_the_cone,
    directions_from_rest,
    onset,
    onset_segment,
    terms_for,
)
from tt_precise.nonsmooth.phases import REST_SPEED, SLOW_SPEED, slow, sticking
from tt_precise.nonsmooth.segments import MOST_SEGMENTS, SegmentStart
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import InputError, Scalar
from tt_precise.scene.initial_state import InitialState

GOES_ON = ("slow", "fast", "stick", "slip")
# Columns that are zero at rest; what is left of them where a top sticks is the speed that counts
# as zero.
VELOCITY = ("vx", "vy", "nu_x", "nu_y", "gliding_speed")


def sticking_and_slipping(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[Segment]:
    """Return the segments of the motion of scene ``name`` from ``start`` to its end.

    Raises ``InputError``: more segments than ``MOST_SEGMENTS``, or gliding can begin in no
    direction, or in several.
    """
    segments: list[Segment] = []
    here, status = SegmentStart.of_run(setup, start), "rest"
    begin = start.until * 0
    if any(start.vectors.v):
        speed = here.q.fn.hypot(*start.vectors.v[:2])
        status = "slow" if speed < SLOW_SPEED else "fast"
        if speed <= REST_SPEED * setup.precision.eps and _sticks(here.q):
            here, status = here.at_rest(), "stick"
    while status in ("rest", *GOES_ON):
        if len(segments) == MOST_SEGMENTS:
            raise InputError(
                f"{name}: got more than {MOST_SEGMENTS} changes between gliding and rolling, "
                "expected fewer: ask for a shorter time"
            )
        if status in ("rest", "stick", "slip"):
            last = _from_rest(name, setup, here, status, begin)
        else:
            last = here.segment(slow(setup) if status == "slow" else setup, begin)
        status = last.run.status
        joint = status if status in ("stick", "slip") else ""
        segments.append(replace(last, ended=joint, cleared=VELOCITY if joint == "stick" else ()))
        if isinstance(last, OnsetSegment) and status != "complete":
            status = "slow"
        begin, here = begin + last.end_time, here.after(last)
        if status == "stick":
            here = here.at_rest()
        if progress and start.until:
            progress(float(begin / start.until))
    return segments


def _sticks(q: Motion) -> bool:
    """Return whether the force that keeps the top rolling lies within the cone of friction."""
    pressed = rolling.constraint_force(q.body, q.state)[2] > 0
    return bool(pressed and friction.cone_margin(q.body, q.state) >= 0)


def _from_rest(name: str, setup: Setup, here: SegmentStart, status: str, begin: Scalar) -> Segment:
    """Rolling if the force lies within the cone, otherwise the onset of gliding."""
    body, vectors, fn = here.q.body, here.q.state, here.q.fn
    if status != "slip" and _sticks(here.q):
        return here.segment(sticking(setup), begin)
    on_the_cone = status == "slip"
    directions = (
        [direction_on_the_cone(body, vectors, fn)]
        if on_the_cone
        else directions_from_rest(body, vectors, fn)
    )
    if len(directions) != 1:
        raise InputError(
            f"{name}: got {len(directions)} directions in which gliding could begin from rest, "
            "expected one: Coulomb's law does not determine how this motion continues"
        )
    precision = setup.precision
    # plane motion stays plane
    e = tuple(fn.chop(entry, tol=precision.eps) for entry in directions[0])
    series = onset(body, vectors, e, terms_for(precision.bits), precision.eps, fn, on_the_cone)
    begun = replace(here.start, model="gliding", vectors=vectors, until=here.until)
    return onset_segment(slow(setup), begun, series, here.recorded, begin)
