"""Flight: of a rigid top that has lost contact, and between contacts with an elastic table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from tt_precise.integration.contact import contact_terms
from tt_precise.integration.continuing import after, entering, propagated
from tt_precise.integration.events import existing
from tt_precise.integration.pieces import MotionPiece
from tt_precise.integration.setup import Setup
from tt_precise.mechanics import compliant
from tt_precise.mechanics.formulations import FLIGHT, flight_over
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.lifted import LiftedState
from tt_precise.runtime.arithmetic import Functions
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress

MOST_BOUNCES = 10_000


def flying(setup: Setup, start: InitialState) -> list[MotionPiece]:
    """The flight that begins at ``start``, until the top comes down: one piece."""
    fn = setup.precision.context
    here = replace(start, row=start.row or tuple(fn.mpf(0) for _ in setup.record))
    output = propagated(setup, entering(here, setup.formulation, fn))
    if output.propagation.status == "landing":
        output.propagation = replace(output.propagation, status="landed")
    return [MotionPiece(start.until * 0, output, "")]


def flying_on(
    pieces: Sequence[MotionPiece], setup: Setup, start: InitialState
) -> list[MotionPiece]:
    """``pieces``, and the flight where the last one has lost contact, until the top comes down."""
    *former, last = pieces
    if last.output.propagation.status != "contact_lost":
        return list(pieces)
    rest = start.until - last.begin
    here = after(last.output, replace(last.output.start, until=rest))
    form = FLIGHT[setup.formulation.coordinates]
    flight = setup.but(formulation=form, events=existing(setup.events, "flight"))
    (flown,) = flying(flight, here)
    begin = last.begin + last.output.end_time
    return [*former, replace(last, ended="lift_off"), replace(flown, begin=begin)]


def bouncing(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[MotionPiece]:
    """The pieces of the motion on an elastic table: in contact, and in flight, in turn.

    It begins where a table at rest carries what the rigid one would, unless the scene says at
    which height. A damped table lets go before it has come up, and takes the top again where its
    force would push once more.

    Raises
    ------
    InputError
        Too many of them.
    """
    fn, contact = setup.precision.context, setup.formulation
    here = _begun(start, setup, fn)
    found: list[MotionPiece] = []
    begin, flies = start.until * 0, _flies(here)
    while True:
        form = flight_over(contact.model, contact.coordinates) if flies else contact
        events = existing(setup.events, "flight") if flies else setup.events
        output = propagated(setup.but(formulation=form, events=events), entering(here, form, fn))
        status = output.propagation.status
        joint = {"release": "separation", "sinking": "landing"}.get(status, status)
        found.append(
            MotionPiece(begin, output, joint if joint in ("separation", "landing") else "")
        )
        if joint not in ("separation", "landing"):
            return found
        if len(found) == MOST_BOUNCES:
            raise InputError(
                f"{name}: got more than {MOST_BOUNCES} changes of contact, expected fewer: ask "
                "for a shorter time"
            )
        begin = begin + output.end_time
        here, flies = after(output, here), joint == "separation"
        if status == "landing" or (contact.own_time and status == "separation"):
            here = replace(here, vectors=_on_the_surface(here.vectors, fn))
        if progress:
            progress(float(begin / start.until))


def _on_the_surface(vectors: Any, fn: Functions) -> Any:
    return vectors._replace(height=fn.mpf(0))


def _flies(here: InitialState) -> bool:
    vectors: Any = here.vectors
    pulls = bool(compliant.reach(here.body, vectors.height, vectors.rise) > 0)
    return bool(vectors.height > 0) or (vectors.height == 0 and vectors.rise >= 0) or pulls


def _begun(start: InitialState, setup: Setup, fn: Functions) -> InitialState:
    vectors: Any = start.vectors
    if not isinstance(vectors, LiftedState):
        numerator, denominator = contact_terms("gliding", start.body, vectors, fn)
        height = compliant.resting_height(start.body, numerator / denominator, fn)
        vectors = LiftedState(*(*vectors, height, fn.mpf(0)))
    zeros = tuple(fn.mpf(0) for _ in setup.record)
    return replace(start, vectors=vectors, row=zeros)
