"""Section 2.2: ranges, and single integrations of starts that climb at once."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache, partial
from itertools import pairwise

import pandas
from msgspec.structs import replace

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.run import DEFINITIONS, FINE, REFERENCE, Run, variant
from tt_precise.claims.part import Part, Value, decimal, statement, statements
from tt_precise.claims.verdicts import Grounds
from tt_precise.integration import Trajectory
from tt_precise.integration.precision import precision_named
from tt_precise.runtime.values import Scalar
from tt_precise.scene.scene import load_scene

claim = claims_of("2.2")
PHI_DOTS = tuple(str(195 + half / 2) for half in range(11))
SMOOTH_STARTS = "phi_dot(0) from 195 to 200 rad/s in steps of 0.5"
# Distance from pi in rad, within which the oscillation at the end of the climb sets in.
TO_THE_POLE = 0.2
SECANTS = 6  # Most steps of the secant method; the function is nearly straight.
AT_ONCE = 0.05  # Tolerance in rad of where monotony begins.
VISIBLE = 1e-3  # Smallest visible fall in rad, a third of a promille of a graph's height.


def _range(name: str, unit: str, printed: str, run: Run = REFERENCE) -> Grounds:
    low, high = (run.extreme(name, largest=largest) for largest in (False, True))
    larger = max(low, high, key=lambda extreme: abs(part.fraction_of(extreme)))
    size = Value(abs(larger.value), larger.digits)
    excess = 100 * (float(size) / float(printed) - 1)
    bound = part.at_most(printed, size, unit)
    words, shown = f"-{printed} to {printed} {unit}", f"{low} to {high} {unit}"
    numbers = {"share": abs(excess) / 100, "side": "above" if excess > 0 else "below"}
    return replace(bound, printed=words, measured=shown), numbers


for id, name, unit, printed, wrong in (
    ("NUM-11", "nu_x", "m/s", "0.3", "0.1"),
    ("NUM-12", "nu_y", "m/s", "0.8", "0.7"),
    ("NUM-13", "theta_dot", "rad/s", "15", "9"),
):
    words = f"""The reference solution's {name} varies within -{printed} to {printed} {unit}.

    Sec. 2.2: "within the maximal range of variability of {name}(t) in [-{printed},{printed}]
    displayed by the reference solution"
    Definition: least and largest value over 0..8 s: extrema found as events, values in
    double-double with the digits that triple-double confirms; both rounded to the digits of the
    printed bound
    Note: The largest absolute value is {{share:.1%}} {{side}} the printed bound; the range is not
    symmetric.
    """
    judge = partial(_range, name, unit, printed=printed)
    claim(id, words, control="refuted", printed=wrong)(judge)


@claim("NUM-15", control="refuted", printed="0.996")
def cosine(printed: str = "0.995", theta: str = "0.1") -> Grounds:
    """The cosine of 0.1 rad is 0.995.

    Sec. 2.2: "cos theta=0.995≈1"
    Definition: theta(0) = 0.1
    Note: Correctly rounded.
    """
    return part.rounds_to(printed, math.cos(float(theta)))


@claim("NUM-16", rule="misprint", control="rounded", printed="0.10")
def sine(printed: str = "0.01", theta: str = "0.1") -> Grounds:
    """The sine of 0.1 rad is 0.01.

    Sec. 2.2: "sin theta=0.01≈0"
    Definition: theta(0) = 0.1
    Note: 0.01 is its square, sin^2 = {square:3}, which is what lambda contains.
    """
    sine = math.sin(float(theta))

    def compare(text: str) -> Part:
        return replace(part.rounds_to(text, sine), printed=f"sin(theta) = {text}", formula=True)

    return part.misprint(compare, printed, "0.10"), {"square": sine**2}


@claim("NUM-17", rule="interpretations", control="refuted", printed="0.1")
def share_of_the_precession(printed: str = "1", phi_dot: str = "200") -> Grounds:
    """A precession of 200 rad/s at the start changes lambda by only 1 %.

    Sec. 2.2: "phi_dot(0) in [-200,200] affects the value of lambda as little as 1%"
    Definition: the change of lambda between phi_dot(0) = 0 and 200 rad/s, relative to lambda;
    theta(0) = 0.1 and omega_3(0) = 155 rad/s stay as they are
    Note: (I1/I3)(phi_dot/omega_3) sin^2(theta)/(cos(theta) - alpha). With psi_dot(0) kept instead
    of omega_3(0), lambda would be multiplied by {kept:4}.
    """
    body, start = load_scene("reference").body, load_scene("reference").start
    theta = float(start.theta.offset)
    share = float(100 * body.I1 * Fraction(phi_dot) / (body.I3 * start.omega_3))
    share *= math.sin(theta) ** 2 / (math.cos(theta) - float(body.alpha))
    kept = share / 100 + 1 + float(phi_dot) * math.cos(theta) / float(start.omega_3)
    return {
        "of the order of 1 %": part.at_most_order(printed, share, "%"),
        "1 %, correctly rounded": part.rounds_to(printed, share, "%"),
    }, {"kept": kept}


@claim("NUM-18", control="partly", printed="83.4")
def start_without_synchronisation(printed: str = "83.1", theta: str = "0.1") -> Grounds:
    """The initiation time vanishes when phi_dot(0) is about 83.1 rad/s.

    Sec. 2.2: "t_{theta≈0} goes to zero when phi_dot(0)≈83.1"
    Definition: the phi_dot(0) with which the axis passes exactly through the pole at the first
    minimum of theta: root of sign(phi_dot) theta there, which is smooth in phi_dot(0); beyond it
    t_init = 0 in definitions A, B and C
    Note: Just below the threshold t_init is the time of the first minimum of theta, {times} s.
    SWP-01 judges how it goes to zero.
    """
    root = threshold(theta)
    below, above = (initiations(theta, root.value, side) for side in (-1, 1))
    times = tuple(f"{name} {decimal(value, 3)}" for name, value in below.items())
    at_once = not any(above.values())
    later = "0 s in A, B and C" if at_once else str(above)
    return {
        "where t_init vanishes": part.about(printed, root, "rad/s"),
        "t_init beyond": statement(at_once, "0 s", later),
    }, {"times": times}


@claim("NUM-31", rule="interpretations", control="refuted", printed="0.3")
def monotonous_climb(printed: str = "0.8", theta: str = "0.1") -> Grounds:
    """With phi_dot(0) in [195, 200] and theta(0) = 0.1, theta grows monotonically from 0.8 on.

    Sec. 2.2: "The increase of theta(t) becomes monotonous starting from theta=0.8"
    Definition: {SMOOTH_STARTS}, theta(0) = 0.1; the last turning point of theta below pi -
    {TO_THE_POLE}; monotony begins there: within {AT_ONCE} rad
    Note: The last turning point lies {below:2} rad below the printed angle.
    """
    angles = [last_turning_point(theta, phi_dot)[1] for phi_dot in PHI_DOTS]
    low, high = min(angles), max(angles)
    shown = f"theta turns for the last time at {decimal(low, 4)} to {decimal(high, 4)} rad"
    below = float(printed) - high
    parts = {
        f"monotonic beyond {printed}": statement(below >= 0, f"from theta = {printed}", shown),
        f"monotony begins at {printed}": statement(
            abs(below) < AT_ONCE, f"begins at theta = {printed}", shown
        ),
    }
    return parts, {"below": below}


@claim("NUM-32", rule="interpretations", control="reproduced", time="0.9", angle="0.04")
def smoother_climb(time: str = "0.3", angle: str = "0.02", theta: str = "0.01") -> Grounds:
    """With theta(0) = 0.01, theta grows monotonically from 0.3 s, 0.02 rad on.

    Sec. 2.2: "the increase of theta(t) is monotononous starting from time 0.3s and angle
    theta(t)=0.02"
    Definition: {SMOOTH_STARTS}, theta(0) = 0.01; turning points and falls of theta (from a maximum
    to the next minimum) after the printed time and below pi - {TO_THE_POLE}; a graph shows falls of
    {VISIBLE} rad at best
    Note: A fall of {fall:1} rad is {share:1} of the height of a graph of theta.
    """
    turns = [last_turning_point(theta, phi_dot) for phi_dot in PHI_DOTS]
    times, angles = zip(*turns, strict=True)
    fall = max(_largest_fall(theta, phi_dot, float(time)) for phi_dot in PHI_DOTS)
    turning = max(times) <= float(time) and max(angles) <= float(angle)
    shown = f"turns for the last time at {decimal(min(times), 3)} to {decimal(max(times), 3)} s, "
    shown += f"{decimal(min(angles), 3)} to {decimal(max(angles), 3)} rad"
    falls = f"falls by at most {decimal(fall, 2)} rad"
    smooth = statement(turning, f"monotonous from {time} s, {angle} rad on", shown)
    visible = statement(fall < VISIBLE, f"monotonic from {time} s on", falls)
    parts = {"no turning point after that": smooth, "no fall that a graph shows": visible}
    return parts, {"fall": fall, "share": fall / math.pi}


@claim("NUM-33", rule="interpretations", control="refuted", printed="7.9")
def ending_time_of_smooth_climbs(printed: str = "7.77", theta: str = "0.01") -> Grounds:
    """With theta(0) = 0.01 and phi_dot(0) in [195, 200] the climb ends at about 7.77 s.

    Sec. 2.2: "their ending time is about t_{theta≈pi}=7.77"
    Definition: {SMOOTH_STARTS}, theta(0) = 0.01; t_end in each definition, from the least to the
    largest of these starts; the one nearest to the printed time counts
    Note: The ending time depends on phi_dot(0).
    """
    parts = {}
    for name, meaning in DEFINITIONS.items():
        ends = [float(getattr(_run(theta, p).inversion, name).t_end) for p in PHI_DOTS]
        nearest = min(max(min(ends), float(printed)), max(ends))
        shown = f"{decimal(min(ends), 4)} to {decimal(max(ends), 4)} s"
        parts[meaning] = replace(part.about(printed, nearest, "s"), measured=shown, rounded=False)
    return parts


@claim("NUM-34", control="refuted", starts=("82.5", "83"))
def no_initiation(starts: tuple[str, ...] = PHI_DOTS) -> Grounds:
    """With phi_dot(0) in [195, 200] the initiation time is zero.

    Sec. 2.2: "Their initiation time is zero"
    Definition: {SMOOTH_STARTS}, theta(0) = 0.1 and 0.01; t_init in definitions A, B and C
    Note: phi_dot > 0 at the first minimum of theta in {positive} of {count} starts.
    """
    runs = [_run(theta, phi_dot) for theta in ("0.1", "0.01") for phi_dot in starts]
    times = [getattr(run.inversion, name).t_init for run in runs for name in DEFINITIONS]
    zero = sum(t_init == 0 for t_init in times)
    positive = sum(_first_minimum(run.trajectory())["phi_dot"] > 0 for run in runs)
    shown = f"0 in {zero} of {len(times)} cases (start and definition)"
    numbers = {"positive": positive, "count": len(runs)}
    return statement(zero == len(times), "t_init = 0", shown), numbers


@claim("FIG-15", control="refuted", phi_dot="180")
def exceptionally_smooth(phi_dot: str = "195") -> Grounds:
    """The solution with phi_dot(0) = 195 is exceptionally smooth.

    Fig. 8, caption: "The behaviour of the dynamical variables is exceptionally smooth"
    Definition: total variation (sum of all rises and falls between extrema found as events) of
    theta_dot, nu_x, nu_y and g_n over 8 s, against starts with phi_dot(0) = 0, 50, 100 and 150;
    exceptionally smooth: below a third of the least of theirs
    Note: With phi_dot(0) = 200 the total variation of theta_dot is {most:3} rad/s.
    """
    parts = {}
    for name in ("theta_dot", "nu_x", "nu_y", "g_n"):
        here = _variation(name, phi_dot)
        others = [_variation(name, other) for other in ("0", "50", "100", "150")]
        shown = f"{decimal(min(others), 3)} to {decimal(max(others), 3)}"
        parts[name] = 3 * here < min(others), f"{decimal(here, 3)} against {shown}"
    return statements("exceptionally smooth", parts), {"most": _variation("theta_dot", "200")}


def _run(theta: str, phi_dot: str) -> Run:
    return Run(variant(theta=theta, phi_dot=phi_dot, until="9"))


@cache
def threshold(theta: str) -> Value:
    """Root in phi_dot(0) of the signed first perigee, fine, with double's confirmation."""
    fine, rough = (_root(theta, precision) for precision in (FINE, "double"))
    return Value.of(fine, rough)


def _root(theta: str, precision: str) -> Scalar:
    def height(phi_dot: Scalar) -> Scalar:
        return _signed_perigee(theta, phi_dot, precision)

    # secant steps, each of which multiplies the digits by 1.6
    fn = precision_named(precision).context
    return fn.findroot(height, (83, fn.mpf("83.2")), maxsteps=SECANTS, verify=False)


def _signed_perigee(theta: str, phi_dot: Scalar, precision: str) -> Scalar:
    """sign(phi_dot) theta at the first minimum of theta."""
    text = precision_named(precision).text(phi_dot)
    run = Run(variant(theta=theta, phi_dot=text, until="0.05"))
    first = _first_minimum(run.trajectory(precision))
    return first["theta"] if first["phi_dot"] > 0 else -first["theta"]


def _first_minimum(run: Trajectory) -> pandas.Series:
    return run.events[run.events["name"] == "theta_min"].iloc[0]


def initiations(theta: str, phi_dot: Scalar, side: int) -> dict[str, float]:
    """t_init in A, B and C at ``phi_dot`` (moved by a millionth to one side)."""
    moved = repr(float(phi_dot) * (1 + side * 1e-6))
    inversion = _run(theta, moved).inversion
    return {name: float(getattr(inversion, name).t_init) for name in DEFINITIONS}


def _climbing_turning_points(theta: str, phi_dot: str) -> pandas.DataFrame:
    turns = _run(theta, phi_dot).turning_points
    ending = turns["theta"] > math.pi - TO_THE_POLE
    return turns[: int(ending.argmax())] if ending.any() else turns


def last_turning_point(theta: str, phi_dot: str) -> tuple[float, float]:
    """Time (s) and angle of the last turning point of theta in the climb."""
    last = _climbing_turning_points(theta, phi_dot).iloc[-1]
    return float(last["t"]), float(last["theta"])


def _largest_fall(theta: str, phi_dot: str, after: float) -> float:
    turns = _climbing_turning_points(theta, phi_dot)
    angles = [float(x) for x in turns["theta"][turns["t"] > after]]
    return max((a - b for a, b in pairwise(angles)), default=0.0)


def _variation(name: str, phi_dot: str) -> float:
    return sum(Run(variant(phi_dot=phi_dot)).rises_and_falls(name))
