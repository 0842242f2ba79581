"""Enclosures for the claims from the committed proofs of golden digits (``golden certify``)."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from functools import cache

from tt_precise.golden import proofs
from tt_precise.golden.proofs import Established, Interval
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene, load_scene

Event = dict[str, Interval]
SceneLike = str | Scene


@cache
def proofs_of(scene: SceneLike) -> Established:
    """The statements about ``scene`` that the files of its golden data prove."""
    try:
        return proofs.established(load_scene(scene))
    except InputError as error:  # the note names unusable golden data, like missing ones
        return Established(why=str(error))


def count(events: Iterable[Event], column: str, low: Fraction, high: Fraction) -> Interval:
    """Count events with a column between two numbers: surely, and possibly."""
    values = [event[column] for event in events if column in event]
    surely = sum(low < value.low and value.high < high for value in values)
    possibly = sum(low <= value.high and value.low <= high for value in values)
    return Interval(Fraction(surely), Fraction(possibly))


# ---- phi_dot around the climb: rad/s, None or 0 where nothing is proved -------------------------


def reversal(scene: SceneLike, extremum: str, which: str) -> list[Interval | None]:
    """phi_dot at the turning points before and after ``t_init`` or ``t_end`` (definition A)."""
    statements = proofs_of(scene)
    turns, moment = statements.events(extremum), statements.moment("A", which)
    if not turns or moment is None:
        return [None, None]
    before = [event for event in turns if event["t"].high < moment.low]
    after = [event for event in turns if event["t"].low > moment.high]
    if len(before) + len(after) < len(turns) or not (before and after):
        return [None, None]
    return [before[-1].get("phi_dot"), after[0].get("phi_dot")]


def precession(scene: SceneLike) -> list[Interval | None]:
    """phi_dot where L.k = L.z for the last time, and at the maxima before and after t_init (A)."""
    statements = proofs_of(scene)
    aligned, moment = statements.events("Lk_equals_Lz"), statements.moment("B", "t_init")
    there: list[Interval | None] = [None]
    if aligned and moment:
        met = [event for event in aligned if _overlap(event["t"], moment)]
        there = [met[0].get("phi_dot")] if len(met) == 1 else [None]
    return there + reversal(scene, "theta_max", "t_init")


def sign_of_precession(scene: SceneLike) -> int:
    """The sign of phi_dot throughout the climb (definition A) where it has no zero; else 0.

    It is the sign at the equator then.
    """
    statements = proofs_of(scene)
    zeros, middle = statements.events("phi_dot_zero"), statements.events("equator")
    begin, end = (statements.moment("A", which) for which in ("t_init", "t_end"))
    if zeros is None or not middle or begin is None or end is None:
        return 0
    if any(_overlap(zero["t"], Interval(begin.low, end.high)) for zero in zeros):
        return 0
    there, phi_dot = middle[0]["t"], middle[0]["phi_dot"]
    if not begin.high < there.low <= there.high < end.low:
        return 0
    return int(phi_dot.low > 0) - int(phi_dot.high < 0)


def _overlap(a: Interval, b: Interval) -> bool:
    return a.low <= b.high and b.low <= a.high
