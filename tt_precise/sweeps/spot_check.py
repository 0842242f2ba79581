"""The spot check: some rows integrated again in a finer arithmetic, and compared.

One row in a thousand, drawn with the sweep's seed, is integrated in double-double by the integrator
of ``taylor``, which shares only the equations with heyoka. Scenes that ``taylor`` cannot integrate
are integrated in quad. The arithmetic, the lanes, the step sizes and the evaluation differ.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy

from tt_precise.integration.setup import refused_in_doubles
from tt_precise.runtime.values import Json
from tt_precise.scene.scene import Scene
from tt_precise.sweeps.alone import row_of

ONE_IN = 1000
FINE, WHERE_REFUSED = "double-double", "quad"
TOLERANCE = 1e-22  # a million times finer than double, in half the time of the tolerance eps


def sampled_rows(rows: int, seed: int, one_in: int = ONE_IN) -> Iterator[int]:
    """Indices of the rows to recompute, one in every ``one_in`` rows, in order."""
    for block in range(-(-rows // one_in) if one_in else 0):
        size = min(one_in, rows - block * one_in)
        yield block * one_in + int(numpy.random.default_rng([seed, block]).integers(size))


def recomputed(scene: Scene, record: tuple[str, ...]) -> dict[str, Json]:
    """A row's results from a fine integration: "outcome", and floats, None if missing.

    Without steps and drift, which an arithmetic has of its own. Only for contact "unilateral".
    """
    precision = WHERE_REFUSED if refused_in_doubles(scene) else FINE
    row = row_of(scene, record, precision=precision, tolerance=TOLERANCE)
    return {name: value for name, value in row.items() if name not in ("steps", "jellett_drift")}


def differences(row: Mapping[Any, Json], again: Mapping[str, Json]) -> dict[str, float]:
    """Absolute difference of each column with a value; infinite where only one result has one."""
    by_name = {}
    for name, fine in again.items():
        if name == "outcome":
            continue
        rough = row[name]
        missing = rough is None or math.isnan(rough)
        if not missing and fine is not None:
            by_name[name] = abs(rough - fine)
        elif missing != (fine is None):
            by_name[name] = math.inf
    return by_name
