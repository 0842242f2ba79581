"""Section 2.1: the three phases, and the two moments of singular phi_dot between them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

from tt_precise.claims import evidence
from tt_precise.claims.claim import claim
from tt_precise.claims.evidence import SceneLike, proved_climb
from tt_precise.claims.evidence import reference_series as series
from tt_precise.claims.evidence.proved import digits, proofs_of, settles
from tt_precise.claims.measured import decimal, measured_text
from tt_precise.claims.statements.inversion_times import DEFINITION, DEFINITIONS
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    about,
    all_of,
    judged,
    misprint,
    readings,
    statement,
)
from tt_precise.integration import Trajectory
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.scene.scene import load_scene

SECTION = "Sec. 2.1"
AFTER_EQUATION = "Sec. 2.1, after eq. (phi_dot_equ)"
MANY = 10
LARGE = 100  # rad/s
TIMES = 10
ENDS = ("t_init", "t_end")
QUOTIENT = (
    "the quotient q as corrected for the missing factors R I1 and gamma has the same sign of "
    "1 - q as phi_dot"
)


@claim(
    "NUM-06",
    quote="during the climbing phase of TT between 3.2 and 7.86 seconds",
    where=SECTION,
    definition=f"both ends in each definition. {DEFINITION}",
    control={"printed": ("3.2", "7.83")},
)
def climbing_phase(
    printed: tuple[str, str] = ("3.2", "7.86"), scene: SceneLike = "reference"
) -> Finding:
    """The climbing phase lasts from 3.2 to 7.86 s."""
    checks, known, proved = {}, proofs_of(scene), True
    moments = {(name, which): known.moment(name, which) for name in DEFINITIONS for which in ENDS}
    for name, reading in DEFINITIONS.items():
        ends = [evidence.settled(partial(_moment, name, which), scene) for which in ENDS]
        found = [about(one, end) for one, end in zip(printed, ends, strict=True)]
        fits = [one.holds for one in found]
        proved &= all(
            settles(check, partial(about, one), moments[name, which])
            for check, one, which in zip(found, printed, ENDS, strict=True)
        )
        checks[reading] = statement(
            all(fits),
            printed=" to ".join(printed) + " s",
            measured=" to ".join(map(measured_text, ends)) + " s",
        )
    return readings(
        checks,
        "Each printed time counts as right within one unit of its last digit. The same section "
        "gives the ending time as 7.87 s and as 7.86 s."
        + known.sentence(proved, f"each of these times {digits(moments.values())}"),
        proved=proved,
    )


@claim(
    "NUM-08",
    quote="the time required to accelerate phi_dot to about 80 rad/s needed for the climbing phase",
    where=SECTION,
    definition="phi_dot where L.k = L.z for the last time before the climb (initiation time B), "
    "and at the maxima of theta before and after the initiation time A; at the minima of theta "
    "between them phi_dot is singular",
    control={"printed": "60"},
)
def precession_at_initiation(printed: str = "80", scene: SceneLike = "reference") -> Finding:
    """The climb starts when phi_dot has been accelerated to about 80 rad/s."""

    def check(value: Scalar) -> Check:
        return about(printed, value, "rad/s")

    checks = {
        name: check(evidence.settled(value, scene))
        for name, value in (
            ("where L.k = L.z", _precession_where_aligned),
            ("last maximum of theta before", lambda run: _precession_at_top(run, 0)),
            ("first maximum of theta after", lambda run: _precession_at_top(run, 1)),
        )
    }
    tops, climb = evidence.times_of("theta_max", scene), series.climb(scene)
    courses = [
        float(x) for x in tops["phi_dot"][(tops["t"] > climb.begin) & (tops["t"] < climb.end)]
    ]
    rises = sum(b > a for a, b in pairwise(courses))
    intervals = proved_climb.precession(scene)
    proved = all(
        settles(found, check, interval)
        for found, interval in zip(checks.values(), intervals, strict=True)
    )
    return readings(
        checks,
        f"At the maxima of theta in the climb phi_dot goes from {decimal(courses[0], 3)} to "
        f"{decimal(courses[-1], 3)} rad/s, and rises in {rises} of {len(courses) - 1} steps."
        + proofs_of(scene).sentence(proved, f"these three values {digits(intervals)}"),
        proved=proved,
    )


@claim(
    "QUAL-03",
    quote="two moments of singular behaviour ... changes sign from large negative values to large "
    "positive values",
    where="Sec. 2.1; Summary c)",
    definition="phi_dot at the turning point of theta next to the pole before and after the "
    f"initiation and the ending time; large: its size is above {LARGE} rad/s",
    control={"printed": (("-", "+"), ("+", "-"))},
)
def reversals(
    printed: Sequence[tuple[str, str]] = (("-", "+"), ("-", "+")),
    scene: SceneLike = "reference",
) -> Finding:
    """At two moments phi_dot changes from large negative to large positive values."""
    found = [_reversal(scene, "theta_min", 0), _reversal(scene, "theta_max", 1)]
    signs = [tuple("+" if value > 0 else "-" for value in pair) for pair in found]
    large = all(abs(value) > LARGE for pair in found for value in pair)
    peaks = [*proved_climb.reversal(scene, "theta_min", "t_init"),
             *proved_climb.reversal(scene, "theta_max", "t_end")]  # fmt: skip
    proved = large and all(
        peak is not None and all(end * value > 0 and abs(end) > LARGE for end in peak)
        for peak, value in zip(peaks, (value for pair in found for value in pair), strict=True)
    )
    shown = "; ".join(f"from {decimal(a, 3)} to {decimal(b, 3)} rad/s" for a, b in found)

    def says(wanted: Sequence[tuple[str, str]]) -> Check:
        text = "; ".join(f"from {a} to {b}" for a, b in wanted)
        same = [tuple(pair) for pair in wanted] == signs
        return statement(large and same, printed=text, measured=shown)

    return misprint(
        says(printed),
        says((("-", "+"), ("+", "-"))),
        "from large negative to large positive values at the first moment, and from large "
        "positive to large negative values at the second",
        "The heights of these peaks are ill conditioned, their signs are not."
        + proofs_of(scene).sentence(proved, f"the four peaks {digits(peaks)}"),
        proved=proved,
    )


@claim(
    "QUAL-04",
    quote="theta takes locally minimal value close to 0 at t_init and locally maximal close to pi",
    where=SECTION,
    definition="the minimum of theta next to t_init and the maximum next to t_end, definition A; "
    "close: within 0.01 rad; at the same moment: within half a nutation, 0.02 and 0.04 s",
    control={"turns": ("theta_max", "theta_min")},
)
def nearest_to_the_poles(
    turns: tuple[str, str] = ("theta_min", "theta_max"), scene: SceneLike = "reference"
) -> Finding:
    """theta is locally minimal and close to 0 at t_init, maximal and close to pi at t_end."""
    checks = {}
    for name, when, pole, half in (
        (turns[0], "t_init", 0.0, 0.02),
        (turns[1], "t_end", math.pi, 0.04),
    ):
        moment = float(getattr(evidence.trajectory(scene).inversion.A, when))
        events = evidence.times_of(name, scene)
        nearest = min(range(len(events)), key=lambda i: abs(float(events["t"][i]) - moment))
        t, theta = float(events["t"][nearest]), float(events["theta"][nearest])
        checks[when] = statement(
            abs(t - moment) < half and abs(theta - pole) < 0.01,
            printed=f"{name.replace('_', ' ')} close to {'pi' if pole else '0'} at {when}",
            measured=f"{decimal(abs(theta - pole), 3)} rad from the pole at {decimal(t, 6)} s",
        )
    return all_of(
        checks, "How near it comes to the poles is a matter of chance: see the height of phi_dot."
    )


@claim(
    "QUAL-05",
    quote="sudden increase, by orders of magnitude, of oscillation amplitudes",
    where=SECTION,
    definition="half the distance of consecutive extrema of phi_dot (events), the largest within "
    "0.1 s of the moment against the one a second earlier; orders of magnitude: at least 100 times",
    control={"name": "omega_3"},
)
def growth_of_amplitudes(name: str = "phi_dot", scene: SceneLike = "reference") -> Finding:
    """Near both moments the oscillation amplitudes grow suddenly by orders of magnitude."""
    times, values = series.extrema(name, scene)
    swings = [(float(t), abs(b - a) / 2) for t, a, b in zip(times[1:], values, values[1:],
                                                           strict=False)]  # fmt: skip
    checks = {}
    for when, moment in zip(("t_init", "t_end"), series.climb(scene), strict=True):
        near = max((swing for t, swing in swings if abs(t - moment) < 0.1), default=0.0)
        earlier = [swing for t, swing in swings if abs(t - moment + 1) < 0.1]
        before = max(earlier, default=near)
        checks[when] = statement(
            near > 100 * before,
            printed="by orders of magnitude",
            measured=f"{decimal(before, 3)} a second before, {decimal(near, 3)} at {when}",
        )
    return all_of(
        checks,
        "The amplitude grows like the reciprocal of the nearest distance of the axis from the "
        "pole; the largest value depends on how near it happens to come and is ill conditioned.",
    )


@claim(
    "QUAL-17",
    quote="changes sign many times ... the quotient is close to 1",
    where=AFTER_EQUATION,
    definition=f"changes of sign of 1 - q before t_init (A); {QUOTIENT}; close to 1: |1 - q| below "
    "0.05, with the printed quotient (extremes closed in on in the dense output)",
    control={"phase": "climb"},
)
def quotient_before(phase: str = "synchronisation", scene: SceneLike = "reference") -> Finding:
    """Before t_init 1 - q changes sign many times, and q is close to 1."""
    span = {"synchronisation": series.synchronisation, "climb": series.climb}[phase](scene)
    zeros = [t for t in evidence.times_of("phi_dot_zero", scene)["t"] if span.has(float(t))]
    sizes = [abs(series.extreme_of(_printed_bracket(scene), ("omega_3", "kz"), scene,
             largest=largest, span=span)[1]) for largest in (False, True)]  # fmt: skip
    return all_of(
        {
            "sign": statement(
                len(zeros) >= MANY,
                printed="changes sign many times",
                measured=f"{len(zeros)} times",
            ),
            "quotient": statement(
                max(sizes) < 0.05,
                printed="close to 1",
                measured=f"|1 - q| at most {decimal(max(sizes), 3)}",
            ),
        },
        "The changes of sign are the zeros of phi_dot, found as events.",
    )


@claim(
    "QUAL-18",
    quote="at time t_init the term acquires a positive sign",
    where=AFTER_EQUATION,
    definition=f"the last zero of phi_dot before mid-climb, and its sign from there to t_end (A); "
    f"{QUOTIENT}",
    control={"sign": "negative"},
)
def quotient_after(
    sign: str = "positive", printed: str = "3.2", scene: SceneLike = "reference"
) -> Finding:
    """At t_init 1 - q becomes positive, and it stays so during the climb."""
    climb = series.climb(scene)
    last = evidence.settled(lambda run: run.inversion.C.t_init, scene)
    zeros = [t for t in evidence.times_of("phi_dot_zero", scene)["t"] if climb.has(float(t))]
    middle = climb.begin + climb.length / 2
    inside = float(series.columns(["phi_dot"], [middle], scene)["phi_dot"][0])
    at_last, known = about(printed, last, "s"), proofs_of(scene)
    proved = (
        settles(at_last, partial(about, printed), known.moment("C", "t_init"))
        and not zeros
        and proved_climb.sign_of_precession(scene) * inside > 0
    )
    return all_of(
        {
            "at t_init": at_last,
            "during the climb": statement(
                not zeros and (inside > 0) == (sign == "positive"),
                printed=f"stays {sign}",
                measured=f"{'positive' if inside > 0 else 'negative'}, {len(zeros)} changes",
            ),
        },
        "Before the climb the axis passes nearest to the pole "
        f"{decimal(_nearest_pass(scene) - float(last.value), 3)} s after the last change of sign."
        + known.sentence(proved, "its last zero before the climb, and that there is none within"),
        proved=proved,
    )


@claim(
    "QUAL-25",
    quote="three main phases separated by two moments",
    where=SECTION,
    definition="the middle between consecutive turning points of theta: lower before t_init "
    "than at the start, rising from t_init to t_end, within 0.05 rad of pi after t_end "
    "(definition A)",
    control={"scene": "phi-dot-195"},
)
def three_phases(scene: SceneLike = "reference") -> Finding:
    """There are three phases, and theta climbs only after t_init."""
    turns = series.turning_points(scene)
    times, thetas = ([float(x) for x in turns[name]] for name in ("t", "theta"))
    middles = [(t, (a + 2 * b + c) / 4)
               for t, a, b, c in zip(times[1:], thetas, thetas[1:], thetas[2:],
                                     strict=False)]  # fmt: skip
    climb = series.climb(scene)
    before = [middle for t, middle in middles if t < climb.begin]
    during = [middle for t, middle in middles if climb.has(t)]
    after = [middle for t, middle in middles if t > climb.end]
    lowest = min(middles[: len(middles) // 2 + 1], key=lambda pair: pair[1])
    furthest = max((math.pi - middle for middle in after), default=math.inf)
    return all_of(
        {
            "synchronisation": statement(
                len(before) >= MANY and before[-1] < before[0],
                printed="theta does not climb before t_init",
                measured=f"{len(before)} turning points"
                + (f", the middle falls from {decimal(before[0], 3)} to {decimal(before[-1], 3)} "
                   "rad" if before else ""),
            ),
            "climb": statement(
                all(b > a for a, b in pairwise(during)),
                printed="theta climbs from t_init to t_end",
                measured=f"the middle rises from {decimal(during[0], 3)} to "
                f"{decimal(during[-1], 4)} rad without a fall",
            ),
            "stabilisation": statement(
                furthest < 0.05,
                printed="theta near pi after t_end",
                measured=f"at most {decimal(furthest, 2)} rad away" if after else "not seen",
            ),
        },
        f"The middle is lowest at {decimal(lowest[0], 6)} s, where the axis passes the pole.",
    )  # fmt: skip


@claim(
    "QUAL-26",
    quote="from large negative values to large positive values of phi_dot",
    where="Summary c)",
    definition="the least phi_dot before the initiation time A (extremum event), against the "
    f"largest phi_dot at the maxima of theta before it; large: {TIMES} times as large",
    control={"phase": "climb"},
)
def large_negative_values(
    phase: str = "synchronisation", scene: SceneLike = "reference"
) -> Finding:
    """Before t_init phi_dot reaches large negative values."""
    span = {"synchronisation": series.synchronisation, "climb": series.climb}[phase](scene)
    lowest = series.extreme("phi_dot", scene, largest=False, span=span)
    tops = series.turning_points(scene)
    tops = tops[(tops["name"] == "theta_max") & (tops["t"] < span.end) & (tops["t"] > span.begin)]
    usual = float(abs(tops["phi_dot"]).max())
    return judged(
        statement(
            float(lowest.value) < -TIMES * usual,
            printed="large negative values",
            measured=f"{measured_text(lowest)} rad/s, against {decimal(usual, 3)} rad/s at the "
            "maxima of theta",
        ),
        "How deep it goes hangs on how near the axis happens to pass the pole, and with it on the "
        "last digits of the parameters: no value to aim at.",
    )


def _moment(definition: str, which: str, run: Trajectory) -> Scalar:
    return getattr(getattr(run.inversion, definition), which)


def _precession_where_aligned(run: Trajectory) -> Scalar:
    return run.at(run.inversion.B.t_init).phi_dot


def _precession_at_top(run: Trajectory, place: int) -> Scalar:
    events, moment = run.events, run.inversion.A.t_init
    tops = events[events["name"] == "theta_max"]
    before = tops["phi_dot"][tops["t"] < moment]
    return before.iloc[-1] if place == 0 else tops["phi_dot"][tops["t"] > moment].iloc[0]


def _reversal(scene: SceneLike, turn: str, which: int) -> tuple[float, float]:
    """phi_dot at the turning points before and after the initiation or the ending time."""
    moment = series.climb(scene)[which]
    events = evidence.times_of(turn, scene)
    before, after = (events["phi_dot"][mask] for mask in (events["t"] < moment,
                                                         events["t"] > moment))  # fmt: skip
    return float(before.iloc[-1]), float(after.iloc[0])


def _nearest_pass(scene: SceneLike) -> float:
    """When theta is least, in s."""
    events = evidence.times_of("theta_min", scene)
    return float(events["t"][events["theta"].astype(float).idxmin()])


def _printed_bracket(scene: SceneLike) -> Callable[[dict[str, Array]], Array]:
    """1 - omega_3 (alpha - cos theta)/(the same at t = 0), as in eq (phi_dot_equ)."""
    start = load_scene(scene)
    alpha = float(start.body.alpha)
    first = series.columns(["omega_3", "kz"], [0.0], scene)
    scale = float((first["omega_3"] * (alpha - first["kz"]))[0])
    return lambda columns: 1 - columns["omega_3"] * (alpha - columns["kz"]) / scale
