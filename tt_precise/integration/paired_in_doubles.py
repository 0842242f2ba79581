"""A run in several doubles and its reference run: digits from what their states differ by."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from tt_precise.integration.accuracy import RATIO, digits_over_rows
from tt_precise.integration.columns import Columns
from tt_precise.integration.dense_output import DenseOutput, StoredPieces
from tt_precise.integration.in_doubles import propagate_in_doubles
from tt_precise.integration.paired import Beginning
from tt_precise.integration.propagate import ARRIVED, Pieces, Propagation
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import full_tolerance
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.progress import Progress

SMALL = 2.0**-600  # of deviations, so that their squares vanish where values are zero


@dataclass(frozen=True)
class PairInDoubles:
    """A run and its reference run, as ``paired.Pair``, and their rows at the samples' times.

    These have the axes (time, part, entry).
    """

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

        from tt_precise.integration import deviation

        # the first parts are close to each other, so their difference is exact
        apart = self.rows - self.reference_rows
        entries = numpy.empty((apart.shape[2], len(apart)), dtype=complex)
        entries.real, entries.imag = self.rows[:, 0].T, SMALL * sum(apart.transpose(1, 2, 0))
        columns = Columns(self.setup, self.beginning.start)
        with numpy.errstate(all="ignore"):
            found = columns.of_arrays(columns.names, tuple(entries), float, deviation)
        return digits_over_rows(
            {name: one.real for name, one in found.items()},
            {name: abs(one.imag) / SMALL for name, one in found.items()},
            columns.start,
            columns.precision.bits,
        )


def run_in_doubles(
    setup: Setup, start: InitialState, progress: Progress | None = None
) -> DenseOutput:
    """One propagation, its series stored."""
    stored = StoredPieces(setup)
    propagation = propagate_in_doubles(setup, start, dense=stored, progress=progress)

    def again(pieces: Pieces, progress: Progress | None) -> Propagation:
        return propagate_in_doubles(setup, start, dense=pieces, progress=progress)

    return DenseOutput(setup, start, propagation, stored.pieces, again)


def pair_in_doubles(run: DenseOutput, beginning: Beginning) -> PairInDoubles | None:
    """``run`` with its reference run, compared at the scene's samples.

    That has the tolerance over ``RATIO``, so other steps and another order, and body and start
    rounded the other way. None where the tolerance leaves no room for that, where a run ends
    before its horizon, and where rows or steps are too many: then reference runs are made one
    after the other.
    """
    setup, times = run.setup, beginning.sample_moments
    finer = setup.but(tolerance=setup.tolerance / RATIO, events=(), paired=False)
    if finer.tolerance < full_tolerance(setup.precision) or times is None:
        return None
    if run.propagation.status not in ARRIVED or not run.stored:
        return None
    reference = run_in_doubles(finer, beginning.reference)
    if reference.propagation.status not in ARRIVED or not reference.stored:
        return None
    return PairInDoubles(
        setup, beginning, run, reference, run.in_parts(times), reference.in_parts(times)
    )
