"""A run in several doubles and its reference run: digits from what their states differ by."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import NamedTuple

from tt_precise.arithmetic import Array
from tt_precise.initial_state import InitialState
from tt_precise.integrate.accuracy import RATIO, digits_over_rows
from tt_precise.integrate.columns import Columns
from tt_precise.integrate.dense_output import DenseOutput, StoredPieces
from tt_precise.integrate.in_doubles import ReadPiece, propagate_in_doubles
from tt_precise.integrate.paired import MOST_ROWS, Beginning
from tt_precise.integrate.propagate import ARRIVED, Pieces, Propagation
from tt_precise.integrate.setup import Setup
from tt_precise.integrate.system import full_tolerance
from tt_precise.numerals import to_mpmath
from tt_precise.progress import Progress
from tt_precise.taylor.numbers import multiples, split


class OutputInDoubles(NamedTuple):
    """A propagation's dense output, and its series where these could be stored."""

    output: DenseOutput
    pieces: tuple[ReadPiece, ...] | None

    def rows(self, times: Array) -> Array:
        """States at rising times in parts: axes (time, part, entry)."""
        import numpy

        assert self.pieces is not None
        ends = [float(piece.bounds[1]) for piece in self.pieces[:-1]]
        of_piece = numpy.searchsorted(ends, times[:, 0], side="left")
        bounds = numpy.searchsorted(of_piece, range(len(self.pieces) + 1))
        return numpy.concatenate(
            [
                piece.at(times[low:high])
                for piece, low, high in zip(self.pieces, bounds, bounds[1:], strict=False)
                if high > low
            ]
        )


@dataclass(frozen=True)
class PairInDoubles:
    """A run and its reference run, as ``paired.Pair``; rows have the axes (time, part, entry)."""

    setup: Setup
    beginning: Beginning
    run: DenseOutput
    reference: DenseOutput
    rows: Array
    reference_rows: Array

    @cached_property
    def digits(self) -> Array:
        """Significant digits of the worst entry of the run, at its samples."""
        import numpy

        from tt_precise.integrate.deviation import Deviating

        # the first parts are close to each other, so their difference is exact
        apart = (self.rows - self.reference_rows).sum(axis=1)
        entries = tuple(map(Deviating, self.rows.sum(axis=1).T, apart.T))
        columns = Columns(self.setup, self.beginning.start)
        with numpy.errstate(all="ignore"):  # once for all: it costs as much as an operation
            found = columns.of_arrays(columns.names, entries, float)
        same = numpy.zeros(len(self.rows))  # what is the same number in both, as v_A in rolling
        return digits_over_rows(
            {name: getattr(one, "value", one) for name, one in found.items()},
            {name: numpy.abs(getattr(one, "deviation", same)) for name, one in found.items()},
            columns.start.units,
            columns.precision.bits,
        )


def run_in_doubles(
    setup: Setup, start: InitialState, progress: Progress | None = None
) -> OutputInDoubles:
    """One propagation, its series stored."""
    stored = StoredPieces(setup)
    propagation = propagate_in_doubles(setup, start, dense=stored, progress=progress)

    def again(pieces: Pieces, progress: Progress | None) -> Propagation:
        return propagate_in_doubles(setup, start, dense=pieces, progress=progress)

    output = DenseOutput(setup, start, propagation, stored.pieces, again)
    return OutputInDoubles(output, stored.pieces)


def pair_in_doubles(
    run: OutputInDoubles, setup: Setup, beginning: Beginning, every: Fraction
) -> PairInDoubles | None:
    """``run`` with its reference run, compared ``every`` so many s and at the end.

    That has the tolerance over ``RATIO``, so other steps and another order, and body and start
    rounded the other way. None where the tolerance leaves no room for that, where a run ends
    before its horizon, and where rows or steps are too many: then reference runs are made one
    after the other.
    """
    import numpy

    tolerance = setup.tolerance / RATIO
    start = beginning.start
    fn, parts = setup.precision.context, setup.precision.doubles
    step = to_mpmath(every, fn) / start.units.time
    if tolerance < full_tolerance(setup.precision) or start.until > MOST_ROWS * step:
        return None
    complete = run.output.propagation.status in ARRIVED and run.pieces is not None
    if not complete or not start.until:
        return None
    reference = run_in_doubles(
        setup.but(tolerance=tolerance, events=(), paired=False), beginning.reference
    )
    if reference.output.propagation.status not in ARRIVED or reference.pieces is None:
        return None
    count = math.ceil(float(start.until / step) - 1e-9)
    times = numpy.concatenate(
        [multiples(step, numpy.arange(count), parts), [split(start.until, parts)]]
    )
    return PairInDoubles(
        setup, beginning, run.output, reference.output, run.rows(times), reference.rows(times)
    )
