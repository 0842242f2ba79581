"""Section 2.2: other inclinations theta(0)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.claims.claim import claim
from tt_precise.claims.evidence.section22 import (
    AMPLITUDES,
    CONTACTS,
    HORIZON,
    SECTION,
    counted,
    number,
    reference,
    share,
    starts,
    width,
)
from tt_precise.claims.verdicts import Check, Finding, all_of, readings, statement

if TYPE_CHECKING:
    import pandas

DEFINITION = (
    "Ranges of nu_x, nu_y and theta_dot along the trajectory, and the climbing time in definition "
    f"A, from each theta(0) to the next, 0.005 rad on; omega_3(0) = 155 rad/s. {HORIZON}"
)


@claim(
    "SWP-15", where=SECTION, definition=DEFINITION, control={"upper": "0.4"},
    quote="decreasing theta(0) below 0.1 reduces oscillations, smooths out solution curves and "
    "increases the climbing time",
)  # fmt: skip
def flatter_is_calmer(upper: str = "0.1") -> Finding:
    """Below theta(0) = 0.1 oscillations grow and the climbing time falls with theta(0)."""
    rows, every = starts("theta", "through"), starts("theta", "unilateral")
    return all_of(
        _trend(rows[rows["theta"] <= float(upper)]),
        f"{counted(every[every['theta'] <= float(upper)], 'contact_lost')} of these starts lose "
        "contact.",
    )


@claim(
    "SWP-16", where=SECTION, definition=DEFINITION, control={"upper": "0.13"},
    quote="Increase of theta(0) makes amplitudes of oscillations larger and decreases the "
    "climbing time",
)  # fmt: skip
def steeper_is_wilder(lower: str = "0.1", upper: str = "0.3") -> Finding:
    """From theta(0) = 0.1 up, oscillations grow and the climbing time falls with theta(0)."""
    every = starts("theta", "unilateral")
    lost = every[every["outcome"] == "contact_lost"]["theta"].min()
    through = starts("theta", "through")
    quick = through[through["theta"] <= float(upper)].sort_values("climb_A").iloc[0]

    def check(contact: str) -> Check:
        rows = starts("theta", contact)
        rows = rows[(rows["theta"] >= float(lower)) & (rows["theta"] <= float(upper))]
        parts = _trend(rows)
        return statement(
            all(part.holds for part in parts.values()),
            printed="larger amplitudes, shorter climb",
            measured=f"to {number(rows['theta'].max())} rad: "
            + "; ".join(f"{name} {part.measured}" for name, part in parts.items()),
        )

    return readings(
        {reading: check(contact) for contact, reading in CONTACTS.items()},
        "Up to 0.3 rad, where the paper's remark on omega_3(0) begins. Starts from "
        f"{number(lost)} rad on lose contact; integrated on, the climb is quickest from "
        f"{number(quick['theta'])} rad, in {number(quick['climb_A'])} s.",
    )


@claim(
    "SWP-17", where=SECTION, control={"beyond": "0.02"},
    definition="omega_3(0) with which the other start values at rest give the reference's lambda.",
    quote="Beyond the angle theta(0)=0.3 the term alpha - cos theta starts to play a role and "
    "omega_3(0) has to be increased to keep lambda = 2 lambda_thres",
)  # fmt: skip
def more_spin_needed(beyond: str = "0.3") -> Finding:
    """Beyond theta(0) = 0.3 more spin is needed for the same lambda."""
    fixed, free = starts("theta at lambda", "unilateral"), starts("theta", "unilateral")
    spins = fixed[fixed["theta"] >= float(beyond)]["omega_3"]
    ratio = free[free["theta"] >= float(beyond)]["lambda_ratio"]
    spin = float(reference()["omega_3"])
    return all_of(
        {
            "omega_3(0) kept": statement(
                bool((ratio < reference()["lambda_ratio"]).all()),
                printed="lambda too small",
                measured=f"{number(ratio.iloc[0])} lambda_thres, {number(ratio.iloc[-1])} at 1 rad",
            ),
            "lambda kept": statement(
                bool((spins > spin).all() and (spins.diff().iloc[1:] > 0).all()),
                printed="omega_3(0) increased",
                measured=f"{number(spins.iloc[0])} rad/s, {number(spins.iloc[-1])} at 1 rad",
            ),
        },
        f"At {beyond} rad omega_3(0) has to be {share(spins.iloc[0] / spin - 1)} higher.",
    )


def _trend(rows: pandas.DataFrame) -> dict[str, Check]:
    checks = {}
    for name in AMPLITUDES:
        steps = width(rows, name).diff().iloc[1:]
        checks[f"range of {name}"] = statement(
            bool((steps > 0).all()),
            printed="grows",
            measured=f"grows in {(steps > 0).sum()} of {len(steps)} steps",
        )
    steps = rows["climb_A"].diff().dropna()
    checks["climbing time"] = statement(
        bool((steps < 0).all()) and not rows["climb_A"].isna().any(),
        printed="falls",
        measured=f"falls in {(steps < 0).sum()} of {len(steps)} steps, from "
        f"{number(rows['climb_A'].iloc[0])} s to {number(rows['climb_A'].iloc[-1])} s",
    )
    return checks
