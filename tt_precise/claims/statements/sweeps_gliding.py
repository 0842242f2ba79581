"""Section 2.2: starts that glide or nod, in nu_x, nu_y and theta_dot one by one and at random."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.section22 import (
    ALONE,
    AMPLITUDES,
    CONTACTS,
    HORIZON,
    SECTION,
    both_ways,
    counted,
    greatest,
    losing_contact,
    number,
    reference,
    share,
    starts,
    width,
)
from tt_precise.claims.verdicts import Check, Finding, readings, statement

if TYPE_CHECKING:
    import pandas

RANGES = {"nu_x": "0.3", "nu_y": "0.8", "theta_dot": "15"}
EVERY = (*ALONE, "box")
TESTED = (
    "nu_x(0) in [-0.3, 0.3], nu_y(0) in [-0.8, 0.8] and theta_dot(0) in [-15, 15] one at a time, "
    "and 2,048 starts of the box of the three and phi_dot(0) in [-200, 200]."
)
INVERTS = '"Inverts": the climb ends, in definition A, within the horizon.'


@claim(
    "SWP-10", where=SECTION, control={"series": "phi_dot"},
    definition="Definition A: starts of the box with phi_dot(0) > 83.13 rad/s, which without "
    "gliding and nodding have none, and t_init > 0.",
    quote="with adding large nonzero nu_x(0), nu_y(0) or theta_dot(0) the synchronisation phase "
    "may reappear",
)  # fmt: skip
def synchronisation_reappears(series: str = "box", beyond: str = "83.13") -> Finding:
    """Some starts that would climb at once need a synchronisation phase when they glide or nod."""

    def check(rows: pandas.DataFrame) -> Check:
        some = rows[rows["phi_dot"] > float(beyond)]
        count = int((some["t_init_A"] > 0).sum())
        return statement(
            count > 0, printed="may reappear", measured=f"in {count} of {len(some)} starts"
        )

    every = starts(series, "unilateral")
    through = starts(series, "through")
    waiting = through[(through["phi_dot"] > float(beyond)) & (through["t_init_A"] > 0)]
    again = every[every["index"].isin(waiting["index"])]
    return readings(
        both_ways(series, check),
        f"{counted(again, 'contact_lost')} starts in which it reappears lose contact.",
    )


@claim(
    "SWP-11", where=SECTION, control={"limit": "6"},
    definition=f"t_end - t_init in definition A, of the starts that invert. {TESTED} {HORIZON}",
    quote="the climbing time remains below 7-8 s",
)  # fmt: skip
def climb_stays_short(limit: str = "8") -> Finding:
    """The climb takes less than 7 to 8 s."""

    def check(rows: pandas.DataFrame) -> Check:
        longest = greatest(rows, "climb_A")
        return statement(
            longest["climb_A"] < float(limit),
            printed=f"below {limit} s",
            measured=f"up to {number(longest['climb_A'])} s",
        )

    longest = greatest(starts(EVERY, "through"), "climb_A")
    return readings(
        both_ways(EVERY, check),
        f"The longest climb starts with {_start_of(longest)}.",
    )


@claim(
    "SWP-12", where=f"{SECTION}, Summary", control={"series": ("theta",)},
    definition=f"{INVERTS} {TESTED} {HORIZON}",
    quote="the main qualitative features of inverting remain intact",
)  # fmt: skip
def still_inverts(series: tuple[str, ...] = EVERY) -> Finding:
    """All these starts invert."""

    def check(rows: pandas.DataFrame) -> Check:
        count = int(rows["t_end_A"].notna().sum())
        return statement(
            0 < count == len(rows), printed="all invert", measured=f"{count} of {len(rows)}"
        )

    return readings(
        both_ways(series, check),
        f"{losing_contact(series)} lose contact; without these "
        f"{counted(starts(series, 'held'), 'inverts')} invert. The paper's theorem says nothing "
        "about a start that loses contact.",
    )


@claim(
    "SWP-13", where=SECTION, control={"factor": "5"}, definition=f"{TESTED} {HORIZON}",
    quote="oscillate strongly with amplitudes staying within the same maximal range variability "
    "nu_x in [-0.3,0.3], nu_y in [-0.8,0.8] and theta_dot in [-15,15]",
)  # fmt: skip
def stays_in_the_range(factor: str = "1") -> Finding:
    """nu_x, nu_y and theta_dot stay within the ranges named for the reference solution."""

    def check(rows: pandas.DataFrame) -> Check:
        inside = 0 * rows["index"] == 0
        largest = []
        for name, limit in RANGES.items():
            size = rows[[f"min_{name}", f"max_{name}"]].abs().max(axis=1)
            inside &= size <= float(limit) * float(factor)
            largest.append(f"{name} up to {number(size.max(), 3)}")
        return statement(
            bool(inside.all()),
            printed="within the range",
            measured=f"{inside.sum()} of {len(rows)} starts; {', '.join(largest)}",
        )

    known = reference()
    return readings(
        both_ways(EVERY, check),
        f"The reference solution itself has nu_y up to {number(known['max_nu_y'], 3)} m/s, nu_x "
        f"within [{number(known['min_nu_x'], 3)}, {number(known['max_nu_x'], 3)}] m/s and "
        f"theta_dot within [{number(known['min_theta_dot'], 3)}, "
        f"{number(known['max_theta_dot'], 3)}] rad/s.",
    )


@claim(
    "SWP-14", where=SECTION, control={"tolerance": "0.01"},
    definition='"Not much": at most 10 %, as much as was perturbed. 512 starts within a tenth of '
    f"the three ranges, phi_dot(0) = 0; definition A. {HORIZON}",
    quote="Small perturbations not exceeding 10 % of the range of variability ... do not change "
    "much the parameters and behaviour of inverting solutions",
)  # fmt: skip
def small_changes(tolerance: str = "0.1") -> Finding:
    """Perturbations of a tenth of the ranges change the inverting solution little."""
    known = reference()
    checks = {}
    for contact, reading in CONTACTS.items():
        rows = starts("tenth", contact)
        for name, what in (("climb_A", "climbing time"), ("t_init_A", "initiation time")):
            # NaN, and so no small change, where a start has no such time
            change = float((rows[name] / known[name] - 1).abs().max(skipna=False))
            checks[f"{what}, {reading}"] = statement(
                change <= float(tolerance),
                printed="not much",
                measured=f"by up to {share(change)}",
            )
    return readings(
        checks,
        f"{counted(starts('tenth', 'through'), 'inverts')} starts invert. The initiation time has "
        "a sharp peak beside the reference start (SWP-05).",
    )


@claim(
    "SWP-19", where="Summary", control={"tolerance": "0.01"},
    definition="The first time after theta = pi/2 at which nu_y falls through nu_x, and its "
    f"distance from t_end in definition A, at most 0.1 s. {TESTED} {HORIZON}",
    quote="For all tested IC the climbing time-interval ends at the ending time ... the graph of "
    "nu_y crosses the graph of nu_x from above",
)  # fmt: skip
def ends_with_a_crossing(tolerance: str = "0.1") -> Finding:
    """Every climb ends with a reversal of phi_dot, at which nu_y falls below nu_x."""

    def check(rows: pandas.DataFrame) -> Check:
        apart = (rows["nu_crossing_end"] - rows["t_end_A"]).abs()
        count = int((apart <= float(tolerance)).sum())
        return statement(
            0 < count == len(rows),
            printed="for all tested IC",
            measured=f"{count} of {len(rows)}, at most {number(apart.max(), 2)} s apart",
        )

    held = starts(("phi_dot", *EVERY), "held")
    held = held[held["outcome"] == "inverts"]
    near = int(((held["nu_crossing_end"] - held["t_end_A"]).abs() <= float(tolerance)).sum())
    return readings(
        both_ways(("phi_dot", *EVERY), check),
        f"Of the starts that invert and keep contact, {near} of {len(held)} have both "
        "within that time.",
    )


@claim(
    "SWP-20", where="Summary", control={"usually": "0.1"},
    definition="Range of the quantity along the trajectory, against the reference's; "
    f'"usually": for more than half of the starts, in each of nu_x, nu_y, theta_dot. {TESTED}',
    quote="amplitudes of oscillations for all dynamical variables usually increases",
)  # fmt: skip
def amplitudes_increase(usually: str = "0.5") -> Finding:
    """Starts that glide or nod usually oscillate more than the reference solution."""
    known = reference()
    ahead = starts("nu_y", "through")
    ahead = ahead[ahead["nu_y"] > 0]
    calm = float((width(ahead, "theta_dot") > width(known, "theta_dot")).mean())

    def check(series: str, contact: str) -> Check:
        rows = starts(series, contact)
        larger = {
            name: float((width(rows, name) > width(known, name)).mean()) for name in AMPLITUDES
        }
        shown = ", ".join(f"{name} {share(part)}" for name, part in larger.items())
        return statement(
            all(part > float(usually) for part in larger.values()),
            printed="usually increase",
            measured=shown,
        )

    return readings(
        {
            f"{series}, {reading}": check(series, contact)
            for series in EVERY
            for contact, reading in CONTACTS.items()
        },
        f"With nu_y(0) > 0 alone, theta_dot ranges wider for {share(calm)} of the starts.",
    )


def _start_of(row: pandas.Series) -> str:
    """The start values of a row that the section varies, in words."""
    return ", ".join(f"{name}(0) = {number(row[name], 3)}" for name in ("phi_dot", *ALONE))
