"""One segment of a motion: from a ``Joint`` to the next."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from tt_precise.integration.columns import Row
from tt_precise.integration.dense_output import DenseOutput, StoredPieces
from tt_precise.integration.heyoka_backend import propagate, repeating
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.quantities import Motion
from tt_precise.nonsmooth.regularised_time import RegularisedTimeOutput
from tt_precise.runtime.values import Scalar
from tt_precise.scene.initial_state import InitialState

MOST_SEGMENTS = 10_000  # of one run


def propagated(setup: Setup, start: InitialState) -> DenseOutput:
    """Return the segment from ``start``, readable over t."""
    stored = StoredPieces(setup) if setup.precision.in_software or setup.events else None
    propagation = propagate(setup, start, dense=stored)
    pieces = stored.pieces if stored else None
    again = repeating(setup, start, propagation)
    if not setup.phase.has_clock:
        return DenseOutput(setup, start, propagation, pieces, again)
    t = setup.formulation.columns.index("t")
    found = propagation.found
    found = found._replace(hits=tuple(hit._replace(time=hit.state[t]) for hit in found.hits))
    return RegularisedTimeOutput(setup, start, replace(propagation, found=found), pieces, again)


class Joint(NamedTuple):
    """A motion at an instant from which a segment begins.

    ``recorded`` are the quadratures so far (scaled), ``until`` is the time left, and ``start`` that
    of the whole run.
    """

    start: InitialState
    q: Motion
    recorded: Row
    until: Scalar

    @classmethod
    def at_start(cls, setup: Setup, start: InitialState) -> Joint:
        """Return the begin of a run."""
        fn = setup.precision.context
        q = Motion(start.body, start.vectors, fn, start.model, euler=start.euler)
        return cls(start, q, tuple(fn.mpf(0) for _ in setup.record), start.until)

    def after(self, output: DenseOutput) -> Joint:
        """Return the end of a segment that begins here."""
        row, layout = output.end_row, output.setup.layout
        q = layout.motion(output.start.body, row, self.q.fn)
        return Joint(self.start, q, row[len(layout.form.columns) :], self.until - output.end_time)

    def at(self, **entries: Scalar) -> Joint:
        """Return the same joint with other entries of the state."""
        q = self.q
        return self._replace(q=Motion(q.body, q.state._replace(**entries), q.fn, q.model))

    def at_rest(self) -> Joint:
        """Return the same joint with a contact point at rest."""
        zero = self.q.fn.mpf(0)
        return self.at(vx=zero, vy=zero)

    def entering(self, setup: Setup, until: Scalar = None) -> InitialState:
        """Return the start of a segment that is integrated as ``setup`` says."""
        form = setup.formulation
        return replace(
            self.start,
            model=form.model,
            vectors=self.q.state,
            until=self.until if until is None else until,
            row=(*form.State.of(self.q), *self.recorded),
        )

    def propagated(self, setup: Setup, until: Scalar = None) -> DenseOutput:
        """Return the segment that begins here, readable over t."""
        return propagated(setup, self.entering(setup, until))
