"""Whether a trajectory follows its equations of motion between the rows.

For every interval the change of each entry x of the state, x(t1) - x(t0), is compared with the
integral of its rate, and the change of E with the integral of -mu g_n v_A^2. The integrals come
from the Taylor coefficients that the equations themselves give at both ends, by Hermite's rule,
in rising order until the interval is resolved. The differences are added up from the start, so
that the sampling interval does not matter: what is measured is
|x(t) - x(0) - integral of rates|, in units of the size of x at the start.

What the highest order leaves open is followed from row to row (``follow``), and the solution's
end compared with the next row; the first interval is followed back from its end, too. Where the
equations may change (stick, slip, landing, a loss of contact), the scene itself is integrated from
row to row (``through_joints``). Where rows lie too far apart even for that, the interval is left
out and counted. From the sum of the others, the error bounds and the rounding are subtracted: a
value that remains is the trajectory's own. Rows closer together than the equations need are passed
over.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import CheckSetup, Samples
from tt_precise.mechanics import compliant, quantities
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, Formulation, formulation
from tt_precise.mechanics.friction import cone_margin
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot
from tt_precise.nonsmooth.phases import elastic_in_time, raised
from tt_precise.runtime.values import Array, InputError, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene
from tt_precise.taylor.series import SeriesFunctions, Truncated, coefficients

ON_TABLE = 1e-9  # of R: below this a rigid table is touched
POINTS = 9  # points of an interval at which a solution is tested
State = NewtonState | LiftedState
Rates = Callable[[tuple[Scalar, ...]], Sequence[Scalar]]
SERIES = SeriesFunctions(numpy)


class RowsUnder(NamedTuple):
    """Rows (a mask, or all) that obey one formulation, in vectors."""

    rows: Array | slice
    form: Formulation


def rows_under(scene: Scene, body: Parameters, state: State) -> list[RowsUnder]:
    """The rows of ``state`` grouped by their equations, without empty groups."""
    lifted = isinstance(state, LiftedState)
    if scene.model == "flight" and lifted:
        return [RowsUnder(slice(None), raised())]
    gliding = formulation(scene.model, "newton", scene.body.friction)
    on_table = numpy.ones(len(state.kx), bool)
    if isinstance(state, LiftedState) and not body.spring:
        on_table = state.height <= ON_TABLE * body.R
    elif isinstance(state, LiftedState):
        on_table = (state.height < 0) & (compliant.reach(body, state.height, state.rise) < 0)
        gliding = elastic_in_time(body.spring, body.friction)
    rests = numpy.zeros(len(on_table), bool)
    if scene.may_stick:
        rests = on_table & (state.vx == 0) & (state.vy == 0)
    candidates = (
        (on_table & ~rests, gliding),
        (rests, formulation("rolling", "newton")),
        (~on_table, raised()),
    )
    there = [(rows, form) for rows, form in candidates if rows.any()]
    if len(there) == 1:  # all rows
        return [RowsUnder(slice(None), there[0][1])]
    return [RowsUnder(*pair) for pair in there]


def rates_of(form: Formulation, body: Parameters) -> Rates:
    """The equations of ``form`` for series."""
    return lambda entries: form.rates(body, form.State(*entries), SERIES)


def least_margin(rows: Samples, steps: Array) -> Array:
    """The least contact force of the solutions through the rows within ``steps`` (s).

    Infinite where the series does not say its sign.
    """
    solved = SolvedRows(rows.setup.scene, rows.setup.body, rows.state, ORDERS[-1])
    times = steps * numpy.linspace(0, 1, POINTS)[1:, None]
    powers = numpy.arange(ORDERS[-1] + 1)[:, None, None]
    with numpy.errstate(all="ignore"):
        terms = solved.margins[:, None] * times**powers
        force = terms.sum(axis=0)
        known = abs(terms[-2:]).max(axis=0) <= FITS * abs(force)
    least: Array = numpy.where(known, force, numpy.inf).min(axis=0)
    return least


def lift_off(rows: Samples) -> float:
    """The time (s) at which a solution through a row leaves the table before the next; or inf."""
    solved = SolvedRows(rows.setup.scene, rows.setup.body, rows.state, ORDERS[-1])
    for row, step in enumerate(numpy.diff(rows.t)):
        margin = solved.margins[:, row]
        if not numpy.isfinite(margin).all():
            break
        roots = numpy.polynomial.Polynomial(margin).roots()
        real = roots.real[abs(roots.imag) < 1e-6 * step]
        times = real[(real > 0) & (real <= step)]
        # where the last two terms are not small, the series is not the solution
        terms = abs(margin[:, None] * times ** numpy.arange(len(margin))[:, None])
        times = times[terms[-2:].max(axis=0) <= FITS * terms.max(axis=0)]
        if len(times):
            return float(rows.t[row] + times.min())
    return math.inf


class SolvedRows:
    """The Taylor series of the solutions through the rows."""

    def __init__(self, scene: Scene, body: Parameters, state: State, order: int):
        self._body, self._order = body, order
        self.parts = rows_under(scene, body, state)
        self._count = len(state.kx)
        solved = [self._solved(state, part) for part in self.parts]
        self.state = solved[0]
        if len(solved) > 1:
            self.state = type(state)(*map(self._together, zip(*solved, strict=True)))

    def _solved(self, state: State, part: RowsUnder) -> State:
        start = numpy.array([entry[part.rows] for entry in state])
        width = len(part.form.columns)
        series = numpy.zeros((len(start), self._order + 1, len(start[0])))
        series[:width] = coefficients(
            rates_of(part.form, self._body), list(start[:width]), self._order
        )
        series[width:, 0] = start[width:]
        return type(state)(*map(Truncated, series))

    def _together(self, series: Sequence[Truncated]) -> Truncated:
        whole = numpy.empty((self._order + 1, self._count))
        for part, terms in zip(self.parts, series, strict=True):
            whole[:, part.rows] = terms.c
        return Truncated(whole)

    def _motions(self) -> Iterator[tuple[RowsUnder, Motion]]:
        for part in self.parts:
            state = type(self.state)(*(Truncated(x.c[:, part.rows]) for x in self.state))
            yield part, Motion(self._body, state, SERIES, part.form.model)

    @property
    def power(self) -> Array:
        """Coefficients of the rate of the energy."""
        coefficients = numpy.zeros((self._order + 1, self._count))
        for part, q in self._motions():
            if part.form.model not in ("rolling", "flight"):
                coefficients[:, part.rows] = quantities.E_dot(q).upto(self._order)
        return coefficients

    @cached_property
    def margins(self) -> Array:
        """Coefficients of the function that is positive until each row's equations change.

        The contact force, the distance from the cone where the contact rests, the height in flight.
        """
        coefficients = numpy.zeros((self._order + 1, self._count))
        for part, q in self._motions():
            margin = q.state.height if part.form.model == "flight" else q.force[2]
            if part.form.model == "rolling":
                margin = cone_margin(self._body, q.state)
            coefficients[:, part.rows] = margin.upto(self._order)
        return coefficients

    def stays(self, steps: Array) -> Array:
        """Intervals (of ``steps`` s) in which the top neither leaves the table nor touches it.

        Seen from either end.
        """
        margins, which = self.margins, numpy.zeros(self._count)
        for part in self.parts:
            which[part.rows] = part.form.model == "flight"
        # just behind a loss of contact a row is still at the table, which would have to pull it
        held = margins[0] >= 0
        staying: Array = (which[:-1] == which[1:]) & held[:-1] & held[1:]
        for end, sign in ((slice(None, -1), 1), (slice(1, None), -1)):
            for fraction in numpy.linspace(0, 1, POINTS)[1:-1]:
                h = sign * fraction * steps
                staying = staying & (
                    numpy.polynomial.polynomial.polyval(h, margins[:, end], False) > 0
                )
        return staying


EPS = float(numpy.finfo(float).eps)
TERMS = 20  # Taylor coefficients: for eps, half its digits in base e, and two
STEP = math.exp(-2)  # of the radius of convergence: the last of TERMS coefficients is then eps
MOST_STEPS = 32
NUDGE = 1e-7  # of the size: far above rounding, far below what is not linear any more
ROUNDED = 4.0  # eps: a row is rounded in two numbers of either end
A_STEP = 2.0  # eps that a Taylor step adds


class Followed(NamedTuple):
    """The solutions through rows at the ends of their spans.

    ``state`` has shape (entries, rows). ``error`` bounds what rounding, of the rows and of the
    steps, has made of it, relative to the sizes; infinite where the end was not reached.
    ``reached`` is the time in s up to which the error stayed below what was wanted.
    """

    state: numpy.ndarray
    error: numpy.ndarray
    reached: numpy.ndarray


def follow(
    rates: Rates,
    start: numpy.ndarray,
    spans: numpy.ndarray,
    sizes: numpy.ndarray,
    wanted: float,
) -> Followed:
    """The solutions that start at the columns of ``start``, each after its span (s).

    ``sizes`` (entries,) is what a difference of each entry is measured in; a solution whose error
    has come above ``wanted``, or which needs more than ``MOST_STEPS``, is given up.
    """
    size = sizes[:, None]
    signs = numpy.where(numpy.arange(len(start)) % 2, -1.0, 1.0)[:, None]
    here = numpy.stack((start, start + NUDGE * signs * size), axis=2)
    t, error = numpy.zeros(len(spans)), numpy.full(len(spans), ROUNDED * EPS)
    open_ = numpy.arange(len(spans))
    for count in range(1, MOST_STEPS + 1):
        both = here[:, open_].reshape(len(start), -1)
        c = coefficients(rates, list(both), TERMS).reshape(len(start), TERMS + 1, len(open_), 2)
        h = numpy.minimum(_step(abs(c[:, :, :, 0]) / sizes[:, None, None]), spans[open_] - t[open_])
        ahead = _at(c, h)
        growth = (abs(ahead[:, :, 1] - ahead[:, :, 0]) / size).max(axis=0) / NUDGE
        bound = EPS * (ROUNDED + A_STEP * count) * numpy.maximum(growth, 1.0)
        good = (bound <= wanted) & (h > 0)  # false where a state is NaN
        open_, h = open_[good], h[good]
        here[:, open_], error[open_] = ahead[:, good], bound[good]
        t[open_] += h
        open_ = open_[t[open_] < spans[open_]]
        if not len(open_):
            break
    error[t < spans] = numpy.inf
    return Followed(here[:, :, 0], error, t)


def _step(sizes: numpy.ndarray) -> numpy.ndarray:
    """Length of the step (s) of each row, from the sizes of its coefficients; NaN if there is none.

    The last two coefficients stand for the radius of convergence, as in Jorba and Zou, Experimental
    Mathematics 14 (2005) 99.
    """
    last, before = sizes[:, -1].max(axis=0), sizes[:, -2].max(axis=0)
    return STEP * numpy.minimum(last ** (-1 / TERMS), before ** (-1 / (TERMS - 1)))


def _at(c: numpy.ndarray, h: numpy.ndarray) -> numpy.ndarray:
    total = c[:, -1]
    for k in range(c.shape[1] - 2, -1, -1):
        total = total * h[:, None] + c[:, k]
    return total


def through_joints(scene: Scene, row: Array, span: float) -> tuple[Array, float, int]:
    """The motion from the state ``row`` on, whatever changes of its equations it meets.

    The state after ``span`` (s) or where the motion ends, the time until then, and the steps taken.
    """
    from tt_precise.integration.setup import Setup, ended_at_start
    from tt_precise.nonsmooth import backend
    from tt_precise.nonsmooth.lifting import flying
    from tt_precise.nonsmooth.segments import SegmentStart

    setup = Setup.of(scene, events=(), record=())
    start = InitialState.of(scene, setup.precision.arithmetic)
    fn, names = setup.precision.context, LiftedState._fields[: len(row)]
    units = [start.units.of_dimension(STATE_DIMENSIONS[name]) for name in names]
    entries = [fn.mpf(float(x)) / unit for x, unit in zip(row, units, strict=True)]
    state: Any = LiftedState(*entries, *[fn.mpf(0)] * (10 - len(row)))
    if abs(state.vx) + abs(state.vy) < ROUNDED_SPEED:
        state = state._replace(vx=fn.mpf(0), vy=fn.mpf(0))
    on_table = state if scene.body.spring else NewtonState(*state[:8])
    start = replace(start, vectors=on_table, until=span / start.units.time)
    try:
        pulled = ended_at_start(start, setup.contact, fn)
        if not scene.body.spring and (pulled or state.height > ON_TABLE):
            above = SegmentStart.of_run(setup, replace(start, vectors=state))
            segments = [flying(setup, above, start.until * 0)]
        else:
            segments = backend.run(scene, setup, start, None, None)
    except InputError:  # the law does not say how the motion goes on
        return row, 0.0, 0
    last = segments[-1]
    there = (*last.columns.motion(last.output.end_row).state, 0, 0)
    end = [float(x * unit) for x, unit in zip(there, units, strict=False)]
    steps = sum(segment.output.propagation.steps for segment in segments)
    return numpy.array(end), float((last.begin + last.output.end_time) * start.units.time), steps


ORDERS = (2, 4, 8, 13)  # Taylor coefficients used at either end of an interval
RESOLVED = 1e-9  # wanted error bound of a whole check, before a higher order is tried
HORIZON = 100.0  # in sqrt(R/g), over which RESOLVED is shared out; the reference has 177
# What a rule misses is taken to be the difference from the rule one order below, times its ratio to
# the difference before, times MARGIN; if the ratio is not small, MOST times it.
MARGIN, MOST = 100.0, 10.0
WIDEST_BOUND = 1e-6  # of one interval through which the solution is followed
FEWEST_RESOLVED = 0.5  # of the intervals: a few resolved ones do not vouch for all the others
FITS = 1e-3  # part of a series that its last two terms may be where the series is the solution
CLOSEST = 0.005  # in sqrt(R/g): nearer rows say nothing new about the equations
ROUNDED_SPEED = 1e-13  # in units of sqrt(g R): of a contact point at rest, from other columns
NEARBY = 1e-10  # of the size: a start so far off shows how an error grows through joints
MOST_JOINTS = 200  # of a block that are integrated


class Residuals(NamedTuple):
    """Changes minus integrals of rates of every interval, with error bounds.

    ``state`` has shape (entries, intervals), ``energy`` (intervals,), both in units of their size
    at the start; ``bound`` (intervals,) is that of the error of these numbers. ``ends`` are the
    rows where the intervals end; ``within`` (s, intervals) is how far the solution was followed, 0
    where the equations may change.
    """

    state: numpy.ndarray
    energy: numpy.ndarray
    bound: numpy.ndarray
    ends: numpy.ndarray
    within: numpy.ndarray


def integral(left: Array, right: Array, steps: Array, terms: int) -> Array:
    """Integrals over intervals of functions with these Taylor coefficients at both ends.

    Hermite's two-point rule with ``terms`` coefficients at either end, exact for polynomials of
    degree 2 ``terms`` - 1. ``left`` and ``right`` have shape (functions, terms or more,
    intervals); the result has shape (functions, intervals).
    """
    total = numpy.zeros((len(left), len(steps)))
    power = numpy.array(steps)
    f, m = math.factorial, terms
    for j in range(m):
        weight = f(m) * f(2 * m - j - 1) / (f(2 * m) * f(m - j - 1) * (j + 1))
        total += weight * power * (left[:, j] + (-1) ** j * right[:, j])
        power = power * steps
    return total


class EquationResidual:
    """The balances of one setup; sizes are taken from its first row.

    ``resolved`` is the error bound of a whole trajectory at which no higher order is tried.
    """

    def __init__(self, setup: CheckSetup, first: Samples, resolved: float = RESOLVED):
        self.setup, self._resolved = setup, resolved
        self._form = formulation(setup.scene.model, "newton", setup.scene.body.friction)
        if setup.flies and setup.height_given:
            self._form = raised()
        self._width = 10 if setup.height_given else len(self._form.columns)
        self._begins, self.joints = float(first.t[0]), numpy.zeros(2, int)  # looked at, and all
        self._energy_size = float(INTEGRALS["energy"].scale(first.first)) or 1.0
        self._entry_sizes = self._sizes_at(first.first)
        spin, speed, *lifted = self._entry_sizes[5], *self._entry_sizes[7:]
        one_axis = [1.0, spin, spin, spin, speed, speed, *lifted]
        self._sizes = self._entry_sizes if setup.columns.azimuth else one_axis

    def _sizes_at(self, q: Motion) -> list[float]:
        spin = float(numpy.sqrt(dot(q.state.L, q.state.L))) or 1.0
        speed = float(q.body.R * numpy.sqrt(dot(q.omega, q.omega))) or 1.0
        lifted = [float(q.body.R), speed] if self.setup.height_given else []
        return [1.0] * 3 + [spin] * 3 + [speed] * 2 + lifted

    def balance(self, samples: Samples) -> Residuals:
        """The balance of every interval of ``samples``; computed once for all checks."""
        if "balance" not in samples.shared:
            apart = self._apart(samples.t)
            rows = samples.rows(apart)
            samples.shared["balance"] = self._followed(rows, self._balance(rows, apart[1:]))
        residuals: Residuals = samples.shared["balance"]
        return residuals

    def _apart(self, t: numpy.ndarray) -> numpy.ndarray:
        last = len(t) - 1
        if t[-1] - t[0] > last * CLOSEST * self.setup.time:
            return numpy.arange(len(t))
        cell = numpy.floor((t - t[0]) / (CLOSEST * self.setup.time))
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
        """Intervals in which the equations may have changed.

        The contact point has not come to rest or left it where it rests at both ends, and cannot
        have where, from either end, twice the rate of v_A would not have brought it to 0. Nor does
        either end's solution leave or touch the table, or the cone where it rests.
        """
        scene, state = self.setup.scene, samples.state
        with numpy.errstate(all="ignore"):
            solved = SolvedRows(scene, self.setup.body, state, ORDERS[-1])
            joined = ~solved.stays(steps)
        if not scene.may_stick:
            return joined
        speed = numpy.hypot(state.vx, state.vy)
        change = 2 * numpy.hypot(solved.state.vx.c[1], solved.state.vy.c[1])
        glides = (speed[:-1] > change[:-1] * steps) & (speed[1:] > change[1:] * steps)
        rests = (speed[:-1] == 0) & (speed[1:] == 0)
        return joined | ~(glides | rests)

    def _wanted(self, steps: Array) -> Array:
        return numpy.maximum(self._resolved * steps / (HORIZON * self.setup.time), 4 * EPS)

    def _followed(self, samples: Samples, residuals: Residuals) -> Residuals:
        """The balance, with the solution followed where the quadrature left it open."""
        steps, sizes = numpy.diff(samples.t), numpy.array(self._entry_sizes)
        joined = residuals.within == 0
        wide = numpy.flatnonzero(~(residuals.bound <= self._wanted(steps)) & ~joined)
        joints = numpy.flatnonzero(joined)
        looked_at = joints[:: math.ceil(len(joints) / MOST_JOINTS) or 1]
        self.joints += len(looked_at), len(joints)
        for open_, solved in ((wide, self._solved), (looked_at, self._joining)):
            if not len(open_):
                continue
            begun, given = self._at(samples, open_), self._at(samples, open_ + 1)
            there, error, reached = solved(begun, steps[open_], sizes)
            mismatch = self._functions(given, 1)[0] - self._functions(there, 1)[0]
            mismatch += (steps[open_] - reached) / self.setup.time  # rows behind a solution's end
            if wide is open_ and open_[0] == 0 and samples.t[0] == self._begins:
                # no interval before it ends in the first row and would say whether that is one
                ends = samples.rows(slice(1, 2))
                own = numpy.minimum(sizes, self._sizes_at(ends.first))
                before, back, _ = self._solved(ends.state, -steps[:1], own)
                if back[0] < error[0]:
                    first = self._functions(self._at(samples, slice(0, 1)), 1)[0]
                    mismatch[:, :1], error[0] = self._functions(before, 1)[0] - first, back[0]
            better = error < residuals.bound[open_]
            chosen, mismatch = open_[better], mismatch[:, better]
            residuals.state[:, chosen], residuals.energy[chosen] = mismatch[:-1], mismatch[-1]
            residuals.bound[chosen] = error[better]
            residuals.within[open_] *= reached / steps[open_]
        return residuals

    @staticmethod
    def _at(samples: Samples, rows: Array | slice) -> State:
        return type(samples.state)(*(entry[rows] for entry in samples.state))

    def _solved(self, here: State, spans: Array, sizes: Array) -> tuple[State, Array, Array]:
        """The solutions through rows after their spans (s, all of one sign); see ``Followed``."""
        end, error, reached = numpy.array(here), abs(spans), abs(spans)
        with numpy.errstate(all="ignore"):
            for rows, form in rows_under(self.setup.scene, self.setup.body, here):
                width, rates = len(form.columns), rates_of(form, self.setup.body)
                turned = rates if spans[0] > 0 else _backwards(rates)
                begun, lengths = end[:width, rows], abs(spans[rows])
                shot = follow(turned, begun, lengths, sizes[:width], WIDEST_BOUND)
                end[:width, rows], error[rows], reached[rows] = shot
        return type(here)(*end), error, reached

    def _joining(self, here: State, spans: Array, sizes: Array) -> tuple[State, Array, Array]:
        """As ``_solved`` where the equations may change; a solution may end before its span."""
        end, error, reached = numpy.array(here), abs(spans), abs(spans)
        aside = NEARBY * numpy.resize([1.0, -1.0], len(sizes)) * sizes
        for i, (row, span) in enumerate(zip(end.T.copy(), spans, strict=True)):
            beside = row + aside * (row != 0)  # an exact 0: the contact point rests
            end[:, i], reached[i], steps = through_joints(self.setup.scene, row, span)
            apart = through_joints(self.setup.scene, beside, span)[0] - end[:, i]
            growth = (abs(apart) / sizes).max() / NEARBY
            error[i] = EPS * (ROUNDED + A_STEP * steps) * max(growth, 1.0)
        return type(here)(*end), error, reached

    def _intervals(self, samples: Samples, chosen: Array, order: int) -> tuple[Array, Array]:
        count = len(chosen)
        if count == len(samples.t) - 1:
            values, rates = self._functions(samples.state, order)
            ends = slice(None, -1), slice(1, None)
        else:
            both = numpy.concatenate((chosen, chosen + 1))
            values, rates = self._functions(self._at(samples, both), order)
            ends = slice(None, count), slice(count, None)
        steps = samples.t[chosen + 1] - samples.t[chosen]
        left, right = (rates[:, :, end] for end in ends)
        orders = (order, order - 1, max(order - 2, 1))
        best, lower, lowest = (integral(left, right, steps, terms) for terms in orders)
        if order == 2:  # Hermite's rule has no order below 1: the left end alone takes its place
            lowest = left[:, 0] * steps
        last, before = abs(best - lower).max(axis=0), abs(lower - lowest).max(axis=0)
        shrinking = numpy.where(before > 0, numpy.minimum(MOST, MARGIN * last / before), MOST)
        change = values[:, ends[1]] - values[:, ends[0]]
        rounding = EPS * abs(best).max(axis=0)
        return change - best, last * shrinking + rounding

    def _functions(self, state: State, order: int) -> tuple[numpy.ndarray, numpy.ndarray]:
        """Values (functions, rows), and Taylor coefficients of their rates, of every row."""
        with numpy.errstate(all="ignore"):
            solved = SolvedRows(self.setup.scene, self.setup.body, state, order)
            power = solved.power[:order] / self._energy_size
        full = solved.state[: self._width]
        functions = full if self.setup.columns.azimuth else _without_azimuth(solved.state, full)
        values = [f.c[0] / size for f, size in zip(functions, self._sizes, strict=False)]
        slopes = [f.rate / size for f, size in zip(functions, self._sizes, strict=False)]
        q_rows = Motion(self.setup.body, state, numpy, self.setup.scene.model)
        values.append(quantities.E(q_rows) / self._energy_size)
        return numpy.array(values), numpy.array([*slopes, power])


def _backwards(rates: Rates) -> Rates:
    return lambda entries: [-rate for rate in rates(entries)]


def _without_azimuth(state: Any, balanced: tuple[Scalar, ...]) -> tuple[Scalar, ...]:
    # what turning the whole motion about the vertical leaves alone
    k, L, v = state.k, state.L, state.v
    entries: tuple[Scalar, ...] = (k[2], L[2], dot(L, k), cross(L, k)[2])
    if len(balanced) > 6:
        entries += (v[0] * k[0] + v[1] * k[1], v[1] * k[0] - v[0] * k[1])
    return (*entries, *balanced[8:])


class SummedResidual:
    """The balances added up from the start: values for the rows of each block, and the bound."""

    def __init__(self, residual: EquationResidual, part: str, limit: float):
        self._residual, self._part, self._limit = residual, part, limit
        self._sum: Array = 0.0
        self._bound = 4 * EPS  # the first and the last row are rounded, in two numbers each
        self._within = numpy.inf  # s: what was followed of the unresolved interval that is worst
        self.intervals = self.unresolved = 0

    def __call__(self, samples: Samples) -> numpy.ndarray:
        if len(samples.t) < 2:
            return numpy.zeros(len(samples.t))
        residuals = self._residual.balance(samples)
        resolved = residuals.bound <= self._limit
        self.intervals += len(resolved)
        self.unresolved += int((~resolved).sum())
        self._within = min(self._within, float(residuals.within[~resolved].min(initial=numpy.inf)))
        mismatch = numpy.atleast_2d(getattr(residuals, self._part))
        sums = numpy.cumsum(numpy.where(resolved, mismatch, 0.0), axis=1)
        sums += numpy.reshape(self._sum, (-1, 1))
        bounds = self._bound + numpy.cumsum(numpy.where(resolved, residuals.bound, 0.0))
        self._sum, self._bound = sums[:, -1], float(bounds[-1])
        values = numpy.maximum(abs(sums).max(axis=0) - bounds, 0.0)
        # a row that was passed over has the value of the end before it
        before = numpy.searchsorted(residuals.ends, numpy.arange(len(samples.t)), side="right")
        return numpy.concatenate(([0.0], values))[before]

    @property
    def error_bound(self) -> float:
        """Largest error that would go unnoticed, in the units of the value.

        Infinite where too many intervals were left out.
        """
        resolved = self.intervals - self.unresolved
        enough = resolved > 0 and resolved >= FEWEST_RESOLVED * self.intervals
        return self._bound if enough else numpy.inf

    @property
    def note(self) -> str:
        """The unresolved intervals, and the spacing of rows that would resolve them."""
        said = f"error bound {self.error_bound:.0e}"
        looked_at, joints = self._residual.joints.tolist()
        if looked_at < joints:
            said += f"; {looked_at} of {joints} possible changes of the equations looked at"
        wide = self.unresolved - (joints - looked_at)
        if wide > 0:
            said += f"; {wide} of {self.intervals} intervals too wide"
            if self._within > 0:
                said += f"; rows {to_one_digit(self._within, math.floor):g} s apart would do"
        return said


def to_one_digit(value: float, rounded: Callable[[float], int]) -> float:
    """``rounded`` up or down in its first digit."""
    exponent = math.floor(math.log10(value))
    return float(f"{rounded(value / 10.0**exponent)}e{exponent}")
