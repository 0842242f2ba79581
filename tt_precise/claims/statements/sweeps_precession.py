"""Section 2.2: how the initiation time depends on phi_dot(0)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.section22 import (
    CONTACTS,
    HORIZON,
    SECTION,
    both_ways,
    counted,
    greatest,
    losing_contact,
    number,
    reference,
    starts,
)
from tt_precise.claims.verdicts import (
    Check,
    Finding,
    about,
    all_of,
    readings,
    statement,
)

if TYPE_CHECKING:
    import pandas

DEFINITIONS = ("A", "B", "C")
DEFINITION = (
    "t_init in the definitions A (signed perigee), B (L.k = L.z) and C (phi_dot > 0), 0 where the "
    "climb is under way from the start."
)
VANISHES = "83.1"


@claim(
    "SWP-01", where=SECTION, definition=DEFINITION, control={"printed": "80.1"},
    quote="An increase of phi_dot(0) from 0 to 83.1 shortens the length of the initial "
    "synchronisation phase so that t_init goes to zero when phi_dot(0) = 83.1",
)  # fmt: skip
def shortened_to_zero(printed: str = VANISHES) -> Finding:
    """From phi_dot(0) = 0 on t_init falls, and reaches zero at phi_dot(0) = 83.1 rad/s."""
    coarse, fine = starts("phi_dot", "held"), starts("phi_dot near the end", "held")
    last = fine[fine["t_init_A"] > 0].iloc[-1]
    after = fine[fine["phi_dot"] > last["phi_dot"]].iloc[0]
    lost = _between("0", str(fine["phi_dot"].max()))
    rising = coarse[(coarse["phi_dot"] >= 0) & (coarse["phi_dot"] <= float(printed))]
    checks = {}
    for one in DEFINITIONS:
        steps = rising[f"t_init_{one}"].diff().iloc[1:]
        checks[f"t_init_{one} falls"] = statement(
            bool((steps < 0).all()),
            printed="falls",
            measured=f"in {(steps < 0).sum()} of {len(steps)} steps of 0.5 rad/s",
        )
        zero = fine["phi_dot"][fine[f"t_init_{one}"] == 0].min()
        checks[f"t_init_{one} is zero from"] = about(printed, zero, "rad/s")
    return all_of(
        checks,
        f"At {number(last['phi_dot'])} rad/s t_init_A is {number(last['t_init_A'], 2)} s, and "
        f"{number(after['t_init_A'], 2)} s at the next start, "
        f"{number(after['phi_dot'] - last['phi_dot'], 3)} rad/s on. {lost} of these starts lose "
        "contact.",
    )


@claim(
    "SWP-02", where=SECTION, definition=DEFINITION, control={"beyond": "70"},
    quote="With further increase of phi_dot(0) the synchronisation phase disappears",
)  # fmt: skip
def gone_beyond(beyond: str = VANISHES) -> Finding:
    """Beyond phi_dot(0) = 83.1 rad/s the climb is under way from the start."""

    def check(one: str) -> Check:
        rows = starts(("phi_dot", "phi_dot near the end"), "held")
        rows = rows[rows["phi_dot"] > float(beyond)]
        none = int((rows[f"t_init_{one}"] == 0).sum())
        return statement(
            0 < none == len(rows),
            printed="no synchronisation",
            measured=f"{none} of {len(rows)} starts",
        )

    return readings(
        {f"definition {one}": check(one) for one in DEFINITIONS},
        f"{_between(beyond, '200')} starts up to 200 rad/s lose contact.",
    )


@claim(
    "SWP-03", where=SECTION, control={"near": "200"},
    definition="Climbing time in definition A.",
    quote="With further increase of phi_dot(0) ... the climbing time is shortened",
)  # fmt: skip
def climb_shortened(near: str = "150", far: str = "200") -> Finding:
    """Beyond phi_dot(0) = 83.1 rad/s the climbing time falls with phi_dot(0)."""
    rows = starts("phi_dot", "held")
    rows = rows[rows["phi_dot"] > float(VANISHES)]
    least = rows.sort_values("climb_A").iloc[0]
    quickest = {one: rows.sort_values(f"climb_{one}").iloc[0]["phi_dot"] for one in DEFINITIONS}

    def check(end: str) -> Check:
        some = rows[rows["phi_dot"] <= float(end)]["climb_A"]
        return statement(
            bool((some.diff().iloc[1:] < 0).all()),
            printed="falls",
            measured=f"from {number(some.iloc[0])} s to {number(some.iloc[-1])} s at {end} rad/s",
        )

    return readings(
        {f"up to {near} rad/s": check(near), f"up to {far} rad/s": check(far)},
        f"The climbing time has a minimum, {number(least['climb_A'])} s at "
        f"{number(least['phi_dot'])} rad/s, from where on it grows; in "
        f"definition B it is at {number(quickest['B'])} rad/s, in C at {number(quickest['C'])}.",
    )


@claim(
    "SWP-04", where=SECTION, definition=f"t_init in definition A. {HORIZON}",
    control={"peak": "0"},
    quote="The initiation time also decreases as phi_dot(0) becomes negative",
)  # fmt: skip
def falls_to_the_left(peak: str = "-2.5", first: str = "0") -> Finding:
    """t_init falls from phi_dot(0) = 0 towards negative phi_dot(0)."""
    top = greatest(starts("phi_dot near the peak", "held"), "t_init_A")
    every = starts("phi_dot", "unilateral")
    lost = every[every["outcome"] == "contact_lost"]["phi_dot"].max()

    def check(start: str, contact: str) -> Check:
        rows = starts("phi_dot", contact)
        rows = rows[rows["phi_dot"] <= float(start)].iloc[::-1]
        steps = rows["t_init_A"].diff().iloc[1:]
        return statement(
            bool((steps < 0).all()),
            printed="falls",
            measured=f"in {(steps < 0).sum()} of {len(steps)} steps, from "
            f"{number(rows['t_init_A'].iloc[0])} s at {start} rad/s to "
            f"{number(rows['t_init_A'].iloc[-1])} s at {number(rows['phi_dot'].iloc[-1])} rad/s",
        )

    return readings(
        {
            f"from {start} rad/s on, {reading}": check(start, contact)
            for start in (first, peak)
            for contact, reading in CONTACTS.items()
        },
        f"Left of zero t_init first rises, to {number(top['t_init_A'])} s at "
        f"{number(top['phi_dot'])} rad/s. Starts with phi_dot(0) of {number(lost)} rad/s and less "
        "lose contact.",
    )


@claim(
    "SWP-05", where=SECTION, control={"zero": "40"},
    definition='"phi_dot(0) = 0" is read as the start itself, and as within 5 rad/s of it, a '
    f"fortieth of the half range. {DEFINITION}",
    quote="Remarkably the IC with phi_dot(0) = 0 have the longest synchronisation phase for the "
    "whole range [-200,200]",
)  # fmt: skip
def longest_at_zero(zero: str = "0") -> Finding:
    """The longest initiation time of the range belongs to phi_dot(0) of about 0."""
    rows = starts(("phi_dot", "phi_dot near the peak"), "through")
    checks = {}
    for one in DEFINITIONS:
        peak = greatest(rows, f"t_init_{one}")
        shown = f"{number(peak[f't_init_{one}'])} s at {number(peak['phi_dot'])} rad/s"
        distance = abs(peak["phi_dot"] - float(zero))
        checks[f"near zero, {one}"] = statement(distance <= 5, printed="at about 0", measured=shown)
        checks[f"at zero itself, {one}"] = statement(
            distance == 0, printed="at about 0", measured=shown
        )
    return readings(
        checks,
        "The peak is sharp and lies beside zero, where t_init_A is "
        f"{number(reference()['t_init_A'])} s.",
    )


@claim(
    "SWP-07", where=f"{SECTION}, Summary", control={"series": "box"},
    definition=f'"Inverts": the climb ends, in definition A, within the horizon. {HORIZON}',
    quote="Numerical simulations confirm that all such sample solutions invert",
)  # fmt: skip
def all_invert(series: str = "phi_dot") -> Finding:
    """Every start with phi_dot(0) in [-200, 200] inverts."""
    return readings(
        both_ways(series, inverting),
        f"But {losing_contact(series)} lose contact on the way, and the theorem that the "
        "paper appeals to says nothing about them.",
    )


@claim(
    "SWP-22", where="Summary", definition=DEFINITION, control={"limit": "90"},
    quote="solutions with phi_dot(0) <= 83 require a synchronisation time-interval before theta "
    "starts to climb",
)  # fmt: skip
def needed_up_to(limit: str = "83") -> Finding:
    """Up to phi_dot(0) = 83 rad/s a synchronisation phase comes before the climb."""

    def check(rows: pandas.DataFrame) -> Check:
        some = rows[rows["phi_dot"] <= float(limit)]
        waiting = int(some[[f"t_init_{one}" for one in DEFINITIONS]].gt(0).all(axis=1).sum())
        return statement(
            0 < waiting == len(some),
            printed="t_init > 0",
            measured=f"{waiting} of {len(some)} starts",
        )

    return readings(both_ways("phi_dot", check), "In all three definitions.")


def _between(low: str, high: str) -> str:
    """How many starts with phi_dot(0) in a range lose contact: "0 of 201"."""
    rows = starts(("phi_dot", "phi_dot near the end"), "unilateral")
    inside = (rows["phi_dot"] >= float(low)) & (rows["phi_dot"] <= float(high))
    return counted(rows[inside], "contact_lost")


def inverting(rows: pandas.DataFrame) -> Check:
    """Whether the climb of all rows ends, in definition A."""
    count = int(rows["t_end_A"].notna().sum())
    return statement(
        0 < count == len(rows), printed="all invert", measured=f"{count} of {len(rows)} invert"
    )
