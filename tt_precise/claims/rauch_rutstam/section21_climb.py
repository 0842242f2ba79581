"""Section 2.1: the times of the reference solution's climb, and the oscillation of theta."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise

import numpy
import pandas
from scipy.optimize import least_squares

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import motions
from tt_precise.claims.evidence import run as runs
from tt_precise.claims.evidence.run import DEFINITIONS, MANY, REFERENCE, Run, Span, rising, variant
from tt_precise.claims.part import Part, Value, about, decimal, statement, statements
from tt_precise.claims.verdicts import Grounds
from tt_precise.golden.proofs import Interval
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.inversion import NEEDED
from tt_precise.mechanics.euler import EulerState
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.scene import Scene

claim = claims_of("2.1")
DEFINITION = (
    "A: zero of sign(phi_dot) times the distance from the pole, interpolated between the nearest "
    "approaches to it. B: L.k = L.z before the climb, L.k = -L.z after it. C: the ends of the "
    "interval around the climb in which phi_dot > 0."
)
START, END = "3.2", "7.87"
TOP = "the maximum of theta nearest to pi"
LARGE = 100  # Size of phi_dot in rad/s that counts as large.
ENDS = ("t_init", "t_end")
BAND = (
    "the band at a turning point of theta: the distance from it to the straight line between the "
    "turning points before and after it"
)
ILL_CONDITIONED = "The distance from the pole is ill conditioned, and so is the height of phi_dot."
EARLY = 20  # First turning points, over which the restarted top must climb.
TWICE_UP, UP_AND_DOWN = (("-", "+"), ("-", "+")), (("-", "+"), ("+", "-"))
SIGNS = {"-": "negative", "+": "positive"}
SINGULAR = 200  # Size of phi_dot in rad/s that counts as singular: above omega_3(0).
SCALES = {
    "theta": "0.1", "omega_3": "155", "phi_dot": "200", "theta_dot": "15", "nu_x": "0.3",
    "nu_y": "0.8",
}  # fmt: skip
# Horizon in s; 1 % of the range of phi_dot downwards delays the end to 9.2 s.
PERTURBED_UNTIL = "10"


@claim("NUM-04", rule="interpretations", control="refuted", printed="3.4")
def initiation_time(printed: str = START, run: Run = REFERENCE) -> Grounds:
    """The climb starts at about 3.2 s.

    Sec. 2.1: "the initiation time t_{theta≈0}≈3.2 s"
    Definition: {DEFINITION}
    Note: The three definitions of the initiation time differ by {spread:2} s; the printed digit
    resolves a tenth of one.
    """
    times = _in_all_definitions("t_init", run)
    values = [time.value for time in times.values()]
    parts = {name: about(printed, time, "s") for name, time in times.items()}
    return parts, {"spread": max(values) - min(values)}


@claim("NUM-05", rule="interpretations", control="ambiguous", printed="7.88")
def ending_time(printed: str = END, run: Run = REFERENCE) -> Grounds:
    """The climb ends at about 7.87 s.

    Sec. 2.1: "the ending time t_{theta≈pi}≈7.87 s"
    Definition: {DEFINITION} Also: {TOP}, where the axis comes nearest to the pole
    Note: The nearest of these times is off by {off:2} s. Section 2.1 says 7.86 s in two other
    places (NUM-06, QUAL-24).
    """
    times = _in_all_definitions("t_end", run)
    highest = run.confirm(
        lambda run: runs.rows_of(run, "theta_max").sort_values("theta")["t"].iloc[-1]
    )
    times[TOP] = highest.within(_highest(run))
    off = min(abs(part.fraction_of(time) - Fraction(printed)) for time in times.values())
    return {name: about(printed, time, "s") for name, time in times.items()}, {"off": off}


@claim("NUM-07")
def climbing_time(run: Run = REFERENCE) -> Grounds:
    """The climbing time is T_inv = t_end - t_init.

    Sec. 2.1: "A climbing time is the quantity T_inv=t_{theta≈pi}-t_{theta≈0} from the first
    definite change of sign of phi_dot(t) at theta(t)≈0 to the second change of sign"
    Definition: {DEFINITION}
    Note: A definition: the paper prints no number for T_inv. Its two times, {END} s and {START} s,
    are NUM-05 and NUM-04.
    """
    times = _in_all_definitions("duration", run).items()
    shown = ", ".join(f"{decimal(time, 5)} s ({meaning})" for meaning, time in times)
    return part.untestable("T_inv = t_end - t_init", shown)


def _in_all_definitions(which: str, run: Run) -> dict[str, Value]:
    return {meaning: run.moment(name, which) for name, meaning in DEFINITIONS.items()}


def _highest(run: Run) -> Interval | None:
    """The proved time of the maximum of theta that is surely the highest."""
    tops = run.proofs.events("theta_max")
    if not tops:
        return None
    highest = max(tops, key=lambda top: top["theta"])
    others = (top["theta"].high for top in tops if top is not highest)
    return highest["t"] if all(other < highest["theta"].low for other in others) else None


@claim(
    "NUM-06", rule="interpretations", finding="NUM-05", control="ambiguous", printed=("3.2", "7.83")
)
def climbing_phase(printed: tuple[str, str] = ("3.2", "7.86"), run: Run = REFERENCE) -> Grounds:
    """The climbing phase lasts from 3.2 to 7.86 s.

    Sec. 2.1: "During the climbing phase of TT between 3.2 and 7.86 seconds"
    Definition: both ends in each definition. {DEFINITION}
    Note: Each printed time counts as right within one unit of its last digit. The same section
    gives the ending time as 7.87 s and as 7.86 s.
    """
    parts = {}
    for name, meaning in DEFINITIONS.items():
        ends = [about(text, run.moment(name, end)) for text, end in zip(printed, ENDS, strict=True)]
        shown = f"{' to '.join(end.measured for end in ends)} s"
        holds, sure = (all(getattr(end, key) for end in ends) for key in ("holds", "proved"))
        parts[meaning] = statement(holds, f"{' to '.join(printed)} s", shown, proved=sure)
    return parts


@claim("NUM-08", rule="interpretations", control="refuted", printed="60")
def precession_at_initiation(printed: str = "80", run: Run = REFERENCE) -> Grounds:
    """The climb starts when phi_dot has been accelerated to about 80 rad/s.

    Sec. 2.1: "the time required to accelerate the angular velocity phi_dot to about 80 rad/s needed
    for the climbing phase to start"
    Definition: phi_dot where L.k = L.z for the last time before the climb (initiation time B), and
    at the maxima of theta before and after the initiation time A; at the minima of theta between
    them phi_dot is singular
    Note: At the maxima of theta in the climb phi_dot goes from {first:3} to {last:3} rad/s, and
    rises in {rises} of {steps} steps.
    """

    def at_top(which: int, run: Trajectory) -> Scalar:
        return _around(runs.rows_of(run, "theta_max"), runs.climb_of(run).A.t_init)[which]

    values: dict[str, Callable[[Trajectory], Scalar]] = {
        "where L.k = L.z": lambda run: run.at(runs.climb_of(run).B.t_init).phi_dot,
        "last maximum of theta before": partial(at_top, 0),
        "first maximum of theta after": partial(at_top, 1),
    }
    pairs = zip(values.items(), runs.precession(run.scene), strict=True)
    parts = {
        name: about(printed, run.confirm(value).within(interval), "rad/s")
        for (name, value), interval in pairs
    }
    tops = run.events("theta_max")
    course = [float(x) for x in tops["phi_dot"][tops["t"].map(run.climb.has)]]
    rises = sum(b > a for a, b in pairwise(course))
    numbers = {"first": course[0], "last": course[-1], "rises": rises, "steps": len(course) - 1}
    return parts, numbers


@claim("QUAL-03", rule="misprint", control="reproduced", printed=UP_AND_DOWN)
def reversals(printed: Sequence[tuple[str, str]] = TWICE_UP, run: Run = REFERENCE) -> Grounds:
    """At two moments phi_dot changes from large negative to large positive values.

    Sec. 2.1: "two moments ... of singular behaviour of phi_dot(t) when this angular velocity
    changes sign from large negative values to large positive values"
    Definition: phi_dot at the turning point of theta next to the pole before and after the
    initiation and the ending time; large: its size is above {LARGE} rad/s
    Note: The heights of these peaks are ill conditioned, their signs are not. For the first moment
    alone, of which Summary c) speaks, the sentence is right (QUAL-26).
    """
    ends = list(zip(("theta_min", "theta_max"), ENDS, run.climb, strict=True))
    jumps = [list(map(float, _around(run.events(each), moment))) for each, _, moment in ends]
    signs = tuple(("-+"[a > 0], "-+"[b > 0]) for a, b in jumps)
    values = [value for jump in jumps for value in jump]
    large = all(abs(value) > LARGE for value in values)
    peaks = [peak for each, which, _ in ends for peak in runs.reversal(run.scene, each, which)]
    sure = large and all(
        peak is not None and all(end * value > 0 and abs(end) > LARGE for end in peak)
        for peak, value in zip(peaks, values, strict=True)
    )
    shown = "; ".join(f"from {decimal(a, 3)} to {decimal(b, 3)} rad/s" for a, b in jumps)

    def compare(claimed: Sequence[tuple[str, str]]) -> Part:
        texts = (f"from large {SIGNS[a]} to large {SIGNS[b]} values" for a, b in claimed)
        text = " at the first moment, ".join(texts) + " at the second"
        return statement(large and claimed == signs, text, shown, proved=sure)

    return part.misprint(compare, printed, UP_AND_DOWN)


@claim("QUAL-04", control="refuted", extremum="theta_max")
def lowest_at_initiation(extremum: str = "theta_min", run: Run = REFERENCE) -> Grounds:
    """theta is locally minimal and close to 0 at t_init.

    Sec. 2.1: "the angle theta(t) takes correspondingly locally minimal value close to 0 at
    t_{theta≈0}"
    Definition: the minimum of theta next to t_init, definition A; close: within 0.001 rad; at the
    same moment: within half a nutation, 0.02 s
    Note: {ILL_CONDITIONED}
    """
    return _nearest_to_a_pole(extremum, "t_init", 0.0, 0.02, run)


@claim("QUAL-33", control="refuted", extremum="theta_min")
def highest_at_ending(extremum: str = "theta_max", run: Run = REFERENCE) -> Grounds:
    """theta is locally maximal and close to pi at t_end.

    Sec. 2.1: "then locally maximal value close to pi at t_{theta≈pi}"
    Definition: the maximum of theta next to t_end, definition A; close: within 0.001 rad; at the
    same moment: within half a nutation, 0.04 s
    Note: {ILL_CONDITIONED}
    """
    return _nearest_to_a_pole(extremum, "t_end", math.pi, 0.04, run)


def _nearest_to_a_pole(extremum: str, which: str, pole: float, half: float, run: Run) -> Part:
    """Test for a turning point of theta close to a pole, ``half`` s around a time of the climb."""
    moment = float(getattr(run.inversion.A, which))
    events = run.events(extremum)[["t", "theta"]].astype(float).to_numpy()
    t, theta = min(events, key=lambda event: abs(event[0] - moment))
    holds = abs(t - moment) < half and abs(theta - pole) < 0.001
    words = f"{extremum.replace('_', ' ')} close to {'pi' if pole else '0'} at {which}"
    shown = f"{decimal(abs(theta - pole), 3)} rad from the pole at {decimal(t, 6)} s"
    return statement(holds, words, shown)


@claim("QUAL-05", control="refuted", name="omega_3")
def growth_of_amplitudes(name: str = "phi_dot", run: Run = REFERENCE) -> Grounds:
    """Near both moments the oscillation amplitudes grow suddenly by orders of magnitude.

    Sec. 2.1: "sudden increase, by orders of magnitude, of oscillation amplitudes in vicinity of the
    initiation time ... and in vicinity of the ending time"
    Definition: half the distance of consecutive extrema of phi_dot (events), the largest within 0.1
    s of the moment against the one a second earlier; orders of magnitude: at least 100 times
    Note: The amplitude grows like the reciprocal of the smallest distance of the axis from the
    pole. The largest value depends on this distance and is ill conditioned.
    """
    times, values = run.extrema(name)
    swings = abs(numpy.diff(values)) / 2
    parts = {}
    for when, moment in zip(ENDS, run.climb, strict=True):
        near = max(swings[abs(times[1:] - moment) < 0.1], default=0.0)
        before = max(swings[abs(times[1:] - moment + 1) < 0.1], default=near)
        shown = f"{decimal(before, 3)} a second before, {decimal(near, 3)} at {when}"
        parts[when] = near > 100 * before, shown
    return statements("by orders of magnitude", parts)


@claim("QUAL-25", control="partly", run=Run("phi-dot-195"))
def three_phases(run: Run = REFERENCE) -> Grounds:
    """There are three phases, and theta climbs only after t_init.

    Sec. 2.1: "consisting of three main phases separated by two moments"
    Definition: the middle of the nutation band: at the last turning point before t_init lower than
    at the first, of at least {MANY}; rising from each to the next from t_init to t_end; within 0.05
    rad of pi after t_end (definition A)
    Note: The middle is lowest at {lowest.t:6} s, where the axis passes the pole.
    """
    band, climb = run.band, run.climb
    before = [turn.middle for turn in band if turn.t < climb.begin]
    during = [turn.middle for turn in band if climb.has(turn.t)]
    after = [math.pi - turn.middle for turn in band if turn.t > climb.end]
    waits = len(before) >= MANY and before[-1] < before[0]
    turns, away = f"{len(before)} turning points", "not seen"
    if before:
        turns += f", the middle falls from {decimal(before[0], 3)} to {decimal(before[-1], 3)} rad"
    if after:
        away = f"at most {decimal(max(after), 2)} rad away"
    rise = f"the middle rises from {decimal(during[0], 3)} to {decimal(during[-1], 4)} rad "
    rise += "without a fall"
    stays = bool(after) and max(after) < 0.05
    return {
        "synchronisation": statement(waits, "theta does not climb before t_init", turns),
        "climb": statement(rising(during), "theta climbs from t_init to t_end", rise),
        "stabilisation": statement(stays, "theta near pi after t_end", away),
    }, {"lowest": min(band[: len(band) // 2 + 1], key=lambda turn: turn.middle)}


def _around(events: pandas.DataFrame, moment: Scalar) -> tuple[Scalar, Scalar]:
    """phi_dot at the last event before a moment and at the first event after it."""
    t, phi_dot = events["t"], events["phi_dot"]
    return phi_dot[t < moment].iloc[-1], phi_dot[t > moment].iloc[0]


@claim("QUAL-02", control="partly", name="omega_3")
def logistic_curve(name: str = "theta", run: Run = REFERENCE) -> Grounds:
    """theta(t) has the form of a logistic curve.

    Sec. 2.1: "It has a general form of a logistic type curve"
    Definition: least-squares fit of pi/(1 + exp(-k (t - t0))) over the climb (definition A), which
    shall leave at most 1 % of the variance; the middle of the band rises; {BAND}
    Note: The curve is not symmetric: theta needs {first:3} s to pi/2 and {second:3} s from there.
    """
    span = run.climb
    rate, centre, left = _logistic_fit(name, run, span)
    middles = [turn.middle for turn in run.band if span.has(turn.t)]
    falls = sum(b < a for a, b in pairwise(middles))
    shown = f"k = {rate:.2f} 1/s, t0 = {centre:.2f} s leave {100 * left:.2g} % of the variance"
    steps = f"falls {falls} of {len(middles) - 1} times"
    return {
        "logistic": statement(left <= 0.01, "logistic type curve", shown),
        "middle of the band": statement(falls == 0, "rises", steps),
    }, {"first": run.equator - span.begin, "second": span.end - run.equator}


@claim("QUAL-42", control="refuted", share=0.01)
def small_oscillations(share: float = 0.1, run: Run = REFERENCE) -> Grounds:
    """The oscillations of theta about the logistic curve are small.

    Sec. 2.1: "superposed with small amplitude oscillations"
    Definition: small: during the climb (definition A) the band is narrower than a tenth of its
    height pi; {BAND}
    Note: QUAL-08 says where the band is widest.
    """
    width = max(turn.width for turn in run.band if run.climb.has(turn.t))
    shown = f"the band is at most {decimal(width, 3)} rad wide"
    return statement(width < share * math.pi, "small amplitude", shown)


@claim("QUAL-08", rule="interpretations", control="reproduced", widest=0.78)
def nutation_band(widest: float = math.pi / 2, run: Run = REFERENCE) -> Grounds:
    """The nutation band widens when theta crosses pi/2.

    Sec. 2.1: "widening of the nutational band when theta(t) is crossing pi/2"
    Definition: {BAND}; as in the text, large theta_dot stands for a wide band
    Note: The largest theta_dot, {fastest.value:5} rad/s, comes at {when:4} s, and theta first
    passes pi/2 at {run.equator:4} s.
    """
    at = min(run.band, key=lambda turn: abs(turn.middle - widest))
    start = min(run.band, key=lambda turn: abs(turn.t - run.climb.begin))
    top = max(run.band, key=lambda turn: turn.width)
    wider = f"{decimal(start.width, 3)} rad at t_init, {decimal(at.width, 3)} rad at theta = "
    most = f"widest, {decimal(top.width, 3)} rad, at theta = {decimal(top.middle, 3)} "
    most += f"({decimal(top.t, 4)} s)"
    there, words = abs(top.middle - widest) < 0.1, f"widest at theta = {decimal(widest, 3)}"
    wider += decimal(at.middle, 3)
    numbers = {
        "fastest": run.extreme("theta_dot", largest=True),
        "when": run.extremum("theta_dot", largest=True)[0],
    }
    return {
        "wider than at t_init": statement(at.width > start.width, "widening", wider),
        "widest there": statement(there, words, most),
    }, numbers


@claim("QUAL-34", control="refuted", run=Run(variant(until="5.5")))
def narrowing_band(run: Run = REFERENCE) -> Grounds:
    """The nutation band narrows on the way to the south pole.

    Sec. 2.1: "The band is narrowing (and theta_dot(t)->0) when 3(t) is approaching the south pole"
    Definition: {BAND}; narrowing: narrower at the last turning point than where its middle is
    nearest to pi/2
    Note: It is {share:2} % as wide at the end.
    """
    at, last = min(run.band, key=lambda turn: abs(turn.middle - math.pi / 2)), run.band[-1]
    shown = f"{decimal(at.width, 3)} rad at theta = {decimal(at.middle, 3)}, "
    shown += f"{decimal(last.width, 2)} rad at {decimal(last.middle, 4)}"
    share = 100 * last.width / at.width
    return statement(last.width < at.width, "narrowing", shown), {"share": share}


def _logistic_fit(name: str, run: Run, span: Span) -> tuple[float, float, float]:
    """Rate (1/s), centre (s), and the share of the variance that the fitted curve leaves."""
    times = numpy.linspace(span.begin, span.end, 2000)
    values = run.column(name, times)

    def rest(parameters: Array) -> Array:
        rate, centre = parameters
        # the logistic curve as a tanh, which cannot overflow
        return values - math.pi / 2 * (1 + numpy.tanh(rate * (times - centre) / 2))

    fit = least_squares(rest, (2.0, span.begin + span.length / 2))
    rate, centre = (float(x) for x in fit.x)
    return rate, centre, float((fit.fun**2).mean() / values.var())


@claim("QUAL-06", control="refuted", share="1")
def small_perturbations(share: str = "0.01", run: Run = REFERENCE) -> Grounds:
    """The singular behaviour at both moments survives small changes of the start.

    Sec. 2.1: "The existence of singular behaviour is not affected by small perturbations of IC"
    Definition: each start value in turn changed by plus and minus 1 % of its value (theta, omega_3)
    or of its range in section 2.2; singular behaviour: a reversal in definition A at both ends of
    the climb, with |phi_dot| above {SINGULAR} rad/s within 0.1 s of each
    Note: The peaks go up to {highest:3} rad/s. t_init is {spread}, farthest from the reference's
    where {farthest}(0) is changed.
    """
    starts = list(_perturbed(Fraction(share), run))
    begins, singular = [], []
    for name, scene in starts:
        changed = integrate(scene, events=NEEDED)
        if pair := _peaks(changed):
            begins.append((float(changed.inversion.A.t_init), name))
            singular += [pair] if min(pair) > SINGULAR else []
    least = min(map(min, singular), default=0.0)
    highest = max(map(max, singular), default=0.0)
    spread, farthest = "none", "nothing"
    if begins:
        spread = f"{decimal(min(begins)[0], 3)} to {decimal(max(begins)[0], 3)} s"
        farthest = max(begins, key=lambda pair: abs(pair[0] - run.climb.begin))[1]
    shown = f"{len(singular)} of {len(starts)} perturbed starts show both reversals, "
    shown += f"with |phi_dot| of at least {decimal(least, 3)} rad/s"
    numbers = {"highest": highest, "spread": spread, "farthest": farthest}
    return statement(len(singular) == len(starts), "not affected", shown), numbers


@claim("QUAL-07", control="refuted", before="1")
def restart(before: str = "0", run: Run = REFERENCE) -> Grounds:
    """Started from its state at t_init the top climbs at once.

    Sec. 2.1: "When values of dynamical variables attained close to the first time of singularity
    are taken as initial conditions ... the solution theta(t) climbs immediately"
    Definition: starts at the states of the reference solution (double-double) at t_init in
    definitions A, B and C; immediately: no initiation time but 0 in definition A, and the middle of
    the nutation band rises over the first {EARLY} turning points
    Note: The reference start itself needs {run.equator:5} s to pass pi/2.
    """
    parts = {}
    for name, meaning in DEFINITIONS.items():
        again = Run(_restarted(run, name, Fraction(before)))
        t_init = again.inversion.A.t_init
        shown = f"t_init = {'none' if t_init is None else decimal(t_init, 4)} s, theta passes "
        shown += f"pi/2 after {decimal(again.equator, 5)} s"
        at_once = t_init == 0 and rising([turn.middle for turn in again.band[:EARLY]])
        parts[meaning] = at_once, shown
    return statements("climbs immediately", parts)


def _perturbed(share: Fraction, run: Run) -> Iterator[tuple[str, Scene]]:
    start = run.loaded.start
    for name, scale in SCALES.items():
        value = start.theta.offset if name == "theta" else getattr(start, name)
        for sign in (1, -1):
            changed = value + sign * share * Fraction(scale)
            if name != "theta" or changed > 0:
                yield name, variant(run.scene, **{name: str(changed), "until": PERTURBED_UNTIL})


def _peaks(run: Trajectory) -> tuple[float, float] | None:
    """The largest |phi_dot| at turning points near both reversals; None without the two."""
    climb = run.inversion.A
    if not climb.t_init or climb.t_end is None:
        return None
    turns = runs.rows_of(run, "theta_min", "theta_max")
    first, last = (
        float(abs(turns["phi_dot"][abs(turns["t"] - moment) < 0.1]).max())
        for moment in (climb.t_init, climb.t_end)
    )
    return first, last


def _restarted(run: Run, definition: str, before: Fraction) -> Scene:
    solution = run.trajectory(runs.FINE)
    t_init = getattr(runs.climb_of(solution), definition).t_init
    texts = solution.at(t_init - float(before)).as_text()
    values = {name: text for name in EulerState._fields if (text := texts[name]) is not None}
    return variant(run.scene, **values, until="6")


@claim("NUM-03", control="refuted", printed="1e-9")
def jellett_drift(printed: str = "1e-6", run: Run = REFERENCE) -> Grounds:
    """The paper's computation keeps Jellett's integral to about 1e-6 of its value.

    Sec. 2.1: "Jellett's integral ... is constant with precision of order 10^-6 lambda"
    Definition: largest |lambda(t)/lambda(0) - 1| over 0..8 s, output every 0.01 s, with SciPy's
    odeint, default tolerances, on eqs (2) to (7) in SI: the paper's method as far as it says
    Note: 1e-6 in lambda does not bound the error of the state: in odeint's run theta was off by up
    to {theta:1} rad, theta_dot by {theta_dot:1} rad/s, omega_3 by {omega_3:1} rad/s, and phi_dot at
    one output time by more than {peak:1} rad/s.
    """
    errors = motions.state_errors(run.scene)
    peak = Fraction(10) ** part.decade(Fraction(errors["phi_dot"]))
    drift = Value(motions.paper_odeint(run.scene)[1], 1)  # a digit that every machine has
    return part.at_most_order(printed, drift), {**errors, "peak": peak}
