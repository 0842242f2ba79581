"""The paper's figures redrawn, and what other starts do."""

from __future__ import annotations

from tt_precise.report.document import Section, Text
from tt_precise.report.figures import figures_of


def reference() -> Section:
    """The reference solution in pictures."""
    return Section(
        "figures",
        "The reference solution",
        [
            *figures_of("figures"),
            Text(
                "All pictures hold every extremum of what they show: those are found as events, "
                "not sampled. Moments of initiation and end are marked in definition A."
            ),
            Text(
                "The climb is no smooth rise: theta swings forth and back within a band that "
                "moves from the upright to the inverted pole, and phi_dot has spikes where the "
                "axis passes a pole closely."
            ),
        ],
    )


def starts() -> Section:
    """What other starts do: sweeps of section 2.2, and three maps."""
    return Section(
        "starts",
        "Other starts",
        [
            *figures_of("starts"),
            Text(
                "Section 2.2 varies the reference start. Each start is integrated twice where "
                "contact is lost: up to that moment, and on with g_n < 0 as the paper's equations "
                "would have it; the claims are judged both ways."
            ),
            Text(
                "The initiation time has a sharp peak beside the reference start, which "
                "therefore is no typical one."
            ),
        ],
    )
