"""Whether a trajectory follows its equations of motion between the rows.

For every interval the change of each entry x of the state, x(t1) - x(t0), is compared with the
integral of its rate, and the change of E with the integral of -mu g_n v_A^2. The integrals come
from the Taylor coefficients that the equations themselves give at both ends, by Hermite's rule,
in rising order until the interval is resolved. The differences are added up from the start, so
that the sampling interval does not matter: what is measured is
|x(t) - x(0) - integral of rates|, in units of the size of x at the start.

What the highest order leaves open is followed from row to row (``shooting``), and the solution's
end compared with the next row. Where rows lie too far apart even for that, the interval is left out
and counted. From the sum of the others, the error bounds of the quadrature and the rounding are
subtracted: a value that remains is the trajectory's own. Rows closer together than the equations
need are passed over.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy

from tt_precise.arithmetic import Array, Scalar
from tt_precise.body import Parameters
from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.check.shooting import follow
from tt_precise.mechanics import quantities
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.taylor import SeriesFunctions, TaylorSeries, integral, solution
from tt_precise.mechanics.vectors import cross, dot

ORDERS = (2, 4, 8, 13)  # Taylor coefficients used at either end of an interval
RESOLVED = 1e-9  # wanted error bound of a whole check, before a higher order is tried
HORIZON = 100.0  # in sqrt(R/g), over which RESOLVED is shared out; the reference has 177
# What a rule misses is taken to be the difference from the rule one order below, times its ratio
# to the difference before, times MARGIN; where the ratio is no small one, MOST times it.
MARGIN, MOST = 100.0, 10.0
WIDEST_BOUND = 1e-6  # of one interval through which the solution is followed
CLOSEST = 0.005  # in sqrt(R/g): nearer rows say nothing new about the equations
EPS = float(numpy.finfo(float).eps)


@dataclass(frozen=True)
class Residuals:
    """Changes minus integrals of rates of every interval, and how far to trust them.

    ``state`` has shape (entries, intervals), ``energy`` (intervals,), both in units of their size
    at the start; ``bound`` (intervals,) is that of the error of these numbers. ``ends`` are the
    rows where the intervals end; ``within`` (s, intervals) is how far the solution was followed, 0
    where no spacing of the rows would help.
    """

    state: numpy.ndarray
    energy: numpy.ndarray
    bound: numpy.ndarray
    ends: numpy.ndarray
    within: numpy.ndarray


class EquationResidual:
    """The balances of one setup; sizes are taken from its first row.

    ``resolved`` is the error bound of a whole trajectory at which no higher order is tried.
    """

    def __init__(self, setup: CheckSetup, first: Samples, resolved: float = RESOLVED):
        self.setup, self._resolved = setup, resolved
        self._form = formulation(setup.scene.model, "newton", setup.scene.body.law)
        self._time = float(numpy.sqrt(setup.body.R / setup.body.g))
        q = first.first
        spin = float(numpy.sqrt(dot(q.state.L, q.state.L))) or 1.0
        speed = float(setup.body.R * numpy.sqrt(dot(q.omega, q.omega))) or 1.0
        self._energy_size = float(INTEGRALS["energy"].scale(q)) or 1.0
        self._entry_sizes = [1.0] * 3 + [spin] * 3 + [speed] * 2
        one_axis = [1.0, spin, spin, spin, speed, speed]
        self._sizes = self._entry_sizes if setup.columns.azimuth else one_axis

    def balance(self, samples: Samples) -> Residuals:
        """The balance of every interval of ``samples``; computed once for all checks."""
        if "balance" not in samples.shared:
            apart = self._apart(samples.t)
            rows = samples.rows(apart)
            samples.shared["balance"] = self._followed(rows, self._balance(rows, apart[1:]))
        found: Residuals = samples.shared["balance"]
        return found

    def changes(self, samples: Samples) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Change of each entry of the state in each interval, and its balance, whatever it is."""
        with numpy.errstate(all="ignore"):
            functions, _ = self._functions(samples.state, 1)
        found = self._balance(samples, numpy.arange(1, len(samples.t)))
        return numpy.diff(functions[:-1]), found.state

    def _apart(self, t: numpy.ndarray) -> numpy.ndarray:
        last = len(t) - 1
        if t[-1] - t[0] > last * CLOSEST * self._time:
            return numpy.arange(len(t))
        cell = numpy.floor((t - t[0]) / (CLOSEST * self._time))
        apart = numpy.flatnonzero(numpy.diff(cell, prepend=-1.0))
        return apart if apart[-1] == last else numpy.append(apart, last)

    def _balance(self, samples: Samples, ends: numpy.ndarray) -> Residuals:
        steps = numpy.diff(samples.t)
        every = numpy.arange(len(steps))
        with numpy.errstate(all="ignore"):
            mismatch, bound = self._intervals(samples, every, ORDERS[0])
            for order in ORDERS[1:]:
                open_ = every[~(bound <= self._wanted(steps))]
                if not len(open_):
                    break
                finer, finer_bound = self._intervals(samples, open_, order)
                better = (finer_bound <= bound[open_]) | numpy.isnan(bound[open_])
                mismatch[:, open_[better]] = finer[:, better]
                bound[open_[better]] = finer_bound[better]
        usable = numpy.isfinite(mismatch).all(axis=0)
        if self.setup.joins:
            joined = self._joined(samples, steps)
            usable, steps = usable & ~joined, numpy.where(joined, 0.0, steps)
        bound = numpy.where(usable, bound, numpy.inf)
        return Residuals(mismatch[:-1], mismatch[-1], bound, ends, steps)

    def _joined(self, samples: Samples, steps: Array) -> Array:
        """Intervals in which the contact point may have come to rest or have left it.

        It has not where it rests at both ends, and cannot have where, from either end, twice the
        rate of v_A would not have brought it to 0.
        """
        with numpy.errstate(all="ignore"):
            values, rates = self._functions(samples.state, 1)
        speed = numpy.hypot(*values[-3:-1])
        change = 2 * numpy.hypot(*rates[-3:-1, 0])
        glides = (speed[:-1] > change[:-1] * steps) & (speed[1:] > change[1:] * steps)
        rests = (speed[:-1] == 0) & (speed[1:] == 0)
        return ~(glides | rests)

    def _wanted(self, steps: numpy.ndarray) -> numpy.ndarray:
        return numpy.maximum(self._resolved * steps / (HORIZON * self._time), 4 * EPS)

    def _followed(self, samples: Samples, found: Residuals) -> Residuals:
        """The balance with the solution followed through what the quadrature left open."""
        steps = numpy.diff(samples.t)
        open_ = numpy.flatnonzero(~(found.bound <= self._wanted(steps)))
        # what joins two pieces is no solution of either's equations
        if not len(open_) or self.setup.joins:
            return found
        width = len(self._form.columns)
        start = numpy.array([entry[open_] for entry in samples.state])
        sizes = numpy.array(self._entry_sizes[:width])
        with numpy.errstate(all="ignore"):
            shot = follow(self._rates, start[:width], steps[open_], sizes, WIDEST_BOUND)
            start[:width] = shot.state
            there, _ = self._functions(NewtonState(*start), 1)
            given = NewtonState(*(entry[open_ + 1] for entry in samples.state))
            mismatch = self._functions(given, 1)[0] - there
        better = shot.error < found.bound[open_]
        chosen, mismatch = open_[better], mismatch[:, better]
        found.state[:, chosen], found.energy[chosen] = mismatch[:-1], mismatch[-1]
        found.bound[chosen], found.within[open_] = shot.error[better], shot.reached
        return found

    def _intervals(
        self, samples: Samples, chosen: numpy.ndarray, order: int
    ) -> tuple[numpy.ndarray, numpy.ndarray]:
        count = len(chosen)
        if count == len(samples.t) - 1:
            values, rates = self._functions(samples.state, order)
            ends = slice(None, -1), slice(1, None)
        else:
            both = numpy.concatenate((chosen, chosen + 1))
            state = NewtonState(*(entry[both] for entry in samples.state))
            values, rates = self._functions(state, order)
            ends = slice(None, count), slice(count, None)
        steps = samples.t[chosen + 1] - samples.t[chosen]
        left, right = (rates[:, :, end] for end in ends)
        best, lower, lowest = (
            integral(left, right, steps, max(order - back, 1)) for back in (0, 1, 2)
        )
        if order == 2:  # Hermite's rule has no order below 1: the left end alone takes its place
            lowest = left[:, 0] * steps
        last, before = abs(best - lower).max(axis=0), abs(lower - lowest).max(axis=0)
        shrinking = numpy.where(before > 0, numpy.minimum(MOST, MARGIN * last / before), MOST)
        change = values[:, ends[1]] - values[:, ends[0]]
        rounding = EPS * abs(best).max(axis=0)
        return change - best, last * shrinking + rounding

    def _rates(self, entries: tuple[Scalar, ...]) -> Sequence[Scalar]:
        form = self._form
        found: Sequence[Scalar] = form.rates(self.setup.body, form.State(*entries), SeriesFunctions)
        return found

    def _functions(self, state: NewtonState, order: int) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Values (functions, rows), and Taylor coefficients of their rates, of every row."""
        body, model = self.setup.body, self.setup.scene.model
        width = len(self._form.columns)
        with numpy.errstate(all="ignore"):
            entries = solution(self._rates, list(state[:width]), order)
        if body.law == "coulomb" and model == "gliding":
            _let_roll(body, state, entries, order)
        full = NewtonState(*entries, *(0,) * (8 - width))
        functions = full[:width] if self.setup.columns.azimuth else _without_azimuth(full, width)
        values = [f.c[0] / size for f, size in zip(functions, self._sizes, strict=False)]
        slopes = [f.rate / size for f, size in zip(functions, self._sizes, strict=False)]
        q, q_rows = Motion(body, full, SeriesFunctions, model), Motion(body, state, numpy, model)
        values.append(quantities.E(q_rows) / self._energy_size)
        power: Array = 0.0 if model == "rolling" else quantities.E_dot(q).c[:order]
        if body.law == "coulomb" and model == "gliding":
            power = numpy.where(q_rows.rolls, 0.0, power)
        slopes.append(power / self._energy_size + numpy.zeros_like(slopes[0]))
        return numpy.array(values), numpy.array(slopes)


def _let_roll(
    body: Parameters, state: NewtonState, entries: Sequence[TaylorSeries], order: int
) -> None:
    """Replace, in rows at rest, the series of gliding by those of rolling.

    Coulomb's friction: what such a row belongs to. An interval between a row at rest and one that
    glides is not smooth, and its quadrature shows no convergence.
    """
    rest = (state.vx == 0) & (state.vy == 0)
    if not rest.any():
        return
    roll = formulation("rolling", "newton")

    def rates(parts: tuple[TaylorSeries, ...]) -> Sequence[Scalar]:
        found: Sequence[Scalar] = roll.rates(body, roll.State(*parts), SeriesFunctions)
        return found

    rolling = solution(rates, [numpy.asarray(entry)[rest] for entry in state[:6]], order)
    for whole, part in zip(entries, rolling, strict=False):
        whole.c[:, rest] = part.c
    for whole in entries[6:]:
        whole.c[:, rest] = 0.0


def _without_azimuth(state: NewtonState, width: int) -> tuple[Scalar, ...]:
    # what turning the whole motion about the vertical leaves alone
    k, L, v = state.k, state.L, state.v
    found: tuple[Scalar, ...] = (k[2], L[2], dot(L, k), cross(L, k)[2])
    if width == len(state):
        found += (v[0] * k[0] + v[1] * k[1], v[1] * k[0] - v[0] * k[1])
    return found


class SummedResidual:
    """The balances added up from the start: values for the rows of each block, and the bound."""

    def __init__(self, residual: EquationResidual, part: str, limit: float):
        self._residual, self._part, self._limit = residual, part, limit
        self._joins = residual.setup.joins
        self._sum: Array = 0.0
        self._bound = 4 * EPS  # the first and the last row are rounded, in two numbers each
        self._worst = 0.0
        self._within = numpy.inf  # s: what was followed of the unresolved interval that is worst
        self.intervals = self.unresolved = 0

    def __call__(self, samples: Samples) -> numpy.ndarray:
        if len(samples.t) < 2:
            return numpy.zeros(len(samples.t))
        found = self._residual.balance(samples)
        resolved = found.bound <= self._limit
        self.intervals += len(resolved)
        self.unresolved += int((~resolved).sum())
        self._within = min(self._within, float(found.within[~resolved].min(initial=numpy.inf)))
        mismatch = numpy.atleast_2d(getattr(found, self._part))
        sums = numpy.cumsum(numpy.where(resolved, mismatch, 0.0), axis=1)
        sums += numpy.reshape(self._sum, (-1, 1))
        bounds = self._bound + numpy.cumsum(numpy.where(resolved, found.bound, 0.0))
        self._sum, self._bound = sums[:, -1], float(bounds[-1])
        values = numpy.maximum(abs(sums).max(axis=0) - bounds, 0.0)
        self._worst = max(self._worst, float(values.max()))
        # a row that was passed over has the value of the end before it
        before = numpy.searchsorted(found.ends, numpy.arange(len(samples.t)), side="right")
        return numpy.concatenate(([0.0], values))[before]

    @property
    def error_bound(self) -> float:
        """Largest error that would go unnoticed, in the units of the value."""
        return self._bound if self.unresolved < self.intervals else numpy.inf

    @property
    def note(self) -> str:
        """What was not resolved, and from which spacing of the rows on it would be."""
        said = f"error bound {self.error_bound:.0e}"
        if self.unresolved:
            what = "hold a stick or slip, or are too wide" if self._joins else "too wide"
            said += f"; {self.unresolved} of {self.intervals} intervals {what}"
            if self._within > 0:
                said += f"; rows {_rounded_down(self._within):g} s apart would do"
        if self._part == "state" and self._worst > self._limit:
            said += "; if the contact force is another one than the scene's, --friction other"
        return said


def _rounded_down(value: float) -> float:
    """To one digit."""
    unit = 10.0 ** math.floor(math.log10(value))
    return math.floor(value / unit) * unit
