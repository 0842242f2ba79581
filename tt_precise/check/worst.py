"""The worst value of a check and where it was, and a curve of bounded length for the plot."""

from __future__ import annotations

import math

import numpy

MOST_POINTS = 4096


class RunningWorst:
    """Takes values of consecutive rows; keeps the worst, and the worst of every bucket of rows.

    ``largest_is_worst`` is False for checks that ask for values above a limit. A value that is
    no number is the worst of all.
    """

    def __init__(self, largest_is_worst: bool = True):
        self._sign = 1.0 if largest_is_worst else -1.0
        self.worst: float | None = None
        self.at: float | None = None
        self._bucket = 1
        self._t: list[numpy.ndarray] = []
        self._values: list[numpy.ndarray] = []
        self._count = 0

    def add(self, t: numpy.ndarray, values: numpy.ndarray) -> None:
        """The next rows."""
        badness = numpy.where(numpy.isnan(values), numpy.inf, values * self._sign)
        row = int(numpy.argmax(badness))
        if self.worst is None or badness[row] > self.worst * self._sign:
            self.worst, self.at = float(badness[row] * self._sign), float(t[row])
        self._keep(t, badness, self._bucket)
        if self._count > 2 * MOST_POINTS:
            t, badness = numpy.concatenate(self._t), numpy.concatenate(self._values)
            factor = math.ceil(self._count / MOST_POINTS)
            self._t, self._values, self._count = [], [], 0
            self._bucket *= factor
            self._keep(t, badness, factor)

    def _keep(self, t: numpy.ndarray, badness: numpy.ndarray, bucket: int) -> None:
        starts = numpy.arange(0, len(t), bucket)
        self._t.append(t[starts])
        self._values.append(numpy.maximum.reduceat(badness, starts))
        self._count += len(starts)

    @property
    def curve(self) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Times (s) and the worst value of the bucket of rows that begins there."""
        if not self._t:
            return numpy.empty(0), numpy.empty(0)
        return numpy.concatenate(self._t), self._sign * numpy.concatenate(self._values)
