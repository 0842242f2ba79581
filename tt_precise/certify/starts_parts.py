"""A segment of starts in parts: what is proved of each is proved of all of them.

What bends a set on its way grows with the square of its width, so that parts reach where the whole
does not. They are independent of each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

from tt_precise.certify.starts import BITS, UNDECIDED, Box, Fate, outcome
from tt_precise.errors import InputError
from tt_precise.progress import Progress, silent
from tt_precise.scene import Inclination
from tt_precise.workers import Call, Failure, Pool

MOST_PARTS = 10_000


def parts_of(box: Box, count: int) -> Iterator[Box]:
    """A box in one entry of the start as ``count`` boxes side by side, which meet."""
    if len(box.reach) != 1 or not 1 <= count <= MOST_PARTS:
        raise InputError(
            f"parts: got {count} of a box in {', '.join(box.reach)}, expected 1 to {MOST_PARTS} of "
            "a box in one entry of the start"
        )
    ((name, reach),) = box.reach.items()
    start = box.scene.start
    for i in range(count):
        away = reach * Fraction(2 * i + 1 - count, count)
        if name == "theta":
            theta = Inclination(start.theta.offset + away, start.theta.from_pi)
            moved = replace(start, theta=theta)
        else:
            moved = replace(start, **{name: getattr(start, name) + away})
        scene = replace(box.scene, start=moved)
        yield Box(scene, {name: reach / count})


def outcome_in_parts(
    box: Box, count: int, events: Sequence[str], pool: Pool, progress: Progress = silent
) -> Fate:
    """What becomes of all starts in a box, if it is the same in all parts.

    Raises
    ------
    InputError
        The box is one in several entries, or the number is none.
    """
    calls = [Call(i, (part, tuple(events), BITS)) for i, part in enumerate(parts_of(box, count))]
    found: dict[int, Fate] = {}
    for call, result in pool.perform(outcome, calls, progress):
        if isinstance(result, Failure):
            raise result.error
        found[call.key] = result
    return together(box, [found[i] for i in range(count)])


def together(box: Box, fates: Sequence[Fate]) -> Fate:
    """One fate of the whole box, from those of its parts."""
    worst = next((one for one in fates if one.verdict == UNDECIDED), fates[0])
    if any(one.verdict != worst.verdict for one in fates) and worst.verdict != UNDECIDED:
        worst = replace(worst, verdict=UNDECIDED, reason="parts have different fates")
    forces = [one.least_g_n for one in fates if one.least_g_n is not None]
    always = set.intersection(*(set(one.crossings) for one in fates))
    crossings = {
        name: (
            min(one.crossings[name][0] for one in fates),
            max(one.crossings[name][1] for one in fates),
        )
        for name in sorted(always)
    }
    return replace(
        worst,
        box=box,
        since_s=max(one.since_s for one in fates),
        least_g_n=min(forces) if len(forces) == len(fates) else None,
        crossings=crossings,
        steps=sum(one.steps for one in fates),
        parts=len(fates),
    )
