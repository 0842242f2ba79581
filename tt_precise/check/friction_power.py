"""The power of friction in the rows, and the mean normal force: checks for every friction law.

Derivatives are those of polynomials through windows of five rows. The distance from polynomials
through the inner three rows measures how well the rows resolve the motion; the largest distance
among a window and its neighbours, times ``MISFIT_FACTOR``, is subtracted. If the remainder is above
the limit, the check fails; if the subtracted bound is above the limit, the window is open. A check
with more open than other windows is skipped.
"""

from __future__ import annotations

import math

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.force_free import spread
from tt_precise.check.movement import motion_as_given
from tt_precise.check.result import Residual, to_one_digit
from tt_precise.mechanics import conserved
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.values import Array

ROWS = 5  # Rows in a window, through which a polynomial gives the rate in the middle.
MISFIT_FACTOR = 20.0
FARTHEST = 2.0  # rad by which the angular momentum lets the axis turn from row to row
EVEN = 1e-9  # In widths of a window; evenly spaced rows differ by less.
CLOSEST = 0.01  # sqrt(R/g) between rows: what is closer adds roundings only
# friction is seen where at least so many windows show it, and is as a law where what that keeps
# deviates by less than this part; gliding below this part of the fastest says nothing
FEWEST, ALIKE, STILL = 8, 0.05, 0.05
NONE = 1e-9  # In F_z; a smaller force is rounding.
Bounded = tuple[Array, Array]
"""By how much each window is off, and the bound of the error of that."""


class Windows:
    """Windows of ``ROWS`` rows each over times ``t``; the last window ends in the last row.

    ``rows`` are their indices (windows, ROWS), ``spans`` their lengths in s.
    """

    def __init__(self, t: Array, apart: float):
        stride = stride_of(t, apart)
        width = (ROWS - 1) * stride
        if len(t) <= width:
            stride, width = 1, ROWS - 1
        firsts = numpy.arange(0, max(len(t) - width, 0), width)
        if len(firsts) and firsts[-1] != len(t) - 1 - width:
            firsts = numpy.append(firsts, len(t) - 1 - width)
        self.rows = firsts[:, None] + stride * numpy.arange(ROWS)
        nodes = t[self.rows]
        self.spans = nodes[:, -1] - nodes[:, 0]
        self.widest = numpy.diff(nodes).max(axis=1, initial=0.0)
        self.step = self.widest / stride  # between neighbouring rows
        x = (nodes - nodes[:, :1]) / self.spans[:, None]
        # most rows are evenly spaced
        x = x[:1] if len(x) and numpy.ptp(x, axis=0).max() < EVEN else x
        self._slope = _slopes(x)
        self._inner_slope = numpy.pad(_slopes(x[:, 1:4]), ((0, 0), (1, 1)))

    def middle_rate(self, value: Array) -> Bounded:
        """Return the rate in the middle row of each window: the polynomial's through its five rows.

        Also its distance from the rate by the polynomial through the inner three.
        """
        entries = self._components(value)
        rate, apart = (
            (entries * weights).sum(axis=1) / self.spans
            for weights in (self._slope, self._slope - self._inner_slope)
        )
        return rate, apart

    def _components(self, value: Array) -> Array:
        return numpy.broadcast_to(value, self.rows.max(initial=-1) + 1)[self.rows]


def stride_of(t: Array, apart: float) -> int:
    """The fewest rows that are ``apart`` (s) in the mean."""
    return max(1, math.ceil(apart * (len(t) - 1) / (t[-1] - t[0]))) if len(t) > 1 else 1


def _slopes(x: Array) -> Array:
    """Weights of the slope in the middle node of the polynomial through the nodes ``x``."""
    powers, middle = numpy.arange(x.shape[1]), x.shape[1] // 2
    matrix = (x - x[:, middle : middle + 1])[:, None, :] ** powers[None, :, None]
    right = numpy.broadcast_to(powers == 1, x.shape).astype(float)[:, :, None]
    slopes: Array = numpy.linalg.solve(matrix, right)[:, :, 0]
    return slopes


def friction_power(samples: Samples, limit: float) -> Residual:
    """Power of friction F_t.v_A in the middle of each window, over m g R omega at the start."""
    setup, values = samples.setup, numpy.zeros(len(samples.t))
    windows = Windows(samples.t, CLOSEST * setup.time)
    if not len(windows.rows):
        return Residual(values, math.inf)
    q, body = motion_as_given(samples), setup.body
    turning = numpy.sqrt(dot(samples.state.L, samples.state.L)) / body.I1
    seen = windows.widest * turning[windows.rows].max(axis=1) <= FARTHEST
    if setup.scene.may_stick:  # its rates bend where the contact point comes to rest
        vx, vy = samples.state.vx[windows.rows], samples.state.vy[windows.rows]
        speed, change = numpy.hypot(vx, vy), numpy.hypot(numpy.diff(vx), numpy.diff(vy))
        seen &= (speed.max(axis=1) == 0) | (speed.min(axis=1) > change.max(axis=1))
    middle = windows.rows[:, ROWS // 2]
    vx, vy = samples.state.vx[middle], samples.state.vy[middle]
    (x, off_x), (y, off_y), (z, _) = map(windows.middle_rate, q.s_dot)
    force, speed = conserved.contact_force(q, (x, y, z)), numpy.hypot(vx, vy)
    omega = samples.first.omega
    unit = float(body.m * body.g * body.R * numpy.sqrt(dot(omega, omega))) or 1.0
    bound = spread(MISFIT_FACTOR * body.m * numpy.hypot(off_x, off_y) * speed, about=1) / unit
    power = (force[0] * vx + force[1] * vy) / unit
    excess = seen * numpy.maximum(power - bound, 0.0)
    numpy.maximum.at(
        values, windows.rows[:, -1], numpy.where(numpy.isnan(excess), numpy.inf, excess)
    )
    resolved = seen & (bound <= limit)
    kept = resolved & (force[2] > 0.1 * body.m * body.g) & (speed > STILL * speed.max())
    # negative where the force pushes
    ratio = numpy.copysign(numpy.hypot(force[0], force[1]) / force[2], -power)
    friction = _friction(ratio[kept], speed[kept])
    if resolved.any() and 2 * int(resolved.sum()) >= len(resolved):
        return Residual(values, float(bound[resolved].max()), friction)
    open_ = ~resolved
    note = f"{int(open_.sum())} of {len(open_)} windows not resolved"
    with numpy.errstate(all="ignore"):
        enough = windows.step * numpy.sqrt(limit / bound)
    enough = numpy.where(seen & (enough > 0), enough, 0.25 / turning.max())
    wide = float(enough[open_].min())
    if 0 < wide < windows.step.max():
        note += f"; rows {to_one_digit(wide, math.floor):g} s apart would suffice"
    return Residual(values, math.inf, "; ".join(filter(None, (friction, note))))


def _friction(ratio: Array, speed: Array) -> str:
    """Say which friction is seen: |F_t|/F_z at the speeds |v_A|."""
    if len(ratio) < FEWEST:
        return ""
    if abs(ratio).max() < NONE:
        return "no friction seen"
    for law, values, unit in (("Coulomb's", ratio, ""), ("viscous", ratio / speed, " s/m v_A")):
        mean, deviation = float(values.mean()), float(values.std())
        if deviation < ALIKE * abs(mean):
            law += ", but along the motion" if mean < 0 else ""
            return f"friction seen: {mean:.3g} +- {deviation:.1g}{unit} of F_z, as {law}"
    return f"friction seen: {ratio.min():.2g} to {ratio.max():.2g} of F_z"


def normal_force(samples: Samples, limit: float) -> Residual:
    """Mean F_z/(m g) since the row before, from the change of the vertical velocity."""
    t, setup = samples.t, samples.setup
    values = numpy.full(len(t), numpy.inf)
    rows = numpy.arange(0, len(t), stride_of(t, CLOSEST * setup.time))
    speed = numpy.broadcast_to(motion_as_given(samples).s_dot[2], t.shape)[rows]
    values[rows[1:]] = 1 + numpy.diff(speed) / (setup.body.g * numpy.diff(t[rows]))
    return Residual(values)
