"""The choice of an arithmetic and a tolerance that deliver a number of digits."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from tt_precise.integration.errors import errors_of
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.integration.solution import Solution
from tt_precise.runtime.values import InputError, whole_number
from tt_precise.scene.scene import Scene

# Digits by which an estimate must exceed the requested ones: a reference run that errs by a tenth
# of the run's error is off by half of that.
RESERVE = 0.1
LOSS = 2.0  # Digits of the tolerance that most scenes lose.
MOST_DIGITS = 300  # Errors are doubles, of which the smallest is 1e-308.
FEWEST_BITS_OF_MP = 128


class Level(NamedTuple):
    """An arithmetic and a tolerance; ``bits`` only for mp, which has its full accuracy."""

    precision: str
    tolerance: float
    bits: int | None = None

    @property
    def digits(self) -> float:
        """Digits of the tolerance, or of the bits in mp."""
        return -math.log10(self.tolerance) if self.tolerance else math.log10(2) * (self.bits or 0)


# heyoka's error follows its order, which rises by one at exp(-30) = 9.36e-14
LADDER = (
    Level("double", 1e-10), Level("double", 9.3e-14),
    Level("double-double", 1e-18), Level("double-double", 1e-23), Level("double-double", 1e-28),
    Level("triple-double", 1e-34), Level("triple-double", 1e-40), Level("triple-double", 3e-45),
)  # fmt: skip


def integrate_to_digits(digits: Any, scene: Scene, run: Callable[[Level], Solution]) -> Solution:
    """Return the solution from the first level that delivers ``digits`` throughout.

    The error estimate of the run decides, for every component at every sample, in every event and
    at the end. The next level adds the digits that are missing.

    Raises ``InputError``: the digits are not a whole number in range, or two levels of mp in a row
    gain nothing.
    """
    whole_number(digits, "digits", 1, MOST_DIGITS)
    refused, needed, best = refused_in_doubles(scene), digits + LOSS, -math.inf
    levels = [level for level in LADDER if level.precision == "double" or not refused]
    while True:
        bits = max(FEWEST_BITS_OF_MP, math.ceil(needed / math.log10(2)))
        level = next((x for x in levels if x.digits >= needed), Level("mp", 0.0, bits))
        solution = run(level)
        failed = solution.status == "failed"
        reached = 0.0 if failed else errors_of(solution).digits_throughout
        if reached >= digits + RESERVE:
            return solution
        if level.bits and reached < best + RESERVE:
            raise InputError(
                f"digits: got {digits}, but {scene.name} has {reached:.1f} in mp with "
                f"{level.bits} bits ({solution.status} at {float(solution.t_end):.3g} s), and "
                "finer numbers gain no more; expected fewer digits, or a precision in their place"
            )
        best = max(best, reached)
        needed = level.digits + max(digits + RESERVE - reached, LOSS if level.bits else RESERVE)
