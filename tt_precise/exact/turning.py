"""The proof that the equations which heyoka integrates in a turning frame are those of eq (1)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from tt_precise.exact.chart import FrameChart
from tt_precise.exact.proof import identity
from tt_precise.mechanics import centre, turning
from tt_precise.mechanics.centre import CentreState
from tt_precise.runtime.arithmetic import Scalar


@identity("turning frame = Newton form", "(1), (7), (10)")
def _turning(chart: FrameChart) -> Iterable[Scalar]:
    """In axes that turn at Omega a horizontal pair p gains (Omega p_y, -Omega p_x), and no more.

    With lambda from the state itself, and m = R = g = 1; the state (k, L, s_dot) is free.
    """
    one, Omega = chart.field.one, chart.symbol["Omega"]
    body = replace(chart.body, m=one, R=one, g=one)
    state = CentreState(*chart.state)
    there = turning.from_centre(body, state)
    top = turning.top_of(body, there, Omega)
    found = turning.to_centre(body, turning.rates(top, there))
    inertial = centre.rates(body, state)
    gains = (
        Omega * state.ky, -Omega * state.kx, 0, Omega * state.Ly, -Omega * state.Lx, 0,
        Omega * state.s_dot_y, -Omega * state.s_dot_x,
    )  # fmt: skip
    for rate, still, gain in zip(found, inertial, gains, strict=True):
        yield rate - still - gain
