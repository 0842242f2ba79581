"""Section 3, the summary: statements that are not in the previous sections."""

from __future__ import annotations

import math
from functools import partial

import pandas

from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence.formulas import equal, motion, names, parse, prove_identity, rate_of
from tt_precise.claims.evidence.run import REFERENCE, Run, Span, rows_of, variant
from tt_precise.claims.evidence.sweeps import (
    AMPLITUDES,
    CONTACTS,
    HORIZON,
    both_ways,
    of_all,
    others,
    percent,
    reference_row,
    short,
    starts,
    width,
)
from tt_precise.claims.paper import RAUCH_RUTSTAM
from tt_precise.claims.rauch_rutstam.section1_equations import FORMS
from tt_precise.claims.rauch_rutstam.section22_starts import initiations, threshold
from tt_precise.claims.rauch_rutstam.section22_sweeps import (
    ABC,
    AMONG,
    CLOSE,
    EVERY,
    T_INIT,
    TESTED,
    closeness,
    inverting,
    least_energy,
)
from tt_precise.claims.verdicts import (
    Grounds,
    Part,
    decimal,
    rounds_to,
    statement,
    statements,
)
from tt_precise.mechanics import euler
from tt_precise.mechanics.vectors import cross, dot

claim = claims_of(RAUCH_RUTSTAM, "3")
FACTOR = 10  # "large"
STARTS = ("0", "50", "83", "100", "150", "180", "195", "200")


@claim(
    "EQ-42",
    quote="the dynamical equations (2)-(6)",
    where="Sec. 3; captions of Figs 2 and 7",
    control=("partly", {"last": 5}),
    definition="numbers counted in the order of the printed equations",
)
def cross_reference(first: int = 2, last: int = 6) -> Grounds:
    """The dynamical equations are (2) to (6)."""
    cited = RAUCH_RUTSTAM.equations[first - 1 : last]
    moving = {"theta_dot": "ddth", "phi_dot": "ddph", "omega_3": "dot_om"}
    needed = [moving.get(name, name) for name in euler.EulerState._fields[1:]]
    begin, end = (RAUCH_RUTSTAM.equations.index(name) + 1 for name in (needed[0], needed[-1]))
    return (
        {
            "the numbers": statement(
                list(cited) == needed, f"({first})-({last})", f"({begin})-({end})"
            ),
            FORMS: prove_identity(FORMS),
        },
        "Five equations for the rates of theta_dot, phi_dot, omega_3, nu_x, nu_y. Eq (7) for g_n "
        "closes the system; the captions include it.",
    )


@claim(
    "QUAL-26",
    where="Summary c)",
    control=("refuted", {"phase": "climb"}),
    definition="the least phi_dot before and the largest after the initiation time A (extremum "
    "events), against the largest phi_dot at the maxima of theta before it; large: "
    f"{FACTOR} times as large",
    quote="by reversal of amplitude of oscillations of phi_dot(t) from large negative values to "
    "large positive values of phi_dot(t)",
)
def reversal_at_initiation(phase: str = "synchronisation", run: Run = REFERENCE) -> Grounds:
    """At t_init phi_dot goes from large negative to large positive values."""
    span = getattr(run, phase)
    lowest = run.extreme("phi_dot", largest=False, span=span)
    tops = run.turning_points
    tops = tops[(tops["name"] == "theta_max") & (tops["t"] < span.end) & (tops["t"] > span.begin)]
    usual = float(abs(tops["phi_dot"]).max())
    after = Span(span.end, run.equator if span.end < run.equator else run.whole.end)
    highest = run.extreme("phi_dot", largest=True, span=after)
    against = f"against {decimal(usual, 3)} rad/s at the maxima of theta"
    return (
        {
            "before": statement(
                float(lowest) < -FACTOR * usual,
                "large negative values",
                f"{lowest} rad/s, {against}",
            ),
            "after": statement(
                float(highest) > FACTOR * usual,
                "large positive values",
                f"{highest} rad/s, {against}",
            ),
        },
        "The depth depends on the distance at which the axis passes the pole, and so on the last "
        "digits of the parameters: it is ill conditioned.",
    )


@claim(
    "SUM-07",
    rule="misprint",
    where="Summary",
    control=("reproduced", {"printed": "climb"}),
    definition="theta at the end of each interval, with the times of definition A; to pi: within "
    "0.05 rad",
    quote="a naturally defined climbing time interval [0,t_{theta≈pi}-t_{theta≈0}] ... during "
    "which the angle theta increases to pi",
)
def climbing_interval(printed: str = "shifted", run: Run = REFERENCE) -> Grounds:
    """During the interval from 0 to t_end - t_init the angle theta increases to pi."""
    climb = run.climb
    ends = {
        "shifted": (climb.length, "from 0 to t_end - t_init"),
        "climb": (climb.end, "from t_init to t_end"),
    }

    def check(which: str) -> Part:
        end, words = ends[which]
        theta = run.value("theta", end)
        shown = f"theta = {decimal(theta, 4)} rad at its end, {decimal(end, 5)} s"
        return statement(math.pi - theta < 0.05, words, shown)

    return map(check, (printed, "climb")), "The climb has this length, but begins at t_init."


@claim(
    "NUM-19",
    rule="interpretations",
    where="Summary",
    control=("refuted", {"printed": "82"}),
    definition="t_init = 0 or not, in definition A; threshold as for NUM-18",
    quote="solutions with phi_dot(0)>83 rad/s start to invert directly",
)
def threshold_of_the_summary(printed: str = "83", theta: str = "0.1") -> Grounds:
    """Starts with phi_dot(0) above 83 rad/s climb at once."""
    root = threshold(theta)
    between = (float(printed) + float(root.value)) / 2
    t_init = initiations(theta, between, 0)["A"]
    return (
        {
            "as a threshold of two digits": rounds_to(printed, root, "rad/s"),
            "as it stands": statement(
                not t_init,
                f"direct above {printed}",
                f"t_init = {decimal(t_init, 3)} s at {decimal(between, 5)} rad/s",
            ),
        },
        f"Section 2.2 has the better value 83.1; up to {decimal(root.value, 7)} rad/s there is "
        "still a synchronisation phase. SWP-22 has the starts below it.",
    )


@claim(
    "SWP-22",
    where="Summary",
    definition=T_INIT,
    control=("refuted", {"limit": "90"}),
    quote="solutions with phi_dot(0)<=83 require a synchronisation time-interval for phi_dot(t), "
    "nu_x(t) and nu_y(t) before theta(t) starts to climb",
)
def needed_up_to(limit: str = "83") -> Grounds:
    """Up to phi_dot(0) = 83 rad/s a synchronisation phase comes before the climb."""

    def check(rows: pandas.DataFrame) -> Part:
        some = rows[rows["phi_dot"] <= float(limit)]
        waiting = int(some[[f"t_init_{definition}" for definition in ABC]].gt(0).all(axis=1).sum())
        return statement(0 < waiting == len(some), "t_init > 0", f"{waiting} of {len(some)} starts")

    return both_ways("phi_dot", check), "In all three definitions."


@claim(
    "SWP-19",
    finding="SWP-12",
    where="Summary",
    control=("untestable", {"series": ("theta",)}),
    definition="The climb ends in definition A, whose time is that of the reversal of phi_dot. "
    f"{TESTED} {HORIZON}",
    quote="For all tested IC the climbing time-interval ends at the ending time distinguished by "
    "another reversal of high amplitude oscillations of phi_dot(t)",
)
def ends_with_a_reversal(
    series: tuple[str, ...] = ("phi_dot", *EVERY),
) -> Grounds:
    """Every climb ends with a reversal of phi_dot."""
    check = both_ways(series, partial(inverting, how=" end so"))
    return check, "SUM-06 judges the height of these oscillations."


@claim(
    "SWP-28",
    finding="SWP-12",
    where="Summary",
    control=("refuted", {"tolerance": "0.01"}),
    definition="The first time after theta = pi/2 at which nu_y falls through nu_x, and its "
    f"distance from t_end in definition A, at most 0.1 s. {TESTED} {HORIZON}",
    quote="At t_{theta≈pi} the graph of nu_y(t) crosses the graph of nu_x(t) from above",
)
def ends_with_a_crossing(tolerance: str = "0.1") -> Grounds:
    """Every climb ends where nu_y falls below nu_x."""

    def close(rows: pandas.DataFrame) -> tuple[pandas.Series, pandas.Series]:
        apart = (rows["nu_crossing_end"] - rows["t_end_A"]).abs()
        return apart <= float(tolerance), apart

    def check(rows: pandas.DataFrame) -> Part:
        near, apart = close(rows)
        shown = f", at most {short(apart.max(), 2)} s apart"
        return of_all(rows, near, "for all tested IC", shown)

    held = starts(("phi_dot", *EVERY), "held")
    held = held[held["t_end_A"].notna()]
    return (
        both_ways(("phi_dot", *EVERY), check),
        f"Of the starts that invert and keep contact, {close(held)[0].sum()} of {len(held)} have "
        "both within that time.",
    )


@claim(
    "SWP-20",
    where="Summary",
    control=("reproduced", {"usually": "0.1"}),
    definition="Range of the quantity along the trajectory, against the reference's; "
    '"usually": for more than half of the other starts, in each of nu_x, nu_y, theta_dot. '
    f"{TESTED}",
    quote="amplitudes of oscillations for all dynamical variables usually increases",
)
def amplitudes_increase(usually: str = "0.5") -> Grounds:
    """Starts that glide or nod usually oscillate more than the reference solution."""

    def wider(rows: pandas.DataFrame, name: str) -> float:
        return float((width(others(rows), name) > width(reference_row(), name)).mean())

    ahead = starts("nu_y", "through")
    parts = {}
    for series in EVERY:
        for contact, meaning in CONTACTS.items():
            larger = {name: wider(starts(series, contact), name) for name in AMPLITUDES}
            shown = ", ".join(f"{name} {percent(part)}" for name, part in larger.items())
            parts[f"{series}, {meaning}"] = min(larger.values()) > float(usually), shown
    return (
        statements("usually increase", parts),
        "With nu_y(0) > 0 alone, theta_dot ranges wider for "
        f"{percent(wider(ahead[ahead['nu_y'] > 0], 'theta_dot'))} of the starts.",
    )


@claim(
    "SWP-21",
    rule="interpretations",
    where="Summary",
    definition=AMONG,
    control=("refuted", {"close": "0.01"}),
    quote="the total energy for the reference solution is close to the minimal value of total "
    "energy among solutions having lambda≈2lambda_thres",
)
def energy_close_to_least_energy(close: str = CLOSE) -> Grounds:
    """The energy of the reference solution is close to the least energy with its lambda."""
    _, least = least_energy()
    inverted = float(REFERENCE.thresholds.quantities["E1"].value)
    parts = {
        "among starts with theta(0) = 0.1": closeness(close, least),
        "among all states": closeness(close, inverted),
    }
    return parts, "The inverted spin, in which the top ends, has the least energy with this lambda."


@claim(
    "SUM-04",
    control=("refuted", {"torque": "dot(omega, cross(F, a))"}),
    definition="the power of the torque is omega.(a x F)",
    quote="This transfer is due to the torque that ... performs work needed for energy transfer",
)
def transfer_by_the_torque(torque: str = "dot(omega, cross(a, F))") -> Grounds:
    """The torque transfers the energy between the three modes."""
    q = motion()
    known = {"omega": q.omega, "a": q.a, "F": q.force, "dot": dot, "cross": cross}
    power = parse(torque, {**names(), **known})
    rotation = equal(power, rate_of("E_rot"), "E_rot_dot = dot(omega, cross(a, F))")
    potential = equal("0", rate_of("E_pot"), "E_pot_dot = 0")
    work = "" if potential.holds else ": m g s_dot.z is the work of the weight"
    every = statement(
        bool(rotation.holds and potential.holds),
        "due to the torque",
        f"E_pot changes without a torque{work}",
        proved=True,
    )
    return (
        {"between translation and rotation": rotation, "between all three modes": every},
        "E_trans and E_rot exchange omega.(a x F). E_trans and E_pot exchange m g s_dot.z, to "
        "which the torque does not contribute (EQ-34).",
    )


@claim(
    "SUM-06",
    rule="interpretations",
    control=("refuted", {"around": 0.001}),
    definition=f"phi_dot(0) = {', '.join(STARTS)} rad/s, otherwise the reference start, 12 s; "
    "those that invert. Peak: largest |phi_dot| at turning points of theta within 0.3 s of the "
    "ending time (definition A), against those from the equator to 0.3 s before it",
    quote="These oscillations are well visible in all graphs of a fully inverting Tippe Top",
)
def oscillations_at_the_end(around: float = 0.3, starts: tuple[str, ...] = STARTS) -> Grounds:
    """phi_dot oscillates with high amplitude at the ending time of every inverting solution."""
    peaks = [_peak(phi_dot, around) for phi_dot in starts]
    inverting = [peak for peak in peaks if peak is not None]
    smooth = _peak("195", around) or (0.0, 0.0)
    largest, usual = (min(ratios) for ratios in zip(*inverting, strict=True))
    parts = {
        name: (
            ratio >= limit,
            f"at least {decimal(ratio, 3)} times; {len(inverting)} of {len(starts)} solutions",
        )
        for name, ratio, limit in (
            ("twice as high as anything before", largest, 2),
            ("ten times as high as usual (median)", usual, 10),
        )
    }
    return (
        statements("well visible in all graphs", parts),
        "The peaks are computed as events, so no peak is missed. For the start of Fig. 8, which "
        f"the paper calls exceptionally smooth, the peak is {decimal(smooth[0], 3)} times as "
        "high.",
    )


def _peak(phi_dot: str, around: float) -> tuple[float, float] | None:
    """The peak at the ending time over the largest, and over the median, |phi_dot| before."""
    run = Run(variant(phi_dot=phi_dot, until="12")).trajectory()
    end = run.inversion.A.t_end
    if end is None:
        return None
    turns = rows_of(run, "theta_min", "theta_max")
    speed = turns["phi_dot"].astype(float).abs()
    before = speed[(turns["t"] > run.inversion.equator) & (turns["t"] < end - 0.3)]
    near = speed[abs(turns["t"] - end) < around]
    peak = float(near.max()) if len(near) else 0.0
    return peak / float(before.max()), peak / float(before.median())
