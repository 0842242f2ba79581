"""Pieces that are made before it is their turn, so that other processes prepare them meanwhile.

A piece follows from the one before it, and is kept where that is proved; where it is not, all that
was made after it is dropped, and made again. So what is proved does not depend on how many pieces
are made ahead.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flint import arb

from tt_precise.certify.approximation import Piece, Steps
from tt_precise.certify.error_set import ErrorSet
from tt_precise.certify.sets import One
from tt_precise.certify.step import Crossing
from tt_precise.certify.verdict import NotProved
from tt_precise.runtime.arithmetic import Scalar

NEARLY, FORGETTING = 0.9, 1.01  # of the length of a step that failed; by which each step raises it


@dataclass(frozen=True)
class Pace:
    """How long the next step may be: at most ``limit``."""

    limit: arb
    ceiling: arb
    longest: arb

    def on(self) -> Pace:
        """After a step."""
        ceiling = min(self.ceiling * FORGETTING, self.longest)
        return Pace(min(self.limit * 5 / 4, ceiling), ceiling, self.longest)

    def back(self, length: arb) -> Pace:
        """After a step that failed: these stay in mind, for those to come are much alike."""
        ceiling = min(self.ceiling, length) * NEARLY
        return Pace(min(self.limit, length) / 2, ceiling, self.longest)


@dataclass(frozen=True)
class Made:
    """A piece, or why there is none, and the step of the theorem that begins with it."""

    before: list[Scalar]
    pace: Pace
    length: arb
    piece: Piece | None
    begun: Callable[[ErrorSet], Crossing] | None
    failure: NotProved | None = None

    def proved(
        self, course: One, reached: Sequence[arb], errors: ErrorSet
    ) -> tuple[Piece, Crossing]:
        """The piece and what is proved of it, for errors at the end of the former piece.

        Raises
        ------
        NotProved
            There is no piece, or a hypothesis did not verify for it.
        """
        if self.piece is None or self.begun is None:
            raise self.failure or NotProved("approximation", "there is no piece")
        return self.piece, self.begun(errors.shifted(course.gaps(reached, self.piece)))


class Ahead:
    """The pieces of ``course`` in turn."""

    def __init__(self, course: One, steps: Steps, longest: arb):
        self._course, self._steps = course, steps
        self._pace = Pace(longest, longest, longest)
        self._made: deque[Made] = deque()

    def next(self) -> Made:
        """The next one."""
        while len(self._made) < self._course.ahead:
            if self._made and self._made[-1].failure:
                break
            self._made.append(self._make())
        return self._made.popleft()

    def _make(self) -> Made:
        before, pace = self._steps.state, self._pace
        try:
            piece = self._steps.step(pace.limit)
            begun = self._course.begin(piece)
        except NotProved as why:
            return Made(before, pace, self._steps.length, None, None, why)
        self._pace = pace.on()
        return Made(before, pace, self._steps.length, piece, begun)

    def again(self, made: Made) -> None:
        """Make it again, and all after it, with shorter steps."""
        self._steps.back(made.before)
        self._pace = made.pace.back(made.length)
        self._made.clear()
