"""Section 2.1: spin, precession and normal force of the reference solution."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise

import numpy

from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import chart, equal, names, parse, quantity
from tt_precise.claims.evidence.proved import sign_of_precession
from tt_precise.claims.evidence.run import (
    DEFINITIONS,
    MANY,
    REFERENCE,
    Run,
    Span,
    climb_of,
    exact,
    rows_of,
    variant,
)
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.verdicts import (
    Grounds,
    Part,
    about,
    decimal,
    fraction_of,
    statement,
    statements,
)
from tt_precise.integration import Trajectory
from tt_precise.mechanics.quantities import QUANTITIES, Motion, Quantity
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.values import Scalar

claim = claims_of(RAUCH_RUTSTAM, "2.1")
QUOTIENT = (
    "the quotient q as corrected for the missing factors R I1 and gamma has the same sign of "
    "1 - q as phi_dot"
)
CLOSE_DEG = 10
PRECESSION = "lambda_/(R*I3) + omega_3*(alpha - cos(theta))"
CORRECT_PRECESSION = "lambda_/(R*I1) + omega_3*(alpha - cos(theta))/gamma"
JELLETT_AT_START = "-R*I3*omega_3*(alpha - cos(theta))"


@claim(
    "QUAL-17",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    control=("refuted", {"phase": "climb"}),
    definition=f"changes of sign of 1 - q before t_init (A); {QUOTIENT}",
    quote="the quantity (1-...) changes sign many times",
)
def quotient_before(phase: str = "synchronisation", run: Run = REFERENCE) -> Grounds:
    """Before t_init 1 - q changes sign many times."""
    span = getattr(run, phase)
    zeros = [t for t in run.events("phi_dot_zero")["t"] if span.has(float(t))]
    check = statement(len(zeros) >= MANY, "changes sign many times", f"{len(zeros)} times")
    return check, "The changes of sign are the zeros of phi_dot, found as events."


@claim(
    "QUAL-36",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    control=("refuted", {"phase": "climb"}),
    definition="before t_init (A); close to 1: |1 - q| below 0.05, with the printed quotient "
    "(extrema found as events)",
    quote="the quotient is close to 1",
)
def quotient_close_to_one(phase: str = "synchronisation", run: Run = REFERENCE) -> Grounds:
    """Before t_init the printed quotient q is close to 1."""

    def dividend(q: Motion) -> Scalar:
        return QUANTITIES["omega_3"].evaluate(q) * (q.body.alpha - q.state.kz)

    name = Quantity.of(dividend, "1/s")
    quotients = run.extrema(name, getattr(run, phase))[1] / run.value(name, 0.0)
    size = float(abs(1 - quotients).max())
    check = statement(size < 0.05, "close to 1", f"|1 - q| at most {decimal(size, 3)}")
    return check, "So the right side of the equation is small (EQ-29 judges its form)."


@claim(
    "QUAL-18",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    control=("partly", {"sign": "negative"}),
    definition=f"the last zero of phi_dot before mid-climb, and its sign from there to t_end (A); "
    f"{QUOTIENT}",
    quote="At time t_{theta≈0} the term (1-...) acquires a positive sign",
)
def quotient_after(sign: str = "positive", printed: str = "3.2", run: Run = REFERENCE) -> Grounds:
    """At t_init 1 - q becomes positive, and it stays so during the climb."""
    climb = run.climb
    last = run.moment("C", "t_init")
    zeros = [t for t in run.events("phi_dot_zero")["t"] if climb.has(float(t))]
    inside = run.value("phi_dot", climb.middle)
    proved = not zeros and sign_of_precession(run.scene) * inside > 0
    nearest = float(run.events("theta_min").sort_values("theta")["t"].iloc[0])  # to the pole
    return (
        {
            "at t_init": about(printed, last, "s"),
            "during the climb": statement(
                not zeros and (inside > 0) == (sign == "positive"),
                f"stays {sign}",
                f"{'positive' if inside > 0 else 'negative'}, {len(zeros)} changes",
                proved=proved,
            ),
        },
        "Before the climb the axis passes nearest to the pole "
        f"{decimal(nearest - float(last), 3)} s after the last change of sign.",
    )


@claim(
    "QUAL-32",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    control=("refuted", {"name": "theta_dot"}),
    definition="half the distance of consecutive extrema of phi_dot (events) from t_init (A) to "
    "the equator, the largest in each tenth of that time; decreases: from each tenth to the next",
    quote="the amplitude of phi_dot(t) decreases with rising angle theta(t)",
)
def amplitude_falls(name: str = "phi_dot", run: Run = REFERENCE) -> Grounds:
    """From t_init on the amplitude of phi_dot decreases as theta rises."""
    span = Span(run.climb.begin, run.equator)
    times, values = run.extrema(name, span)
    swings = abs(numpy.diff(values)) / 2
    tenths = numpy.minimum(10 * (times[:-1] - span.begin) / span.length, 9).astype(int)
    largest = [float(swings[tenths == tenth].max()) for tenth in range(10)]
    falls = sum(b < a for a, b in pairwise(largest))
    check = statement(
        falls == 9,
        "decreases",
        f"falls in {falls} of 9 steps, from {decimal(largest[0], 3)} to "
        f"{decimal(largest[-1], 3)} rad/s",
    )
    return check, "The amplitude is largest where the axis passes the pole, at the beginning."


@claim(
    "NUM-09",
    control=("reproduced", {"printed": "-82"}),
    definition="omega_3 at 8 s, the end of the graphs; it tends to -lambda/(R (1 + alpha) I3)",
    quote="from the initial value of 155 rad/s to about -85 rad/s",
)
def final_spin(printed: str = "-85", run: Run = REFERENCE) -> Grounds:
    """omega_3 falls from 155 rad/s to about -85 rad/s."""
    spin = run.at("omega_3", "8")
    body = run.loaded.body
    limit = -run.lambda_ / (body.R * (1 + body.alpha) * body.I3)
    off = abs(float(spin) / float(printed) - 1)
    return (
        about(printed, spin, "rad/s"),
        f"It ends at {decimal(spin, 7)} rad/s, {100 * off:.1f} % from the printed value, and "
        f"tends to {decimal(limit, 7)} rad/s.",
    )


@claim(
    "NUM-10",
    rule="interpretations",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    control=("refuted", {"printed": "152"}),
    definition="omega_3 at the initiation time in definitions A, B and C",
    quote="in the quotient omega_3(t) (≈154 rad/s) is close to omega_3(0)=155 rad/s",
)
def spin_at_initiation(printed: str = "154", run: Run = REFERENCE) -> Grounds:
    """At the initiation time omega_3 is about 154 rad/s."""
    checks = {
        meaning: about(printed, run.confirm(partial(_spin_at, name)), "rad/s")
        for name, meaning in DEFINITIONS.items()
    }
    return checks, "Until then friction has reduced the spin only slightly."


@claim(
    "QUAL-09",
    control=("refuted", {"sum_": "psi_dot"}),
    definition="swings (largest minus least value, extrema as events) of phi_dot, psi_dot and "
    "omega_3 from 0.1 s before to 0.1 s after the initiation and the ending time; compensation: "
    "omega_3 swings less than a hundredth of either",
    quote="The strong oscillations of phi_dot(t), psi_dot(t) ... compensate each other",
)
def compensation(sum_: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """Near both moments the oscillations of phi_dot and psi_dot cancel in omega_3."""
    parts = {}
    for when, t in zip(("initiation", "ending"), run.climb, strict=True):
        span = Span(t - 0.1, min(t + 0.1, run.whole.end))
        phi, psi, both = (
            float(numpy.ptp(run.extrema(name, span)[1])) for name in ("phi_dot", "psi_dot", sum_)
        )
        parts[when] = (
            100 * both < min(phi, psi),
            f"phi_dot swings by {decimal(phi, 3)}, psi_dot by {decimal(psi, 3)}, "
            f"{sum_} by {decimal(both, 3)} rad/s",
        )
    return (
        statements("compensate each other", parts),
        "omega_3 = psi_dot + phi_dot cos(theta), and cos(theta) is near 1 and -1 there. The height "
        "of the peaks is ill conditioned, the compensation is not.",
    )


@claim(
    "QUAL-10",
    control=("refuted", {"name": "theta"}),
    definition="almost: all rises between its extrema (events) together are below 1 % of its fall",
    quote="is (unexpectedly) an almost monotonously decreasing function",
)
def monotonous_spin(name: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """omega_3 decreases almost monotonically."""
    rise, fall = run.rises_and_falls(name)
    values = run.extrema(name)[1]
    return (
        statement(
            rise < 0.01 * (fall - rise),
            "almost monotonously decreasing",
            f"rises sum up to {decimal(rise, 4)}, falls to {decimal(fall, 5)} rad/s",
        ),
        f"It has {len(values) - 2} local extrema, wherever nu_y vanishes, and starts with a "
        f"{'rise' if values[1] > values[0] else 'fall'}.",
    )


@claim(
    "QUAL-11",
    control=("refuted", {"name": "nu_x"}),
    definition="mean slope over the first and the last half second, against the steepest half "
    "second of the run; almost horizontal: below 2 % of that",
    quote="The curve omega_3(t) is in the beginning and at the end almost horizontal",
)
def horizontal_ends(name: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """omega_3 is almost constant in the beginning and at the end."""
    end = run.whole.end
    times = [0.5 * k for k in range(int(2 * end) + 1)]
    values = run.column(name, times)
    slopes = [(b - a) / 0.5 for a, b in pairwise(values)]
    steepest = max(slopes, key=abs)
    begin, most = times[slopes.index(steepest)], abs(steepest)
    parts = {
        when: (
            abs(slope) < 0.02 * most,
            f"slope {decimal(slope, 3)} against {decimal(most, 4)} rad/s^2",
        )
        for when, slope in (("beginning", slopes[0]), ("end", slopes[-1]))
    }
    return (
        statements("almost horizontal", parts),
        f"The steepest half second begins at {decimal(begin, 2)} s.",
    )


@claim(
    "QUAL-12",
    where="Sec. 2.1; 2.3",
    control=("refuted", {"axis": "3"}),
    definition=f"angle between omega and the vertical; close to parallel: below {CLOSE_DEG} "
    "degrees at every instant (the extrema of its cosine are events)",
    quote="the angular velocity omega remains close to be parallel with the z axis",
)
def vertical_angular_velocity(axis: str = "z", run: Run = REFERENCE) -> Grounds:
    """The angular velocity stays close to vertical."""

    def cosine(q: Motion) -> Scalar:
        along = q.omega[2] if axis == "z" else dot(q.omega, q.k)
        return along / q.fn.sqrt(dot(q.omega, q.omega))

    when, least = run.extremum(Quantity.of(cosine, "1"), largest=False)
    largest = math.degrees(math.acos(least))
    check = statement(
        largest < CLOSE_DEG,
        f"parallel to {axis}, within {CLOSE_DEG} degrees",
        f"largest angle {decimal(largest, 5)} degrees, at {decimal(when, 5)} s",
    )
    return check, f"theta is {decimal(run.value('theta', when), 3)} rad there."


@claim(
    "QUAL-13",
    control=("refuted", {"name": "L_z"}),
    definition="zeros of omega_3 over the whole run",
    quote="the projection omega.3 of the predominantly vertical angular velocity omega on 3 "
    "changes sign",
)
def spin_changes_sign(name: str = "omega_3", run: Run = REFERENCE) -> Grounds:
    """During the climb the projection of omega on the symmetry axis changes sign."""
    zeros_in_double, known = run.zeros(name), run.proofs
    first = run.confirm(lambda solution: rows_of(solution, "omega_3_zero")["t"].iloc[0])
    at = f", at {decimal(first.value, 16)} s" if zeros_in_double else ""
    holds = len(zeros_in_double) == 1 and run.climb.has(zeros_in_double[0])
    zeros = known.events("omega_3_zero") if name == "omega_3" else None
    begin, end = (known.moment("A", which) for which in ("t_init", "t_end"))
    proved = bool(
        holds
        and zeros and begin and end
        and len(zeros) == 1
        and begin.high < zeros[0]["t"].low <= zeros[0]["t"].high < end.low
    )  # fmt: skip
    check = statement(
        holds,
        "changes sign during the climb",
        f"{len(zeros_in_double)} change{'' if len(zeros_in_double) == 1 else 's'} of sign{at}",
        proved=proved,
    )
    return check, f"theta first passes pi/2 at {decimal(run.equator, 6)} s."


@claim(
    "QUAL-14",
    where="Sec. 2.1, Fig. 3b",
    control=("refuted", {"name": "E_dot"}),
    definition="positive local maxima of omega_3_dot (events) within 0.4 s of the initiation time, "
    "definition A",
    quote="the graph for omega_3_dot(t) in Fig. 3b acquires positive spikes in a neighborhood of "
    "t_{theta≈0}",
)
def positive_spikes(name: str = "omega_3_dot", run: Run = REFERENCE) -> Grounds:
    """The derivative of omega_3 has positive spikes near the initiation time."""
    t_init = run.climb.begin
    times, values = run.extrema(name)
    near = [
        value for t, value in zip(times, values, strict=True) if abs(t - t_init) < 0.4 and value > 0
    ]
    early = [t for t in run.zeros(name) if run.climb.has(t) and t < t_init + 2]
    last = f" The last positive spike before mid-climb ends at {early[-1]:.3f} s." if early else ""
    check = statement(
        len(near) > 1,
        "positive spikes",
        f"{len(near)} positive maxima, up to {decimal(max(near, default=0.0), 4)} rad/s^2",
    )
    return check, f"omega_3_dot has the sign of -nu_y, as the paper says.{last}"


def _spin_at(definition: str, run: Trajectory) -> Scalar:
    t = getattr(climb_of(run), definition).t_init
    return exact(run, "omega_3", t)[0]


@claim(
    "QUAL-15",
    quote="The value g_n(t) of the reaction force ... stays positive all time during the inversion",
    where="Sec. 2.1, Fig. 3c",
    control=("refuted", {"run": Run(variant(phi_dot="-1000", until="1"))}),
    definition="the smallest of all local minima of g_n, found as events, and of both ends",
)
def normal_force_stays_positive(run: Run = REFERENCE) -> Grounds:
    """The normal force of the reference solution is positive all the time."""
    least = run.least("g_n")
    ended = run.trajectory().status
    holds = ended == "complete" and least.value > 0
    check = statement(
        holds,
        "g_n > 0",
        f"least g_n {least} N, {ended}",
        proved=holds and run.proofs.g_n_positive,
    )
    return check, f"The least g_n is {decimal(fraction_of(least) / run.weight, 4)} of m g."


@claim(
    "QUAL-16",
    where="Sec. 2.1, Fig. 3c",
    control=("refuted", {"phase": "synchronisation"}),
    definition="extrema of g_n found as events; strongly: half the largest distance of consecutive "
    "extrema exceeds that before the climb (definition A) ten times",
    quote="it oscillates strongly during the climbing phase",
)
def strong_normal_force(phase: str = "climb", run: Run = REFERENCE) -> Grounds:
    """g_n oscillates strongly in the climb."""
    phases = ("synchronisation", phase)
    before, during = (run.largest_swing("g_n", getattr(run, each)) / 2 for each in phases)
    check = statement(
        during > 10 * before,
        "strongly in the climb",
        f"{decimal(before, 2)} N in {phases[0]} and {decimal(during, 2)} N in {phase}",
    )
    return check, f"The weight is {decimal(run.weight, 3)} N."


@claim(
    "QUAL-35",
    where="Sec. 2.1, Fig. 3c",
    control=("refuted", {"about": "0.15"}),
    definition="extrema of g_n found as events; about m g: its mean over synchronisation and over "
    "climb (definition A) is m g within 1 %, and consecutive extrema lie on both sides of m g",
    quote="Values of g_n(t) are oscillating about mg",
)
def normal_force_about_the_weight(about: str = "", run: Run = REFERENCE) -> Grounds:
    """g_n oscillates about m g."""
    weight = float(about or run.weight)
    parts = {}
    for phase in ("synchronisation", "climb"):
        span = getattr(run, phase)
        values = run.extrema("g_n", span)[1]
        crossings = sum((a - weight) * (b - weight) < 0 for a, b in pairwise(values))
        average = run.mean("g_n", span)
        parts[phase] = (
            abs(average / weight - 1) < 0.01 and crossings >= MANY,
            f"mean {decimal(average / weight, 5)} m g, {crossings} crossings",
        )
    return (
        statements("oscillates about m g", parts),
        "The mean has to be m g wherever the vertical velocity of the centre of mass ends as it "
        "began.",
    )


@claim(
    "EQ-28",
    rule="misprint",
    where="Sec. 2.1, eq (21)",
    control=("reproduced", {"printed": CORRECT_PRECESSION}),
    quote="phi_dot sin^2 theta=lambda/(R I3)+omega_3(alpha-cos theta)",
)
def precession_from_jellett(printed: str = PRECESSION) -> Grounds:
    """Jellett's integral solved for phi_dot sin^2 theta."""
    known = dict(names()) | {"lambda_": quantity("lambda")}
    left = parse("phi_dot*sin(theta)**2")

    def compare(text: str) -> Part:
        return equal(parse(text, known), left, f"phi_dot*sin(theta)**2 = {text}")

    return (
        map(compare, (printed, CORRECT_PRECESSION)),
        "The printed right side is gamma phi_dot sin^2 theta, gamma = I1/I3. The factor is "
        "positive, so the paper's statements about signs hold.",
    )


@claim(
    "EQ-29",
    rule="misprint",
    where="Sec. 2.1, eq (21)",
    control=("reproduced", {"printed": "-w0*(1 - w/w0)"}),
    definition="w0 = omega_3(0)(alpha - cos theta(0)), w = omega_3(alpha - cos theta), quotient "
    "w/w0",
    quote="-omega_3(0)(alpha-cos theta(0))+... =omega_3(0)(alpha-cos theta(0))(1-quotient)",
)
def factored_form(printed: str = "w0*(1 - w/w0)") -> Grounds:
    """The last step takes w0 out of -w0 + w."""
    correct = "-w0*(1 - w/w0)"
    # w and w0 are independent quantities: any two symbols of the chart stand for them
    symbols = chart()
    known = {"w": symbols.state.nu_x, "w0": symbols.state.nu_y}

    def compare(text: str) -> Part:
        return equal(parse(text, known), parse("-w0 + w", known), f"-w0 + w = {text}")

    return (
        map(compare, (printed, correct)),
        "The sign is lost. Because alpha - cos theta(0) < 0, phi_dot has the sign of 1 - quotient "
        "only with the minus, as the following text requires.",
    )


@claim(
    "EQ-30",
    quote="since lambda=-R I3 omega_3(0)(alpha-cos theta(0))",
    where="Sec. 2.1, eq (21), after it",
    definition="at the reference start, phi_dot(0) = 0",
    control=("refuted", {"printed": JELLETT_AT_START.replace("I3", "I1")}),
)
def jellett_of_the_start(printed: str = JELLETT_AT_START) -> Grounds:
    """lambda of a start with phi_dot(0) = 0."""
    symbols = chart()
    started = symbols.field(quantity("lambda"))
    phi_dot = symbols.symbol["phi_dot"].numer
    at_rest = symbols.field(started.numer.subs(phi_dot, 0)) / symbols.field(started.denom)
    check = equal(printed, at_rest, f"lambda = {printed}")
    return check, "Jellett's integral at phi_dot(0) = 0, for every theta(0) and omega_3(0)."
