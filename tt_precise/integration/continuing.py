"""From one piece of a motion to the next: propagating it, where it ends, and entering another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from tt_precise.integration.dense_output import DenseOutput, StoredPieces
from tt_precise.integration.own_time import OwnTimeOutput
from tt_precise.integration.propagate import propagate
from tt_precise.integration.quadratures import motion
from tt_precise.integration.setup import Setup
from tt_precise.mechanics import polar
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Functions, Scalar


def propagated(setup: Setup, start: InitialState) -> DenseOutput:
    """One piece: ``start`` propagated as ``setup`` says, readable over t."""
    stored = StoredPieces(setup) if setup.precision.name in ("quad", "mp") else None
    propagation = propagate(setup, start, dense=stored)
    pieces = stored.pieces if stored else None
    if not setup.formulation.own_time:
        return DenseOutput(setup, start, propagation, pieces)
    t = setup.formulation.columns.index("t")
    hits = tuple(hit._replace(time=hit.state[t]) for hit in propagation.hits)
    return OwnTimeOutput(setup, start, replace(propagation, hits=hits), pieces)


def after(output: DenseOutput, before: InitialState, *, at_rest: bool = False) -> InitialState:
    """Where the next piece begins: the last one's end, as a row of its own formulation."""
    setup, fn = output.setup, output.precision.context
    row = output.end_row
    q = motion(setup.formulation, setup.record, output.start.body, row, fn)
    vectors = q.state
    if at_rest:
        vectors = vectors._replace(vx=fn.mpf(0), vy=fn.mpf(0))
    euler = q.euler if setup.formulation.coordinates == "euler" else before.euler
    return replace(
        before,
        model=setup.formulation.model,
        vectors=vectors,
        euler=euler,
        until=before.until - output.end_time,
        row=row[len(setup.formulation.columns) :],
    )


def entering(here: InitialState, form: Formulation, fn: Functions) -> InitialState:
    """The same place as the start of a piece that is integrated as ``form``.

    The row of ``here`` holds quadratures only.
    """
    state: tuple[Scalar, ...]
    if "rise" in form.columns:
        state = _lifted(here, form, fn)
    elif not form.own_time:
        state = form.start(here.body, here.vectors, here.euler)
    elif form.coordinates == "euler":
        state = polar.from_euler(here.euler, fn)
    else:
        state = polar.from_vectors(here.vectors, fn)
    return replace(here, model=form.model, row=(*state, *here.row))


def _lifted(here: InitialState, form: Formulation, fn: Functions) -> tuple[Scalar, ...]:
    vectors: Any = here.vectors
    height, rise = getattr(vectors, "height", fn.mpf(0)), getattr(vectors, "rise", fn.mpf(0))
    turning = here.euler if form.coordinates == "euler" else vectors[:8]
    if not form.own_time:
        return (*turning, height, rise)
    return (*turning, fn.sqrt(-height) if height < 0 else fn.mpf(0), rise, fn.mpf(0))
