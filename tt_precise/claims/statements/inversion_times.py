"""Section 2.1: initiation time, ending time and climbing time of the reference solution."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.proved import digits, proofs_of, settles
from tt_precise.claims.measured import Settled, decimal, fraction_of
from tt_precise.claims.verdicts import Check, Finding, about, readings
from tt_precise.golden.proofs import Interval
from tt_precise.runtime.arithmetic import Scalar

if TYPE_CHECKING:
    from tt_precise.integration import Trajectory

SECTION = "Sec. 2.1"
DEFINITIONS = {"A": "A, signed perigee", "B": "B, algebraic", "C": "C, literal"}
DEFINITION = (
    "A: zero of sign(phi_dot) times the distance from the pole, interpolated between the nearest "
    "approaches to it. B: L.k = L.z before the climb, L.k = -L.z after it. C: the ends of the "
    "interval around the climb in which phi_dot > 0."
)
START, END = "3.2", "7.87"
TOP = "the maximum of theta nearest to pi"


@claim(
    "NUM-04",
    quote="initiation time t_{theta approx 0} approx 3.2 s",
    where=SECTION,
    definition=DEFINITION,
    control={"printed": "3.4"},
)
def initiation_time(printed: str = START, scene: str = "reference") -> Finding:
    """The climb starts at about 3.2 s."""
    times = _in_all_definitions("t_init", scene)
    values = [one.value for one in times.values()]
    spread = decimal(max(values) - min(values), 2)
    return _found(
        printed,
        times,
        _proved("t_init", scene),
        f"The three definitions of the initiation time differ by {spread} s; the printed digit "
        "resolves 0.1 s.",
        scene,
    )


@claim(
    "NUM-05",
    quote="ending time t_{theta approx pi} approx 7.87 s",
    where=SECTION,
    definition=f"{DEFINITION} And {TOP}, where the axis comes nearest to the pole.",
    control={"printed": "7.88"},
)
def ending_time(printed: str = END, scene: str = "reference") -> Finding:
    """The climb ends at about 7.87 s."""
    times = _in_all_definitions("t_end", scene)
    times[TOP] = evidence.settled(_closest_to_the_pole, scene)
    off = min(abs(fraction_of(one) - Fraction(printed)) for one in times.values())
    return _found(
        printed,
        times,
        {**_proved("t_end", scene), TOP: _highest(scene)},
        f"The nearest of them is off by {decimal(off, 2)} s. Section 2.1 itself says 7.86 s in two "
        "other places.",
        scene,
    )


@claim(
    "NUM-07",
    quote="A climbing time is the quantity T_inv=t_{theta approx pi}-t_{theta approx 0}",
    where=SECTION,
    definition=f"T_inv = t_end - t_init; the printed times give {END} - {START}, which has the "
    f"one decimal of {START}. {DEFINITION}",
    control={"printed": "4.4"},
)
def climbing_time(printed: str = "4.7", scene: str = "reference") -> Finding:
    """The climbing time T_inv = t_end - t_init, from the first to the second reversal."""
    return _found(
        printed,
        _in_all_definitions("duration", scene),
        _proved("duration", scene),
        f"The paper prints no number for T_inv; its two times give {END} - {START} = "
        f"{decimal(Fraction(END) - Fraction(START), 3)} s.",
        scene,
    )


def _in_all_definitions(which: str, scene: str) -> dict[str, Settled]:
    def timed(name: str) -> Settled:
        return evidence.settled(lambda run: getattr(getattr(run.inversion, name), which), scene)

    return {reading: timed(name) for name, reading in DEFINITIONS.items()}


def _proved(which: str, scene: str) -> dict[str, Interval | None]:
    known = proofs_of(scene)
    return {reading: known.moment(name, which) for name, reading in DEFINITIONS.items()}


def _found(
    printed: str,
    times: dict[str, Settled],
    intervals: dict[str, Interval | None],
    note: str,
    scene: str,
) -> Finding:
    def check(time: Scalar) -> Check:
        return about(printed, time, "s")

    checks = {reading: check(time) for reading, time in times.items()}
    proved = all(settles(checks[one], check, intervals[one]) for one in checks)
    shown = proofs_of(scene).sentence(proved, f"each of these times {digits(intervals.values())}")
    return readings(checks, note + shown, proved=proved)


def _highest(scene: str) -> Interval | None:
    """The proved time of the maximum of theta that is surely the highest."""
    tops = proofs_of(scene).events("theta_max")
    if not tops:
        return None
    highest = max(tops, key=lambda top: top["theta"])
    others = (top["theta"].high for top in tops if top is not highest)
    return highest["t"] if all(other < highest["theta"].low for other in others) else None


def _closest_to_the_pole(run: Trajectory) -> Scalar:
    tops = run.events[run.events["name"] == "theta_max"]
    return max(zip(tops["theta"], tops["t"], strict=True))[1]
