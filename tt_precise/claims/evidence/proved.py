"""Evidence for claims from the committed proofs of golden digits (``golden certify``).

A verdict counts as proved if it is the same at both ends of the proved interval of the number. (A
check accepts a much wider interval, so the verdict is the same in between.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cache

from tt_precise.claims.evidence.run import SceneLike
from tt_precise.claims.verdicts import MOST_DIGITS, Measured, Proof, decade, verdict_of
from tt_precise.golden import proofs
from tt_precise.golden.proofs import Established, Interval
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.values import Check, InputError, Json
from tt_precise.scene.scene import load_scene

Event = dict[str, Interval]


@dataclass(frozen=True)
class Proved:
    """The statements of ``proof`` about a scene; without a proof, ``why``."""

    proof: Established | None
    why: str

    def says(self, settled: bool, theorem: str) -> Proof:
        """For a claim: that ``theorem`` is proved, or that nothing is proved, and why."""
        if settled:
            return Proof(True, f" Proved (rigorous enclosure): {theorem}.")
        return Proof(False, f" Not proved: {self.why or 'the enclosure does not decide it'}.")

    @property
    def g_n_positive(self) -> bool:
        """Whether g_n > 0 at all times from 0 to the horizon, both included."""
        return self.proof is not None and self.proof.contact["g_n_positive"] is True

    @property
    def contact_lost(self) -> Interval | None:
        """The time of the first zero of g_n, a simple zero; None if that is not proved."""
        ball = self.proof.contact.get("lost_at_s") if self.proof else None
        return Interval.around(ball["middle"], ball["radius"]) if ball else None

    @property
    def energy_falls(self) -> bool:
        """Whether E falls throughout: E' = -mu g_n v_A^2 (EQ-05) is negative except at instants.

        An analytic v_A that is not identically zero vanishes only at isolated instants.
        """
        if self.proof is None or not self.g_n_positive or not self.proof.stored.scene.body.mu:
            return False
        times = self.proof.stored.trajectory.column("t")
        speeds = (self.proof.at(name, t) for t in times for name in ("vx", "vy"))
        return any(speed is not None and not speed.low <= 0 <= speed.high for speed in speeds)

    @property
    def for_ever(self) -> dict[str, Json] | None:
        """The statement for all later times (``certify.energy_well``); None if there is none.

        With ``theta_tends_to``, ``limits`` and ``g_n_at_least_mg``.
        """
        forever = self.proof.record.content["forever"] if self.proof else {}
        return forever.get("at_the_end", forever.get("held"))

    @property
    def inverts(self) -> bool:
        """Whether the inverted spin is proved to be the limit of the motion, for t -> infinity."""
        return bool(self.for_ever and self.for_ever["theta_tends_to"] == "pi")

    @property
    def span(self) -> str:
        """In words, the times for which ``g_n_positive`` and ``least_g_n`` hold."""
        if self.proof is None or self.for_ever is not None:
            return "at all times t >= 0"
        return f"at all times from 0 to {Decimal(self.proof.record.until_s):.3g} s"

    @property
    def least_g_n(self) -> str:
        """A proved lower bound of g_n in units of m g, rounded down; "0" if none is proved."""
        bound = self.proof.contact.get("g_n_at_least_mg") if self.proof else None
        if not bound:
            return "0"
        later = self.for_ever
        least = min(Decimal(bound), Decimal(later["g_n_at_least_mg"] if later else bound))
        return f"{least:f}"

    def moment(self, definition: str, which: str) -> Interval | None:
        """``t_init``, ``t_end`` or ``duration`` in s in a definition; None if not proved."""
        if self.proof is None:
            return None
        if which != "duration":
            return self.proof.moment(definition, which)
        begin, end = (self.proof.moment(definition, name) for name in ("t_init", "t_end"))
        return Interval(end.low - begin.high, end.high - begin.low) if begin and end else None

    def events(self, *names: str) -> list[Event] | None:
        """All events with one of these names, in order of time; None if any is undecided."""
        if self.proof is None:
            return None
        happened: list[Event] = []
        for name in names:
            events = self.proof.happened(name)
            if events is None:
                return None
            happened += events
        return sorted(happened, key=lambda event: event["t"])

    def at(self, column: str, t: str) -> Interval | None:
        """A column of the golden trajectory at the sampled time ``t``; None if not proved."""
        return self.proof.at(column, t) if self.proof else None

    def potential_energy(self, t: str) -> Interval | None:
        """E_pot in J at the sampled time ``t``; linear in cos theta."""
        height = self.at("kz", t)
        if self.proof is None or height is None:
            return None
        body = self.proof.stored.scene.body.numbers(Fraction)
        ends = []
        for kz in height:
            state = NewtonState(*(0,) * len(NewtonState._fields))._replace(kz=kz)
            ends.append(QUANTITIES["E_pot"].evaluate(Motion(body, state, None)))
        return Interval(min(ends), max(ends))


@cache
def proofs_of(scene: SceneLike) -> Proved:
    """The statements about ``scene`` that the files of its golden data prove."""
    try:
        return Proved(*proofs.established(load_scene(scene)))
    except InputError as error:  # the note names unusable golden data, like missing ones
        return Proved(None, str(error))


def settles(computed: Check, check: Callable[[Fraction], Check], interval: Interval | None) -> bool:
    """Whether ``check`` gives the verdict ``computed`` at both ends of a proved interval."""
    return interval is not None and all(
        verdict_of(check(end)) == verdict_of(computed) for end in interval
    )


def enclosed(
    scene: SceneLike, check: Callable[[Measured], Check],
    numbers: Mapping[str, tuple[Measured, Interval | None]], what: str,
) -> tuple[dict[str, Check], Proof]:  # fmt: skip
    """Checks of numbers, proved if each has the same verdict at both ends of its interval."""
    checks = {name: check(value) for name, (value, _) in numbers.items()}
    settled = all(settles(checks[name], check, ends) for name, (_, ends) in numbers.items())
    return checks, proofs_of(scene).says(
        settled, f"{what} {digits(e for _, e in numbers.values())}"
    )


def digits(intervals: Iterable[Interval | None]) -> str:
    """The number of proved digits in words, such as "to 41 digits or more"."""
    numbers = []
    for low, high in filter(None, intervals):
        radius, size = (high - low) / 2, min(abs(low), abs(high))
        numbers.append(-decade(radius / size) - 1 if radius and size else MOST_DIGITS)
    return f"to {min(numbers, default=0)} digits or more"


def count(events: Iterable[Event], column: str, low: Fraction, high: Fraction) -> Interval:
    """How many events have a column between two numbers: surely, and possibly."""
    values = [event[column] for event in events if column in event]
    surely = sum(low < value.low and value.high < high for value in values)
    possibly = sum(low <= value.high and value.low <= high for value in values)
    return Interval(Fraction(surely), Fraction(possibly))


# ---- phi_dot around the climb: rad/s, None or 0 where nothing is proved -------------------------


def reversal(scene: SceneLike, turn: str, which: str) -> list[Interval | None]:
    """phi_dot at the turning points before and after ``t_init`` or ``t_end`` (definition A)."""
    known = proofs_of(scene)
    turns, moment = known.events(turn), known.moment("A", which)
    if not turns or moment is None:
        return [None, None]
    before = [turn for turn in turns if turn["t"].high < moment.low]
    after = [turn for turn in turns if turn["t"].low > moment.high]
    if len(before) + len(after) < len(turns) or not (before and after):
        return [None, None]
    return [before[-1].get("phi_dot"), after[0].get("phi_dot")]


def precession(scene: SceneLike) -> list[Interval | None]:
    """phi_dot where L.k = L.z for the last time, and at the maxima before and after t_init (A)."""
    known = proofs_of(scene)
    aligned, moment = known.events("Lk_equals_Lz"), known.moment("B", "t_init")
    there: list[Interval | None] = [None]
    if aligned and moment:
        met = [event for event in aligned if _overlap(event["t"], moment)]
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
    if any(_overlap(zero["t"], Interval(begin.low, end.high)) for zero in zeros):
        return 0
    there, phi_dot = middle[0]["t"], middle[0]["phi_dot"]
    if not begin.high < there.low <= there.high < end.low:
        return 0
    return int(phi_dot.low > 0) - int(phi_dot.high < 0)


def _overlap(a: Interval, b: Interval) -> bool:
    return a.low <= b.high and b.low <= a.high
