"""Statistics of the trade-off's tables: exponents, what conservation hides, what estimates hold."""

from __future__ import annotations

from typing import TYPE_CHECKING

OPTIMISM = 0.5  # digits that an estimate may be above the truth
from tt_precise.tradeoff import error_growth
from tt_precise.tradeoff.evaluators import MISSING, Amount
from tt_precise.tradeoff.plan import SHORT
from tt_precise.tradeoff.tables import WHOLE_S, chosen
from tt_precise.tradeoff.work_precision import slope

if TYPE_CHECKING:
    import pandas

PRINTED = 1e-6  # the paper's "precision of order 1e-6" of lambda; section 2.1
PAPER_METHOD = "SciPy odeint, Python"
BROUWER = 0.5
DIGITS_PER_BIT = 0.30103


def ladder_exponent(rows: pandas.DataFrame, column: str, low: int, high: int) -> Amount:
    """p in column ~ digits^p over the arithmetics from ``low`` to ``high`` digits."""
    mine = chosen(
        rows, method="heyoka", formulation="newton", horizon_s=float(SHORT), tolerance=0.0
    )
    digits = mine["bits"] * DIGITS_PER_BIT
    # ends that round to the number: 53 bits are 15.95 digits, 1,000 are 301
    part = mine[digits.between(low - 0.5, high + 1.5)].assign(digits=digits)
    if len(part) < 2 or part["digits"].max() <= high - 1.5:
        return MISSING
    return Amount(slope(zip(part["digits"], part[column], strict=True)))


def conservation_scatter(rows: pandas.DataFrame) -> pandas.DataFrame:
    """Rows of all double methods on the reference scene with lambda's drift and an error."""
    mine = chosen(rows, precision="double", horizon_s=WHOLE_S)
    return mine[(mine["jellett_drift"] > 0) & (mine["error_on_way"] > 0)]


def largest_hidden_error(rows: pandas.DataFrame) -> Amount:
    """The largest error behind a drift of lambda as small as the paper's."""
    mine = conservation_scatter(rows)
    good = mine[mine["jellett_drift"] <= PRINTED]
    return MISSING if good.empty else _error_and_drift(good.sort_values("error_on_way").iloc[-1])


def error_of_the_paper_s_method(rows: pandas.DataFrame) -> Amount:
    """odeint with its default tolerances, in Euler form."""
    mine = conservation_scatter(rows)
    own = mine[
        (mine["method"] == PAPER_METHOD) & (mine["formulation"] == "euler")
        & (mine["tolerance"] == 0)
    ]  # fmt: skip
    return MISSING if own.empty else _error_and_drift(own.iloc[0])


def _error_and_drift(row: pandas.Series) -> Amount:
    which = f"{row['method']}, {row['setting']}, lambda held to {row['jellett_drift']:.1g}"
    return Amount(float(row["error_on_way"]), which)


def error_over_drift(rows: pandas.DataFrame) -> Amount:
    """The median over all settings."""
    mine = conservation_scatter(rows)
    if mine.empty:
        return MISSING
    ratios = mine["error_on_way"] / mine["jellett_drift"]
    return Amount(
        float(ratios.median()),
        f"{len(mine)} settings of all methods; the largest is {ratios.max():.1g}",
    )


def growth_exponent(rows: pandas.DataFrame, scene: str, integral: str, until_s: float) -> Amount:
    """p in rms error ~ t^p over the seeds that run to ``until_s``."""
    mine = rows[rows["scene"] == scene]
    if until_s not in set(mine.groupby("seed")["t_s"].max()):
        return MISSING
    fit = error_growth.exponent(rows, scene, integral, until_s)
    off = (fit.exponent - BROUWER) / fit.error if fit.error else float("nan")
    return Amount(
        fit.exponent,
        f"{fit.seeds} seeds, standard error {fit.error:.2g} ({off:+.1f} of it from Brouwer's 1/2); "
        f"rms at the end {fit.rms_at_end:.1g}",
    )


def undelivered(estimates: pandas.DataFrame) -> Amount:
    """Scenes that did not get the digits that were requested."""
    ran = _ran(estimates)
    short = ran[ran["right"] < ran["wanted"]]
    refused = len(estimates) - len(ran)
    which = f"{len(ran)} random scenes; {refused} more were refused with an error"
    return Amount(float(len(short)), which)


def too_optimistic(estimates: pandas.DataFrame) -> Amount:
    """Scenes whose estimate exceeds the right digits by more than ``OPTIMISM``."""
    excess = _excess(estimates)
    which = f"{len(excess)}, by more than {OPTIMISM:g} digit; the worst by {excess.max():.2f}"
    return Amount(float((excess > OPTIMISM).sum()), which)


def pessimism(estimates: pandas.DataFrame) -> Amount:
    """How many digits the estimates leave unclaimed, in the median."""
    excess = _excess(estimates)
    return Amount(float(-excess.median()), f"{-excess.min():.2f} at most")


def _ran(estimates: pandas.DataFrame) -> pandas.DataFrame:
    return estimates[estimates["status"] != "raised"]


def _excess(estimates: pandas.DataFrame) -> pandas.Series:
    ran = _ran(estimates)
    return ran["estimated"] - ran["right"]
