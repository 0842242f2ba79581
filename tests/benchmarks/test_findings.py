"""Findings, from a table whose answers are known."""

import math
from typing import Any

import numpy
import pandas
import pytest

from benchmarks.work_precision.findings import (
    Point,
    TradeoffTables,
    cost_of,
    exponent,
    findings,
    slope,
)

DEFAULTS: dict[str, Any] = {
    "scene": "reference", "horizon_s": 8.0, "precision": "double", "bits": 53,
    "formulation": "newton", "tolerance": 1.0, "setup_s": 1.0, "jellett_drift": 1e-12,
    "peer": False, "setting": "s",
}  # fmt: skip


def row(method: str, error: float, seconds: float, **others: Any) -> dict[str, Any]:
    return {
        **DEFAULTS, "method": method, "error": error, "error_on_way": 10 * error,
        "seconds": seconds, "ratio": 100 * seconds, **others,
    }  # fmt: skip


def curve(method: str, factor: float, count: int) -> list[dict[str, Any]]:
    """Settings that are 100 times more exact for twice the time, ``factor`` times heyoka's."""
    peer = method != "heyoka"
    return [row(method, 100.0**-n, factor * 2.0**n, peer=peer) for n in range(count)]


CURVES = pandas.DataFrame([
    *curve("heyoka", 1, 8), *curve("diffrax Dopri8", 30, 7), *curve("CyRK DOP853", 3, 6),
    *curve("SciPy DOP853, numba", 200, 7),
    row("heyoka", 1e-15, 128.0, tolerance=0.0),
    row("heyoka", 1e-16, 0.1, tolerance=0.0, horizon_s=0.1),  # of the ladder of digits
])  # fmt: skip
TOP = pandas.DataFrame([
    row("heyoka", 1e-15, 1.0, tolerance=0.0),
    row("heyoka, contact watched", 1e-15, 1.2, tolerance=0.0),
    row("heyoka, all events", 2e-15, 3.0, tolerance=0.0),
    row("heyoka, 8 lanes", 1e-15, 0.2, tolerance=0.0),
])  # fmt: skip
LADDER = pandas.DataFrame([
    row("heyoka", 2.0**-bits, (bits / 53) ** 2.5, precision=name, bits=bits, tolerance=0.0,
        horizon_s=0.1, setup_s=3.0)
    for bits, name in {53: "double", 113: "quad", 167: "mp", 333: "mp", 1000: "mp"}.items()
])  # fmt: skip
HIDDEN = pandas.DataFrame([
    row("heyoka", 1e-3, 1.0, jellett_drift=1e-7),
    row("diffrax Tsit5", 1e-1, 1.0, jellett_drift=1e-5),  # which lets lambda go
])  # fmt: skip
ESTIMATES = pandas.DataFrame(
    [("complete", 9, 10.0, 10.5), ("complete", 9, 11.0, 8.5), ("contact_lost", 9, 10.0, 10.25),
     ("raised", 9, None, None)],
    columns=["status", "wanted", "estimated", "right"],
)  # fmt: skip


@pytest.mark.parametrize(
    ("table", "answers"),
    [
        (CURVES, {"any peer at 1e-09, newton": 3, "any peer but CyRK at 1e-09, newton": 30,
                  "any peer at 1e-12, newton": 30, "SciPy DOP853 at 1e-11, newton": 200,
                  "full accuracy over 1e-6": 128 / 8, "any peer at 1e-03, euler": None}),
        (TOP, {"contact watched, newton": 1.2, "all events, newton": 2.5, "SIMD": 5,
               "records x, newton": None}),
        (LADDER, {"exponent of time, 16 to 300 digits": 2.5, "1000 bits": (1000 / 53) ** 2.5,
                  "exponent of compile time, 16 to 300 digits": 0}),
        (LADDER[LADDER["bits"] < 500], {"exponent of time, 16 to 300 digits": None}),
        (HIDDEN, {"hidden by conservation": 1e-2, "error over drift, median": 1e5}),
        (ESTIMATES, {"digits requested and not delivered": 1, "estimates too optimistic": 1,
                     "pessimism of the estimates": 0.25}),
    ],
    ids=["peers", "options", "digits", "a short ladder", "conservation", "estimates"],
)  # fmt: skip
def test_the_findings_of_a_table_with_known_answers(
    table: pandas.DataFrame, answers: dict[str, float | None]
) -> None:
    tables = (None, None, table) if table is ESTIMATES else (table,)
    results = {finding.name: finding.value for finding in findings(TradeoffTables(*tables))}
    for name, value in answers.items():
        assert results.get(name) == (None if value is None else pytest.approx(value, abs=1e-12))


# The error is cost^-2, so that an accuracy e costs e^(-1/2).
SQUARE = [Point(10.0 ** (-2 * n), 10.0**n) for n in range(5)]


def test_interpolation_is_exact_on_a_power_law_and_nothing_is_extrapolated() -> None:
    for points in (SQUARE, reversed(SQUARE)):
        assert cost_of(points, 1e-5) == pytest.approx(10**2.5, rel=1e-14)
    assert math.isnan(cost_of(SQUARE, 1e-9))
    assert math.isnan(cost_of([], 1e-3))
    assert cost_of(SQUARE[1:], 1.0) == pytest.approx(10, rel=1e-14)  # the cheapest
    for point, gain in ((Point(1e-3, 1e4), False), (Point(1e-7, 50.0), True)):
        assert (cost_of([*SQUARE, point], 1e-6) < cost_of(SQUARE, 1e-6)) == gain
    assert slope([1.0, math.e], [1.0, math.e**-2]) == pytest.approx(-2, rel=1e-14)


def walks(drift: float) -> pandas.DataFrame:
    """Random walks, with a systematic part in units of their step, at log-spaced times."""
    draw = numpy.random.default_rng(20240229)
    times = [10.0 ** (i / 4) for i in range(17)]
    rows = []
    for seed in range(64):
        walk = numpy.cumsum(draw.choice([-1.0, 1.0], 10_001) + drift)
        rows += [
            {"scene": "s", "seed": seed, "t_s": t, "jellett": 1e-16 * walk[round(t)]} for t in times
        ]
    return pandas.DataFrame(rows)


def test_a_random_walk_has_exponent_one_half_and_a_systematic_error_has_not() -> None:
    growth = exponent(walks(0.0), "s", "jellett", 1e4)
    assert abs(growth.exponent - 0.5) < 3 * growth.error
    assert growth.error < 0.05
    assert growth.seeds == 64
    assert growth.rms_at_end == pytest.approx(1e-14, rel=0.4)
    growth = exponent(walks(1.0), "s", "jellett", 1e4)
    assert growth.exponent - 0.5 > 10 * growth.error
