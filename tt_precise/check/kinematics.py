"""Laws for every friction: attitude and position follow the velocities, L follows the torques.

Both checks compare, over windows of four intervals, the change of something with the integral of
its rate by Boole's rule. Its distance from Simpson's rule says how well the rows resolve the
motion: ``MARGIN`` times the largest of that and of both neighbours' is subtracted. Where the rest
is above the limit the check fails; where the subtracted bound is above it, the window is open, and
a check with more open windows than others is skipped. ``kinematics`` also adds up, from the start,
what windows leave and what is subtracted: a small error that goes on is a large one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy

from tt_precise.check.columns import CheckSetup, Samples
from tt_precise.check.equations import to_one_digit
from tt_precise.mechanics import conserved
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import Quaternion, Vector, added, cross, dot, multiplied, scaled
from tt_precise.runtime.values import Array

ROWS = 5  # of a window
MARGIN = 20.0
FARTHEST = 2.0  # rad by which the angular momentum lets the axis turn from row to row
EVEN = 1e-9  # of a window, by which evenly spaced rows differ
CLOSEST = 0.01  # sqrt(R/g) between rows: what is closer adds roundings only
SINKS = 0.1  # of R: a soft contact may give way up to this depth
ROUNDING = 8 * float(numpy.finfo(float).eps)
# friction is seen where at least so many windows show it, and is as a law where what that keeps
# deviates by less than this part; gliding below this part of the fastest says nothing
FEWEST, ALIKE, STILL = 8, 0.05, 0.05
NONE = 1e-9  # of F_z: rounding
FITS = 0.03  # of what is left over, by a change that explains it
NEAR = 40  # windows on either side of the worst one, from which its cause is sought
Bounded = tuple[Array, Array]
"""By how much each window is off, and the bound of the error of that."""


class Windows:
    """Windows of ``ROWS`` rows each over times ``t``, the last one ending in the last row.

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
        self._boole, self._slope = _weights(x), _slopes(x)
        self._inner_slope = numpy.pad(_slopes(x[:, 1:4]), ((0, 0), (1, 1)))
        half, other = _weights(x[:, :3]), _weights(x[:, 2:])
        self._simpson = numpy.concatenate(
            (half[:, :2], half[:, 2:] + other[:, :1], other[:, 1:]), 1
        )

    def unexplained(self, values: Sequence[Array], rates: Sequence[Array]) -> Bounded:
        """Change - integral of the rate of a vector (entries, windows), and how far to trust it."""
        apart = numpy.array([self.change(value) for value in values])
        integrals = numpy.array([self.integral(rate) for rate in rates])
        coarse = numpy.array([self.integral(rate, self._simpson) for rate in rates])
        return apart - integrals, spread(MARGIN * numpy.linalg.norm(integrals - coarse, axis=0))

    def middle_rate(self, value: Array) -> Bounded:
        """Of an entry, in the middle row of each window, by the polynomial through all five rows.

        And how far the polynomial through the inner three is from that.
        """
        entries = self._entries(value)
        rate, apart = (
            (entries * weights).sum(axis=1) / self.spans
            for weights in (self._slope, self._slope - self._inner_slope)
        )
        return rate, apart

    def _entries(self, value: Array) -> Array:
        return numpy.broadcast_to(value, self.rows.max(initial=-1) + 1)[self.rows]

    def change(self, value: Array) -> Array:
        """From the first row of each window to the last."""
        entries = self._entries(value)
        return entries[:, -1] - entries[:, 0]

    def integral(self, rate: Array, weights: Array | None = None) -> Array:
        """Of a rate over each window, by Boole's rule."""
        weighted = self._entries(rate) * (self._boole if weights is None else weights)
        integrals: Array = self.spans * weighted.sum(1)
        return integrals


def stride_of(t: Array, apart: float) -> int:
    """The fewest rows that are ``apart`` (s) in the mean."""
    return max(1, math.ceil(apart * (len(t) - 1) / (t[-1] - t[0]))) if len(t) > 1 else 1


def windows_of(samples: Samples) -> Windows:
    """The windows of these rows, made once for all checks."""
    if "windows" not in samples.shared:
        samples.shared["windows"] = Windows(samples.t, CLOSEST * samples.setup.time)
    windows: Windows = samples.shared["windows"]
    return windows


def spread(values: Array) -> Array:
    """The largest of each value and its two neighbours."""
    padded = numpy.concatenate((values[:1], values, values[-1:]))
    return numpy.maximum(numpy.maximum(padded[:-2], padded[2:]), values)


def _weights(x: Array) -> Array:
    """Weights of the integral of the polynomial through the nodes ``x`` (windows, n)."""
    width = x[:, -1:] - x[:, :1]
    powers = numpy.arange(x.shape[1])
    matrix = ((x - x[:, :1]) / width)[:, None, :] ** powers[None, :, None]
    right = numpy.broadcast_to(1.0 / (powers + 1), x.shape)[:, :, None]
    weights: Array = numpy.linalg.solve(matrix, right)[:, :, 0] * width
    return weights


def _slopes(x: Array) -> Array:
    """Weights of the slope in the middle node of the polynomial through the nodes ``x``."""
    powers, middle = numpy.arange(x.shape[1]), x.shape[1] // 2
    matrix = (x - x[:, middle : middle + 1])[:, None, :] ** powers[None, :, None]
    right = numpy.broadcast_to(powers == 1, x.shape).astype(float)[:, :, None]
    slopes: Array = numpy.linalg.solve(matrix, right)[:, :, 0]
    return slopes


def _conjugate(q: Sequence[Array]) -> Quaternion:
    return (q[0], -q[1], -q[2], -q[3])


class _OverWindows:
    """Values for the rows of each block, from those of windows; and how many windows are open."""

    def __init__(self, setup: CheckSetup, first: Samples, limit: float):
        self._setup, self._limit = setup, limit
        self._worst = 0.0
        self.windows = self.open = 0
        self._bounds: list[float] = []
        self._wide, self._apart_now = math.inf, 0.0

    def __call__(self, samples: Samples) -> Array:
        values = numpy.zeros(len(samples.t))
        windows = windows_of(samples)
        if not len(windows.rows):
            return values
        q = motion_as_given(samples)
        turning = numpy.sqrt(dot(samples.state.L, samples.state.L)) / q.body.I1
        seen = windows.widest * turning[windows.rows].max(axis=1) <= FARTHEST
        if self._setup.scene.may_stick:  # its rates bend where the contact point comes to rest
            vx, vy = samples.state.vx[windows.rows], samples.state.vy[windows.rows]
            speed, change = numpy.hypot(vx, vy), numpy.hypot(numpy.diff(vx), numpy.diff(vy))
            seen &= (speed.max(axis=1) == 0) | (speed.min(axis=1) > change.max(axis=1))
        excess, bound = self._look(windows, samples, q, seen)
        open_ = ~(bound <= self._limit) | ~seen
        self.windows += len(excess)
        self.open += int(open_.sum())
        if open_.any():
            with numpy.errstate(all="ignore"):
                enough = windows.step * numpy.sqrt(self._limit / bound)
            enough = numpy.where(seen & (enough > 0), enough, 0.25 / turning.max())
            self._wide = min(self._wide, float(enough[open_].min()))
            self._apart_now = max(self._apart_now, float(windows.step.max()))
        self._bounds.append(float(numpy.max(bound, where=~open_, initial=0.0)))
        excess = numpy.where(numpy.isnan(excess), numpy.inf, excess)
        numpy.maximum.at(values, windows.rows[:, -1], excess)
        return values

    def _look(self, windows: Windows, samples: Samples, q: Motion, seen: Array) -> Bounded:
        """The error of each window beyond its bound, 0 if not ``seen`` in the rows; the bound."""
        raise NotImplementedError

    @property
    def error_bound(self) -> float:
        """Largest error that would go unnoticed; infinite where too many windows are open."""
        resolved = self.windows - self.open
        return max(self._bounds) if resolved > 0 and resolved >= self.open else math.inf

    @property
    def note(self) -> str:
        """The unresolved windows."""
        bound = self.error_bound
        said = f"error bound {bound:.0e}" if math.isfinite(bound) else ""
        if self.open:
            said += f"{'; ' if said else ''}{self.open} of {self.windows} windows not resolved"
            if 0 < self._wide < self._apart_now:
                said += f"; rows {to_one_digit(self._wide, math.floor):g} s apart would do"
        return said


def motion_as_given(samples: Samples) -> Motion:
    """The rows as a motion whose centre of mass moves as the columns say, where they do."""
    given, state = samples.given, samples.state
    if "vcz" not in given or not samples.setup.velocity_given:
        return samples.q
    centre = (given["vcx"], given["vcy"], given["vcz"])
    return Motion(samples.setup.body, state, numpy, samples.setup.scene.model, s_dot=lambda: centre)


class ContactMomentum(_OverWindows):
    """The remaining torque about the lowest point after weight and motion (m g R alpha)."""

    def _look(self, windows: Windows, samples: Samples, q: Motion, seen: Array) -> Bounded:
        off, bound = torque_left(samples)
        excess = seen * numpy.maximum(numpy.linalg.norm(off, axis=0) - bound, 0.0)
        worst = int(numpy.argmax(excess))
        if excess[worst] > max(self._worst, self._limit):
            self._worst = float(excess[worst])
            x, y, z = off[:, worst]
            about = off[2][excess > self._limit]  # of one sign, unlike that of rounding
            steady = len(about) >= FEWEST and abs(about.sum()) > abs(about).sum() / 2
            self._vertical = steady and math.hypot(x, y) < 0.1 * abs(z)
            first, last = windows.rows[max(worst - NEAR, 0), 0], windows.rows[worst:][:NEAR][-1, -1]
            self._rows = samples.rows(slice(first, last + 1))
        return excess, bound

    @property
    def note(self) -> str:
        """A cause of the remaining torque, and the unresolved windows."""
        if self._worst <= max(self._limit, 0.0):
            return super().note
        if self._vertical:
            named = "what is left is about the vertical, as torsional friction is"
        else:
            from tt_precise.check.causes import cause  # few need it

            rows = self._rows
            named = cause(
                lambda rows: torque_left(rows)[0], rows, min(FITS, self._limit / self._worst),
                lambda n: torque_left(rows, n)[0],
            )  # fmt: skip
        return "; ".join(text for text in (named, super().note) if text)


def torque_left(samples: Samples, gyroscopic: float = 1.0) -> Bounded:
    """The remaining mean torque of each window (3, windows), and its bound; both in m g R alpha.

    The motion is supposed to have had the gyroscopic term ``gyroscopic`` times.
    """
    windows, q = windows_of(samples), motion_as_given(samples)
    about, rate = conserved.contact_momentum(q), conserved.contact_momentum_rate(q)
    if gyroscopic != 1.0:
        rate = added(rate, scaled(1.0 - gyroscopic, cross(q.omega, q.state.L)))
    off, bound = windows.unexplained(about, rate)
    bound += ROUNDING * numpy.sqrt(dot(about, about)).max()
    unit = conserved.torque_unit(samples.setup.scene.body.numbers(float)) * windows.spans
    return off / unit, bound / unit


class FrictionPower(_OverWindows):
    """Power of friction F_t.v_A in the middle of each window, over m g R omega at the start."""

    def __init__(self, setup: CheckSetup, first: Samples, limit: float):
        super().__init__(setup, first, limit)
        body, omega = setup.body, first.first.omega
        self._unit = float(body.m * body.g * body.R * numpy.sqrt(dot(omega, omega))) or 1.0
        self._force: list[Array] = []  # |F_t|/F_z and |v_A| in the middle of windows

    def _look(self, windows: Windows, samples: Samples, q: Motion, seen: Array) -> Bounded:
        middle = windows.rows[:, ROWS // 2]
        vx, vy = samples.state.vx[middle], samples.state.vy[middle]
        (x, off_x), (y, off_y), (z, _) = map(windows.middle_rate, q.s_dot)
        force = conserved.contact_force(q, (x, y, z))
        within = numpy.hypot(off_x, off_y)
        speed = numpy.hypot(vx, vy)
        bound = spread(MARGIN * q.body.m * within * speed) / self._unit
        power = (force[0] * vx + force[1] * vy) / self._unit
        ratio = numpy.hypot(force[0], force[1]) / force[2]
        kept = seen & (bound <= self._limit) & (force[2] > 0.1 * q.body.m * q.body.g)
        kept &= speed > STILL * speed.max()
        self._force.append(numpy.array([ratio[kept], speed[kept]]))
        return seen * numpy.maximum(power - bound, 0.0), bound

    @property
    def note(self) -> str:
        """The friction in the rows, and the unresolved windows."""
        return "; ".join(text for text in (self._friction, super().note) if text)

    @property
    def _friction(self) -> str:
        ratio, speed = numpy.concatenate([numpy.empty((2, 0)), *self._force], axis=1)
        if len(ratio) < FEWEST:
            return ""
        if ratio.max() < NONE:
            return "no friction seen"
        for law, values, unit in (("Coulomb's", ratio, ""), ("viscous", ratio / speed, " s/m v_A")):
            mean, deviation = float(values.mean()), float(values.std())
            if deviation < ALIKE * mean:
                return f"friction seen: {mean:.3g} +- {deviation:.1g}{unit} of F_z, as {law}"
        return f"friction seen: {ratio.min():.2g} to {ratio.max():.2g} of F_z"


def normal_force(setup: CheckSetup, first: Samples, limit: float) -> Callable[[Samples], Array]:
    """Mean F_z/(m g) since the row before, from the change of the vertical velocity."""

    def mean(samples: Samples) -> Array:
        t, values = samples.t, numpy.full(len(samples.t), numpy.inf)
        stride = stride_of(t, CLOSEST * setup.time)
        rows = numpy.arange(0, len(t), stride)
        speed = numpy.broadcast_to(motion_as_given(samples).s_dot[2], t.shape)[rows]
        values[rows[1:]] = 1 + numpy.diff(speed) / (setup.body.g * numpy.diff(t[rows]))
        return values

    return mean


class Kinematics(_OverWindows):
    """Attitude (rad) and position (over R) against the integrals of the velocities; the height.

    An integrator of first order takes the velocity of an end of its step for that of the whole: a
    change in velocity of one step, at most the distance of rows, is not a fault.
    """

    def __init__(self, setup: CheckSetup, first: Samples, limit: float):
        super().__init__(setup, first, limit)
        given = first.given
        azimuth = setup.columns.azimuth
        self._looked_at = ["axis" if azimuth else "inclination"]
        if setup.columns.name == "rigid body":
            self._looked_at.append("spin")
        upwards = setup.height_given or not setup.scene.lifts
        if setup.velocity_known:
            names = ("x", "y", "z")[0 if azimuth else 2 : 2 + upwards]
            self._looked_at += [name for name in names if name in given]
        if "z" in given and not setup.scene.lifts:
            self._looked_at.append("height")
        self._what = ""
        self._sums: dict[str, Bounded] = {}
        self._begins = float(first.t[0])

    def _look(self, windows: Windows, samples: Samples, q: Motion, seen: Array) -> Bounded:
        R, given = samples.setup.body.R, samples.given
        excess, bound = numpy.zeros(len(windows.spans)), numpy.zeros(len(windows.spans))
        # the last window may overlap the one before
        follows = numpy.append(True, windows.rows[1:, 0] == windows.rows[:-1, -1])
        for name in self._looked_at:
            if name in ("axis", "inclination"):
                parts = slice(0 if name == "axis" else 2, 3)  # or cos theta alone
                off, within = self._part(windows, q.k[parts], cross(q.omega, q.k)[parts])
            elif name == "spin":
                off, within = self._spin(windows, samples, q)
            elif name == "height":
                off, within = self._height(windows, samples, q), 0 * bound
            else:
                speed = q.s_dot["xyz".index(name)]
                off, within = (x / R for x in self._part(windows, [given[name]], [speed]))
            # the height follows from the attitude of each row, however far apart rows are
            clear = seen | (name == "height")
            beyond = clear * numpy.maximum(numpy.linalg.norm(off, axis=0) - within, 0.0)
            if name != "height":
                counts = seen & follows & (within <= self._limit)
                sums, bounds = self._sums.get(name, (numpy.zeros((len(off), 1)), numpy.zeros(())))
                sums = sums + numpy.cumsum(numpy.where(counts, off, 0.0), axis=1)
                bounds = bounds + numpy.cumsum(numpy.where(counts, within, 0.0))
                self._sums[name] = sums[:, -1:], bounds[-1]
                beyond = numpy.fmax(beyond, numpy.linalg.norm(sums, axis=0) - bounds)
            if beyond.max() > self._worst:
                self._worst, self._what = float(beyond.max()), name
            excess, bound = numpy.fmax(excess, beyond), numpy.fmax(bound, within)
        return excess, bound

    @staticmethod
    def _part(windows: Windows, values: Sequence[Array], rates: Sequence[Array]) -> Bounded:
        off, bound = windows.unexplained(values, rates)
        step = windows.step * numpy.sqrt(sum(windows.change(rate) ** 2 for rate in rates))
        return off, bound + step

    def _height(self, windows: Windows, samples: Samples, q: Motion) -> Array:
        """Distance of z from R (1 - alpha cos theta), over R.

        Under another law the top may leave the table (not at the start), and a soft contact may
        give way.
        """
        body = samples.setup.body
        height = samples.given["z"] / body.R - (1 - body.alpha * q.k[2])
        if samples.setup.friction == "other":
            above = numpy.where(samples.t == self._begins, height, 0.0)
            height = numpy.maximum(numpy.maximum(above, -height) - SINKS, 0.0)
        largest: Array = abs(height[windows.rows]).max(axis=1)
        return largest[None]

    def _spin(self, windows: Windows, samples: Samples, q: Motion) -> Bounded:
        """Turn about the axis against the integral of omega.k, within whole turns.

        From row to row the attitude turns by the shortest way from axis to axis, and about the
        axis. Carried along its own way instead, a frame turns by the area between the two ways
        more.
        """
        rows, spinning = windows.rows, dot(q.omega, q.k)
        k = numpy.array(numpy.broadcast_arrays(*q.k))[:, rows]
        here, there = k[:, :, :-1], k[:, :, 1:]
        attitude = [samples.given[name][rows] for name in ("qw", "qx", "qy", "qz")]
        begin, end = ([part[:, rows] for part in attitude] for rows in (slice(-1), slice(1, None)))
        turned = multiplied((end[0], *_v(end[1:])), _conjugate(begin))
        shortest = [1 + dot(_v(here), _v(there)), *cross(_v(here), _v(there))]
        twist = multiplied(_conjugate(shortest), turned)
        about = 2 * numpy.arctan2(dot(twist[1:], _v(here)), twist[0])
        bent = numpy.diff(k, n=2, axis=2)
        inner = (bent[:, :, :-1] + bent[:, :, 1:]) / 2
        bent = numpy.concatenate((bent[:, :, :1], inner, bent[:, :, -1:]), axis=2)
        area = dot(_v(here), cross(_v(there - here), _v(bent))) / 12
        off = about.sum(axis=1) - area.sum(axis=1) - windows.integral(spinning)
        off -= 2 * math.pi * numpy.rint(off / (2 * math.pi))
        _, coarse = windows.unexplained([0 * spinning], [spinning])
        step = windows.step * abs(windows.change(spinning))
        return off[None], coarse + spread(step + (bent**2).sum(axis=(0, 2)) / 6)

    @property
    def note(self) -> str:
        """The checked columns, and those that do not follow from the velocities."""
        fails = f"{self._what} does not follow" if self._worst > self._limit else ""
        looked = "checked " + ", ".join(self._looked_at)
        lacking = [name for name in ("spin", "x", "y", "z") if name not in self._looked_at]
        if lacking:
            looked += f", not at {', '.join(lacking)} (columns missing)"
        return "; ".join(text for text in (fails, looked, super().note) if text)


def _v(entries: Sequence[Array] | Array) -> Vector:
    return (entries[0], entries[1], entries[2])
