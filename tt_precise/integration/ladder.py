"""The ladder of arithmetics and tolerances that delivers a number of digits."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from tt_precise.integration.errors import errors_of
from tt_precise.integration.precision import MOST_BITS, is_available
from tt_precise.integration.setup import Setup, refused_in_doubles
from tt_precise.integration.solution import Solution, solve
from tt_precise.runtime.values import InputError, whole_number
from tt_precise.scene.scene import Scene

# Digits by which an estimate must exceed the wanted ones: a reference run that errs by a tenth of
# the run's error is off by half of that.
RESERVE = 0.1
LOSS = 2.0  # Digits of the tolerance that most scenes lose.
WORTH = 0.25  # Digits that a digit of the tolerance must win, or a finer arithmetic is tried.
# A step in mp with 200 bits costs about this many seconds of a core, with its share of the reading:
# 6 to 11 ms were measured on gliding, rolling, elastic and Coulomb scenes. The cost grows with the
# square of the order and with the product of long numbers.
SECONDS_A_STEP, BITS_TIMED, GROWTH = 0.01, 200, 2.5
RUNS = 2  # Propagations: the run and its reference.
MOST_SECONDS = 3600.0
DIGITS_PER_BIT = math.log10(2)
MOST_DIGITS = int(MOST_BITS * DIGITS_PER_BIT)


class Level(NamedTuple):
    """An arithmetic and a tolerance; ``bits`` only for mp, which has its full accuracy."""

    precision: str
    tolerance: float
    bits: int | None = None

    @property
    def digits(self) -> float:
        """Digits of the tolerance, or of the bits in mp."""
        return -math.log10(self.tolerance) if self.tolerance else DIGITS_PER_BIT * (self.bits or 0)


# heyoka's error follows its order, which rises by one at exp(-30) = 9.36e-14
LADDER = (
    Level("double", 1e-10), Level("double", 9.3e-14),
    Level("double-double", 1e-18), Level("double-double", 1e-23), Level("double-double", 1e-28),
    Level("triple-double", 1e-34), Level("triple-double", 1e-40), Level("triple-double", 3e-45),
)  # fmt: skip
# Levels of heyoka's arithmetics alone: for motions in segments and Euler angles.
HEYOKAS = (
    Level("double", 1e-10), Level("double", 9.3e-14), Level("extended", 1e-17),
    Level("quad", 1e-23), Level("quad", 1e-30),
)  # fmt: skip


def integrate_to_digits(
    wanted: Any, scene: Scene, run: Callable[[Level], Solution], *, euler: bool = False,
    contact: str = "unilateral",
) -> Solution:  # fmt: skip
    """Return the solution from the first level that delivers ``wanted`` digits throughout.

    The error estimate of the run decides, for every component at every sample, in every event and
    at the end. The next level adds the digits that are missing. Where a finer tolerance wins
    little, a finer arithmetic comes next, and it ends where that wins nothing. A level that records
    more events wins: the last of them, which the level before has lost in noise, have few digits.

    Raises ``InputError``: the digits are not a whole number in range, cannot be reached, or would
    take too long.
    """
    _require_practical(wanted, scene, euler, contact)
    levels = [level for level in ladder_of(scene, euler) if is_available(level.precision)]
    needed, before, best, most = wanted + LOSS, Level("", 1.0), -math.inf, 0
    while True:
        bits = max(128, math.ceil(needed / DIGITS_PER_BIT))
        level = next((r for r in levels if r.digits >= needed), Level("mp", 0.0, bits))
        found = run(level)
        reached = 0.0 if found.status == "failed" else errors_of(found).digits_throughout
        if reached >= wanted + RESERVE:
            return found
        finer = level.precision != before.precision
        last, recorded = level.precision == "mp", found.event_counts.total()
        worth = RESERVE if finer and not last else WORTH * (level.digits - before.digits)
        if reached < best + worth and (last or recorded <= most):
            if finer or last:
                raise InputError(_missed(wanted, found, reached))
            # a finer tolerance wins little here, but a finer arithmetic may
            levels = [other for other in levels if other.precision != level.precision]
        before, best, most = level, max(reached, best), max(recorded, most)
        # in mp at least as many as the estimate may be off by
        needed = level.digits + max(wanted + RESERVE - reached, LOSS if level.bits else RESERVE)


def ladder_of(scene: Scene, euler: bool = False) -> tuple[Level, ...]:
    """Return the levels below mp for a scene, in vectors or in Euler angles."""
    return HEYOKAS if euler or refused_in_doubles(scene) else LADDER


def _missed(wanted: int, run: Solution, digits: float) -> str:
    name, precision = run.scene.name, run.precision
    if run.status == "failed":
        return (
            f"digits: got {wanted}, but the integration of {name} fails after "
            f"{float(run.t_end):.3g} s; expected a scene that can be integrated"
        )
    return (
        f"digits: got {wanted}, but {name} has {digits:.1f} in {precision.name} with "
        f"{precision.bits} bits, and finer numbers win no more; expected fewer digits, or a "
        "precision in their place"
    )


def seconds_for(
    digits: int, scene: Scene, euler: bool = False, contact: str = "unilateral"
) -> float:
    """Estimated cost of ``digits`` of a scene, in s of a core; 0 if mp is not needed.

    From the steps of a run in double, which takes a thousandth of that: the length of a step
    depends on the motion, not on the digits.

    Raises ``InputError``: the scene cannot be integrated so.
    """
    whole_number(digits, "digits", 1, MOST_DIGITS)
    if digits + LOSS <= ladder_of(scene, euler)[-1].digits:
        return 0.0
    form = "euler" if euler else "newton"
    setup = Setup.of(scene, formulation=form, events=(), record=(), contact=contact)
    bits = (digits + LOSS) / DIGITS_PER_BIT
    return RUNS * solve(scene, setup).steps * SECONDS_A_STEP * (bits / BITS_TIMED) ** GROWTH


def _require_practical(wanted: int, scene: Scene, euler: bool, contact: str) -> None:
    seconds = seconds_for(wanted, scene, euler, contact)
    if seconds <= MOST_SECONDS:
        return
    within_an_hour = int((wanted + LOSS) * (MOST_SECONDS / seconds) ** (1 / GROWTH) - LOSS)
    most = max(within_an_hour, int(ladder_of(scene, euler)[-1].digits - LOSS))
    raise InputError(
        f"digits: got {wanted}, which would take about {seconds / 3600:.0f} h for "
        f"{float(scene.until):g} s of {scene.name}; expected at most {most}, which take an hour or "
        "less, or a shorter time"
    )
