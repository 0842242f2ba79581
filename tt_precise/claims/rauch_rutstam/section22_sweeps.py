"""Section 2.2: the dependence of the solutions on the start."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise

import pandas

from tt_precise.claims.claim import claims_of
from tt_precise.claims.evidence import formulas, sweeps
from tt_precise.claims.evidence.run import REFERENCE, Run, variant
from tt_precise.claims.evidence.sweeps import ALONE, AMPLITUDES, CONTACTS, greatest, short, starts
from tt_precise.claims.part import Part, about, statement, statements
from tt_precise.claims.rauch_rutstam.section1_theorem import with_the_same_lambda
from tt_precise.claims.verdicts import Grounds
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.quantities import E, E_pot, jellett
from tt_precise.runtime.values import Arithmetic
from tt_precise.scene.scene import InitialState

claim = claims_of("2.2")
ABC = ("A", "B", "C")
T_INIT = (
    "t_init in the definitions A (signed perigee), B (L.k = L.z) and C (phi_dot > 0), 0 where the "
    "climb is under way from the start."
)
VANISHES = "83.1"
CONTINUOUS = 1e-3  # A last value below this share of the first is invisible at three digits.
NEXT = "from each theta(0) to the next, 0.005 rad on; omega_3(0) = 155 rad/s"
RANGES = f"Ranges of nu_x, nu_y and theta_dot along the trajectory, {NEXT}."
CLIMBING_TIMES = f"Climbing time in definition A, {NEXT}. {sweeps.HORIZON}"
FLATTER = ("0.1", "0.08", "0.06", "0.04", "0.02", "0.01")
LIMITS = {"nu_x": "0.3", "nu_y": "0.8", "theta_dot": "15"}
EVERY = (*ALONE, "box")
TESTED = (
    "nu_x(0) in [-0.3, 0.3], nu_y(0) in [-0.8, 0.8] and theta_dot(0) in [-15, 15] one at a time, "
    "and 2,048 starts of the box of the three and phi_dot(0) in [-200, 200]."
)
INVERTS = '"Inverts": the climb ends, in definition A, within the horizon.'
ENDS = ("195", "197.5", "200")
CLOSE = "0.1"
AMONG = (
    f'"Close": at most {CLOSE} of it above the minimum. The minimum is taken among all starts with '
    "the reference's theta(0) and lambda (over phi_dot, theta_dot, nu_x, nu_y; omega_3 follows "
    "from lambda), and among all states with that lambda."
)


@claim("SWP-01", rule="interpretations", control="refuted", printed="90")
def shortened(printed: str = VANISHES) -> Grounds:
    """From phi_dot(0) = 0 to 83.1 rad/s t_init falls.

    Sec. 2.2: "An increase of phi_dot(0) from 0 to 83.1 shortens the length of the initial
    synchronisation phase"
    Definition: {T_INIT}
    Note: {lost} starts lose contact.
    """
    rows = starts("phi_dot", "held", f"0 <= phi_dot <= {printed}")
    parts = {}
    for definition in ABC:
        times = rows[f"t_init_{definition}"]
        down, steps = trend(times)
        first, last = (short(times.iloc[end], 3) for end in (0, -1))
        parts[f"definition {definition}"] = down, f"falls in {steps}, from {first} to {last} s"
    return statements("shortened", parts), {"lost": lost_between("0", printed)}


@claim("SWP-23", rule="interpretations", control="refuted", printed="80.1")
def goes_to_zero(printed: str = VANISHES) -> Grounds:
    """t_init goes to zero at phi_dot(0) = 83.1 rad/s.

    Sec. 2.2: "so that t_{theta≈0} goes to zero when phi_dot(0)≈83.1"
    Definition: {T_INIT} Tends to zero: falls below a thousandth of its first value before it
    vanishes
    Note: In definitions A, B and C alike. The last synchronisation phase is the first half
    nutation, and there is none shorter.
    """
    fine = starts("phi_dot near the end", "held")
    last = fine[fine["t_init_A"] > 0].iloc[-1]
    after = fine[fine["phi_dot"] > last["phi_dot"]].iloc[0]
    longest = starts("phi_dot", "held", "phi_dot == 0")["t_init_A"].iloc[0]
    zero = [fine["phi_dot"][fine[f"t_init_{definition}"] == 0].min() for definition in ABC]
    gone = all(about(printed, where, "rad/s").holds for where in zero)
    tends = gone and last["t_init_A"] < CONTINUOUS * longest
    shown = ", ".join(
        f"{short(row['t_init_A'], 2)} s at {short(row['phi_dot'])} rad/s" for row in (last, after)
    )
    parts = {"it is zero from there on": (gone, shown), "it tends to zero": (tends, shown)}
    return statements("to zero", parts)


@claim("SWP-02", rule="interpretations", control="refuted", beyond="70")
def gone_beyond(beyond: str = VANISHES) -> Grounds:
    """Beyond phi_dot(0) = 83.1 rad/s the climb is under way from the start.

    Sec. 2.2: "With further increase of phi_dot(0) the synchronisation phase disappears"
    Definition: {T_INIT}
    Note: {lost} starts up to 200 rad/s lose contact.
    """
    rows = starts(("phi_dot", "phi_dot near the end"), "held", f"phi_dot > {beyond}")
    none = {definition: int((rows[f"t_init_{definition}"] == 0).sum()) for definition in ABC}
    parts = {
        f"definition {definition}": (0 < count == len(rows), f"{count} of {len(rows)} starts")
        for definition, count in none.items()
    }
    return statements("no synchronisation", parts), {"lost": lost_between(beyond, "200")}


@claim("SWP-03", control="refuted", near="200")
def climb_shortened(near: str = "150", far: str = "200") -> Grounds:
    """Beyond phi_dot(0) = 83.1 rad/s the climbing time falls with phi_dot(0).

    Sec. 2.2: "With further increase of phi_dot(0) ... the climbing time is shortened"
    Definition: Climbing time in definition A
    Note: The climbing time has a minimum, {A[climb_A]:.4g} s at {A[phi_dot]:.4g} rad/s, and grows
    from there to {most[climb_A]:.4g} s at {most[phi_dot]:.4g} rad/s; in definition B it is at
    {B[phi_dot]:.4g} rad/s, in C at {C[phi_dot]:.4g}.
    """
    rows = starts("phi_dot", "held", f"phi_dot > {VANISHES}")
    parts = {}
    for name, end in ((f"up to {near} rad/s", near), ("up to the end", far)):
        times = rows["climb_A"][rows["phi_dot"] <= float(end)]
        shown = f"from {short(times.iloc[0])} s to {short(times.iloc[-1])} s at {end} rad/s"
        parts[name] = trend(times)[0], shown
    quickest = {name: rows.sort_values(f"climb_{name}").iloc[0] for name in ABC}
    return statements("falls", parts), {**quickest, "most": greatest(rows, "climb_A")}


@claim("SWP-04", control="refuted", peak="0")
def falls_to_the_left(peak: str = "-2.5", first: str = "0") -> Grounds:
    """t_init falls from phi_dot(0) = 0 towards negative phi_dot(0).

    Sec. 2.2: "The initiation time t_{theta≈0} also decreases as phi_dot(0) becomes negative"
    Definition: t_init in definition A. {sweeps.HORIZON}
    Note: Left of zero t_init first rises, to {top[t_init_A]:.4g} s at {top[phi_dot]:.4g} rad/s.
    Starts with phi_dot(0) of {lost:.4g} rad/s and less lose contact.
    """
    parts = {}
    for start in (first, peak):
        for contact, which in CONTACTS.items():
            rows = starts("phi_dot", contact, f"phi_dot <= {start}").iloc[::-1]
            down, steps = trend(rows["t_init_A"])
            begin, end = (short(rows["t_init_A"].iloc[row]) for row in (0, -1))
            at = short(rows["phi_dot"].iloc[-1])
            shown = f"in {steps}, from {begin} s at {start} rad/s to {end} s at {at} rad/s"
            parts[f"from {start} rad/s on, {which}"] = down, shown
    lost = starts("phi_dot", "unilateral", "outcome == 'contact_lost'")["phi_dot"].max()
    top = greatest(starts("phi_dot near the peak", "held"), "t_init_A")
    return statements("falls", parts), {"top": top, "lost": lost}


@claim("SWP-05", rule="interpretations", control="refuted", zero="40")
def longest_at_zero(zero: str = "0") -> Grounds:
    """The longest initiation time of the range belongs to phi_dot(0) of about 0.

    Sec. 2.2: "Remarkably the IC with phi_dot(0)≈0 have the longest synchronatisation phase for the
    whole range phi_dot(0) in [-200,200]"
    Definition: "phi_dot(0)≈0": within 5 rad/s of it, a fortieth of the half range. {T_INIT}
    Note: The peak is sharp and lies next to zero, where t_init_A is {reference[t_init_A]:.4g} s.
    """
    rows = starts(("phi_dot", "phi_dot near the peak"), "through")
    parts = {}
    for definition in ABC:
        peak = greatest(rows, f"t_init_{definition}")
        shown = f"{short(peak[f't_init_{definition}'])} s at {short(peak['phi_dot'])} rad/s"
        parts[f"definition {definition}"] = abs(peak["phi_dot"] - float(zero)) <= 5, shown
    return statements("at about 0", parts), {"reference": sweeps.reference_row()}


@claim("SWP-07", control="partly", series="box")
def all_invert(series: str = "phi_dot") -> Grounds:
    """Every start with phi_dot(0) in [-200, 200] inverts.

    Sec. 2.2, Summary: "Numerical simulations confirm that all such sample solutions invert"
    Definition: {INVERTS} {sweeps.HORIZON}
    Note: But {lost} starts lose contact, and the paper's theorem does not cover these starts.
    """
    return sweeps.both_ways(series, inverting), {"lost": sweeps.losing_contact(series)}


def lost_between(low: str, high: str) -> str:
    """Count the starts with phi_dot(0) in a range that lose contact: "0 of 201"."""
    series = ("phi_dot", "phi_dot near the end")
    return sweeps.losing_contact(series, f"{low} <= phi_dot <= {high}")


def trend(column: pandas.Series, sign: int = -1) -> tuple[bool, str]:
    """Test for a column that falls (or rises) in each step, and count: "5 of 7 steps"."""
    steps = sign * column.diff().iloc[1:]
    return bool((steps > 0).all()), f"{(steps > 0).sum()} of {len(steps)} steps"


def inverting(rows: pandas.DataFrame, how: str = " invert") -> Part:
    """Test for the end of all climbs, in definition A."""
    return sweeps.of_all(rows, rows["t_end_A"].notna(), "all invert", how)


@claim("SWP-15", control="partly", upper="0.4")
def flatter_is_calmer(upper: str = "0.1") -> Grounds:
    """Below theta(0) = 0.1 oscillations grow with theta(0).

    Sec. 2.2: "decreasing theta(0) below 0.1 reduces oscillations"
    Definition: {RANGES}
    Note: {lost} starts lose contact.
    """
    query = f"theta <= {upper}"
    lost = sweeps.losing_contact("theta", query)
    return statements("grows", _wider(starts("theta", "through", query))), {"lost": lost}


@claim("SWP-24", control="refuted", inclinations=FLATTER[::-1])
def flatter_is_smoother(inclinations: tuple[str, ...] = FLATTER) -> Grounds:
    """From theta(0) = 0.1 down, the curves of the solutions become smoother.

    Sec. 2.2: "smooths out solution curves"
    Definition: total variation (sum of all rises and falls between extrema found as events) of
    theta_dot, nu_x, nu_y and g_n over 8 s; theta(0) = {FLATTER} rad; smoother: it falls from each
    to the next
    Note: Half as steep a start leaves about half of the total variation.
    """
    parts = {}
    for name in ("theta_dot", "nu_x", "nu_y", "g_n"):
        sums = [sum(Run(variant(theta=theta)).rises_and_falls(name)) for theta in inclinations]
        falls, steps = sum(b < a for a, b in pairwise(sums)), len(sums) - 1
        shown = f"falls in {falls} of {steps} steps, from {short(sums[0], 3)} to "
        parts[name] = falls == steps, shown + short(sums[-1], 3)
    return statements("smoother", parts)


@claim("SWP-25", control="refuted", upper="0.4")
def flatter_is_slower(upper: str = "0.1") -> Grounds:
    """Below theta(0) = 0.1 the climbing time falls with theta(0).

    Sec. 2.2: "decreasing theta(0) below 0.1 ... increases the climbing time"
    Definition: {CLIMBING_TIMES}
    Note: From {least:.4g} rad on.
    """
    rows = starts("theta", "through", f"theta <= {upper}")
    return statement(*_quicker(rows)), {"least": rows["theta"].iloc[0]}


@claim("SWP-16", control="reproduced", upper="0.13")
def steeper_is_wilder(lower: str = "0.1", upper: str = "0.3") -> Grounds:
    """From theta(0) = 0.1 up, oscillations grow with theta(0).

    Sec. 2.2: "Increase of theta(0) makes amplitudes of oscillations larger"
    Definition: {RANGES}
    Note: Up to 0.3 rad, where the paper's remark on omega_3(0) begins. Starts from {lost[0]:.4g} to
    {lost[1]:.4g} rad lose contact.
    """

    def check(rows: pandas.DataFrame) -> Part:
        parts = _wider(rows)
        holds = all(up for up, _ in parts.values())
        shown = "; ".join(f"{name} {measured}" for name, (_, measured) in parts.items())
        shown = f"to {short(rows['theta'].max())} rad: {shown}"
        return statement(holds, "larger amplitudes", shown)

    parts = sweeps.both_ways("theta", check, f"{lower} <= theta <= {upper}")
    return parts, {"lost": _lost_by_inclination()}


@claim("SWP-26", control="reproduced", upper="0.13")
def steeper_is_quicker(lower: str = "0.1", upper: str = "0.3") -> Grounds:
    """From theta(0) = 0.1 up, the climbing time falls with theta(0).

    Sec. 2.2: "Increase of theta(0) ... decreases the climbing time"
    Definition: {CLIMBING_TIMES}
    Note: Starts from {lost[0]:.4g} to {lost[1]:.4g} rad lose contact. With g_n < 0 allowed, the
    climb is quickest from {quick[theta]:.4g} rad, in {quick[climb_A]:.4g} s.
    """

    def check(rows: pandas.DataFrame) -> Part:
        down, words, shown = _quicker(rows)
        return statement(down, words, f"to {short(rows['theta'].max())} rad: {shown}")

    parts = sweeps.both_ways("theta", check, f"{lower} <= theta <= {upper}")
    quick = starts("theta", "through", f"theta <= {upper}").sort_values("climb_A").iloc[0]
    return parts, {"lost": _lost_by_inclination(), "quick": quick}


@claim("SWP-17", control="refuted", beyond="0.02")
def inclination_counts(beyond: str = "0.3") -> Grounds:
    """Beyond theta(0) = 0.3 the inclination makes lambda smaller.

    Sec. 2.2: "Beyond the angle theta(0)=0.3 the term alpha-cos theta starts to play a role"
    Definition: lambda of the starts that keep omega_3(0)
    Note: At {beyond} rad lambda is {smaller:.1%} smaller than the reference's.
    """
    ratio = starts("theta", "unilateral", f"theta >= {beyond}")["lambda_ratio"]
    reference = sweeps.reference_row()["lambda_ratio"]
    shown = f"{short(ratio.iloc[0])} lambda_thres, {short(ratio.iloc[-1])} at 1 rad"
    smaller = 1 - ratio.iloc[0] / reference
    return statement((ratio < reference).all(), "lambda too small", shown), {"smaller": smaller}


@claim("SWP-27", control="refuted", beyond="0.02")
def more_spin_needed(beyond: str = "0.3") -> Grounds:
    """Beyond theta(0) = 0.3 more spin is needed for the same lambda.

    Sec. 2.2: "omega_3(0) has to be increased to keep lambda≈2lambda_thres"
    Definition: omega_3(0) with which the other start values at rest give the reference's lambda
    Note: At {beyond} rad omega_3(0) has to be {higher:.1%} higher.
    """
    spins = starts("theta at lambda", "unilateral", f"theta >= {beyond}")["omega_3"]
    spin = float(sweeps.reference_row()["omega_3"])
    holds = (spins > spin).all() and trend(spins, 1)[0]
    shown = f"{short(spins.iloc[0])} rad/s, {short(spins.iloc[-1])} at 1 rad"
    return statement(holds, "omega_3(0) increased", shown), {"higher": spins.iloc[0] / spin - 1}


def _wider(rows: pandas.DataFrame) -> dict[str, tuple[bool, str]]:
    """Test whether the ranges of the gliding velocities and of theta_dot grow from row to row."""
    trends = {name: trend(sweeps.width(rows, name), 1) for name in AMPLITUDES}
    return {f"range of {name}": (up, f"grows in {steps}") for name, (up, steps) in trends.items()}


def _quicker(rows: pandas.DataFrame) -> tuple[bool, str, str]:
    """Test whether the climbing time falls from row to row."""
    down, steps = trend(rows["climb_A"])
    first, last = (short(rows["climb_A"].iloc[end]) for end in (0, -1))
    return down, "falls", f"falls in {steps}, from {first} s to {last} s"


def _lost_by_inclination() -> tuple[float, float]:
    """The least and the largest inclination (rad) from which the top loses contact."""
    lost = starts("theta", "unilateral", "outcome == 'contact_lost'")["theta"]
    return lost.min(), lost.max()


@claim("SWP-10", control="refuted", series="phi_dot")
def synchronisation_reappears(series: str = "box", beyond: str = "83.13") -> Grounds:
    """Gliding or nodding makes some starts that climb at once need a synchronisation phase.

    Sec. 2.2: "with adding large nonzero nu_x(0), nu_y(0) or theta_dot(0) the synchronisation phase
    may reappear"
    Definition: Definition A: starts of the box with phi_dot(0) > 83.13 rad/s, which without gliding
    and nodding have none, and t_init > 0
    Note: {lost} starts in which it reappears lose contact.
    """

    def check(rows: pandas.DataFrame) -> Part:
        count = int((rows["t_init_A"] > 0).sum())
        return statement(count > 0, "may reappear", f"in {count} of {len(rows)} starts")

    query = f"phi_dot > {beyond}"
    waiting = list(starts(series, "through", f"{query} and t_init_A > 0")["index"])
    lost = sweeps.losing_contact(series, f"index in {waiting}")
    return sweeps.both_ways(series, check, query), {"lost": lost}


@claim("SWP-11", control="refuted", limit="6")
def climb_stays_short(limit: str = "8") -> Grounds:
    """The climb takes less than 7 to 8 s.

    Sec. 2.2: "the climbing time remains below 7-8 s"
    Definition: t_end - t_init in definition A, of the starts that invert. {TESTED} {sweeps.HORIZON}
    Note: The longest climb that ends within the horizon starts with {start}.
    """

    def check(rows: pandas.DataFrame) -> Part:
        longest = rows["climb_A"].max()
        return statement(longest < float(limit), f"below {limit} s", f"up to {short(longest)} s")

    longest = greatest(starts(EVERY, "through"), "climb_A")
    start = tuple(f"{name}(0) = {short(longest[name], 3)}" for name in ("phi_dot", *ALONE))
    return sweeps.both_ways(EVERY, check), {"start": start}


@claim("SWP-12", control="untestable", series=("theta",))
def still_inverts(series: tuple[str, ...] = EVERY) -> Grounds:
    """All these starts invert.

    Sec. 2.2, Summary: "the main qualitative features of inverting remain intact"
    Definition: {INVERTS} {TESTED} {sweeps.HORIZON}
    Note: {lost} starts lose contact; without these {climbed} invert. The paper's theorem does not
    cover a start that loses contact.
    """
    numbers = {"lost": sweeps.losing_contact(series), "climbed": sweeps.climbed(series, "held")}
    return sweeps.both_ways(series, partial(inverting, how="")), numbers


@claim("SWP-13", control="reproduced", factor="5")
def stays_in_the_range(factor: str = "1") -> Grounds:
    """nu_x, nu_y and theta_dot stay within the ranges named for the reference solution.

    Sec. 2.2: "oscillate strongly with amplitudes staying within the same maximal range variability
    nu_x in [-0.3,0.3], nu_y in [-0.8,0.8] and theta_dot in [-15,15]"
    Definition: Each range is the wider one of the printed and the reference solution's own.
    {TESTED} {sweeps.HORIZON}
    Note: The reference solution itself has nu_y up to {own[max_nu_y]:.3g} m/s, nu_x within
    [{own[min_nu_x]:.3g}, {own[max_nu_x]:.3g}] m/s and theta_dot within [{own[min_theta_dot]:.3g},
    {own[max_theta_dot]:.3g}] rad/s.
    """
    own = sweeps.reference_row()

    def check(rows: pandas.DataFrame) -> Part:
        inside, largest = rows["index"] >= 0, []
        for name, limit in LIMITS.items():
            ends = [f"min_{name}", f"max_{name}"]
            size = rows[ends].abs().max(axis=1)
            inside &= size <= max(float(limit), own[ends].abs().max()) * float(factor)
            largest.append(f"{name} up to {short(size.max(), 3)}")
        shown = f"{inside.sum()} of {len(rows)} starts; {', '.join(largest)}"
        return statement(inside.all(), "within the range", shown)

    return sweeps.both_ways(EVERY, check), {"own": own}


@claim("SWP-14", control="refuted", tolerance="0.01")
def small_changes(tolerance: str = "0.1") -> Grounds:
    """Perturbations of a tenth of the ranges change the inverting solution little.

    Sec. 2.2: "Small perturbations not exceeding 10 % of the range of variability ... do not change
    much the parameters and behaviour of inverting solutions"
    Definition: "Not much": at most 10 %, as much as was perturbed. 512 starts within a tenth of the
    three ranges, phi_dot(0) = 0; definition A. {sweeps.HORIZON}
    Note: {climbed} starts invert. The initiation time has a sharp peak next to the reference start
    (SWP-05).
    """
    reference, parts = sweeps.reference_row(), {}
    for contact, which in CONTACTS.items():
        rows = starts("tenth", contact)
        for name, what in (("climb_A", "climbing time"), ("t_init_A", "initiation time")):
            # NaN, and so no small change, where a start has no such time
            change = float((rows[name] / reference[name] - 1).abs().max(skipna=False))
            shown = f"by up to {100 * change:.1f} %"
            parts[f"{what}, {which}"] = change <= float(tolerance), shown
    return statements("not much", parts), {"climbed": sweeps.climbed("tenth", "through")}


@claim("SWP-08", control="refuted", starts=("0", "50"))
def very_smooth(starts: tuple[str, ...] = ENDS) -> Grounds:
    """With phi_dot(0) in [195, 200] all dynamical variables oscillate very little.

    Sec. 2.2: "solutions with very small amplitude oscillations for all dynamical variables"
    Definition: Oscillation: the smaller one of two consecutive distances of extrema (events); very
    small: the largest is below a third of the reference solution's. Starts with phi_dot(0) = {ENDS}
    rad/s over 8 s
    Note: phi_dot peaks where the axis passes near a pole, in every inverting solution (SUM-06).
    """
    runs = [Run(variant(phi_dot=phi_dot)) for phi_dot in starts]
    parts = {}
    for name in EulerState._fields:
        share = max(run.oscillation(name)[0] for run in runs) / REFERENCE.oscillation(name)[0]
        parts[name] = share < 1 / 3, f"at most {short(share, 2)} of the reference's"
    return statements("very small", parts)


@claim("SWP-09", control="refuted", theta="0.1")
def even_smoother(theta: str = "0.01") -> Grounds:
    """With theta(0) = 0.01 these solutions are smoother still.

    Sec. 2.2: "Solutions with phi_dot(0) in [195,200] become even more smooth when theta(0)=0.01"
    Definition: Smoother: the ranges of nu_x, nu_y and theta_dot along the trajectory are smaller
    than those with theta(0) = 0.1 and the same phi_dot(0)
    Note: {lost} starts lose contact.
    """
    series = "phi_dot, smooth"
    rows, others = (
        starts(series, "held", f"theta == {angle}").reset_index(drop=True)
        for angle in (theta, "0.1")
    )
    parts = {}
    for name in AMPLITUDES:
        shares = sweeps.width(rows, name) / sweeps.width(others, name)
        shown = f"{short(shares.min(), 3)} to {short(shares.max(), 3)} of that at 0.1 rad"
        parts[f"range of {name}"] = (shares < 1).all(), shown
    lost = sweeps.losing_contact(series, f"theta == {theta}")
    return statements("smaller", parts), {"lost": lost}


@claim("SWP-06", control="refuted", close="0.01")
def longest_where_energy_is_least(close: str = CLOSE) -> Grounds:
    """The energy is close to its minimum where the synchronisation phase is longest.

    Sec. 2.2, Summary: "It may be related to the fact that the total energy is close to its minimal
    value when lambda=2lambda_thres is kept fixed"
    Definition: {AMONG}
    Note: At fixed lambda it is {still:.4g} J at phi_dot(0) = 0 and {turning:.4g} J at 200 rad/s,
    where there is no synchronisation phase: closeness to the minimum does not make the phase long.
    """
    where, least = least_energy()
    longest = float(greatest(starts("phi_dot near the peak", "held"), "t_init_A")["phi_dot"])
    shown = f"t_init is longest at {short(longest)} rad/s, the energy least at {short(where)} rad/s"
    return {
        "the energy is close to its minimum": closeness(close, least),
        "the energy is least there": statement(abs(where - longest) <= 5, "related", shown),
    }, {"still": _energy("0"), "turning": _energy("200")}


@claim("SWP-18", control="partly", names=("theta_dot", "nu_x", "nu_y", "phi_dot"))
def lambda_depends_not(names: tuple[str, ...] = ("theta_dot", "nu_x", "nu_y")) -> Grounds:
    """lambda does not depend on theta_dot, nu_x and nu_y.

    Sec. 2.2: "lambda ... does not depend on theta_dot, nu_x or nu_y"
    Definition: Derivatives of -L.a by the start values, with symbols for all of them
    Note: Differentiated symbolically; lambda depends only on theta, phi_dot and omega_3.
    """
    symbols, function = formulas.chart().symbol, formulas.quantity("lambda")
    slopes = {name: function.diff(symbols[name]) for name in names}
    return {
        f"d lambda/d {name}": statement(slope == 0, "0", str(slope), proved=True)
        for name, slope in slopes.items()
    }


def closeness(close: str, least: float) -> Part:
    """Test for a reference energy at most the fraction ``close`` above ``least``."""
    energy = _energy("0")
    above = energy / least - 1
    shown = f"{short(energy)} J, {100 * above:.1f} % above {short(least)} J"
    return statement(above <= float(close), "close to minimal", shown)


def _energy(phi_dot: str) -> float:
    """E (J) of the reference start with another phi_dot and the omega_3 that keeps lambda."""
    start = InitialState.in_si(with_the_same_lambda(phi_dot), Arithmetic(math, float))
    return float(E(start.motion(math)))


def least_energy() -> tuple[float, float]:
    """phi_dot (rad/s) and E (J) at the least E for the reference's theta(0) and lambda.

    The centre of mass is at rest there. What is left, I1 sin^2 phi_dot^2/2 + I3 omega_3^2/2, is
    least at this lambda = R (I1 sin^2 phi_dot - I3 omega_3 u), u = alpha - cos, where
    omega_3 = -u phi_dot.
    """
    start = InitialState.in_si(REFERENCE.loaded, Arithmetic(math, float))
    q, body = start.motion(math), start.body
    u, s = body.alpha - q.state.kz, q.state.kx
    per_R = float(jellett(q)) / body.R
    phi_dot = per_R / (body.I1 * s * s + body.I3 * u * u)
    return phi_dot, float(per_R * phi_dot / 2 + E_pot(q))
