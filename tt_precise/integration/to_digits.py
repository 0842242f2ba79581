"""The cheapest way to a requested number of correct digits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from tt_precise.integration.cost_table import Setting, cost_with_estimate, settings, wide
from tt_precise.integration.precision import NAMES, is_available
from tt_precise.integration.trajectory import Trajectory
from tt_precise.runtime.errors import InputError
from tt_precise.scene.scene import Scene

MOST_DIGITS = 3_000
SPARE = 0.1  # digits; a reference that errs by a tenth of the run's error is off by half of this
# What hard scenes lose beyond the median one (most that invert lose two or three digits more), and
# what is uncertain of a scene's own loss once a run has shown it. A decade of tolerance costs 5 %,
# a second run a whole one: with 1.4 nine digits of the reference scene took six times as long.
SPREAD, KNOWN_SPREAD = 2.4, 0.3
# What many scenes have beyond the median one: a setting that lacks no more by the table is tried
# where it costs this many times less than the first that suffices there, and twice as many times
# for each digit that it lacks. About half of the scenes have what the table says.
HOPE, WORTH_A_TRY = 1.5, 2.0
# Digits a scene has more for each decade that it is shorter than the table's, in units of time.
LONG, GAIN, MOST_GAIN = 177.0, 3.0, 4.0
WIDENINGS = 5  # tries beyond the table, each time with what the last estimate missed


def integrate_to_digits(
    wanted: int,
    formulation: str | None,
    run: Callable[[Setting], Trajectory],
    gain: float = 0.0,
    precisions: Iterable[str] = NAMES,
) -> Trajectory:
    """What ``run`` makes of the cheapest setting that leaves ``wanted`` digits all along.

    By the error estimate of that very run, in every entry at every sample. The settings are those
    of the measured table, of these ``precisions``, and of one formulation if it is given. What a
    scene loses beyond the median one is known after its first run, and the next setting is chosen
    with that; before, it is expected to have ``gain`` digits more than the table says.

    Raises
    ------
    InputError
        The digits are no whole number in range, or cannot be reached.
    """
    whole = isinstance(wanted, int) and not isinstance(wanted, bool)
    if not whole or not 1 <= wanted <= MOST_DIGITS:
        raise InputError(f"digits: got {wanted}, expected a whole number from 1 to {MOST_DIGITS}")
    available = frozenset(filter(is_available, precisions))
    every = settings(formulation, available)
    expected = wanted + SPARE - gain
    rest = [one for one in every if one.digits >= expected]
    tries = _hopeful(every, rest[0], expected) if rest else []
    loss: float | None = None
    widened, spread = 0, SPREAD
    while widened < WIDENINGS:
        needed = expected if loss is None else wanted + SPARE + loss
        # what a scene loses to truncation says nothing of what it loses to rounding
        rest = [one for one in rest if one.digits >= (needed if one.tolerance else expected)]
        if tries:
            setting = tries.pop()
        else:
            widened += not rest
            setting = (
                _first(rest, needed + spread)
                if rest
                else wide(needed + spread + widened - 1, formulation, available)
            )
            rest = rest[rest.index(setting) + 1 :] if rest else rest
        trajectory, spread = run(setting), KNOWN_SPREAD
        if trajectory.status == "failed":
            continue
        if trajectory.digits_throughout >= wanted + SPARE:
            return trajectory
        lost = setting.digits - trajectory.digits_throughout
        loss = lost if loss is None else max(loss, lost)
    if trajectory.status == "failed":
        raise InputError(
            f"digits: got {wanted}, but the integration of {trajectory.scene.name} fails after "
            f"{float(trajectory.t_end):.3g} s; expected a scene that can be integrated"
        )
    raise InputError(
        f"digits: got {wanted}, but {trajectory.precision.name} with "
        f"{trajectory.precision.bits} bits reaches {trajectory.digits_throughout:.1f}; "
        "expected fewer digits, or give precision mp and bits"
    )


def expected_gain(scene: Scene) -> float:
    """Digits that a scene has beyond what the table says because it is shorter than its scenes.

    Seeded random scenes of 0.3 s have four digits more than golden ones of 8 s.
    """
    units = float(scene.until) / math.sqrt(float(scene.body.R / scene.body.g))
    return min(MOST_GAIN, GAIN * math.log10(LONG / units)) if 0 < units < LONG else 0.0


def _hopeful(every: Sequence[Setting], enough: Setting, digits: float) -> list[Setting]:
    """The finest of the much cheaper settings that nearly suffice by the table."""
    most = cost_with_estimate(enough)
    cheap = [
        one
        for one in every
        if one.tolerance and digits - HOPE <= one.digits < digits
        if WORTH_A_TRY * 2 ** (digits - one.digits) * cost_with_estimate(one) <= most
    ]
    return cheap[-1:]


def _first(rest: Sequence[Setting], digits: float) -> Setting:
    """The cheapest setting with ``digits``, or the finest that costs about what the cheapest does.

    That is one of the same arithmetic and form, with a tolerance.
    """
    kind = rest[0].formulation, rest[0].precision
    alike = [one for one in rest if (one.formulation, one.precision) == kind and one.tolerance]
    if not rest[0].tolerance or not alike:
        return rest[0]
    return next((one for one in alike if one.digits >= digits), alike[-1])
