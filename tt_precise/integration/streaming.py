"""Samples of a long run in double, a block at a time: memory grows with neither steps nor samples.

A ``Trajectory`` keeps the Taylor series of all its steps once it is asked for a state in between:
1.5 kB a step, 25 GB for a day of the toy top.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy

from tt_precise.integration.columns import Columns
from tt_precise.integration.dense_output import Status, long_double, moved_arrays
from tt_precise.integration.equations import longest_step
from tt_precise.integration.heyoka_backend import integrator, status_of
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup, require_contact
from tt_precise.mechanics.formulations import integrated
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.values import Array, InputError
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene, load_scene

if TYPE_CHECKING:
    import pandas

BLOCK = 16_384
# Ctrl-C is noticed between blocks only: so much of dimensionless time takes 1 s or less
LONGEST_BLOCK = 1e5


class Stream:
    """An iterator over the samples of a scene: data frames of column ``t`` and the named columns.

    As ``Trajectory.frame``, in double and in the Newton form. Sampled every ``sample_every`` of
    the scene, the last multiple up to ``until`` included. Has to be exhausted before ``status``
    says how it ended; like a trajectory, it gives nothing beyond the end of its model.

    Attributes
    ----------
    status
        As of a trajectory; None while there are more samples.
    """

    def __init__(self, scene: str | Scene, *names: str, block: int = BLOCK):
        self.scene = load_scene(scene)
        if self.scene.may_stick:
            raise InputError(
                f"{self.scene.name}: got Coulomb's friction, expected another law: its pieces "
                "are joined by integrate(), not streamed"
            )
        if self.scene.lifts:
            raise InputError(
                f"{self.scene.name}: got a scene with flight or an elastic table, expected another "
                "one: its pieces are joined by integrate(), not streamed"
            )
        self.status: Status | None = None
        precision = precision_named("double")
        self._setup = Setup(
            formulation=integrated(self.scene.model, "newton", self.scene.body.friction),
            precision=precision,
        )
        self._start = InitialState.of(self.scene, precision.arithmetic)
        require_contact(self.scene.name, self._start, precision.context, "unilateral")
        self._columns = Columns(self._setup, self._start)
        self._names = names or self._columns.names
        for name in self._names:
            self._columns.dimension(name)
        step = float(to_mpmath(self.scene.sample_every, precision.context) / self._start.units.time)
        self._block = max(1, min(block, int(LONGEST_BLOCK / step)))

    def __iter__(self) -> Iterator[pandas.DataFrame]:
        import pandas

        count = int(self.scene.until / self.scene.sample_every) + 1
        body = self._start.body.map(float)
        self.status = None
        for first, rows in self._rows(count):
            entries = tuple(rows.T)
            numbers = numpy.arange(first, first + len(rows))
            moved = moved_arrays(self._setup, body, entries, self._times(numbers)[1])
            if not first:  # not moved: rates may be undefined there
                moved = tuple(
                    numpy.where(numbers == 0, x, m) for x, m in zip(entries, moved, strict=True)
                )
            columns = self._columns.of_arrays(self._names, moved)
            seconds = numbers * numpy.longdouble(self.scene.sample_every.numerator)
            seconds = (seconds / self.scene.sample_every.denominator).astype(float)
            yield pandas.DataFrame({"t": seconds, **columns})

    def _rows(self, count: int) -> Iterator[tuple[int, Array]]:
        start, setup = self._start, self._setup
        with integrator(setup) as made:
            made.begin(setup, start)
            longest = longest_step(start.body, start.vectors, made.adaptive.order, setup.precision)
            limits = {} if longest is None else {"max_delta_t": float(longest)}
            for first in range(0, count, self._block):
                times = self._times(numpy.arange(first, min(first + self._block, count)))[0]
                # a grid has to begin at the time where the integrator is
                grid = numpy.concatenate([[made.adaptive.time], times]) if first else times
                outcome, *_, rows = made.adaptive.propagate_grid(grid, **limits)
                rows = rows[int(first > 0) :]
                yield first, rows[numpy.isfinite(rows).all(axis=1)]
                status = status_of(outcome, made.terminal)
                if status != "complete":
                    self.status = status
                    return
        self.status = "complete"

    def _times(self, numbers: Array) -> tuple[Array, Array]:
        """Dimensionless times of samples: rounded to double, and what the rounding cut off."""
        context = self._setup.precision.context
        step = to_mpmath(self.scene.sample_every, context) / self._start.units.time
        exact = numbers * long_double(step)
        rounded = exact.astype(float)
        return rounded, (exact - rounded).astype(float)
