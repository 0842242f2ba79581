"""Findings about the knob: what ``digits=`` delivers, and how good its estimates are."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.bench.estimates import OPTIMISM
from tt_precise.bench.finding import Finding

if TYPE_CHECKING:
    import pandas


def findings(estimates: pandas.DataFrame) -> list[Finding]:
    """From the table of ``tt_precise.bench.estimates``: seeded random scenes with a wish each."""
    ran = estimates[estimates["status"] != "raised"]
    excess = ran["estimated"] - ran["right"]
    short = ran[ran["right"] < ran["wanted"]]
    refused = len(estimates) - len(ran)
    return [
        Finding(
            "digits wished for and not delivered",
            float(len(short)),
            "scenes",
            f"of {len(ran)} random scenes; {refused} more were refused with an error",
            ("below", 1.0),
        ),
        Finding(
            "estimates too optimistic",
            float((excess > OPTIMISM).sum()),
            "scenes",
            f"of {len(ran)}, by more than {OPTIMISM:g} digit; the worst by {excess.max():.2f}",
            ("below", 1.0),
        ),
        Finding(
            "pessimism of the estimates",
            float((ran["right"] - ran["estimated"]).median()),
            "digits",
            f"median of right digits less estimated ones; {-excess.min():.2f} at most",
        ),
    ]
