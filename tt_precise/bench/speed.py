"""Findings about speed: what an accuracy costs, by method, and against the fastest peer.

All on the reference scene, 0 to 8 s, in double, events off and compilation apart; the accuracy is
the largest absolute error of k, L, v at the end, dimensionless; costs are interpolated on the
curve of each method.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.bench.finding import Finding, chosen, least, points, quotient
from tt_precise.bench.work_precision import cost_of

if TYPE_CHECKING:
    import pandas

ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
BARS = {1e-9: 20.0, 1e-12: 25.0}
OURS = "heyoka"
CYRK = "CyRK"
DOP853 = "SciPy DOP853"
DOP853_ACCURACY, DOP853_BAR = 1e-11, 150.0
FULL_BAR = 4.0
WHOLE_S = 8.0


def costs(rows: pandas.DataFrame, coordinates: str, cost: str) -> dict[str, dict[float, float]]:
    """For each double method what each of ``ACCURACIES`` costs, where it reaches it."""
    mine = chosen(rows, precision="double", formulation=coordinates, horizon_s=WHOLE_S)
    found: dict[str, dict[float, float]] = {}
    for method, group in mine.groupby("method", sort=False):
        curve = points(group, cost)
        prices = {a: cost_of(curve, a) for a in (*ACCURACIES, DOP853_ACCURACY)}
        found[str(method)] = {a: price for a, price in prices.items() if price is not None}
    return found


def findings(rows: pandas.DataFrame) -> list[Finding]:
    """Ratios to the peers, in both forms; in Newton's with the bars."""
    found = []
    peers = set(rows.loc[rows["peer"].astype(str) == "True", "method"])
    for coordinates in ("newton", "euler"):
        prices = costs(rows, coordinates, "ratio")
        ours = prices.get(OURS, {})
        for accuracy in ACCURACIES:
            for who, names in (
                ("any peer", peers),
                ("any peer but CyRK", {name for name in peers if not name.startswith(CYRK)}),
            ):
                theirs = {n: p[accuracy] for n, p in prices.items() if n in names and accuracy in p}
                fastest = min(theirs, key=lambda name: theirs[name], default="none")
                bar = BARS.get(accuracy) if coordinates == "newton" else None
                found.append(
                    Finding(
                        f"{who} at {accuracy:.0e}, {coordinates}",
                        quotient(theirs.get(fastest), ours.get(accuracy)),
                        "times",
                        f"time of the fastest ({fastest}) over heyoka's, to an error of "
                        f"{accuracy:.0e} at 8 s",
                        ("at least", bar) if bar else None,
                    )
                )
    prices = costs(rows, "newton", "ratio")
    ours = prices.get(OURS, {})
    scipy = least(
        price.get(DOP853_ACCURACY) for name, price in prices.items() if name.startswith(DOP853)
    )
    found.append(
        Finding(
            f"SciPy DOP853 at {DOP853_ACCURACY:.0e}, newton",
            quotient(scipy, ours.get(DOP853_ACCURACY)),
            "times",
            "time of SciPy's DOP853 with its best right-hand side over heyoka's, to an error of "
            f"{DOP853_ACCURACY:.0e} at 8 s",
            ("at least", DOP853_BAR),
        )
    )
    double = chosen(rows, method=OURS, precision="double", formulation="newton", horizon_s=WHOLE_S)
    full = chosen(double, tolerance=0.0)
    found.append(
        Finding(
            "full accuracy over 1e-6",
            quotient(least(full["ratio"]), ours.get(1e-6)),
            "times",
            "heyoka's time at its best double tolerance over that to an error of 1e-6",
            ("below", FULL_BAR),
        )
    )
    return found
