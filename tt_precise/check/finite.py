"""The check that every number is one: a simulation that blew up fails, at a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy

from tt_precise.check.blocks import Block, NotFinite
from tt_precise.check.finding import CheckFinding
from tt_precise.check.samples import Samples

NAME = "finite"
MEANING = "every column holds finite numbers, but for Euler angles where they are undefined"


class Finiteness:
    """Counts the entries that are no finite numbers, in the columns ``also`` beside the state's."""

    def __init__(self, also: Sequence[str]):
        self._also = also
        self._count, self._first = 0, ""
        self._at: float | None = None

    def look(self, block: Block, samples: Samples) -> None:
        """The next rows, as given and as vectors."""
        tilted = (samples.state.kx != 0) | (samples.state.ky != 0)
        for name in self._also:
            wrong = numpy.flatnonzero(~numpy.isfinite(block.values[name]) & tilted)
            self._count += len(wrong)
            if len(wrong) and (self._at is None or samples.t[wrong[0]] < self._at):
                row = int(wrong[0])
                self._at = float(samples.t[row])
                self._first = f"{name} = {block.values[name][row]} in {block.place(row)}"

    def finding(self, broken: NotFinite | None) -> CheckFinding:
        """How many entries are not finite, the row at which reading stopped included."""
        count, at, first = self._count, self._at, self._first
        if broken is not None:
            count, first = count + 1, f"{broken}, where the checks stop"
            at = broken.t if at is None else min(at, broken.t)
        return CheckFinding(
            NAME, "fail" if count else "pass", float(count), 0.0, at, first, MEANING
        )
