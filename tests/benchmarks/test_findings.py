"""Findings, from a table whose answers are known."""

import math
from pathlib import Path
from typing import Any

import numpy
import pandas
import pytest

from benchmarks.work_precision.findings import (
    GROWTH,
    TABLE,
    Point,
    TradeoffTables,
    cost_of,
    exponent,
    findings,
    front,
    load,
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


def table(*rows: dict[str, Any]) -> pandas.DataFrame:
    return pandas.DataFrame(list(rows))


# both 100 times more exact for twice the time; the peer 30 times slower
CURVES = table(
    *(row("heyoka", 100.0**-n, 2.0**n) for n in range(8)),
    *(row("diffrax Dopri8", 100.0**-n, 30 * 2.0**n, peer=True) for n in range(7)),
    *(row("CyRK DOP853", 100.0**-n, 3 * 2.0**n, peer=True) for n in range(6)),
    *(row("SciPy DOP853, numba", 100.0**-n, 200 * 2.0**n, peer=True) for n in range(7)),
    row("heyoka", 1e-15, 128.0, tolerance=0.0),
    row("heyoka", 1e-16, 0.1, tolerance=0.0, horizon_s=0.1),  # of the ladder of digits
)


# error = cost^-2, so an accuracy e costs e^(-1/2)
SQUARE = [Point(10.0 ** (-2 * n), 10.0**n) for n in range(5)]


def values(*tables: pandas.DataFrame | None) -> dict[str, float | None]:
    return {one.name: one.value for one in findings(TradeoffTables(*tables))}


def test_ratios_to_the_fastest_peer() -> None:
    found = values(CURVES)
    assert found["any peer at 1e-09, newton"] == pytest.approx(3)
    assert found["any peer but CyRK at 1e-09, newton"] == pytest.approx(30)
    assert found["any peer at 1e-12, newton"] == pytest.approx(30)
    assert found["SciPy DOP853 at 1e-11, newton"] == pytest.approx(200)
    assert found["full accuracy over 1e-6"] == pytest.approx(128 / 8)
    assert "any peer at 1e-03, euler" not in found
    named = {one.name: one.definition for one in findings(TradeoffTables(CURVES))}
    assert "(diffrax Dopri8)" in named["any peer at 1e-12, newton"]


def test_what_is_on_top_is_measured_against_what_is_below() -> None:
    rows = table(
        row("heyoka", 1e-15, 1.0, tolerance=0.0),
        row("heyoka, contact watched", 1e-15, 1.2, tolerance=0.0),
        row("heyoka, all events", 2e-15, 3.0, tolerance=0.0),
        row("heyoka, 8 lanes", 1e-15, 0.2, tolerance=0.0),
    )
    found = values(rows)
    assert found["contact watched, newton"] == pytest.approx(1.2)
    assert found["all events, newton"] == pytest.approx(2.5)
    assert found["SIMD"] == pytest.approx(5)
    assert "records x, newton" not in found


def test_exponent_of_the_digits() -> None:
    ladder = {113: "quad", 167: "mp", 333: "mp", 1000: "mp"}
    rows = table(
        *(
            row("heyoka", 2.0**-bits, (bits / 53) ** 2.5, precision=name, bits=bits,
                tolerance=0.0, horizon_s=0.1, setup_s=3.0)
            for bits, name in {53: "double", **ladder}.items()
        )
    )  # fmt: skip
    found = values(rows)
    assert found["exponent of time, 16 to 300 digits"] == pytest.approx(2.5)
    assert found["exponent of compile time, 16 to 300 digits"] == pytest.approx(0, abs=1e-12)
    assert found["1000 bits"] == pytest.approx((1000 / 53) ** 2.5)
    assert "exponent of time, 16 to 300 digits" not in values(rows[rows["bits"] < 500])


def test_errors_hidden_by_conservation_are_counted() -> None:
    rows = table(
        row("heyoka", 1e-3, 1.0, jellett_drift=1e-7),
        row("diffrax Tsit5", 1e-1, 1.0, jellett_drift=1e-5),
    )
    found = values(rows)
    assert found["hidden by conservation"] == pytest.approx(1e-2)  # the other one lets lambda go
    assert found["error over drift, median"] == pytest.approx(1e5)


def test_what_requested_digits_deliver() -> None:
    rows = [
        ("complete", 9, 10.0, 10.5),
        ("complete", 9, 11.0, 8.5),
        ("contact_lost", 9, 10.0, 10.25),
        ("raised", 9, None, None),
    ]
    estimates = pandas.DataFrame(rows, columns=["status", "wanted", "estimated", "right"])
    found = values(None, None, estimates)
    assert found["digits requested and not delivered"] == 1
    assert found["estimates too optimistic"] == 1
    assert found["pessimism of the estimates"] == pytest.approx(0.25)


def test_a_table_survives_its_file(tmp_path: Path) -> None:
    CURVES.to_csv(tmp_path / TABLE, index=False)
    tables = load(tmp_path)
    assert tables.long_runs is None
    assert findings(tables) == findings(TradeoffTables(CURVES))
    assert not (tmp_path / GROWTH).exists()


def test_interpolation_is_exact_on_a_power_law_and_nothing_is_extrapolated() -> None:
    for points in (SQUARE, reversed(SQUARE)):
        assert cost_of(points, 1e-5) == pytest.approx(10**2.5, rel=1e-14)
    assert math.isnan(cost_of(SQUARE, 1e-9))
    assert math.isnan(cost_of([], 1e-3))
    assert cost_of(SQUARE[1:], 1.0) == pytest.approx(10, rel=1e-14)  # the cheapest


def test_a_better_point_changes_the_cost_and_a_beaten_one_does_not() -> None:
    beaten, lucky = Point(1e-3, 1e4), Point(1e-7, 50.0)
    assert beaten not in front([*SQUARE, beaten])
    assert cost_of([*SQUARE, beaten], 1e-3) == cost_of(SQUARE, 1e-3)
    assert cost_of([*SQUARE, lucky], 1e-6) < cost_of(SQUARE, 1e-6)


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


def test_a_random_walk_has_exponent_one_half() -> None:
    found = exponent(walks(0.0), "s", "jellett", 1e4)
    assert abs(found.exponent - 0.5) < 3 * found.error
    assert found.error < 0.05
    assert found.seeds == 64
    assert found.rms_at_end == pytest.approx(1e-14, rel=0.4)
    # a systematic error has not
    found = exponent(walks(1.0), "s", "jellett", 1e4)
    assert found.exponent - 0.5 > 10 * found.error


def test_slope_of_a_power_law() -> None:
    costs = [3.0, 3 * 10**1.75, 3 * 40**1.75]
    assert slope([1.0, 10.0, 40.0], costs) == pytest.approx(1.75, rel=1e-14)
    falling = slope([1.0, math.e], [1.0, math.e**-2])
    assert falling == pytest.approx(-2, rel=1e-14)
