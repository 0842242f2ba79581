"""phi_dot around the climb, enclosed: rad/s, None or 0 where nothing is proved."""

from __future__ import annotations

from tt_precise.claims.evidence import SceneLike
from tt_precise.claims.evidence.proved import Event, proofs_of
from tt_precise.golden.proofs import Interval


def reversal(scene: SceneLike, turn: str, which: str) -> list[Interval | None]:
    """phi_dot at the turning points before and after ``t_init`` or ``t_end`` (definition A)."""
    known = proofs_of(scene)
    turns, moment = known.events(turn), known.moment("A", which)
    if not turns or moment is None:
        return [None, None]
    before, after = _parted(turns, moment)
    if len(before) + len(after) < len(turns) or not (before and after):
        return [None, None]
    return [before[-1].get("phi_dot"), after[0].get("phi_dot")]


def precession(scene: SceneLike) -> list[Interval | None]:
    """phi_dot where L.k = L.z for the last time, and at the maxima before and after t_init (A)."""
    known = proofs_of(scene)
    aligned, moment = known.events("Lk_equals_Lz"), known.moment("B", "t_init")
    there: list[Interval | None] = [None]
    if aligned and moment:
        met = [event for event in aligned if _meet(event["t"], moment)]
        there = [met[0].get("phi_dot")] if len(met) == 1 else [None]
    return there + reversal(scene, "theta_max", "t_init")


def sign_of_precession(scene: SceneLike) -> int:
    """The sign of phi_dot throughout the climb (definition A) where it has no zero; else 0.

    It is the sign at the equator then.
    """
    known = proofs_of(scene)
    zeros, middle = known.events("phi_dot_zero"), known.events("equator")
    begin, end = (known.moment("A", which) for which in ("t_init", "t_end"))
    if zeros is None or not middle or begin is None or end is None:
        return 0
    if any(_meet(zero["t"], Interval(begin.low, end.high)) for zero in zeros):
        return 0
    there, phi_dot = middle[0]["t"], middle[0]["phi_dot"]
    if not begin.high < there.low <= there.high < end.low:
        return 0
    return int(phi_dot.low > 0) - int(phi_dot.high < 0)


def _parted(events: list[Event], moment: Interval) -> tuple[list[Event], list[Event]]:
    """The events surely before and surely after a moment."""
    return (
        [event for event in events if event["t"].high < moment.low],
        [event for event in events if event["t"].low > moment.high],
    )


def _meet(one: Interval, other: Interval) -> bool:
    return one.low <= other.high and other.low <= one.high
