"""Golden rows carried to other times: near the golden rows there, and honest about how near."""

from __future__ import annotations

from dataclasses import replace

import numpy
import pytest

from tt_precise.golden.carrying import Carried, Carrier
from tt_precise.golden.store import read
from tt_precise.mechanics.newton import NewtonState
from tt_precise.scene.scene import Scene, load_scene

EPS = float(numpy.finfo(float).eps)
ROWS = numpy.array([1, 100, 314, 318, 330, 500, 799])  # 314 to 330: about the climb's beginning
VECTORS = NewtonState._fields


def golden(scene: str, stride: int = 1) -> tuple[numpy.ndarray, list[numpy.ndarray]]:
    """Times (s) and vectors of every ``stride``-th golden row."""
    table = read(scene).trajectory
    names = [name for name in ("t", *VECTORS) if name in table.columns]
    t, *vectors = (numpy.array([float(x) for x in table.column(name)[::stride]]) for name in names)
    return t, vectors


def carried(scene: Scene, vectors: list[numpy.ndarray], by: float) -> Carried:
    delays = numpy.full(len(ROWS), by)
    return Carrier(scene, vectors).carry(ROWS, delays, EPS * abs(delays))


@pytest.mark.parametrize("scene", ["reference", "rolling"])
@pytest.mark.parametrize("way", [1, -1])
def test_a_row_carried_to_the_next_is_the_next_within_its_bound(scene: str, way: int) -> None:
    t, vectors = golden(scene)
    found = carried(load_scene(scene), vectors, way * 0.01)
    assert t[1] - t[0] == 0.01
    assert len(found.values) == {"reference": 8, "rolling": 6}[scene] + 6
    for name, true in zip(VECTORS, vectors, strict=True):
        if name not in found.values:
            continue  # rolling, where it is zero
        error = abs(found.values[name] - true[ROWS + way])
        assert (error <= found.bounds[name]).all(), name
        size = abs(true).max()
        assert numpy.median(found.bounds[name]) < 1e-9 * size, name  # it resolves something


def test_the_bounds_have_the_units_of_what_they_bound() -> None:
    """In units of 4 kg, 4 m and 2 s everything is the same, to the bit: they are powers of two."""
    scene, (_, vectors) = load_scene("reference"), golden("reference")
    body = scene.body
    larger = replace(
        body, m=4 * body.m, R=4 * body.R, I1=64 * body.I1, I3=64 * body.I3, mu=body.mu / 2
    )
    factors = dict(zip(VECTORS, [1.0] * 3 + [32.0] * 3 + [2.0] * 2, strict=True))
    enlarged = [x * factor for x, factor in zip(vectors, factors.values(), strict=True)]
    for by in (1e-4, 0.005, 0.01):
        one = carried(scene, vectors, by)
        other = carried(replace(scene, body=larger), enlarged, 2 * by)
        for name, factor in factors.items():
            assert (other.values[name] == factor * one.values[name]).all(), name
            assert (other.bounds[name] == factor * one.bounds[name]).all(), (name, by)


def test_far_away_nothing_is_claimed() -> None:
    _, vectors = golden("reference")
    found = carried(load_scene("reference"), vectors, 0.5)
    assert not numpy.isfinite(found.bounds["kx"]).any()


def test_each_row_is_carried_by_its_own_delay() -> None:
    scene, (_, vectors) = load_scene("reference"), golden("reference")
    rows, delays = numpy.array([5, 5, 5, 9]), numpy.array([-1e-3, 0.0, 2e-3, 1e-3])
    carrier = Carrier(scene, vectors)
    together = carrier.carry(rows, delays, numpy.zeros(4))
    for i in range(4):
        alone = carrier.carry(rows[i : i + 1], delays[i : i + 1], numpy.zeros(1))
        for name in VECTORS:
            assert alone.values[name][0] == pytest.approx(together.values[name][i], rel=4 * EPS)
    assert together.values["kx"][1] == vectors[0][5]
    late = carrier.carry(rows, delays, numpy.full(4, 1e-6))
    assert (late.bounds["kx"] > 1e3 * together.bounds["kx"]).all()  # a time known to 1 us


def test_a_row_that_starts_nowhere_leads_nowhere() -> None:
    _, vectors = golden("reference")
    vectors[3][ROWS[2]] = numpy.nan
    found = carried(load_scene("reference"), vectors, 0.001)
    assert numpy.isnan(found.values["kx"][2])
    assert numpy.isfinite(numpy.delete(found.values["kx"], 2)).all()


def test_beside_a_pole_the_tilt_keeps_its_digits() -> None:
    """There k_xy and L_xy are 1e-9 of the vertical entries, and are resolved by their own size."""
    _, vectors = golden("beside-the-pole")
    found = carried(load_scene("beside-the-pole"), vectors, 0.002)
    for x, y in (("kx", "ky"), ("Lx", "Ly")):
        size = numpy.hypot(found.values[x], found.values[y])[:2]
        assert (size < 1e-7 * abs(found.values[f"{x[0]}z"][:2])).all()
        assert (found.bounds[x][:2] < 1e-9 * size).all()
