"""Section 3, the summary: statements that are not in the previous sections."""

from __future__ import annotations

import math
from functools import partial

import pandas

from tt_precise.claims import part
from tt_precise.claims.claim import EQUATIONS, claims_of
from tt_precise.claims.evidence import formulas, sweeps
from tt_precise.claims.evidence.run import REFERENCE, Run, Span, rows_of, variant
from tt_precise.claims.part import Part, decimal, statement, statements
from tt_precise.claims.rauch_rutstam import section22_starts, section22_sweeps
from tt_precise.claims.rauch_rutstam.section1_equations import FORMS
from tt_precise.claims.rauch_rutstam.section22_sweeps import ABC, CLOSE, EVERY, closeness, inverting
from tt_precise.claims.verdicts import Grounds
from tt_precise.mechanics import euler

claim = claims_of("3")
FACTOR = 10  # Least ratio to the usual size that counts as large.
STARTS = ("0", "50", "83", "100", "150", "180", "195", "200")
WITH_PRECESSION = ("phi_dot", *EVERY)  # Series of the statements about all tested starts.
NEAR_S = 0.3  # Distance in s from the ending time, within which its peak is sought.


@claim("EQ-42", control="partly", last=5)
def cross_reference(first: int = 2, last: int = 6) -> Grounds:
    """The dynamical equations are (2) to (6).

    Sec. 3; captions of Figs 2 and 7: "the dynamical equations (2)-(6)"
    Definition: numbers counted in the order of the printed equations
    Note: Five equations for the rates of theta_dot, phi_dot, omega_3, nu_x, nu_y. Eq (7) for g_n
    closes the system; the captions include it.
    """
    moving = {"theta_dot": "ddth", "phi_dot": "ddph", "omega_3": "dot_om"}
    needed = [moving.get(name, name) for name in euler.EulerState._fields[1:]]
    begin, end = (EQUATIONS.index(name) + 1 for name in (needed[0], needed[-1]))
    right = list(EQUATIONS[first - 1 : last]) == needed
    numbers = statement(right, f"({first})-({last})", f"({begin})-({end})")
    return {"the numbers": numbers, FORMS: formulas.prove_identity(FORMS)}


@claim("QUAL-26", control="refuted", phase="climb")
def reversal_at_initiation(phase: str = "synchronisation", run: Run = REFERENCE) -> Grounds:
    """At t_init phi_dot goes from large negative to large positive values.

    Summary c): "by reversal of amplitude of oscillations of phi_dot(t) from large negative values
    to large positive values of phi_dot(t)"
    Definition: the least phi_dot before and the largest after the initiation time A (extremum
    events), against the largest phi_dot at the maxima of theta before it; large: {FACTOR} times as
    large
    Note: The depth depends on the distance at which the axis passes the pole, and so on the last
    digits of the parameters: it is ill conditioned.
    """
    span = getattr(run, phase)
    after = Span(span.end, run.equator if span.end < run.equator else run.whole.end)
    lowest = run.extreme("phi_dot", largest=False, span=span)
    highest = run.extreme("phi_dot", largest=True, span=after)
    tops = run.events("theta_max")
    usual = float(
        abs(tops["phi_dot"][tops["t"].between(span.begin, span.end, inclusive="neither")]).max()
    )
    against = f"rad/s, against {decimal(usual, 3)} rad/s at the maxima of theta"
    falls, rises = float(lowest) < -FACTOR * usual, float(highest) > FACTOR * usual
    return {
        "before": statement(falls, "large negative values", f"{lowest} {against}"),
        "after": statement(rises, "large positive values", f"{highest} {against}"),
    }


@claim("SUM-07", rule="misprint", control="reproduced", printed="climb")
def climbing_interval(printed: str = "shifted", run: Run = REFERENCE) -> Grounds:
    """During the interval from 0 to t_end - t_init the angle theta increases to pi.

    Summary: "a naturally defined climbing time interval [0,t_{theta≈pi}-t_{theta≈0}] ... during
    which the angle theta increases to pi"
    Definition: theta at the end of each interval, with the times of definition A; to pi: within
    0.05 rad
    Note: The climb has this length, but begins at t_init.
    """
    words = {"shifted": "from 0 to t_end - t_init", "climb": "from t_init to t_end"}
    ends = {"shifted": run.climb.length, "climb": run.climb.end}

    def compare(interval: str) -> Part:
        theta = run.value("theta", ends[interval])
        shown = f"theta = {decimal(theta, 4)} rad at its end, {decimal(ends[interval], 5)} s"
        return statement(math.pi - theta < 0.05, words[interval], shown)

    return part.misprint(compare, printed, "climb")


@claim("NUM-19", rule="interpretations", control="refuted", printed="82")
def threshold_of_the_summary(printed: str = "83", theta: str = "0.1") -> Grounds:
    """Starts with phi_dot(0) above 83 rad/s climb at once.

    Summary: "solutions with phi_dot(0)>83 rad/s start to invert directly"
    Definition: t_init = 0 or not, in definition A; threshold as for NUM-18
    Note: Section 2.2 has the better value 83.1; up to {root.value:7} rad/s there is still a
    synchronisation phase. SWP-22 has the starts below it.
    """
    root = section22_starts.threshold(theta)
    between = (float(printed) + float(root.value)) / 2
    t_init = section22_starts.initiations(theta, between, 0)["A"]
    shown = f"t_init = {decimal(t_init, 3)} s at {decimal(between, 5)} rad/s"
    return {
        "as a threshold of two digits": part.rounds_to(printed, root, "rad/s"),
        "as it stands": statement(not t_init, f"direct above {printed}", shown),
    }, {"root": root}


@claim("SWP-22", control="refuted", limit="90")
def needed_up_to(limit: str = "83") -> Grounds:
    """Up to phi_dot(0) = 83 rad/s a synchronisation phase comes before the climb.

    Summary: "solutions with phi_dot(0)<=83 require a synchronisation time-interval for phi_dot(t),
    nu_x(t) and nu_y(t) before theta(t) starts to climb"
    Definition: {section22_sweeps.T_INIT}
    Note: In all three definitions.
    """

    def check(rows: pandas.DataFrame) -> Part:
        rows = rows[rows["phi_dot"] <= float(limit)]
        waiting = int(rows[[f"t_init_{definition}" for definition in ABC]].gt(0).all(axis=1).sum())
        shown = f"{waiting} of {len(rows)} starts"
        return statement(0 < waiting == len(rows), "t_init > 0", shown)

    return sweeps.both_ways("phi_dot", check)


@claim("SWP-19", finding="SWP-12", control="untestable", series=("theta",))
def ends_with_a_reversal(series: tuple[str, ...] = WITH_PRECESSION) -> Grounds:
    """Every climb ends with a reversal of phi_dot.

    Summary: "For all tested IC the climbing time-interval ends at the ending time distinguished by
    another reversal of high amplitude oscillations of phi_dot(t)"
    Definition: The climb ends in definition A, whose time is that of the reversal of phi_dot.
    {section22_sweeps.TESTED} {sweeps.HORIZON}
    Note: SUM-06 judges the height of these oscillations.
    """
    return sweeps.both_ways(series, partial(inverting, how=" end so"))


@claim("SWP-28", finding="SWP-12", control="refuted", tolerance="0.01")
def ends_with_a_crossing(tolerance: str = "0.1") -> Grounds:
    """Every climb ends where nu_y falls below nu_x.

    Summary: "At t_{theta≈pi} the graph of nu_y(t) crosses the graph of nu_x(t) from above"
    Definition: The first time after theta = pi/2 at which nu_y falls through nu_x, and its distance
    from t_end in definition A, at most 0.1 s. {section22_sweeps.TESTED} {sweeps.HORIZON}
    Note: Of the starts that invert and keep contact, {near} of {inverting} have both within that
    time.
    """

    def apart(rows: pandas.DataFrame) -> pandas.Series:
        return (rows["nu_crossing_end"] - rows["t_end_A"]).abs()

    def check(rows: pandas.DataFrame) -> Part:
        distances = apart(rows)
        shown = f", at most {sweeps.short(distances.max(), 2)} s apart"
        return sweeps.of_all(rows, distances <= float(tolerance), "for all tested IC", shown)

    inverting = sweeps.starts(WITH_PRECESSION, "held", "t_end_A.notna()")
    near = (apart(inverting) <= float(tolerance)).sum()
    numbers = {"near": near, "inverting": len(inverting)}
    return sweeps.both_ways(WITH_PRECESSION, check), numbers


@claim("SWP-20", control="reproduced", usually="0.1")
def amplitudes_increase(usually: str = "0.5") -> Grounds:
    """Starts that glide or nod usually oscillate more than the reference solution.

    Summary: "amplitudes of oscillations for all dynamical variables usually increases"
    Definition: Range of the quantity along the trajectory, against the reference's; "usually": for
    more than half of the other starts, in each of nu_x, nu_y, theta_dot. {section22_sweeps.TESTED}
    Note: With nu_y(0) > 0 alone, theta_dot ranges wider for {ahead:.1%} of the starts.
    """
    reference = sweeps.reference_row()

    def wider(rows: pandas.DataFrame, name: str) -> float:
        widths = sweeps.width(sweeps.others(rows), name)
        return float((widths > sweeps.width(reference, name)).mean())

    parts = {}
    for series in EVERY:
        for contact, meaning in sweeps.CONTACTS.items():
            rows = sweeps.starts(series, contact)
            shares = {name: wider(rows, name) for name in sweeps.AMPLITUDES}
            shown = ", ".join(f"{name} {100 * share:.1f} %" for name, share in shares.items())
            parts[f"{series}, {meaning}"] = min(shares.values()) > float(usually), shown
    ahead = sweeps.starts("nu_y", "through").query("nu_y > 0")
    return statements("usually increase", parts), {"ahead": wider(ahead, "theta_dot")}


@claim("SWP-21", rule="interpretations", control="refuted", close="0.01")
def energy_close_to_least_energy(close: str = CLOSE) -> Grounds:
    """The energy of the reference solution is close to the least energy with its lambda.

    Summary: "the total energy for the reference solution is close to the minimal value of total
    energy among solutions having lambda≈2lambda_thres"
    Definition: {section22_sweeps.AMONG}
    Note: The inverted spin, in which the top ends, has the least energy with this lambda.
    """
    _, least = section22_sweeps.least_energy()
    inverted = float(REFERENCE.thresholds.quantities["E1"].value)
    return {
        "among starts with theta(0) = 0.1": closeness(close, least),
        "among all states": closeness(close, inverted),
    }


@claim("SUM-04", control="refuted", torque="dot(omega, cross(F, a))")
def transfer_by_the_torque(torque: str = "dot(omega, cross(a, F))") -> Grounds:
    """The torque transfers the energy between the three modes.

    Sec. 3: "This transfer is due to the torque that ... performs work needed for energy transfer"
    Definition: the power of the torque is omega.(a x F)
    Note: E_trans and E_rot exchange omega.(a x F). E_trans and E_pot exchange m g s_dot.z, to which
    the torque does not contribute (EQ-34).
    """
    rotation = formulas.identity(torque, "rate_of('E_rot')", "E_rot_dot = dot(omega, cross(a, F))")
    potential = formulas.identity("0", "rate_of('E_pot')", "E_pot_dot = 0")
    work = "" if potential.holds else ": m g s_dot.z is the work of the weight"
    shown = f"E_pot changes without a torque{work}"
    holds = rotation.holds and potential.holds
    return {
        "between translation and rotation": rotation,
        "between all three modes": statement(holds, "due to the torque", shown, proved=True),
    }


@claim("SUM-06", rule="interpretations", control="refuted", around=0.001)
def oscillations_at_the_end(around: float = NEAR_S, starts: tuple[str, ...] = STARTS) -> Grounds:
    """phi_dot oscillates with high amplitude at the ending time of every inverting solution.

    Sec. 3: "These oscillations are well visible in all graphs of a fully inverting Tippe Top"
    Definition: phi_dot(0) = {STARTS} rad/s, otherwise the reference start, 12 s; those that invert.
    Peak: largest |phi_dot| at turning points of theta within {NEAR_S} s of the ending time
    (definition A), against those from the equator to {NEAR_S} s before it
    Note: The peaks are computed as events, so no peak is missed. For the start of Fig. 8, which the
    paper calls exceptionally smooth, the peak is {smooth[0]:3} times as high.
    """
    peaks = [peak for phi_dot in starts if (peak := _peak(phi_dot, around)) is not None]
    over_largest, over_usual = (min(ratios) for ratios in zip(*peaks, strict=True))
    limits = {
        "twice as high as anything before": (over_largest, 2),
        "ten times as high as usual (median)": (over_usual, 10),
    }
    parts = {
        name: (
            ratio >= limit,
            f"at least {decimal(ratio, 3)} times; {len(peaks)} of {len(starts)} solutions",
        )
        for name, (ratio, limit) in limits.items()
    }
    smooth = _peak("195", around) or (0.0, 0.0)
    return statements("well visible in all graphs", parts), {"smooth": smooth}


def _peak(phi_dot: str, around: float) -> tuple[float, float] | None:
    """The peak at the ending time over the largest, and over the median, |phi_dot| before."""
    run = Run(variant(phi_dot=phi_dot, until="12")).trajectory()
    end = run.inversion.A.t_end
    if end is None:
        return None
    turns = rows_of(run, "theta_min", "theta_max")
    speed = turns["phi_dot"].astype(float).abs()
    before = speed[(turns["t"] > run.inversion.equator) & (turns["t"] < end - NEAR_S)]
    peak = speed[abs(turns["t"] - end) < around].max()
    peak = 0.0 if math.isnan(peak) else float(peak)
    return peak / float(before.max()), peak / float(before.median())
