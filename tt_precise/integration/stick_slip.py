"""Exact Coulomb friction: gliding and rolling as pieces of one trajectory.

The top glides; below a small speed in polar form, in a time of its own, in which it comes to rest
without end and so reaches v = 0 to the last bit. There it rolls on where the force that rolling
needs lies within the cone |F_f| <= mu g_n ("stick"), until that force reaches the cone ("slip").
Gliding then begins anew with a power series, as it does from rest where no rolling is possible.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from tt_precise.integration.continuing import after, entering, propagated
from tt_precise.integration.dense_output import DenseOutput
from tt_precise.integration.events import existing
from tt_precise.integration.onset_output import OnsetOutput, terms_for
from tt_precise.integration.pieces import MotionPiece
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import SLOW_SPEED
from tt_precise.mechanics import friction, rolling
from tt_precise.mechanics.formulations import SLOW, STICKING
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.onset import direction_on_the_cone, directions_from_rest, onset
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress

MOST_PIECES = 10_000
GOES_ON = ("slow", "fast", "stick", "slip")


def pieces_of(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[MotionPiece]:
    """The pieces of the motion of scene ``name`` from ``start``, the last one ends it.

    Raises
    ------
    InputError
        More pieces than ``MOST_PIECES``, or gliding can begin in no direction, or in several.
    """
    found: list[MotionPiece] = []
    begin = start.until * 0
    for output in _outputs(name, setup, start, progress):
        if len(found) == MOST_PIECES:
            raise InputError(
                f"{name}: got more than {MOST_PIECES} changes between gliding and rolling, "
                "expected fewer: ask for a shorter time"
            )
        status = output.propagation.status
        found.append(MotionPiece(begin, output, status if status in ("stick", "slip") else ""))
        begin = begin + output.end_time
    return found


def _outputs(
    name: str, setup: Setup, start: InitialState, progress: Progress | None
) -> Iterator[DenseOutput]:
    plain, context = setup.formulation, setup.precision.context
    coordinates = plain.coordinates
    here = replace(start, row=tuple(context.mpf(0) for _ in setup.record))
    at_rest = not any(start.vectors.v)
    status = "rest" if at_rest else _speed_of(start.motion(context), context)
    while True:
        if status in ("rest", "stick", "slip"):
            output = _from_rest(name, setup, here, status)
        else:
            form = SLOW[coordinates] if status == "slow" else plain
            output = propagated(setup.but(formulation=form), entering(here, form, context))
        yield output
        status = output.propagation.status
        if isinstance(output, OnsetOutput) and status != "complete":
            status = "slow"
        if progress:
            progress(float(1 - (here.until - output.end_time) / start.until))
        if status not in GOES_ON:
            return
        here = after(output, here, at_rest=status == "stick")


def _speed_of(q: Motion, fn: Any) -> str:
    return "slow" if fn.hypot(q.state.vx, q.state.vy) < SLOW_SPEED else "fast"


def _from_rest(name: str, setup: Setup, here: InitialState, status: str) -> DenseOutput:
    """Rolling where the cone allows it, and the begin of gliding where not."""
    coordinates, fn = setup.formulation.coordinates, setup.precision.context
    q = here.motion(fn)
    if status != "slip":
        pressed = rolling.constraint_force(q.body, q.state)[2] > 0
        if pressed and friction.cone_margin(q.body, q.state) >= 0:
            form = STICKING[coordinates]
            rolls = setup.but(formulation=form, events=existing(setup.events, "rolling"))
            return propagated(rolls, entering(here, form, fn))
    precision = setup.precision
    vectors = here.vectors
    on_the_cone = status == "slip"
    directions = (
        [direction_on_the_cone(q.body, vectors, fn)]
        if on_the_cone
        else directions_from_rest(q.body, vectors, fn)
    )
    if len(directions) != 1:
        raise InputError(
            f"{name}: got {len(directions)} directions in which gliding could begin from rest, "
            "expected one: Coulomb's law does not say how this motion goes on"
        )
    series = onset(
        q.body, vectors, directions[0], terms_for(precision.bits), precision.eps, fn, on_the_cone
    )
    form = SLOW[coordinates]
    begun = replace(here, model="gliding", row=())
    return OnsetOutput(setup.but(formulation=form), begun, series, here.row)
