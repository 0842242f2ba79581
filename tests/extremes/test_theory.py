"""The theory that cases are judged by, at limits where it is known otherwise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mpmath
import pytest

from tt_precise.exact.arithmetic import own_context, rounding_to
from tt_precise.exact.stability import linearised
from tt_precise.extremes import theory
from tt_precise.mechanics.parameters import Parameters
from tt_precise.scene.scene import load_scene

FN = own_context(50)
TINY = FN.mpf(10) ** -40


def body(**changes: Any) -> Parameters:
    """The reference top, dimensionless, with some parameters replaced."""
    top = load_scene("reference").body.dimensionless(FN, rounding_to(FN))
    return replace(
        top.numbers(FN.convert), **{name: FN.mpf(value) for name, value in changes.items()}
    )


@pytest.mark.parametrize("side", [1, -1])
def test_the_matrix_worked_out_by_hand_is_that_of_the_equations(side: int) -> None:
    """Eigenvalues of both: by hand from eq (1), and from ``newton.rates`` by dual numbers."""
    top = body()
    by_hand = theory.tilt_modes(top, side, FN.mpf(side), FN)
    numbers = [[FN.mpc(x.re, x.im) for x in row] for row in linearised(top, side, FN.mpf(1))]
    numerical = sorted(FN.eig(FN.matrix(numbers))[0], key=FN.re, reverse=True)
    for a, b in zip(by_hand, numerical, strict=True):
        assert abs(a - b) < FN.mpf(10) ** -30


def test_a_mode_is_an_eigenvector_and_the_tilt_after_no_time_the_start() -> None:
    top, omega_3 = body(), FN.mpf(3)
    for rate in theory.tilt_modes(top, -1, omega_3, FN):
        mode = FN.matrix(list(theory.mode(top, -1, omega_3, rate)))
        assert FN.norm(theory.tilt_matrix(top, -1, omega_3, FN) * mode - rate * mode) < TINY
    tilt = theory.tilt_at(body(), 1, FN.mpf(2), FN.mpf(0), FN)
    assert abs(tilt.k - 1) + abs(tilt.L - 2 * body().I3) + abs(tilt.v) < TINY


def test_a_small_fall_is_a_quarter_of_a_pendulum_s_swing() -> None:
    top, theta = body(), FN.mpf("1e-10")
    quarter = FN.pi / 2 * FN.sqrt(top.I1 / top.alpha)
    assert abs(theory.fall_time(top, theta, FN.mpf(0), FN) / quarter - 1) < 1e-15


def test_a_fast_plane_top_leaves_the_table_at_the_equator() -> None:
    angle = theory.plane_loss(body(), FN.mpf(1), FN.mpf(10) ** 6, FN)
    assert 0 < angle - FN.pi / 2 < 1e-10


def test_a_plane_top_of_a_heavy_rim_turns_uniformly() -> None:
    """Without eccentricity nothing changes the rate."""
    time = theory.plane_time(body(alpha="0"), FN.mpf("0.5"), FN.mpf(4), FN.mpf("2.5"), FN)
    assert abs(time - FN.mpf("0.5")) < TINY


def test_the_turn_is_where_the_energy_is_all_potential() -> None:
    """A fast passage with L.z - L.k = d turns at d/(I1 rate), to first order in d."""
    top, spin, rate = body(), FN.mpf(1), FN.mpf(20)
    energy = top.I1 * rate**2 / 2 + spin**2 / (2 * top.I3) + 1 - top.alpha
    missed = FN.mpf(10) ** -15
    turn = theory.frictionless_turning_point(top, spin, spin + missed, energy, FN)
    assert abs(turn * top.I1 * rate / missed - 1) < 1e-10
    assert mpmath.isfinite(turn)
