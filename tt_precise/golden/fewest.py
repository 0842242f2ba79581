"""The fewest correct digits of every column, over any number of measured rows."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy

from tt_precise.golden.distance import correct_digits
from tt_precise.golden.measuring import Measured


@dataclass
class _Column:
    error: float = 0.0  # the largest that is not within its bound
    bound: float = 0.0  # the largest of those that errors were within


@dataclass
class FewestDigits:
    """Takes blocks of measured rows.

    ``rows`` were compared, of which ``exactly`` at golden times, the start apart; ``at`` is the
    time (s) of the largest error of all.
    """

    rows: int = 0
    exactly: int = 0
    at: float | None = None
    _worst: float = -1.0
    _columns: dict[str, _Column] = field(default_factory=dict)

    def add(self, found: Measured) -> None:
        """The next rows."""
        self.rows += int(found.compared.sum())
        for name, errors in found.errors.items():
            bounds, there = found.bounds[name], ~numpy.isnan(errors)
            if not there.any():
                continue
            column = self._columns.setdefault(name, _Column())
            own = errors > bounds
            error = numpy.max(errors, where=own, initial=column.error)
            bound = numpy.max(bounds, where=there & ~own, initial=column.bound)
            column.error, column.bound = float(error), float(bound)
        exact = [bounds == 0 for bounds in found.bounds.values()]
        if exact:
            self.exactly += int((numpy.any(exact, axis=0) & found.compared & ~found.start).sum())
        worst = found.worst()
        if found.compared.any():
            row = int(numpy.argmax(numpy.where(found.compared, worst, -1.0)))
            if worst[row] > self._worst:
                self._worst, self.at = float(worst[row]), float(found.t[row])

    @property
    def digits(self) -> dict[str, float]:
        """Of each column; at least so many where most rows lie between golden times."""
        between = self.rows > 2 * self.exactly + 1
        return {
            name: correct_digits(max(one.error, one.bound) if between else one.error)
            for name, one in self._columns.items()
        }

    @property
    def worst(self) -> float:
        """The fewest of all."""
        return min(self.digits.values())
