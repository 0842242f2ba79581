"""The cheapest way to a requested number of correct digits."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from tt_precise.errors import InputError
from tt_precise.integrate.cost_table import Setting, settings, wide
from tt_precise.integrate.precision import NAMES, is_available
from tt_precise.integrate.trajectory import Trajectory

MOST_DIGITS = 3_000
SPARE = 0.1  # digits; a reference that errs by a tenth of the run's error is off by half of this
# What nearly all scenes lose at most beyond the median one, and what is uncertain of a scene's own
# loss once a run has shown it. A decade of tolerance costs 5 %, a second run costs a whole one.
SPREAD, KNOWN_SPREAD = 1.5, 0.3
WIDENINGS = 4  # times that the bits of mp are raised, each time by what the last estimate missed


def integrate_to_digits(
    wanted: int, formulation: str | None, run: Callable[[Setting], Trajectory]
) -> Trajectory:
    """What ``run`` makes of the cheapest setting that leaves ``wanted`` digits all along.

    By the error estimate of that very run, in every entry at every sample. The settings are those
    of the measured table, of one formulation if it is given. What a scene loses beyond the median
    one is known after its first run, and the next setting is chosen with that.

    Raises
    ------
    InputError
        The digits are no whole number in range, or cannot be reached.
    """
    whole = isinstance(wanted, int) and not isinstance(wanted, bool)
    if not whole or not 1 <= wanted <= MOST_DIGITS:
        raise InputError(f"digits: got {wanted}, expected a whole number from 1 to {MOST_DIGITS}")
    loss, widened, spread = 0.0, 0, SPREAD
    rest = settings(formulation, frozenset(filter(is_available, NAMES)))
    while widened < WIDENINGS:
        needed = wanted + SPARE + loss
        # what a scene loses to truncation says nothing of what it loses to rounding
        rest = [one for one in rest if one.digits >= (needed if one.tolerance else wanted + SPARE)]
        widened += not rest
        setting = _first(rest, needed + spread) if rest else wide(needed + widened - 1, formulation)
        rest = rest[rest.index(setting) + 1 :] if rest else rest
        spread = KNOWN_SPREAD
        trajectory = run(setting)
        if trajectory.status == "failed":
            continue
        if trajectory.digits_throughout >= wanted + SPARE:
            return trajectory
        loss = max(loss, setting.digits - trajectory.digits_throughout)
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


def _first(rest: Sequence[Setting], digits: float) -> Setting:
    """The cheapest setting with ``digits``, or the finest that costs about what the cheapest does.

    That is one of the same arithmetic and form, with a tolerance.
    """
    kind = rest[0].formulation, rest[0].precision
    alike = [one for one in rest if (one.formulation, one.precision) == kind and one.tolerance]
    if not rest[0].tolerance or not alike:
        return rest[0]
    return next((one for one in alike if one.digits >= digits), alike[-1])
