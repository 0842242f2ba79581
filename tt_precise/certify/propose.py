"""Lengths of steps. Nothing here is trusted: a bad length is refused, or makes the enclosure wide.

The kernel computes the polynomials itself, from the middle of the enclosure, and returns the costs
of a step: the defect, the error of the flow, the growth of errors. These costs determine the next
length.
"""

from __future__ import annotations

import math

from flint import arb, fmpz

from tt_precise.certify.balls import NotProved
from tt_precise.certify.kernel import LOW, KernelEquations, Step

FIRST = 2.0**-3  # Length of the first step, in the problem's unit of time.
LONGER = 1.25  # A step is at most so much longer than the one before it.
AGAIN = 0.8  # A step that should have been shorter than this, relatively, is made again.
SHORTER = 0.95  # A step that is made again has this part of the length that its costs ask for.
MOST_FAILURES = 12  # Steps in a row that are made again, most half as long as the one before.
# Of a step: before an undecided instant, or the end of a solution, they would get shorter for ever.
# The fastest passage of a pole in a golden scene takes steps that are a thousand times as long.
SHORTEST = 2.0**-24
DEFECT_BITS = 8  # The defect may exceed a rounding error of the polynomials by so many bits.
FLOW_ERROR = 1e-5  # Largest q G: growth of an error in a step by the error of its flow, relative.
GROWTH = 1e5  # Largest exp(a S): the bound within a step over the bound at its end.


class Proposer:
    """The unit and length of the next step: ``power`` and ``length`` (units of 2^power)."""

    def __init__(self, equations: KernelEquations):
        self.equations, self.power, self._size, self.failures = equations, 0, FIRST, 0
        self._why: ArithmeticError = NotProved("time", "the solution may end here")

    def next(self, left: float) -> tuple[int, arb]:
        """Return power and length of a step that does not go much further than a time ``left``.

        Raises ``NotProved``: steps have become too short.
        """
        if self._size * 2.0**self.power < SHORTEST:
            raise self._why
        self._size = min(self._size, left / 2.0**self.power * (1 + 1e-9) + 1e-9)
        # a length near 1/4 gives the coefficients of the polynomials about the same size
        shift = math.frexp(self._size)[1] + 1 if not 1 / 16 < self._size < 1 / 2 else 0
        self.power, self._size = self.power + shift, self._size / 2.0**shift
        # a short mantissa, which is exact in any arithmetic
        exponent = math.frexp(self._size)[1] - 24
        whole = max(1, int(self._size * 2.0**-exponent))
        return self.power, arb(fmpz(whole)) * arb(2) ** exponent

    def accepts(self, step: Step) -> bool:
        """Choose the next length by the costs of a step; False if the step should be repeated."""
        defect, flow, growth = (float(x) for x in step.costs)
        order, length = self.equations.order, float(step.length)
        allowed = 2.0 ** (DEFECT_BITS - self.equations.bits) * order
        factor = min(
            LONGER,
            (allowed / max(defect, 1e-300)) ** (1 / order),
            (FLOW_ERROR / max(flow, 1e-30)) ** (1 / (LOW + 1)),
            math.log(GROWTH) / max(math.log(growth), 1e-9),
        )
        # where shorter steps do not cost less, the enclosure is as good as the precision allows
        good = factor >= AGAIN or self.failures >= MOST_FAILURES
        self._size = length * (factor if good else max(factor, 0.1) * SHORTER)
        self.failures += not good
        return good

    def shorten(self, why: ArithmeticError) -> None:
        """Halve the length of a step that did not verify.

        Raises ``NotProved``: shorter steps do not help.
        """
        self.failures += 1
        self._size /= 2
        self._why = why if isinstance(why, NotProved) else NotProved("S2", str(why))
        if self.failures > MOST_FAILURES:
            raise self._why from None
