"""Findings from the tables of ``benchmarks.work_precision``: costs, ratios, exponents.

By default a finding is about the reference scene, 0 to 8 s, in double, without events and without
compilation. An error is the largest absolute error of k, L, v at the end, dimensionless.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy
import pandas

from tt_precise.claims.claim import LAMBDA_KEPT
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.values import Array

SCENE = "reference"
WORKLOAD = "reference workload"
EVENTS = ("contact watched", "one event", "all events")
RECORDS = ("records phi", "records x", "records phi, psi, x, y")
SHORT = "0.1"  # Horizon in s of the ladder to 1,000 bits, of which 8 s would take an hour.
LADDER = (113, 167, 200, 333, 500, 665, 1000)  # Bits of the ladder, which are 34 to 301 digits.
TABLE, GROWTH, ESTIMATES = "tradeoff.csv", "tradeoff-growth.csv", "estimates.csv"
ACCURACIES = (1e-3, 1e-6, 1e-9, 1e-12)
WHOLE_S = 8.0  # Horizon of the reference scene in s.
FORMULATIONS = ("newton", "euler")
BARE = "heyoka"
WATCHED = "contact watched"
# Each variant, and the variant to whose time its own is compared.
VARIANTS = {
    WATCHED: "",
    **dict.fromkeys((*EVENTS[1:], *RECORDS), WATCHED),
    **dict.fromkeys(("high_accuracy", "fast_math", "compact_mode"), ""),
}
WIDE = (("quad", 30), ("mp", 50))  # Wide arithmetics with their digits.
# Pairs of digits to compare; above 34 digits all arithmetic is software.
SPANS = ((16, 300), (34, 300), (34, 100), (100, 300))
# The scenes of the long runs, and the integrals with their symbols.
LONG_SCENES = ("frictionless", "rolling")
GROWING = {"jellett": "lambda", "energy": "E"}
PAPER_METHOD = "SciPy odeint, Python"
# Exponent of time with which the error of an integral grows (D. Brouwer, Astron. J. 46, 1937):
# without truncation roundings are practically random; a systematic part would grow as t.
BROUWER = 0.5
DIGITS_PER_BIT = 0.30103
OPTIMISM = 0.3  # Digits by which an estimate may exceed the truth.


class TradeoffTables(NamedTuple):
    """The measured tables; None for a missing table."""

    rows: pandas.DataFrame | None
    long_runs: pandas.DataFrame | None = None
    estimates: pandas.DataFrame | None = None


def load(folder: Path) -> TradeoffTables:
    """The tables in a folder."""
    files = [folder / name for name in (TABLE, GROWTH, ESTIMATES)]
    return TradeoffTables(*(pandas.read_csv(file) if file.is_file() else None for file in files))


class Finding(Record, frozen=True):
    """A number from the tables, with its definition."""

    name: Annotated[str, means("what it is")]
    value: Annotated[float, means("its value")]
    definition: Annotated[str, means("how it is computed")]
    unit: Annotated[str, means("its unit")] = "times"

    def __str__(self) -> str:
        return f"{self.name}: {f'{self.value:.3g} {self.unit}'.strip()}  ({self.definition})"


def findings(tables: TradeoffTables) -> list[Finding]:
    """All findings from the tables."""
    computed = (
        finding
        for compute, table in (
            (_peers, tables.rows),
            (_variants, tables.rows),
            (_digits, tables.rows),
            (_machine, tables.rows),
            (_conservation, tables.rows),
            (_growth, tables.long_runs),
            (_estimates, tables.estimates),
        )
        if table is not None
        for finding in compute(table)
    )
    return [finding for finding in computed if not math.isnan(finding.value)]


class Point(NamedTuple):
    """A setting of a method: its error and its cost, both above 0."""

    error: float
    cost: float


def front(points: Iterable[Point]) -> list[Point]:
    """The points that no other point beats in error and cost, the cheapest first."""
    best: list[Point] = []
    for point in sorted(points, key=lambda p: (p.cost, p.error)):
        if not best or point.error < best[-1].error:
            best.append(point)
    return best


def cost_of(points: Iterable[Point], error: float) -> float:
    """The cost of an accuracy: on the front, log cost interpolated linearly in log error.

    The cheapest point if it is already better; NaN if no point is good enough: a curve is not
    extrapolated.
    """
    best = front(points)
    if not best or best[-1].error > error:
        return math.nan
    errors, costs = (numpy.log(values) for values in zip(*reversed(best), strict=True))
    return float(numpy.exp(numpy.interp(math.log(error), errors, costs)))


def points(rows: pandas.DataFrame, cost: str) -> list[Point]:
    """Points (error at the end, cost) of the rows that have both."""
    both = rows[["error", cost]].dropna()
    return [Point(float(error), float(value)) for error, value in both.to_numpy() if error > 0]


def chosen(rows: pandas.DataFrame, **wanted: object) -> pandas.DataFrame:
    """Rows of the reference scene (unless another is wanted) with these values."""
    for column, value in {"scene": SCENE, **wanted}.items():
        rows = rows[rows[column] == value]
    return rows


def costs(
    rows: pandas.DataFrame,
    formulation: str,
    cost: str,
    accuracies: Iterable[float] = ACCURACIES,
    precision: str = "double",
) -> dict[str, dict[float, float]]:
    """The cost of each accuracy that each method reaches, over the whole horizon.

    ``cost`` is a column: "seconds", or "ratio" to the bare heyoka loop.
    """
    mine = chosen(rows, precision=precision, formulation=formulation, horizon_s=WHOLE_S)
    wanted, curves = tuple(accuracies), {}
    for method, group in mine.groupby("method", sort=False):
        prices = {accuracy: cost_of(points(group, cost), accuracy) for accuracy in wanted}
        curves[str(method)] = {a: price for a, price in prices.items() if not math.isnan(price)}
    return curves


def _cheapest(
    rows: pandas.DataFrame, error: float, formulation: str = "newton", but: str = ""
) -> tuple[float, str]:
    """The cost of ``error`` by the fastest method in ``rows``, and its name."""
    prices = {
        method: known[error]
        for method, known in costs(rows, formulation, "ratio", [error]).items()
        if error in known and not (but and method.startswith(but))
    }
    return min(((price, method) for method, price in prices.items()), default=(math.nan, "none"))


def _peers(rows: pandas.DataFrame) -> Iterator[Finding]:
    peers, own = rows[rows["peer"].astype(str) == "True"], rows[rows["method"] == BARE]
    for formulation in FORMULATIONS:
        for error in ACCURACIES:
            bare, _ = _cheapest(own, error, formulation)
            for name, but in (("any peer", ""), ("any peer but CyRK", "CyRK")):
                cost, which = _cheapest(peers, error, formulation, but)
                yield Finding(
                    f"{name} at {error:.0e}, {formulation}",
                    cost / bare,
                    f"time of the fastest ({which}) over heyoka's, to an error of {error:.0e} at "
                    "8 s",
                )
    scipy, _ = _cheapest(rows[rows["method"].str.startswith("SciPy DOP853")], 1e-11)
    yield Finding(
        "SciPy DOP853 at 1e-11, newton",
        scipy / _cheapest(own, 1e-11)[0],
        "time of SciPy's DOP853 with its best right-hand side over heyoka's, to an error of 1e-11 "
        "at 8 s",
    )
    yield Finding(
        "full accuracy over 1e-6",
        _at_best(rows, BARE)["ratio"] / _cheapest(own, 1e-6)[0],
        "heyoka's time at its best double tolerance over that to an error of 1e-6",
    )


def _at_best(rows: pandas.DataFrame, *methods: str, **others: object) -> pandas.Series:
    """The fastest row of a method at its best tolerance; NaN without a row."""
    wanted = {
        "precision": "double", "formulation": "newton", "tolerance": 0.0, "horizon_s": WHOLE_S,
    } | others  # fmt: skip
    mine = chosen(rows[rows["method"].isin(methods)], **wanted).sort_values("ratio")
    return mine.reset_index(drop=True).reindex([0]).iloc[0]


def _variants(rows: pandas.DataFrame) -> Iterator[Finding]:
    for formulation in FORMULATIONS:
        for variant, without in VARIANTS.items():
            above = _at_best(rows, f"{BARE}, {variant}", formulation=formulation)
            below = _at_best(
                rows, f"{BARE}, {without}" if without else BARE, formulation=formulation
            )
            yield Finding(
                f"{variant}, {formulation}",
                above["ratio"] / below["ratio"],
                f"heyoka's time with over without ({without or 'the bare loop'}); error at the end "
                f"{above['error']:.2g}, without {below['error']:.2g}",
            )
    lanes = _at_best(rows, *(f"{BARE}, {width} lanes" for width in (4, 8)))
    yield Finding(
        "SIMD",
        _at_best(rows, BARE)["ratio"] / lanes["ratio"],
        f"trajectories per second of {lanes['method']} over those of the scalar loop, one core",
    )


def _digits(rows: pandas.DataFrame) -> Iterator[Finding]:
    own = rows[rows["method"] == BARE]
    for precision, digits in WIDE:
        error = 10.0**-digits
        prices = costs(own, "newton", "seconds", [error], precision).get(BARE, {})
        yield Finding(
            f"{digits} digits in {precision}",
            prices.get(error, math.nan),
            f"seconds to an error of 1e-{digits} at 8 s, interpolated on the curve",
            "s",
        )
    for low, high in SPANS:
        for column, what in (("seconds", "time"), ("setup_s", "compile time")):
            yield Finding(
                f"exponent of {what}, {low} to {high} digits",
                _ladder_exponent(rows, column, low, high),
                f"p in {what} ~ digits^p, least squares over arithmetics from double to mp at "
                f"their own eps, reference scene, 0 to {SHORT} s",
                "",
            )
    for precision, bits in (("double", 53), *(("mp", n) for n in LADDER)):
        short = {"precision": precision, "bits": bits, "horizon_s": float(SHORT)}
        plain = _at_best(rows, BARE, **short)
        parallel = _at_best(rows, f"{BARE}, parallel_mode", **short)
        where = f"0 to {SHORT} s in {precision}, error {plain['error']:.1g}"
        yield Finding(f"{bits} bits", plain["seconds"], where, "s")
        yield Finding(f"compiling, {bits} bits", plain["setup_s"], "for the run above", "s")
        with_over_without = parallel["seconds"] / plain["seconds"]
        yield Finding(f"parallel_mode, {bits} bits", with_over_without, "time with over without")
    quad, real = (
        _at_best(rows, BARE, precision=name, bits=113, horizon_s=float(SHORT))["seconds"]
        for name in ("quad", "mp")
    )
    yield Finding("113 bits as mp over quad", real / quad, "the same accuracy")


def _ladder_exponent(rows: pandas.DataFrame, column: str, low: int, high: int) -> float:
    """p in column ~ digits^p over the arithmetics from ``low`` to ``high`` digits."""
    mine = chosen(rows, method=BARE, formulation="newton", horizon_s=float(SHORT), tolerance=0.0)
    digits = mine["bits"] * DIGITS_PER_BIT
    # ends that round to the number: 53 bits are 15.95 digits, 1,000 are 301
    part = mine[digits.between(low - 0.5, high + 1.5)].assign(digits=digits)
    if len(part) < 2 or part["digits"].max() <= high - 1.5:
        return math.nan
    return slope(part["digits"], part[column])


def _machine(rows: pandas.DataFrame) -> Iterator[Finding]:
    fastest = rows[rows["method"] == WORKLOAD].set_index("setting")["seconds"]
    yield Finding(
        "drift of the machine",
        fastest.get("end", math.nan) / fastest.get("start", math.nan),
        "fastest bare heyoka loop at the end over the one at the start of the measurement",
    )


def conservation_scatter(rows: pandas.DataFrame) -> pandas.DataFrame:
    """Rows of all double methods on the reference scene with lambda's drift and an error."""
    mine = chosen(rows, precision="double", horizon_s=WHOLE_S)
    return mine[(mine["jellett_drift"] > 0) & (mine["error_on_way"] > 0)]


def _conservation(rows: pandas.DataFrame) -> Iterator[Finding]:
    mine = conservation_scatter(rows)
    if mine.empty:
        return
    hidden = mine[mine["jellett_drift"] <= LAMBDA_KEPT]
    of_paper = chosen(mine, method=PAPER_METHOD, formulation="euler", tolerance=0.0)
    for name, rows_of_name, definition in (
        ("hidden by conservation", hidden,
         f"largest error of the state on the way among all settings that hold lambda to "
         f"{LAMBDA_KEPT:.0e}"),
        ("the paper's own way", of_paper,
         "error of the state on the way with odeint's default tolerances in Euler form, "
         "dimensionless (NUM-03: in SI)"),
    ):  # fmt: skip
        for _, row in rows_of_name.nlargest(1, "error_on_way").iterrows():
            which = f"{row['method']}, {row['setting']}, lambda held to {row['jellett_drift']:.1g}"
            yield Finding(name, float(row["error_on_way"]), f"{definition}: {which}", "")
    ratios = mine["error_on_way"] / mine["jellett_drift"]
    yield Finding(
        "error over drift, median",
        float(ratios.median()),
        f"largest error of the state over largest drift of lambda, both on the way, over "
        f"{len(mine)} settings of all methods; the largest is {ratios.max():.1g}",
    )


class Exponent(NamedTuple):
    """The exponent of rms error ~ t^exponent, and its standard error over the seeds."""

    exponent: float
    error: float
    seeds: int
    rms_at_end: float


def exponent(rows: pandas.DataFrame, scene: str, integral: str, until_s: float) -> Exponent:
    """The growth of one integral's error up to ``until_s``, over all seeds that reach it.

    The slope of log rms (over the seeds) against log t by least squares; its standard error from
    leaving out one seed after the other (the jackknife), as the points of one run are correlated.
    """
    mine = rows[(rows["scene"] == scene) & (rows["t_s"] <= until_s * 1.001)]
    errors = mine.pivot(index="seed", columns="t_s", values=integral).dropna().to_numpy()
    times, seeds = numpy.unique(mine["t_s"]), len(errors)

    def steepness(chosen: Array) -> float:
        rms = numpy.sqrt((chosen**2).mean(axis=0))
        return slope(times, numpy.maximum(rms, 1e-20))

    others = numpy.array([steepness(numpy.delete(errors, i, axis=0)) for i in range(seeds)])
    spread = math.sqrt((seeds - 1) / seeds * float(((others - others.mean()) ** 2).sum()))
    rms_at_end = float(numpy.sqrt((errors[:, -1] ** 2).mean()))
    return Exponent(steepness(errors), spread, seeds, rms_at_end)


def slope(x: Array, y: Array) -> float:
    """Exponent p of y = c x^p by least squares in logarithms; at least two points."""
    return float(numpy.polyfit(numpy.log(x), numpy.log(y), 1)[0])


def _growth(long_runs: pandas.DataFrame) -> Iterator[Finding]:
    for scene in LONG_SCENES:
        mine = long_runs[long_runs["scene"] == scene]
        for until in sorted(set(mine.groupby("seed")["t_s"].max())):
            for integral, symbol in GROWING.items():
                fit = exponent(long_runs, scene, integral, until)
                off = (fit.exponent - BROUWER) / fit.error if fit.error else math.nan
                yield Finding(
                    f"growth of {symbol}, {scene}, to {until:.0e} s",
                    fit.exponent,
                    f"p in rms error ~ t^p over {fit.seeds} seeds, standard error {fit.error:.2g} "
                    f"({off:+.1f} of it from Brouwer's 1/2); rms at the end {fit.rms_at_end:.1g}",
                    "",
                )


def _estimates(estimates: pandas.DataFrame) -> Iterator[Finding]:
    ran = estimates[estimates["status"] != "raised"]
    excess = ran["estimated"] - ran["right"]
    yield Finding(
        "digits requested and not delivered",
        float((ran["right"] < ran["wanted"]).sum()),
        f"of {len(ran)} random scenes; {len(estimates) - len(ran)} more were refused with an error",
        "scenes",
    )
    yield Finding(
        "estimates too optimistic",
        float((excess > OPTIMISM).sum()),
        f"of {len(excess)}, by more than {OPTIMISM:g} digit; the worst by {excess.max():.2f}",
        "scenes",
    )
    yield Finding(
        "pessimism of the estimates",
        float(-excess.median()),
        f"median of right digits less estimated ones; {-excess.min():.2f} at most",
        "digits",
    )
