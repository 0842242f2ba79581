"""Golden rows carried to other times by the equations of motion, with a bound on the error.

The Taylor coefficients that the equations give at a row make its solution known around it, in
double: a row of a simulator that lies between two golden times is compared with the nearer one,
carried over the difference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy

from tt_precise.mechanics.conversion import euler_from_vectors
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.taylor import SeriesFunctions, solution
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.scene import Scene

ORDER = 24
# The terms left out are less than the last two, where two terms are at most this part of the two
# before them (two, because every other one may be zero).
SHRINKING = 0.25
EPS = float(numpy.finfo(float).eps)
# Rounding of the row and of the equations, in terms of what the rates are made of: they may cancel.
ROUNDINGS = 16 * EPS
TINY = float(numpy.finfo(float).tiny)


@dataclass(frozen=True)
class Carried:
    """Columns by name at the times asked for, and bounds of their errors; NaN where undefined."""

    values: dict[str, numpy.ndarray]
    bounds: dict[str, numpy.ndarray]


class Carrier:
    """The solutions through rows of vectors, each in double around its own time.

    ``vectors`` has shape (6 or 8, rows), SI, in the order of ``NewtonState``; rows that start
    nowhere are NaN.
    """

    def __init__(self, scene: Scene, vectors: Sequence[numpy.ndarray]):
        self._body = scene.body.numbers(float)
        self._lifts = scene.lifts and scene.model != "flight"
        self._form = formulation(scene.model, "newton", scene.body.friction)
        self._start = [numpy.asarray(entry, float) for entry in vectors]

    @cached_property
    def _coefficients(self) -> numpy.ndarray:
        """Shape (rows, terms, entries): a matrix for each row."""

        def rates(entries: tuple[Scalar, ...]) -> Sequence[Scalar]:
            found: Sequence[Scalar] = self._form.rates(
                self._body, self._form.State(*entries), SeriesFunctions
            )
            return found

        width = len(self._form.columns)
        with numpy.errstate(all="ignore"):
            series = solution(rates, self._start[:width], ORDER)
        return numpy.ascontiguousarray(numpy.array([s.c for s in series]).transpose(2, 1, 0))

    @cached_property
    def _scales(self) -> numpy.ndarray:
        parts = (slice(0, 3), slice(3, 6), slice(6, 8))
        sizes = [float(numpy.nanmax(numpy.abs(self._start[part]), initial=0)) for part in parts]
        kinds = [0, 0, 0, 1, 1, 1, 2, 2][: len(self._form.columns)]
        return numpy.array([sizes[kind] or 1.0 for kind in kinds])

    @cached_property
    def _rates(self) -> numpy.ndarray:
        """How large the terms are that the rates are sums of, shape (rows, entries)."""
        kx, ky, _, Lx, Ly, Lz, *v = self._start
        R, g = self._body.R, self._body.g
        L = numpy.sqrt(Lx**2 + Ly**2 + Lz**2)
        omega = L / min(self._body.I1, self._body.I3)
        speed = R * omega + numpy.sqrt(R * g)
        # all but the vertical entries, and all rates, vanish together in an upright spin
        tilt = numpy.hypot(kx, ky) + numpy.hypot(Lx, Ly) / numpy.fmax(L, TINY)
        if v:
            tilt = tilt + numpy.hypot(*v) / speed
        tilt = numpy.fmin(tilt, 1.0)
        sizes = [omega * tilt] * 3 + [L * omega * tilt] * 3 + [speed**2 / R * tilt] * 2
        return numpy.array(sizes[: len(self._form.columns)]).T

    def carry(self, rows: numpy.ndarray, delays: numpy.ndarray, rounding: numpy.ndarray) -> Carried:
        """Row ``rows[i]`` at ``delays[i]`` seconds after its time, for each i; rows ascending.

        ``rounding`` is the error of each delay, in s.
        """
        width = len(self._scales)
        change, bound = numpy.empty((len(rows), width)), numpy.empty((len(rows), width))
        with numpy.errstate(all="ignore"):
            for part in _stretches(rows):
                matrix = self._coefficients[rows[part.start]]
                powers = numpy.cumprod(numpy.tile(delays[part], (ORDER, 1)), axis=0).T
                slopes = abs(matrix[2:]) * numpy.arange(2, ORDER + 1)[:, None]
                change[part] = powers @ matrix[1:]
                sizes = abs(powers) @ abs(matrix[1:])
                terms = (abs(powers[:, -4:, None] * matrix[-4:]) / self._scales).max(axis=2)
                last, before = terms[:, 2:].sum(axis=1), terms[:, :2].sum(axis=1)
                tail = numpy.where(last <= SHRINKING * before, last, numpy.inf)
                bound[part] = (
                    ROUNDINGS * (sizes + abs(delays[part, None]) * self._rates[rows[part.start]])
                    + tail[:, None] * self._scales
                    + rounding[part, None] * (abs(matrix[1]) + abs(powers[:, :-1]) @ slopes)
                )
                if self._lifts:  # where the top is not on the table, the equations are others
                    bound[part] = numpy.inf
                if not self._form.friction.smooth_at_rest:
                    # smooth only while the gliding cannot come to rest
                    moved = numpy.hypot(sizes[:, 6], sizes[:, 7])
                    speed = numpy.hypot(*(entry[rows[part.start]] for entry in self._start[6:]))
                    bound[part][~(moved < speed)] = numpy.inf
        given = numpy.array([entry[rows] for entry in self._start[:width]]).T
        values = (given + change).T
        bounds = (bound + EPS * (abs(given) + abs(change))).T
        names = self._form.columns
        euler, euler_bounds = self._euler(values, bounds)
        return Carried(
            {**dict(zip(names, values, strict=True)), **euler},
            {**dict(zip(names, bounds, strict=True)), **euler_bounds},
        )

    def _euler(
        self, values: numpy.ndarray, bounds: numpy.ndarray
    ) -> tuple[dict[str, numpy.ndarray], dict[str, numpy.ndarray]]:
        """The Euler angles of vectors, and what errors of the vectors make of them."""

        def angles(vectors: numpy.ndarray) -> numpy.ndarray:
            state = NewtonState(*vectors, *(numpy.zeros_like(vectors[0]),) * (8 - len(vectors)))
            return numpy.array(euler_from_vectors(self._body, state, numpy))

        with numpy.errstate(all="ignore"):
            found = angles(values)
            spread = ROUNDINGS * abs(found)
            for entry, bound in enumerate(bounds):
                moved = values.copy()
                moved[entry] += bound
                spread += abs(angles(moved) - found)
        names = EulerState._fields
        return dict(zip(names, found, strict=True)), dict(zip(names, spread, strict=True))


def _stretches(rows: numpy.ndarray) -> Iterator[slice]:
    """Runs of equal entries."""
    ends = numpy.flatnonzero(numpy.diff(rows, append=-1)) + 1
    start = 0
    for end in ends.tolist():
        yield slice(start, end)
        start = end
