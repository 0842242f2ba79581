"""Maps for the report: inclination against lambda, friction and precession against spin.

Each map has the outcome of every start: over theta(0) and lambda/lambda_thres, over mu and
omega_3(0), and over phi_dot(0) and omega_3(0). All other values are those of the reference start.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

import numpy

from tt_precise.claims.evidence.sweeps import exact_values
from tt_precise.mechanics.thresholds import lambda_thres
from tt_precise.runtime.cache import cached_table
from tt_precise.runtime.values import Array, Json
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.sweeps.run import integrate_tables, lambda_of_start, sweep_pool
from tt_precise.sweeps.specification import SweepSpec

if TYPE_CHECKING:
    import pandas

UNTIL = "20"  # Horizon in s.
COUNT = 41  # Values along each side.
RECORD = ("climb_A", "lambda_ratio", "end_theta")
FILE = "sweeps-maps.csv.gz"
VERSION = 2  # Version of everything here that the definition does not contain.


@dataclass(frozen=True)
class Side:
    """A side of a map: its column and range."""

    name: str
    low: float
    high: float

    def values(self) -> Array:
        """``COUNT`` values, ends included."""
        return numpy.linspace(self.low, self.high, COUNT)


MAPS = {
    "inclination and lambda": (Side("theta", 0.02, 1.22), Side("lambda_ratio", 0.2, 3.2)),
    "friction and spin": (Side("mu", 0.05, 4.05), Side("omega_3", 20.0, 260.0)),
    "precession and spin": (Side("phi_dot", -200.0, 200.0), Side("omega_3", 20.0, 260.0)),
}


@cache
def rows() -> pandas.DataFrame:
    """All rows of the maps: ``series`` (its name), starts, and the columns of a sweep."""
    return cached_table(FILE, definition(), compute)


def map_rows(name: str) -> pandas.DataFrame:
    """The rows of one map, a full grid in the columns of its sides."""
    table = rows()
    return table[table["series"] == name].reset_index(drop=True)


def compute(workers: int | None = None) -> pandas.DataFrame:
    """Integrate the maps."""
    import pandas

    tables = []
    with sweep_pool(workers) as pool:
        for name, (x, y) in MAPS.items():
            along, up = (values.ravel() for values in numpy.meshgrid(x.values(), y.values()))
            spins = _spins(along, up) if y.name == "lambda_ratio" else up
            spec = SweepSpec(_scene(), names=(x.name, "omega_3"), record=RECORD)
            starts = numpy.column_stack([along, spins])
            table = integrate_tables(pool, spec, [(name, numpy.arange(len(starts)), starts)])
            # the requested value: the one computed back from omega_3 has some eps of error
            tables.append(table.assign(**{y.name: up}))
    return pandas.concat(tables, ignore_index=True)


def definition() -> dict[str, Json]:
    """The definition of the rows: scene, sides, horizon, columns."""
    scene = _scene()
    sides = {name: repr(pair) for name, pair in MAPS.items()}
    made_from = {**exact_values(scene), "sides": sides}
    return {**made_from, "version": VERSION, "until": UNTIL, "count": COUNT, "record": RECORD}


def _scene() -> Scene:
    return replace(load_scene("reference"), until=Fraction(UNTIL))


def _spins(thetas: Array, ratios: Array) -> Array:
    """omega_3 for these lambda/lambda_thres, for starts at rest except for omega_3."""
    scene = _scene()
    threshold = lambda_thres(scene.body.dimensionless(math, float), math)
    each = {theta: lambda_of_start(scene, theta) for theta in sorted(set(thetas.tolist()))}
    # lambda_of_start is that of omega_3 = 1 rad/s, dimensionless like the threshold
    pairs = zip(ratios.tolist(), thetas.tolist(), strict=True)
    return numpy.array([ratio * threshold / each[theta] for ratio, theta in pairs])
