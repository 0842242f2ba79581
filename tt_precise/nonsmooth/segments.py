"""Segments of a motion whose equations change, and the states at which they begin."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy

from tt_precise.integration.columns import Row
from tt_precise.integration.heyoka_backend import propagate
from tt_precise.integration.multidouble_backend import propagate_in_doubles
from tt_precise.integration.precision import LONG_DOUBLES, Hardware, functions_of, times_in
from tt_precise.integration.segment import Segment
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.initial_state import InitialState

MOST_SEGMENTS = 10_000  # A run with more segments is refused.
NEWTON_STEPS = 60  # Newton steps from a knot of the series at most; 3 to 10 are needed.


@dataclass(frozen=True, eq=False)
class RegularisedSegment(Segment):
    """A segment in a regularised time s, whose state contains the time t."""

    def inside(self, times: Array, numbers: Any) -> list[Array]:
        """Solve t(s) = time by Newton's method, and evaluate the state there.

        t(s) is monotonic and bends one way in a step: from the end where it rises faster the
        method approaches the solution from one side.
        """
        wide: Any = LONG_DOUBLES if isinstance(numbers, Hardware) else numbers
        form, series, fn = self.setup.formulation, self.series, functions_of(wide)
        t, size = form.columns.index("t"), len(form.columns)

        def clock(row: list[Array]) -> Array:
            rate: Array = form.State(*row[:size]).clock(fn)
            return rate

        step = numpy.searchsorted(series.terms[:, t, 0], times.astype(float), side="left") - 1
        step = numpy.maximum(step, 0)
        ends = [series.begin[step], series.begin[step] + series.length[step]]
        knots = [times_in(wide, end.tolist()) for end in ends]
        faster = clock(series.evaluate(step, knots[0], wide)) >= clock(
            series.evaluate(step, knots[1], wide)
        )
        s = numpy.where(faster.astype(bool), *knots)
        tolerance = wide.number(self.setup.precision.eps) * times
        for _ in range(NEWTON_STEPS):
            row = series.evaluate(step, s, wide)
            rest = times - row[t]
            s = s + rest / clock(row)
            if (abs(rest) <= tolerance).all():
                break
        kind = numbers.kind if isinstance(numbers, Hardware) else object
        return [x.astype(kind) for x in series.evaluate(step, s, wide)]


def segment(setup: Setup, start: InitialState, begin: Scalar) -> Segment:
    """Integrate one segment, which begins at a dimensionless time."""
    run = (propagate_in_doubles if setup.precision.doubles else propagate)(setup, start)
    if not setup.phase.has_clock:
        return Segment(begin, setup, start, run)
    t, hits = setup.formulation.columns.index("t"), run.events.hits
    events = run.events._replace(hits=replace(hits, time=hits.state[t]))
    return RegularisedSegment(begin, setup, start, run._replace(time=run.row[t], events=events))


class SegmentStart(NamedTuple):
    """A motion at an instant from which a segment begins.

    ``recorded`` are the quadratures so far (scaled), ``until`` is the time left, and ``start`` that
    of the whole run.
    """

    start: InitialState
    q: Motion
    recorded: Row
    until: Scalar

    @classmethod
    def of_run(cls, setup: Setup, start: InitialState) -> SegmentStart:
        """Return the begin of a run."""
        fn = setup.precision.context
        q = Motion(start.body, start.vectors, fn, start.model, euler=start.euler)
        return cls(start, q, tuple(fn.mpf(0) for _ in setup.record), start.until)

    def after(self, former: Segment) -> SegmentStart:
        """Return the end of a segment that begins here."""
        row, layout = former.end_row, former.setup.layout
        q = layout.motion(former.start.body, row, self.q.fn)
        recorded, until = row[len(layout.form.columns) :], self.until - former.end_time
        return SegmentStart(self.start, q, recorded, until)

    def at(self, **components: Scalar) -> SegmentStart:
        """Return the same joint with other entries of the state."""
        q = self.q
        return self._replace(q=Motion(q.body, q.state._replace(**components), q.fn, q.model))

    def at_rest(self) -> SegmentStart:
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

    def segment(self, setup: Setup, begin: Scalar, until: Scalar = None) -> Segment:
        """Integrate the segment that begins here."""
        return segment(setup, self.entering(setup, until), begin)
