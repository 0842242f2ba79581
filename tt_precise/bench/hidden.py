"""Findings about what conservation hides: lambda's drift against the error of the state."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.bench.finding import Finding, chosen

if TYPE_CHECKING:
    import pandas

PRINTED = 1e-6  # the paper's "precision of order 1e-6" of lambda; section 2.1
OWN_WAY = "SciPy odeint, Python"


def scatter(rows: pandas.DataFrame) -> pandas.DataFrame:
    """Rows of all double methods on the reference scene that have both numbers."""
    mine = chosen(rows, precision="double", horizon_s=8.0)
    return mine[(mine["jellett_drift"] > 0) & (mine["error_on_way"] > 0)]


def findings(rows: pandas.DataFrame) -> list[Finding]:
    """The largest error behind a drift as small as the paper's, and the paper's own way."""
    mine = scatter(rows)
    good = mine[mine["jellett_drift"] <= PRINTED]
    found = []
    if not good.empty:
        worst = good.sort_values("error_on_way").iloc[-1]
        found.append(
            Finding(
                "hidden by conservation",
                float(worst["error_on_way"]),
                "",
                f"largest error of the state on the way among all settings that hold lambda to "
                f"{PRINTED:.0e}: {worst['method']}, {worst['setting']}, lambda held to "
                f"{worst['jellett_drift']:.1g}",
            )
        )
    if not mine.empty:
        ratios = mine["error_on_way"] / mine["jellett_drift"]
        found.append(
            Finding(
                "error over drift, median",
                float(ratios.median()),
                "times",
                f"largest error of the state over largest drift of lambda, both on the way, over "
                f"{len(mine)} settings of all methods; the largest is {ratios.max():.1g}",
            )
        )
    own = mine[
        (mine["method"] == OWN_WAY) & (mine["formulation"] == "euler") & (mine["tolerance"] == 0)
    ]
    if not own.empty:
        row = own.iloc[0]
        found.append(
            Finding(
                "the paper's own way",
                float(row["error_on_way"]),
                "",
                "error of the state on the way with odeint's default tolerances in Euler form, "
                f"which holds lambda to {row['jellett_drift']:.1g}",
            )
        )
    return found
