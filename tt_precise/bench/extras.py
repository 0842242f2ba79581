"""Findings about what is asked for on top: events, quadratures, options of heyoka, SIMD, digits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tt_precise.bench.finding import Finding, chosen, first, least, points, quotient
from tt_precise.bench.plan import SHORT
from tt_precise.bench.work_precision import cost_of, slope

if TYPE_CHECKING:
    import pandas

WHOLE_S = 8.0
LANES_BAR = 4.0
WIDE = (("quad", 30, 2.0), ("mp", 50, 9.0))  # arithmetic, digits, seconds aimed at
SPANS = ((16, 300), (34, 300), (34, 100), (100, 300))  # digits; above 34 all is software
PER_BIT = 0.30103


def findings(rows: pandas.DataFrame) -> list[Finding]:
    """All of them."""
    return [*on_top(rows), *simd(rows), *wide(rows), *ladder(rows), *machine(rows)]


def on_top(rows: pandas.DataFrame) -> list[Finding]:
    """Each variant of heyoka at its best double tolerance, over the same without it."""
    found = []
    base = "contact watched"
    variants = [(base, ""), *((name, base) for name in ("one event", "all events"))]
    variants += [(f"records {name}", base) for name in ("phi", "x", "phi psi x y")]
    variants += [(name, "") for name in ("high_accuracy", "fast_math", "compact_mode")]
    for coordinates in ("newton", "euler"):
        for name, without in variants:
            times, errors = (
                [_best(rows, one, coordinates, column) for one in (name, without)]
                for column in ("ratio", "error")
            )
            value = quotient(*times)
            if value is None:
                continue
            change = quotient(*errors)
            found.append(
                Finding(
                    f"{name}, {coordinates}",
                    value,
                    "times",
                    f"heyoka's time with over without ({without or 'the bare loop'}); error at the "
                    f"end {change:.2g} times as large",
                )
            )
    return found


def _best(rows: pandas.DataFrame, variant: str, coordinates: str, column: str) -> float | None:
    method = f"heyoka, {variant}" if variant else "heyoka"
    return first(
        chosen(
            rows, method=method, precision="double", formulation=coordinates, tolerance=0.0,
            horizon_s=WHOLE_S,
        ),
        column,
    )  # fmt: skip


def simd(rows: pandas.DataFrame) -> list[Finding]:
    """Throughput of SIMD lanes over the scalar loop, one core."""
    scalar = _best(rows, "", "newton", "ratio")
    lanes = {n: _best(rows, f"{n} lanes", "newton", "ratio") for n in (4, 8)}
    best = least(lanes.values())
    width = next((n for n, value in lanes.items() if value == best), 0)
    return [
        Finding(
            "SIMD",
            quotient(scalar, best),
            "times",
            f"trajectories per second in {width} lanes over those of the scalar loop, one core",
            ("at least", LANES_BAR),
        )
    ]


def wide(rows: pandas.DataFrame) -> list[Finding]:
    """Seconds to so many digits in the wide arithmetics, 0 to 8 s."""
    found = []
    for precision, digits, bar in WIDE:
        mine = chosen(rows, method="heyoka", precision=precision, formulation="newton")
        curve = points(mine[mine["horizon_s"] == WHOLE_S], "seconds")
        found.append(
            Finding(
                f"{digits} digits in {precision}",
                cost_of(curve, 10.0**-digits),
                "s",
                f"seconds to an error of 1e-{digits} at 8 s, interpolated on the curve",
                ("below", bar),
            )
        )
    return found


def ladder(rows: pandas.DataFrame) -> list[Finding]:
    """How cost and compilation grow with the digits."""
    mine = chosen(rows, formulation="newton", horizon_s=float(SHORT), tolerance=0.0)
    scalar = mine[mine["method"] == "heyoka"].copy()
    scalar["digits"] = scalar["bits"] * PER_BIT
    found = []
    for low, high in SPANS:
        # ends that round to the number: 53 bits are 15.95 digits, 1,000 are 301
        part = scalar[scalar["digits"].between(low - 0.5, high + 1.5)]
        for column, what in (("seconds", "time"), ("setup_s", "compile time")):
            reaches = len(part) > 1 and part["digits"].max() > high - 1.5
            found.append(
                Finding(
                    f"exponent of {what}, {low} to {high} digits",
                    slope(zip(part["digits"], part[column], strict=True)) if reaches else None,
                    "",
                    f"p in {what} ~ digits^p, least squares over arithmetics from double to mp "
                    f"at their own eps, reference scene, 0 to {SHORT} s",
                )
            )
    for bits in sorted(scalar["bits"].unique()):
        rung = scalar[scalar["bits"] == bits].iloc[-1]
        found.append(
            Finding(
                f"{bits:.0f} bits",
                float(rung["seconds"]),
                "s",
                f"0 to {SHORT} s in {rung['precision']}, error {rung['error']:.1g}; compiled in "
                f"{rung['setup_s']:.1f} s",
            )
        )
        parallel = mine[(mine["method"] == "heyoka, parallel_mode") & (mine["bits"] == bits)]
        if not parallel.empty:
            value = quotient(first(parallel, "seconds"), float(rung["seconds"]))
            found.append(
                Finding(f"parallel_mode, {bits:.0f} bits", value, "times", "time with over without")
            )
    quad, real = (
        first(scalar[(scalar["bits"] == 113) & (scalar["precision"] == name)], "seconds")
        for name in ("quad", "mp")
    )
    found.append(
        Finding("113 bits as mp over quad", quotient(real, quad), "times", "the same accuracy")
    )
    return found


def machine(rows: pandas.DataFrame) -> list[Finding]:
    """How much the machine itself changed while it was measured."""
    load = rows[rows["method"] == "reference workload"].set_index("setting")
    value = None
    if {"start", "end"} <= set(load.index):
        value = quotient(float(load["seconds"]["end"]), float(load["seconds"]["start"]))
    return [
        Finding(
            "drift of the machine",
            value,
            "times",
            "fastest bare heyoka loop at the end over the one at the start of the measurement",
        )
    ]
