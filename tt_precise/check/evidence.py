"""Whether what was compared with the true solution is enough to vouch for a whole trajectory.

The start is given and vouches for nothing. Of the other rows, 90 % must have been compared, up to
the end of the golden data (or of what was asked for), without a hole on the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy

SHARE = 0.9
HOLE = 1.5  # intervals; between rows that are evenly spaced otherwise
UNEVEN_HOLE = 0.1  # of the span; between rows that are not
EVEN = 0.9  # share of the intervals that are alike in evenly spaced rows
ALIKE = 1e-3  # relative
FEWEST = 10  # rows, where golden data have as many


@dataclass
class Evidence:
    """Takes the times of consecutive rows, and which of them were compared.

    ``compared`` and ``rows`` count rows after the start.
    """

    rows: int = 0
    compared: int = 0
    first: float | None = None
    last: float = 0.0
    _usual: float = 0.0
    _alike: int = 0
    _intervals: int = 0
    _widest: float = 0.0
    _at: float = 0.0

    def add(self, t: numpy.ndarray, compared: numpy.ndarray, start: numpy.ndarray) -> None:
        """The next rows; ``start`` marks the start itself."""
        if not len(t):
            return
        self.rows += int((~start).sum())
        self.compared += int((compared & ~start).sum())
        before = t[:1] if self.first is None else numpy.array([self.last])
        intervals = numpy.diff(numpy.concatenate((before, t)))
        if self.first is None:
            self.first, intervals = float(t[0]), intervals[1:]
        self.last = float(t[-1])
        if not len(intervals):
            return
        if not self._usual:
            # numpy.median would import numpy.ma
            self._usual = float(numpy.sort(intervals)[len(intervals) // 2])
        self._intervals += len(intervals)
        self._alike += int((abs(intervals - self._usual) <= ALIKE * self._usual).sum())
        widest = int(numpy.argmax(intervals))
        if intervals[widest] > self._widest:
            self._widest = float(intervals[widest])
            self._at = float(t[widest - len(intervals)]) - self._widest

    def lacking(self, end: float, most: int) -> str:
        """What is missing for a comparison up to time ``end`` (s); "" if it is enough.

        ``most`` is the number of golden times after the start.
        """
        if self.compared < max(SHARE * self.rows, min(FEWEST, most), 1):
            return f"only {self.compared} of {self.rows} rows after the start could be compared"
        assert self.first is not None
        if self.first > self._usual * (1 + ALIKE):
            return f"the first row is at t = {self.first:.6g} s, expected the start"
        if self.last + self._usual * (1 - ALIKE) <= end:
            return (
                f"the rows end at t = {self.last:.6g} s, expected them to go on to {end:.6g} s, or "
                f"--until {self.last:.6g} where no more is wanted"
            )
        even = self._alike >= EVEN * self._intervals
        widest = HOLE * self._usual if even else UNEVEN_HOLE * (end - self.first)
        if self._widest > widest:
            return f"there is no row between t = {self._at:.6g} and {self._at + self._widest:.6g} s"
        return ""
