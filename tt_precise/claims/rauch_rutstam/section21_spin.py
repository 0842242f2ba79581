"""Section 2.1: spin, precession and normal force of the reference solution."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise

from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import DEFINITIONS, MANY, REFERENCE, Run, Span, variant
from tt_precise.claims.evidence import formulas as f
from tt_precise.claims.evidence.proved import digits, proofs_of, settles, sign_of_precession
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    about,
    all_of,
    decimal,
    fraction_of,
    measured_text,
    misprint,
    readings,
    rounds_to,
    statement,
    within,
)
from tt_precise.integration import Trajectory
from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import Vector, cross, dot
from tt_precise.runtime.arithmetic import Array, Scalar

claim = claims_of(RAUCH_RUTSTAM, "2.1")
QUOTIENT = (
    "the quotient q as corrected for the missing factors R I1 and gamma has the same sign of "
    "1 - q as phi_dot"
)
VECTORS = NewtonState._fields
CLOSE_DEG = 10
PRECESSION = "lambda_/(R*I3) + omega_3*(alpha - cos(theta))"
CORRECT_PRECESSION = "lambda_/(R*I1) + omega_3*(alpha - cos(theta))/gamma"
JELLETT_AT_START = "-R*I3*omega_3*(alpha - cos(theta))"


@claim(
    "QUAL-17",
    quote="changes sign many times ... the quotient is close to 1",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    definition=f"changes of sign of 1 - q before t_init (A); {QUOTIENT}; close to 1: |1 - q| below "
    "0.05, with the printed quotient (extremes closed in on in the dense output)",
    control={"phase": "climb"},
)
def quotient_before(phase: str = "synchronisation", run: Run = REFERENCE) -> Finding:
    """Before t_init 1 - q changes sign many times, and q is close to 1."""
    span = getattr(run, phase)
    zeros = [t for t in run.events("phi_dot_zero")["t"] if span.has(float(t))]
    extremes = (
        run.extreme_of(_printed_bracket(run), ("omega_3", "kz"), largest=largest, span=span)
        for largest in (False, True)
    )
    sizes = [abs(value) for _, value in extremes]
    return all_of(
        {
            "sign": statement(len(zeros) >= MANY, "changes sign many times", f"{len(zeros)} times"),
            "quotient": statement(
                max(sizes) < 0.05, "close to 1", f"|1 - q| at most {decimal(max(sizes), 3)}"
            ),
        },
        "The changes of sign are the zeros of phi_dot, found as events.",
    )


@claim(
    "QUAL-18",
    quote="at time t_init the term acquires a positive sign",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    definition=f"the last zero of phi_dot before mid-climb, and its sign from there to t_end (A); "
    f"{QUOTIENT}",
    control={"sign": "negative"},
)
def quotient_after(sign: str = "positive", printed: str = "3.2", run: Run = REFERENCE) -> Finding:
    """At t_init 1 - q becomes positive, and it stays so during the climb."""
    climb = run.climb
    last = run.moment("C", "t_init")
    zeros = [t for t in run.events("phi_dot_zero")["t"] if climb.has(float(t))]
    middle = climb.begin + climb.length / 2
    inside = run.value("phi_dot", middle)
    at_last, known = about(printed, last, "s"), proofs_of(run.scene)
    proved = (
        settles(at_last, partial(about, printed), known.moment("C", "t_init"))
        and not zeros
        and sign_of_precession(run.scene) * inside > 0
    )
    return all_of(
        {
            "at t_init": at_last,
            "during the climb": statement(
                not zeros and (inside > 0) == (sign == "positive"),
                f"stays {sign}",
                f"{'positive' if inside > 0 else 'negative'}, {len(zeros)} changes",
            ),
        },
        "Before the climb the axis passes nearest to the pole "
        f"{decimal(_nearest_pass(run) - float(last.value), 3)} s after the last change of sign."
        + known.sentence(proved, "its last zero before the climb, and that there is none within"),
        proved=proved,
    )


def _nearest_pass(run: Run) -> float:
    """When theta is least, in s."""
    turns = run.events("theta_min")
    return float(turns.sort_values("theta")["t"].iloc[0])


def _printed_bracket(run: Run) -> Callable[[dict[str, Array]], Array]:
    """1 - omega_3 (alpha - cos theta)/(the same at t = 0), as in eq (phi_dot_equ)."""
    start = run.loaded
    alpha = float(start.body.alpha)
    first = run.columns(["omega_3", "kz"], [0.0])
    scale = float((first["omega_3"] * (alpha - first["kz"]))[0])
    return lambda columns: 1 - columns["omega_3"] * (alpha - columns["kz"]) / scale


@claim(
    "NUM-09",
    quote="from the initial value of 155 rad/s to about -85 rad/s",
    definition="omega_3 at 8 s, the end of the graphs; the value it tends to is "
    "-lambda/(R (1 + alpha) I3), which at 8 s it has reached to six digits",
    control={"printed": "-80"},
)
def final_spin(printed: str = "-85", run: Run = REFERENCE) -> Finding:
    """omega_3 falls from 155 rad/s to about -85 rad/s."""

    def checks(spin: Scalar) -> list[Check]:
        return [rounds_to(printed, spin, "rad/s"), within(printed, spin, "2.5", "rad/s")]

    found, known = run.at("omega_3", "8"), proofs_of(run.scene)
    interval = known.at("omega_3", "8")
    exact, near = checks(found)
    proved = settles(exact, lambda spin: checks(spin)[0], interval) and settles(
        near, lambda spin: checks(spin)[1], interval
    )
    return readings(
        {"to the last printed digit": exact, "to the nearest multiple of 5": near},
        f"It ends at {decimal(found.value, 5)} rad/s."
        + known.sentence(proved, f"this value {digits([interval])}"),
        proved=proved,
    )


@claim(
    "NUM-10",
    quote="in the quotient omega_3(t) (about 154 rad/s) is close to omega_3(0) = 155 rad/s",
    where="Sec. 2.1, after eq. (phi_dot_equ)",
    definition="omega_3 at the initiation time in definitions A, B and C",
    control={"printed": "153"},
)
def spin_at_initiation(printed: str = "154", run: Run = REFERENCE) -> Finding:
    """At the initiation time omega_3 is about 154 rad/s."""
    return readings(
        {
            reading: rounds_to(printed, run.settled(partial(_spin_at, name)), "rad/s")
            for name, reading in DEFINITIONS.items()
        },
        "Friction has taken little of the spin until then.",
    )


@claim(
    "QUAL-09",
    quote="the strong oscillations of phi_dot, psi_dot ... compensate each other",
    definition="swings (largest minus least value, extrema as events) of phi_dot, psi_dot and "
    "omega_3 from 0.1 s before to 0.1 s after the initiation and the ending time; compensation: "
    "omega_3 swings less than a hundredth of either",
    control={"sum_": "psi_dot"},
)
def compensation(sum_: str = "omega_3", run: Run = REFERENCE) -> Finding:
    """Near both moments the oscillations of phi_dot and psi_dot cancel in omega_3."""
    checks = {}
    for when, t in zip(("initiation", "ending"), run.climb, strict=True):
        span = Span(t - 0.1, min(t + 0.1, run.whole.end))
        phi, psi, both = (_swing(one, run, span) for one in ("phi_dot", "psi_dot", sum_))
        checks[when] = statement(
            100 * both < min(phi, psi),
            "compensate each other",
            f"phi_dot swings by {decimal(phi, 3)}, psi_dot by {decimal(psi, 3)}, "
            f"{sum_} by {decimal(both, 3)} rad/s",
        )
    return all_of(
        checks,
        "omega_3 = psi_dot + phi_dot cos(theta), and cos(theta) is near 1 and -1 there. The height "
        "of the peaks is ill conditioned, the compensation is not.",
    )


@claim(
    "QUAL-10",
    quote="omega_3(t) ... is (unexpectedly) an almost monotonously decreasing function",
    definition="almost: all rises between its extrema (events) together are below 1 % of its fall",
    control={"name": "theta"},
)
def monotonous_spin(name: str = "omega_3", run: Run = REFERENCE) -> Finding:
    """omega_3 decreases almost monotonously."""
    rise, fall = run.rises_and_falls(name)
    values = run.extrema(name)[1]
    return all_of(
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
    quote="the curve omega_3(t) is in the beginning and at the end almost horizontal",
    definition="mean slope over the first and the last half second, against the steepest half "
    "second of the run; almost horizontal: below 2 % of that",
    control={"name": "nu_x"},
)
def horizontal_ends(name: str = "omega_3", run: Run = REFERENCE) -> Finding:
    """omega_3 is almost constant in the beginning and at the end."""
    end = run.whole.end
    times = [0.5 * k for k in range(int(2 * end) + 1)]
    values = run.columns([name], times)[name]
    slopes = [(b - a) / 0.5 for a, b in pairwise(values)]
    steepest = max(map(abs, slopes))
    steep = times[[abs(slope) for slope in slopes].index(steepest)]
    return all_of(
        {
            when: statement(
                abs(slope) < 0.02 * steepest,
                "almost horizontal",
                f"slope {decimal(slope, 3)} against {decimal(steepest, 4)} rad/s^2",
            )
            for when, slope in (("beginning", slopes[0]), ("end", slopes[-1]))
        },
        f"The steepest half second begins at {decimal(steep, 2)} s.",
    )


@claim(
    "QUAL-12",
    quote="the predominantly vertical angular velocity; remains close to be parallel with z",
    where="Sec. 2.1; 2.3",
    definition=f"angle between omega and the vertical; close to parallel: below {CLOSE_DEG} "
    "degrees at every instant (the largest angle is closed in on in the dense output)",
    control={"axis": "3"},
)
def vertical_angular_velocity(axis: str = "z", run: Run = REFERENCE) -> Finding:
    """The angular velocity stays close to vertical."""
    body = run.loaded.body.numbers(float)

    def angle(columns: dict[str, Array]) -> Array:
        import numpy

        state = NewtonState(*(columns[name] for name in VECTORS))
        omega = newton.angular_velocity(body, state)
        to: Vector = (0, 0, 1) if axis == "z" else state.k
        across = cross(omega, to)
        return numpy.degrees(numpy.arctan2(numpy.sqrt(dot(across, across)), dot(omega, to)))

    when, largest = run.extreme_of(angle, VECTORS, largest=True)
    return all_of(
        statement(
            largest < CLOSE_DEG,
            f"parallel to {axis}, within {CLOSE_DEG} degrees",
            f"largest angle {decimal(largest, 5)} degrees, at {decimal(when, 5)} s",
        ),
        f"theta is {decimal(run.value('theta', when), 3)} rad there.",
    )


@claim(
    "QUAL-13",
    quote="the projection of omega on 3 changes sign",
    definition="zeros of omega_3 over the whole run",
    control={"name": "L_z"},
)
def spin_changes_sign(name: str = "omega_3", run: Run = REFERENCE) -> Finding:
    """During the climb the projection of omega on the symmetry axis changes sign."""
    found = run.zeros(name)
    climb = run.climb
    at = f", at {decimal(run.settled(_zero_of_spin).value, 16)} s" if found else ""
    check = statement(
        len(found) == 1 and climb.has(found[0]),
        "changes sign during the climb",
        f"{len(found)} change{'' if len(found) == 1 else 's'} of sign{at}",
    )
    known = proofs_of(run.scene)
    half = decimal(run.equator, 6)
    zeros = known.events("omega_3_zero") if name == "omega_3" else None
    begin, end = (known.moment("A", which) for which in ("t_init", "t_end"))
    proved = bool(
        check.holds
        and zeros and begin and end
        and len(zeros) == 1
        and begin.high < zeros[0]["t"].low <= zeros[0]["t"].high < end.low
    )  # fmt: skip
    return all_of(
        check,
        f"theta first passes pi/2 at {half} s."
        + known.sentence(proved, "this one, and that there is no other"),
        proved=proved,
    )


@claim(
    "QUAL-14",
    quote="the graph for omega_3_dot acquires positive spikes in a neighborhood of t_init",
    where="Sec. 2.1, Fig. 3b",
    definition="positive local maxima of omega_3_dot (events) within 0.4 s of the initiation time, "
    "definition A",
    control={"name": "E_dot"},
)
def positive_spikes(name: str = "omega_3_dot", run: Run = REFERENCE) -> Finding:
    """The derivative of omega_3 has positive spikes near the initiation time."""
    t_init = run.climb.begin
    times, values = run.extrema(name)
    near = [v for t, v in zip(times, values, strict=True) if abs(t - t_init) < 0.4 and v > 0]
    changes = run.zeros(name)
    rest = [t for t in changes if run.climb.has(t)]
    early = [t for t in rest if t < t_init + 2]
    return all_of(
        statement(
            len(near) > 1,
            "positive spikes",
            f"{len(near)} positive maxima, up to {decimal(max(near, default=0.0), 4)} rad/s^2",
        ),
        "omega_3_dot has the sign of -nu_y, as the paper says."
        + (
            f" The last positive spike before mid-climb ends at {early[-1]:.3f} s." if early else ""
        ),
    )


def _spin_at(definition: str, run: Trajectory) -> Scalar:
    t = getattr(run.inversion, definition).t_init
    return run.frame("omega_3", times=[t])["omega_3"].iloc[0]


def _zero_of_spin(run: Trajectory) -> Scalar:
    return run.events["t"][run.events["name"] == "omega_3_zero"].iloc[0]


def _swing(name: str, run: Run, span: Span) -> float:
    values = run.extrema(name, span)[1]
    return float(values.max() - values.min())


@claim(
    "QUAL-15",
    quote="g_n(t) ... stays positive all time during the inversion",
    where="Sec. 2.1, Fig. 3c",
    definition="the smallest of all local minima of g_n, found as events, and of both ends",
    control={"run": Run(variant(phi_dot="-1000", until="1"))},
)
def normal_force_stays_positive(run: Run = REFERENCE) -> Finding:
    """The normal force of the reference solution is positive all the time."""
    least = run.least("g_n")
    ended = run.trajectory().status
    check = statement(
        ended == "complete" and least.value > 0,
        "g_n > 0",
        f"least g_n {measured_text(least)} N, {ended}",
    )
    known = proofs_of(run.scene)
    proved = check.holds and known.g_n_positive
    return all_of(
        check,
        f"The least g_n is {decimal(fraction_of(least) / run.weight, 4)} of m g."
        + known.sentence(proved, f"g_n > {known.least_g_n} m g {known.span}"),
        proved=proved,
    )


@claim(
    "QUAL-16",
    quote="oscillates strongly during the climbing phase ... oscillating about mg",
    where="Sec. 2.1, Fig. 3c",
    definition="extrema of g_n found as events; about m g: its mean over synchronisation and over "
    "climb (definition A) is m g within 1 %, and consecutive extrema lie on both sides of m g; "
    "strongly: half the largest distance of consecutive extrema exceeds that before the climb ten "
    "times",
    control={"about": "0.15"},
)
def normal_force_about_the_weight(about: str = "", run: Run = REFERENCE) -> Finding:
    """g_n oscillates about m g, strongly in the climb."""
    weight = float(about or run.weight)
    spans = {"synchronisation": run.synchronisation, "climb": run.climb}
    amplitudes, checks = {}, {}
    for phase, span in spans.items():
        values = run.extrema("g_n", span)[1]
        amplitudes[phase] = max(abs(b - a) for a, b in pairwise(values)) / 2
        crossings = sum((a - weight) * (b - weight) < 0 for a, b in pairwise(values))
        average = run.mean("g_n", span)
        checks[phase] = statement(
            abs(average / weight - 1) < 0.01 and crossings >= MANY,
            "oscillates about m g",
            f"mean {decimal(average / weight, 5)} m g, {crossings} crossings",
        )
    checks["amplitude"] = statement(
        amplitudes["climb"] > 10 * amplitudes["synchronisation"],
        "strongly in the climb",
        " and ".join(f"{decimal(float(a), 2)} N in {p}" for p, a in amplitudes.items()),
    )
    return all_of(
        checks,
        "The mean has to be m g wherever the vertical velocity of the centre of mass ends as it "
        "began.",
    )


@claim(
    "EQ-28",
    quote="phi_dot sin^2 theta=lambda/(R I3)+omega_3(alpha-cos theta)",
    where="Sec. 2.1, eq (21)",
    control={"printed": CORRECT_PRECESSION},
)
def precession_from_jellett(printed: str = PRECESSION) -> Finding:
    """Jellett's integral solved for phi_dot sin^2 theta."""
    known = dict(f.names()) | {"lambda_": f.quantity("lambda")}
    left = f.read("phi_dot*sin(theta)**2")

    def compared(text: str) -> Check:
        return f.equal(f.read(text, known), left, f"phi_dot*sin(theta)**2 = {text}")

    return misprint(
        compared(printed),
        compared(CORRECT_PRECESSION),
        f"phi_dot*sin(theta)**2 = {CORRECT_PRECESSION}",
        "The printed right side is gamma phi_dot sin^2 theta, gamma = I1/I3; the factor is "
        "positive, so what the paper says of signs stands.",
        proved=True,
    )


@claim(
    "EQ-29",
    quote="-omega_3(0)(alpha-cos theta(0))+... =omega_3(0)(alpha-cos theta(0))(1-quotient)",
    where="Sec. 2.1, eq (21)",
    definition="w0 = omega_3(0)(alpha - cos theta(0)), w = omega_3(alpha - cos theta), quotient "
    "w/w0",
    control={"printed": "-w0*(1 - w/w0)"},
)
def factored_form(printed: str = "w0*(1 - w/w0)") -> Finding:
    """The last step takes w0 out of -w0 + w."""
    correct = "-w0*(1 - w/w0)"
    # w and w0 are independent quantities: any two symbols of the chart stand for them
    symbols = f.chart()
    known = {"w": symbols.state.nu_x, "w0": symbols.state.nu_y}

    def compared(text: str) -> Check:
        return f.equal(f.read(text, known), f.read("-w0 + w", known), f"-w0 + w = {text}")

    return misprint(
        compared(printed),
        compared(correct),
        f"-w0 + w = {correct}",
        "The sign is lost. alpha - cos theta(0) < 0, so only with the minus does phi_dot have the "
        "sign of 1 - quotient, as the text goes on to say.",
        proved=True,
    )


@claim(
    "EQ-30",
    quote="since lambda=-R I3 omega_3(0)(alpha-cos theta(0))",
    where="Sec. 2.1, eq (21), after it",
    definition="at the reference start, phi_dot(0) = 0",
    control={"printed": JELLETT_AT_START.replace("I3", "I1")},
)
def jellett_of_the_start(printed: str = JELLETT_AT_START) -> Finding:
    """lambda of a start with phi_dot(0) = 0."""
    symbols = f.chart()
    started = symbols.field(f.quantity("lambda"))
    phi_dot = symbols.symbol["phi_dot"].numer
    at_rest = symbols.field(started.numer.subs(phi_dot, 0)) / symbols.field(started.denom)
    return all_of(
        f.equal(printed, at_rest, f"lambda = {printed}"),
        "Jellett's integral at phi_dot(0) = 0, for every theta(0) and omega_3(0).",
        proved=True,
    )
