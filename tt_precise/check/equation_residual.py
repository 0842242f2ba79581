"""Whether a trajectory follows its equations of motion between the rows.

For every interval the change of each entry x of the state, x(t1) - x(t0), is compared with the
integral of its rate, and the change of E with the integral of -mu g_n v_A^2. The integrals come
from the Taylor coefficients that the equations themselves give at both ends, by Hermite's rule,
in rising order until the interval is resolved. The differences are added up from the start, so
that the sampling interval does not matter: what is measured is
|x(t) - x(0) - integral of rates|, in units of the size of x at the start.

Where rows lie too far apart for the highest order, the interval is left out and counted. From
the sum of the others, the doubts of the quadrature and the rounding are subtracted: a value that
remains is the trajectory's own. Rows closer together than the equations need are passed over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy

from tt_precise.check.samples import CheckSetup, Samples
from tt_precise.mechanics import quantities
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.taylor import SeriesFunctions, TaylorSeries, integral, solution
from tt_precise.mechanics.vectors import cross, dot

ORDERS = (2, 4, 8, 13)  # Taylor coefficients used at either end of an interval
RESOLVED = 1e-9  # wanted doubt of a whole check, before a higher order is tried
HORIZON = 100.0  # in sqrt(R/g), over which RESOLVED is shared out; the reference has 177
# What a rule misses is taken to be the difference from the rule one order below, times its ratio
# to the difference before, times MARGIN; where the ratio is no small one, MOST times it.
MARGIN, MOST = 100.0, 10.0
CLOSEST = 0.005  # in sqrt(R/g): nearer rows tell the equations nothing new
EPS = float(numpy.finfo(float).eps)


@dataclass(frozen=True)
class Residuals:
    """Changes minus integrals of rates of every interval, and how far to trust them.

    ``state`` has shape (entries, intervals), ``energy`` (intervals,), both in units of their size
    at the start; ``doubt`` (intervals,) bounds the quadrature's error in all of them. ``ends``
    are the rows where the intervals end.
    """

    state: numpy.ndarray
    energy: numpy.ndarray
    doubt: numpy.ndarray
    ends: numpy.ndarray


class EquationResidual:
    """The balances of one setup; sizes are taken from its first row.

    ``resolved`` is the doubt of a whole trajectory at which no higher order is tried.
    """

    def __init__(self, setup: CheckSetup, first: Samples, resolved: float = RESOLVED):
        self.setup, self._resolved = setup, resolved
        self._form = formulation(setup.scene.model, "newton", setup.scene.body.law)
        self._time = float(numpy.sqrt(setup.body.R / setup.body.g))
        q = first.first
        spin = float(numpy.sqrt(dot(q.state.L, q.state.L))) or 1.0
        speed = float(setup.body.R * numpy.sqrt(dot(q.omega, q.omega))) or 1.0
        self._energy_size = float(INTEGRALS["energy"].scale(q)) or 1.0
        if setup.columns.azimuth:
            self._sizes = [1.0] * 3 + [spin] * 3 + [speed] * 2
        else:
            self._sizes = [1.0, spin, spin, spin, speed, speed]

    def balance(self, samples: Samples) -> Residuals:
        """The balance of every interval of ``samples``; computed once for all checks."""
        if "balance" not in samples.shared:
            kept = self._apart(samples.t)
            samples.shared["balance"] = self._balance(samples.rows(kept), kept[1:])
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
        kept = numpy.flatnonzero(numpy.diff(cell, prepend=-1.0))
        return kept if kept[-1] == last else numpy.append(kept, last)

    def _balance(self, samples: Samples, ends: numpy.ndarray) -> Residuals:
        steps = numpy.diff(samples.t)
        every = numpy.arange(len(steps))
        with numpy.errstate(all="ignore"):
            mismatch, doubt = self._intervals(samples, every, ORDERS[0])
            for order in ORDERS[1:]:
                wanted = numpy.maximum(self._resolved * steps / (HORIZON * self._time), 4 * EPS)
                open_ = every[~(doubt <= wanted)]
                if not len(open_):
                    break
                finer, finer_doubt = self._intervals(samples, open_, order)
                better = (finer_doubt <= doubt[open_]) | numpy.isnan(doubt[open_])
                mismatch[:, open_[better]] = finer[:, better]
                doubt[open_[better]] = finer_doubt[better]
        doubt = numpy.where(numpy.isfinite(mismatch).all(axis=0), doubt, numpy.inf)
        return Residuals(mismatch[:-1], mismatch[-1], doubt, ends)

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

    def _functions(self, state: NewtonState, order: int) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Values (functions, rows), and Taylor coefficients of their rates, of every row."""
        body, model, form = self.setup.body, self.setup.scene.model, self._form
        width = len(form.columns)

        def rates(entries: tuple[TaylorSeries, ...]) -> Sequence[Any]:
            found: Sequence[Any] = form.rates(body, form.State(*entries), SeriesFunctions)
            return found

        entries = solution(rates, list(state[:width]), order)
        full = NewtonState(*entries, *(0,) * (8 - width))
        functions = full[:width] if self.setup.columns.azimuth else _without_azimuth(full, width)
        values = [f.c[0] / size for f, size in zip(functions, self._sizes, strict=False)]
        slopes = [f.rate / size for f, size in zip(functions, self._sizes, strict=False)]
        q, q_rows = Motion(body, full, SeriesFunctions, model), Motion(body, state, numpy, model)
        values.append(quantities.E(q_rows) / self._energy_size)
        power: Any = 0.0 if model == "rolling" else quantities.E_dot(q).c[:order]
        slopes.append(power / self._energy_size + numpy.zeros_like(slopes[0]))
        return numpy.array(values), numpy.array(slopes)


def _without_azimuth(state: NewtonState, width: int) -> tuple[Any, ...]:
    # what turning the whole motion about the vertical leaves alone
    k, L, v = state.k, state.L, state.v
    found: tuple[Any, ...] = (k[2], L[2], dot(L, k), cross(L, k)[2])
    if width == len(state):
        found += (v[0] * k[0] + v[1] * k[1], v[1] * k[0] - v[0] * k[1])
    return found


class SummedResidual:
    """The balances added up from the start: values for the rows of each block, and the doubt."""

    def __init__(self, residual: EquationResidual, part: str, limit: float):
        self._residual, self._part, self._limit = residual, part, limit
        self._sum: Any = 0.0
        self._doubt = 4 * EPS  # the first and the last row are rounded, in two numbers each
        self.intervals = self.unresolved = 0

    def __call__(self, samples: Samples) -> numpy.ndarray:
        if len(samples.t) < 2:
            return numpy.zeros(len(samples.t))
        found = self._residual.balance(samples)
        resolved = found.doubt <= self._limit
        self.intervals += len(resolved)
        self.unresolved += int((~resolved).sum())
        mismatch = numpy.atleast_2d(getattr(found, self._part))
        sums = numpy.cumsum(numpy.where(resolved, mismatch, 0.0), axis=1)
        sums += numpy.reshape(self._sum, (-1, 1))
        doubts = self._doubt + numpy.cumsum(numpy.where(resolved, found.doubt, 0.0))
        self._sum, self._doubt = sums[:, -1], float(doubts[-1])
        values = numpy.maximum(abs(sums).max(axis=0) - doubts, 0.0)
        # a row that was passed over has the value of the end before it
        before = numpy.searchsorted(found.ends, numpy.arange(len(samples.t)), side="right")
        return numpy.concatenate(([0.0], values))[before]

    @property
    def doubt(self) -> float:
        """Largest error that would go unnoticed, in the units of the value."""
        return self._doubt if self.unresolved < self.intervals else numpy.inf

    @property
    def note(self) -> str:
        """What was not resolved."""
        told = f"own doubt {self.doubt:.0e}"
        if self.unresolved:
            told += f"; {self.unresolved} of {self.intervals} intervals too wide to tell"
        return told
