"""v_A.z = 0, and what it means where it is not: a soft contact, or another arm.

The vertical velocity of the contact point, added up over time, is how far the point has left the
table. In a soft contact it sinks and rises by little, for reasons of its own. With another alpha R
than the scene's it moves with the height of the axis, as alpha R k.z does.
"""

from __future__ import annotations

import math

import numpy

from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.mechanics.newton import arm
from tt_precise.mechanics.vectors import cross, dot

SHALLOW = 0.1  # of R: what leaves the table by more is no contact at all
PROPORTIONAL = 0.99  # correlation of the height with k.z from which it is the arm that is another


class ContactVelocity:
    """|v_A.z| (rolling: |v_A|) of each row over R omega at the start, and why it is not 0."""

    def __init__(self, setup: CheckSetup, first: Samples, limit: float):
        self._setup, self._limit = setup, limit
        omega = first.first.omega
        self._scale = float(setup.body.R * numpy.sqrt(dot(omega, omega))) or 1.0
        self._worst = self._height = 0.0
        self._sums = numpy.zeros(5)  # of h, kz, h^2, kz^2 and h kz, from the first row on
        self._ends = numpy.zeros(2)  # lowest and highest h, in m
        self._rows = 0

    def __call__(self, samples: Samples) -> numpy.ndarray:
        values: numpy.ndarray = samples.slip / self._scale
        self._worst = max(self._worst, float(values.max()))
        if self._setup.columns.name == "rigid body":
            self._follow(samples)
        return values

    def _follow(self, samples: Samples) -> None:
        q = samples.q
        lift = samples.given["vcz"] + cross(q.omega, arm(self._setup.body, q.k))[2]
        risen = numpy.cumsum(numpy.diff(samples.t) * (lift[1:] + lift[:-1]) / 2)
        new = slice(1 if self._rows else 0, None)  # every later block repeats a row
        h = (self._height + numpy.concatenate(([0.0], risen)))[new]
        kz, self._height = samples.state.kz[new], float(h[-1])
        self._rows += len(h)
        self._sums += [h.sum(), kz.sum(), (h * h).sum(), (kz * kz).sum(), (h * kz).sum()]
        low, high = self._ends
        self._ends = numpy.array([min(low, h.min()), max(high, h.max())])

    @property
    def note(self) -> str:
        """What the contact point does, and what to do about it; "" where it stays on the table."""
        if self._worst <= self._limit or not self._rows:
            return ""
        moved = float(self._ends[1] - self._ends[0])
        if not moved <= SHALLOW * self._setup.body.R:
            return ""
        h, kz, hh, kk, hk = self._sums / self._rows
        spread, common = kk - kz * kz, hk - h * kz
        if common**2 > PROPORTIONAL**2 * spread * (hh - h * h):
            lever = float(self._setup.body.R * self._setup.body.alpha)
            return (
                f"its height follows the axis: alpha R = {lever - common / spread:.5g} m would "
                f"keep it on the table, the scene has {lever:.5g} m"
            )
        return (
            f"it sinks and rises by {moved:.1g} m, as a soft contact does: if yours is one, give "
            f"it a limit of its own, as --limit contact_velocity={_rounded_up(2 * self._worst):g}"
        )


def _rounded_up(value: float) -> float:
    """To one digit."""
    exponent = math.floor(math.log10(value))
    return float(f"{math.ceil(value / 10.0**exponent)}e{exponent}")
