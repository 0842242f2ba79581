"""Section 2.1: spin, precession and normal force of the reference solution."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise

import numpy

from tt_precise.claims import part
from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import run as runs
from tt_precise.claims.evidence.formulas import chart, equal, identity, parse, quantity
from tt_precise.claims.evidence.run import (
    DEFINITIONS,
    MANY,
    REFERENCE,
    Run,
    Span,
    sign_of_precession,
    variant,
)
from tt_precise.claims.part import Part, decimal, statement, statements
from tt_precise.claims.verdicts import Grounds
from tt_precise.integration import Trajectory
from tt_precise.mechanics.quantities import QUANTITIES, Motion, Quantity
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.values import Scalar

claim = claims_of("2.1")
QUOTIENT = (
    "the quotient q as corrected for the missing factors R I1 and gamma has the same sign of "
    "1 - q as phi_dot"
)
CLOSE_DEG = 10  # Angle in degrees within which an axis counts as close to the vertical.
PRECESSION = "lambda_/(R*I3) + omega_3*(alpha - cos(theta))"
CORRECT_PRECESSION = "lambda_/(R*I1) + omega_3*(alpha - cos(theta))/gamma"
JELLETT_AT_START = "-R*I3*omega_3*(alpha - cos(theta))"


@claim("QUAL-17", control="refuted", phase="climb")
def quotient_before(phase: str = "synchronisation", run: Run = REFERENCE) -> Grounds:
    """Before t_init 1 - q changes sign many times.

    Sec. 2.1, after eq. (phi_dot_equ): "the quantity (1-...) changes sign many times"
    Definition: changes of sign of 1 - q before t_init (A); {QUOTIENT}
    Note: The changes of sign are the zeros of phi_dot, found as events.
    """
    span = getattr(run, phase)
    zeros = [t for t in run.events("phi_dot_zero")["t"] if span.has(float(t))]
    return statement(len(zeros) >= MANY, "changes sign many times", f"{len(zeros)} times")


@claim("QUAL-36", control="refuted", phase="climb")
def quotient_close_to_one(phase: str = "synchronisation", run: Run = REFERENCE) -> Grounds:
    """Before t_init the printed quotient q is close to 1.

    Sec. 2.1, after eq. (phi_dot_equ): "the quotient is close to 1"
    Definition: before t_init (A); close to 1: |1 - q| below 0.05, with the printed quotient
    (extrema found as events)
    Note: So the right side of the equation is small (EQ-29 judges its form).
    """
    omega_3 = QUANTITIES["omega_3"].evaluate
    name = Quantity.of(lambda q: omega_3(q) * (q.body.alpha - q.state.kz), "1/s")
    quotients = run.extrema(name, getattr(run, phase))[1] / run.value(name, 0.0)
    size = float(abs(1 - quotients).max())
    return statement(size < 0.05, "close to 1", f"|1 - q| at most {decimal(size, 3)}")


@claim("QUAL-18", control="partly", sign="negative")
def quotient_after(sign: str = "positive", printed: str = "3.2", run: Run = REFERENCE) -> Grounds:
    """At t_init 1 - q becomes positive, and it stays so during the climb.

    Sec. 2.1, after eq. (phi_dot_equ): "At time t_{theta≈0} the term (1-...) acquires a positive
    sign"
    Definition: the last zero of phi_dot before mid-climb, and its sign from there to t_end (A);
    {QUOTIENT}
    Note: Before the climb the axis passes nearest to the pole {later:3} s after the last change of
    sign.
    """
    climb, last = run.climb, run.moment("C", "t_init")
    changes = sum(climb.has(float(t)) for t in run.events("phi_dot_zero")["t"])
    inside = run.value("phi_dot", climb.middle)
    proved = not changes and sign_of_precession(run.scene) * inside > 0
    stays = not changes and (inside > 0) == (sign == "positive")
    shown = f"{'positive' if inside > 0 else 'negative'}, {changes} changes"
    nearest = float(run.events("theta_min").sort_values("theta")["t"].iloc[0])  # to the pole
    return {
        "at t_init": part.about(printed, last, "s"),
        "during the climb": statement(stays, f"stays {sign}", shown, proved=proved),
    }, {"later": nearest - float(last)}


@claim("QUAL-32", control="refuted", name="theta_dot")
def amplitude_falls(name: str = "phi_dot", run: Run = REFERENCE) -> Grounds:
    """From t_init on the amplitude of phi_dot decreases as theta rises.

    Sec. 2.1, after eq. (phi_dot_equ): "the amplitude of phi_dot(t) decreases with rising angle
    theta(t)"
    Definition: half the distance of consecutive extrema of phi_dot (events) from t_init (A) to the
    equator, the largest in each tenth of that time; decreases: from each tenth to the next
    Note: The amplitude is largest where the axis passes the pole, at the beginning.
    """
    span = Span(run.climb.begin, run.equator)
    times, values = run.extrema(name, span)
    swings = abs(numpy.diff(values)) / 2
    tenths = numpy.minimum(10 * (times[:-1] - span.begin) / span.length, 9).astype(int)
    largest = [float(swings[tenths == tenth].max()) for tenth in range(10)]
    falls = sum(b < a for a, b in pairwise(largest))
    shown = f"falls in {falls} of 9 steps, from {decimal(largest[0], 3)} to "
    shown += f"{decimal(largest[-1], 3)} rad/s"
    return statement(falls == 9, "decreases", shown)


@claim("NUM-09", control="reproduced", printed="-82")
def final_spin(printed: str = "-85", run: Run = REFERENCE) -> Grounds:
    """omega_3 falls from 155 rad/s to about -85 rad/s.

    Sec. 2.1: "from the initial value of 155 rad/s to about -85 rad/s"
    Definition: omega_3 at 8 s, the end of the graphs; it tends to -lambda/(R (1 + alpha) I3)
    Note: It ends at {spin:7} rad/s, {off:.1%} from the printed value, and tends to {limit:7} rad/s.
    """
    spin = run.at("omega_3", "8")
    body = run.loaded.body
    limit = -run.lambda_ / (body.R * (1 + body.alpha) * body.I3)
    off = abs(float(spin) / float(printed) - 1)
    return part.about(printed, spin, "rad/s"), {"spin": spin, "off": off, "limit": limit}


@claim("NUM-10", rule="interpretations", control="refuted", printed="152")
def spin_at_initiation(printed: str = "154", run: Run = REFERENCE) -> Grounds:
    """At the initiation time omega_3 is about 154 rad/s.

    Sec. 2.1, after eq. (phi_dot_equ): "in the quotient omega_3(t) (≈154 rad/s) is close to
    omega_3(0)=155 rad/s"
    Definition: omega_3 at the initiation time in definitions A, B and C
    Note: Until then friction has reduced the spin only slightly.
    """

    def spin_at(definition: str, run: Trajectory) -> Scalar:
        t = getattr(runs.climb_of(run), definition).t_init
        return runs.exact(run, "omega_3", t)[0]

    return {
        meaning: part.about(printed, run.confirm(partial(spin_at, name)), "rad/s")
        for name, meaning in DEFINITIONS.items()
    }


@claim("QUAL-09", control="refuted", sum_="psi_dot")
def compensation(sum_: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """Near both moments the oscillations of phi_dot and psi_dot cancel in omega_3.

    Sec. 2.1: "The strong oscillations of phi_dot(t), psi_dot(t) ... compensate each other"
    Definition: swings (largest minus least value, extrema as events) of phi_dot, psi_dot and
    omega_3 from 0.1 s before to 0.1 s after the initiation and the ending time; compensation:
    omega_3 swings less than a hundredth of either
    Note: omega_3 = psi_dot + phi_dot cos(theta), and cos(theta) is near 1 and -1 there. The height
    of the peaks is ill conditioned, the compensation is not.
    """
    parts = {}
    for when, t in zip(("initiation", "ending"), run.climb, strict=True):
        span = Span(t - 0.1, min(t + 0.1, run.whole.end))
        names = ("phi_dot", "psi_dot", sum_)
        swings = [float(numpy.ptp(run.extrema(name, span)[1])) for name in names]
        phi, psi, both = (decimal(swing, 3) for swing in swings)
        shown = f"phi_dot swings by {phi}, psi_dot by {psi}, {sum_} by {both} rad/s"
        parts[when] = 100 * swings[2] < min(swings[:2]), shown
    return statements("compensate each other", parts)


@claim("QUAL-10", control="refuted", name="theta")
def monotonous_spin(name: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """omega_3 decreases almost monotonically.

    Sec. 2.1: "is (unexpectedly) an almost monotonously decreasing function"
    Definition: almost: all rises between its extrema (events) together are below 1 % of its fall
    Note: It has {extrema} local extrema, wherever nu_y vanishes, and starts with a {begin}.
    """
    rise, fall = run.rises_and_falls(name)
    values = run.extrema(name)[1]
    shown = f"rises sum up to {decimal(rise, 4)}, falls to {decimal(fall, 5)} rad/s"
    almost = statement(rise < 0.01 * (fall - rise), "almost monotonously decreasing", shown)
    begin = "rise" if values[1] > values[0] else "fall"
    return almost, {"extrema": len(values) - 2, "begin": begin}


@claim("QUAL-11", control="refuted", name="nu_x")
def horizontal_ends(name: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """omega_3 is almost constant in the beginning and at the end.

    Sec. 2.1: "The curve omega_3(t) is in the beginning and at the end almost horizontal"
    Definition: mean slope over the first and the last half second, against the steepest half second
    of the run; almost horizontal: below 2 % of that
    Note: The steepest half second begins at {begin:2} s.
    """
    times = [0.5 * k for k in range(int(2 * run.whole.end) + 1)]
    slopes = [(b - a) / 0.5 for a, b in pairwise(run.column(name, times))]
    steepest = max(slopes, key=abs)
    begin, most = times[slopes.index(steepest)], abs(steepest)
    parts = {}
    for when, slope in (("beginning", slopes[0]), ("end", slopes[-1])):
        shown = f"slope {decimal(slope, 3)} against {decimal(most, 4)} rad/s^2"
        parts[when] = abs(slope) < 0.02 * most, shown
    return statements("almost horizontal", parts), {"begin": begin}


@claim("QUAL-12", control="refuted", axis="3")
def vertical_angular_velocity(axis: str = "z", run: Run = REFERENCE) -> Grounds:
    """The angular velocity stays close to vertical.

    Sec. 2.1; 2.3: "the angular velocity omega remains close to be parallel with the z axis"
    Definition: angle between omega and the vertical; close to parallel: below {CLOSE_DEG} degrees
    at every instant (the extrema of its cosine are events)
    Note: theta is {theta:3} rad there.
    """

    def cosine(q: Motion) -> Scalar:
        along = q.omega[2] if axis == "z" else dot(q.omega, q.k)
        return along / q.fn.sqrt(dot(q.omega, q.omega))

    when, least = run.extremum(Quantity.of(cosine, "1"), largest=False)
    largest = math.degrees(math.acos(least))
    shown = f"largest angle {decimal(largest, 5)} degrees, at {decimal(when, 5)} s"
    words = f"parallel to {axis}, within {CLOSE_DEG} degrees"
    return statement(largest < CLOSE_DEG, words, shown), {"theta": run.value("theta", when)}


@claim("QUAL-13", control="refuted", name="L_z")
def spin_changes_sign(name: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """During the climb the projection of omega on the symmetry axis changes sign.

    Sec. 2.1: "the projection omega.3 of the predominantly vertical angular velocity omega on 3
    changes sign"
    Definition: zeros of omega_3 over the whole run
    Note: theta first passes pi/2 at {run.equator:6} s.
    """
    zeros = run.zeros(name)
    first = run.confirm(lambda run: runs.rows_of(run, "omega_3_zero")["t"].iloc[0])
    at = f", at {decimal(first.value, 16)} s" if zeros else ""
    holds = len(zeros) == 1 and run.climb.has(zeros[0])
    times = [event["t"] for event in run.proofs.events("omega_3_zero") or ()]
    begin, end = (run.proofs.moment("A", which) for which in ("t_init", "t_end"))
    proved = False
    if holds and name == "omega_3" and len(times) == 1 and begin and end:
        proved = begin.high < times[0].low <= times[0].high < end.low
    shown = f"{len(zeros)} change{'' if len(zeros) == 1 else 's'} of sign{at}"
    return statement(holds, "changes sign during the climb", shown, proved=proved)


@claim("QUAL-14", control="refuted", name="E_dot")
def positive_spikes(name: str = "omega_3_dot", run: Run = REFERENCE) -> Grounds:
    """The derivative of omega_3 has positive spikes near the initiation time.

    Sec. 2.1, Fig. 3b: "the graph for omega_3_dot(t) in Fig. 3b acquires positive spikes in a
    neighborhood of t_{theta≈0}"
    Definition: positive local maxima of omega_3_dot (events) within 0.4 s of the initiation time,
    definition A
    Note: omega_3_dot has the sign of -nu_y, as the paper says.{last}
    """
    t_init, (times, values) = run.climb.begin, run.extrema(name)
    spikes = values[(abs(times - t_init) < 0.4) & (values > 0)]
    early = [t for t in run.zeros(name) if run.climb.has(t) and t < t_init + 2]
    last = f" The last positive spike before mid-climb ends at {early[-1]:.3f} s." if early else ""
    shown = f"{len(spikes)} positive maxima, up to {decimal(max(spikes, default=0.0), 4)} rad/s^2"
    return statement(len(spikes) > 1, "positive spikes", shown), {"last": last}


@claim("QUAL-15", control="refuted", run=Run(variant(phi_dot="-1000", until="1")))
def normal_force_stays_positive(run: Run = REFERENCE) -> Grounds:
    """The normal force of the reference solution is positive all the time.

    Sec. 2.1, Fig. 3c: "The value g_n(t) of the reaction force ... stays positive all time during
    the inversion"
    Definition: the smallest of all local minima of g_n, found as events, and of both ends
    Note: The least g_n is {share:4} of m g.
    """
    least, status = run.least("g_n"), run.trajectory().status
    holds = status == "complete" and least.value > 0
    proved = holds and run.proofs.g_n_positive
    force = statement(holds, "g_n > 0", f"least g_n {least} N, {status}", proved=proved)
    return force, {"share": part.fraction_of(least) / run.weight}


@claim("QUAL-16", control="refuted", phase="synchronisation")
def strong_normal_force(phase: str = "climb", run: Run = REFERENCE) -> Grounds:
    """g_n oscillates strongly in the climb.

    Sec. 2.1, Fig. 3c: "it oscillates strongly during the climbing phase"
    Definition: extrema of g_n found as events; strongly: half the largest distance of consecutive
    extrema exceeds that before the climb (definition A) ten times
    Note: The weight is {run.weight:3} N.
    """
    phases = ("synchronisation", phase)
    before, during = (run.largest_swing("g_n", getattr(run, each)) / 2 for each in phases)
    shown = f"{decimal(before, 2)} N in {phases[0]} and {decimal(during, 2)} N in {phase}"
    return statement(during > 10 * before, "strongly in the climb", shown)


@claim("QUAL-35", control="refuted", about="0.15")
def normal_force_about_the_weight(about: str = "", run: Run = REFERENCE) -> Grounds:
    """g_n oscillates about m g.

    Sec. 2.1, Fig. 3c: "Values of g_n(t) are oscillating about mg"
    Definition: extrema of g_n found as events; about m g: its mean over synchronisation and over
    climb (definition A) is m g within 1 %, and consecutive extrema lie on both sides of m g
    Note: The mean has to be m g wherever the vertical velocity of the centre of mass ends as it
    began.
    """
    weight = float(about or run.weight)
    parts = {}
    for phase in ("synchronisation", "climb"):
        span = getattr(run, phase)
        values = run.extrema("g_n", span)[1]
        crossings = sum((a - weight) * (b - weight) < 0 for a, b in pairwise(values))
        mean = run.mean("g_n", span) / weight
        holds = abs(mean - 1) < 0.01 and crossings >= MANY
        parts[phase] = holds, f"mean {decimal(mean, 5)} m g, {crossings} crossings"
    return statements("oscillates about m g", parts)


@claim("EQ-28", rule="misprint", control="reproduced", printed=CORRECT_PRECESSION)
def precession_from_jellett(printed: str = PRECESSION) -> Grounds:
    """Jellett's integral solved for phi_dot sin^2 theta.

    Sec. 2.1, eq (21): "phi_dot sin^2 theta=lambda/(R I3)+omega_3(alpha-cos theta)"
    Note: The printed right side is gamma phi_dot sin^2 theta, gamma = I1/I3. The factor is
    positive, so the paper's statements about signs hold.
    """

    def compare(text: str) -> Part:
        left = "phi_dot*sin(theta)**2"
        return identity(text, left, f"{left} = {text}")

    return part.misprint(compare, printed, CORRECT_PRECESSION)


@claim("EQ-29", rule="misprint", control="reproduced", printed="-w0*(1 - w/w0)")
def factored_form(printed: str = "w0*(1 - w/w0)") -> Grounds:
    """The last step takes w0 out of -w0 + w.

    Sec. 2.1, eq (21): "-omega_3(0)(alpha-cos theta(0))+... =omega_3(0)(alpha-cos
    theta(0))(1-quotient)"
    Definition: w0 = omega_3(0)(alpha - cos theta(0)), w = omega_3(alpha - cos theta), quotient w/w0
    Note: The sign is lost. Because alpha - cos theta(0) < 0, phi_dot has the sign of 1 - quotient
    only with the minus, as the following text requires.
    """
    # w and w0 are independent quantities: any two symbols of the chart stand for them
    words = {"w": chart().state.nu_x, "w0": chart().state.nu_y}

    def compare(text: str) -> Part:
        return equal(parse(text, words), parse("-w0 + w", words), f"-w0 + w = {text}")

    return part.misprint(compare, printed, "-w0*(1 - w/w0)")


@claim("EQ-30", control="refuted", printed=JELLETT_AT_START.replace("I3", "I1"))
def jellett_of_the_start(printed: str = JELLETT_AT_START) -> Grounds:
    """lambda of a start with phi_dot(0) = 0.

    Sec. 2.1, eq (21), after it: "since lambda=-R I3 omega_3(0)(alpha-cos theta(0))"
    Definition: at the reference start, phi_dot(0) = 0
    Note: Jellett's integral at phi_dot(0) = 0, for every theta(0) and omega_3(0).
    """
    symbols = chart()
    jellett, phi_dot = symbols.field(quantity("lambda")), symbols.symbol["phi_dot"].numer
    at_rest = symbols.field(jellett.numer.subs(phi_dot, 0)) / symbols.field(jellett.denom)
    return equal(printed, at_rest, f"lambda = {printed}")
