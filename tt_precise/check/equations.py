"""Residuals of a trajectory in its equations of motion, from row to row.

The flow of the equations propagates every row to the next row, where components and energy are
compared. The differences are summed from the start, in units of the size of the state at the start,
so that a slow drift is detected at every spacing of the rows. The errors of the flow and the
rounding of the rows are subtracted from the sums; the remainder is an error of the trajectory.

Where the equations may change between two rows (stick, slip, landing, a loss of contact), the scene
itself is integrated over the interval. An interval that is too long for the flow is left out and
counted.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy

from tt_precise.check.columns import Samples
from tt_precise.check.flow import (
    EPS,
    MOST_STEPS,
    ON_TABLE,
    FlowEnd,
    State,
    flow,
    margin,
    rows_under,
)
from tt_precise.check.result import Residual, to_one_digit
from tt_precise.mechanics import quantities
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS, formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import cross, dot, scaled, subtracted
from tt_precise.runtime.values import Array, InputError
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene

# The error that the flow may leave of a whole trajectory, a thousandth of the usual limit, is
# shared out over ``HORIZON`` times sqrt(R/g); the reference scene has 177.
RESOLVED, HORIZON = 1e-9, 100.0
ROUNDED = 8.0  # eps: a row is rounded in two numbers and in its energy, at either end.
A_STEP = 2.0  # eps that a step of an integration adds.
FEWEST_RESOLVED = 0.5  # Part of the intervals: a few resolved ones do not confirm the others.
# In sqrt(g R), of a contact point at rest, from other columns: some hundred roundings.
ROUNDED_SPEED = 1e-13
# Of the size: a start so far off shows how an error grows through joints, to 1e-5 by rounding.
NEARBY = 1e-10
MOST_JOINTS = 200  # Intervals that are integrated; of more, every second or third one.
# rad by which the top turns in them altogether: 15 in each. Numbers in another unit ask for hours.
MOST_TURN = 3e3
# Part of their sizes by which rows may leave the equations since the start: a thousand times what
# ``equations`` usually allows, as often with other limits. A solution that is further off is not
# the motion of the rows, and no time is spent on what would have to be carried in many steps.
APART, FAR_BEYOND = 1e-3, 1e3
FEW, FEW_STEPS = 32, 8  # Intervals that are carried on, and their steps, where rows have left.
AT_ONCE = 16_384  # Rows whose states and energies are held at once: 20 MB.


class Differences(NamedTuple):
    """The differences of each row from the row before, propagated to the same time.

    ``state`` (quantities, intervals) and ``energy`` (intervals,) are in units of their sizes at the
    start, ``momentum`` (3, intervals) about the lowest point in units of that of L; ``bound``
    (intervals,) is what the flow and the rounding of the rows make of them, infinite where the row
    before could not be carried so far. ``reached`` (s, intervals) is how far it was, 0 where the
    equations may change, NaN where nobody asked. ``least`` (intervals,) bounds the ``margin`` of
    the equations between the rows from below. ``joints`` counts the intervals in which the
    equations may change: those that were integrated, and all; ``left`` those that were not carried
    because the rows had left the equations.
    """

    state: Array
    momentum: Array
    energy: Array
    bound: Array
    reached: Array
    least: Array
    joints: tuple[int, int] = (0, 0)
    left: int = 0

    @property
    def sums(self) -> tuple[Array, Array]:
        """The differences of the state since the start, and the bounds of their errors."""
        return numpy.cumsum(self.state, axis=1), ROUNDED * EPS + numpy.cumsum(self.bound)


def equations(rows: Samples, limit: float) -> Residual:
    """Add up the differences of the state."""
    found = differences(rows, max(APART, FAR_BEYOND * limit))
    return _added_up(found.state, found, limit)


def energy_balance(rows: Samples, limit: float) -> Residual:
    """Add up the differences of the energy."""
    found = differences(rows, max(APART, FAR_BEYOND * limit))
    return _added_up(found.energy[None], found, limit)


def _added_up(mismatch: Array, found: Differences, limit: float) -> Residual:
    resolved = found.bound <= limit
    sums = numpy.cumsum(numpy.where(resolved, mismatch, 0.0), axis=1)
    bounds = ROUNDED * EPS + numpy.cumsum(numpy.where(resolved, found.bound, 0.0))
    values = numpy.maximum(abs(sums).max(axis=0) - bounds, 0.0)
    enough = resolved.any() and resolved.mean() >= FEWEST_RESOLVED
    bound = float(bounds[-1]) if enough else math.inf
    note = f"error bound {bound:.0e}"
    looked_at, joints = found.joints
    if looked_at < joints:
        note += f"; {looked_at} of {joints} possible changes of the equations looked at"
    if found.left:
        note += f"; {found.left} of {len(resolved)} intervals not looked at: the rows leave too far"
    wide = int((~resolved).sum()) - (joints - looked_at) - found.left
    if wide > 0:
        note += f"; {wide} of {len(resolved)} intervals too wide"
        within = float(numpy.fmin.reduce(found.reached[~resolved]))
        if within > 0:
            note += f"; rows {to_one_digit(within, math.floor):g} s apart would suffice"
    return Residual(numpy.append(0.0, values), bound, note)


def differences(samples: Samples, far: float = APART) -> Differences:
    """Return the differences of all rows, computed once for all checks.

    Behind rows that have left the equations by ``far`` not all are carried.
    """
    key = f"differences up to {far}"
    if key not in samples.shared:
        found = _row_differences(samples, sizes_of(samples), far)
        if samples.setup.may_switch:
            found = _integrate_switches(samples, found)
        samples.shared[key] = found
    there: Differences = samples.shared[key]
    return there


def _row_differences(samples: Samples, sizes: Array, far: float) -> Differences:
    parts, left = [], 0
    for first in range(0, len(samples.t) - 1, AT_ONCE):
        part = samples.rows(slice(first, first + AT_ONCE + 1))
        apart, there, all_carried = _ends_of(samples, part, sizes, far, backward=not first)
        left += 0 if all_carried else int((~numpy.isfinite(there.error)).sum())
        bound = there.error + ROUNDED * EPS * there.growth
        reached = numpy.diff(part.t) * there.reached
        parts.append((apart[:-4], apart[-4:-1], apart[-1], bound, reached, there.least))
    state, momentum, energy, bound, reached, least = (
        numpy.concatenate(one, axis=-1) for one in zip(*parts, strict=True)
    )
    return Differences(state, momentum, energy, bound, reached, least, left=left)


def _ends_of(
    samples: Samples, part: Samples, sizes: Array, far: float, backward: bool
) -> tuple[Array, FlowEnd, bool]:
    """Return the ``_functions`` of a part's rows less those of the rows before, and the flow's end.

    Where the rows have left the equations by ``far``, a few of those that need many steps are
    carried, and in few steps: the last value is False then. With ``backward`` the first interval is
    carried from its end if it cannot be from its begin: no row before would say whether its first
    row is wrong.
    """
    setup, spans = samples.setup, numpy.diff(part.t)
    before, after = (_at(part.state, ends) for ends in (slice(None, -1), slice(1, None)))
    wanted = RESOLVED / (HORIZON * setup.time) * abs(spans)
    watched = not setup.flies
    there = flow(setup.scene, setup.body, before, spans, sizes, wanted, watched=watched, most=1)
    apart = _functions(samples, after, sizes)
    # the energy of rows rises by their differences from the flow, in which it falls
    rise = float((apart[-1] - numpy.minimum.accumulate(apart[-1])).max())
    apart -= _functions(samples, type(before)(*there.state), sizes)

    def propagate(
        some: Array, begin: State, end: State, way: float, most: int = MOST_STEPS
    ) -> None:
        if not len(some):
            return
        here, target = _at(begin, some), _at(end, some)
        found = flow(
            setup.scene, setup.body, here, way * spans[some], sizes, wanted[some],
            watched=watched, most=most,
        )  # fmt: skip
        apart[:, some] = _functions(samples, target, sizes)
        apart[:, some] -= _functions(samples, type(here)(*found.state), sizes)
        for whole, one in zip(there, found, strict=True):
            whole[..., some] = one

    def has_left() -> bool:
        return not setup.may_switch and (rise > far or _gone(apart, there, far))

    late = numpy.flatnonzero(~numpy.isfinite(there.error))
    propagate(late[:FEW], before, after, 1.0, FEW_STEPS if has_left() else MOST_STEPS)
    if has_left():
        return apart, there, False
    propagate(late[FEW:], before, after, 1.0)
    if backward and there.reached[0] != 1:
        propagate(numpy.array([0]), after, before, -1.0)
    return apart, there, True


def _gone(apart: Array, there: FlowEnd, far: float) -> bool:
    """Test that rows have left the equations by ``far`` since the start."""
    carried = numpy.isfinite(there.error)
    compared = numpy.vstack((apart[:-4], apart[-1:]))  # the momentum is not without the azimuth
    sums = abs(numpy.cumsum(numpy.where(carried, compared, 0.0), axis=1)).max(axis=0)
    bounds = numpy.cumsum(numpy.where(carried, there.error + ROUNDED * EPS * there.growth, 0.0))
    return bool((sums - bounds > far).any())


def _at(state: State, rows: Array | slice) -> State:
    return type(state)(*(entry[rows] for entry in state))


def sizes_of(samples: Samples) -> Array:
    """Return the units of differences of the entries: the smaller sizes of the first two rows.

    A wrong first row would make all differences small.
    """
    found = []
    for row in (0, 1):
        q = samples.rows(slice(row, row + 1)).first
        spin = float(numpy.sqrt(dot(q.state.L, q.state.L))) or 1.0
        speed = float(q.body.R * numpy.sqrt(dot(q.omega, q.omega))) or 1.0
        lifted = [float(q.body.R), speed] if samples.setup.height_given else []
        found.append([1.0] * 3 + [spin] * 3 + [speed] * 2 + lifted)
    smaller: Array = numpy.fmin(*numpy.array(found))
    return smaller


def _functions(samples: Samples, state: State, sizes: Array) -> Array:
    """Return the compared quantities over their sizes, one row each; momentum and energy last.

    Without the azimuth, what a turn of the whole motion about the vertical leaves alone.
    """
    setup = samples.setup
    q = Motion(setup.body, state, numpy, setup.scene.model)
    momentum = subtracted(q.state.L, scaled(setup.body.m, cross(q.a, q.s_dot)))
    size = float(INTEGRALS["energy"].scale(samples.first)) or 1.0
    width = len(formulation(setup.scene.model, "newton", setup.scene.body.friction).columns)
    entries = [*state[:width], *state[8:]]
    units = [*sizes[:width], *sizes[8:]]
    if not setup.columns.azimuth:
        k, L, v = state.k, state.L, state.v
        entries = [k[2], L[2], dot(L, k), cross(L, k)[2]]
        units = [1.0, *sizes[3:6]]
        if width > 6:
            entries += [v[0] * k[0] + v[1] * k[1], v[1] * k[0] - v[0] * k[1]]
            units += [*sizes[6:8]]
        entries, units = [*entries, *state[8:]], [*units, *sizes[8:]]
    entries, units = [*entries, *momentum, quantities.E(q)], [*units, *sizes[3:6], size]
    return numpy.array([entry / unit for entry, unit in zip(entries, units, strict=True)])


def _integrate_switches(samples: Samples, found: Differences) -> Differences:
    """Integrate the scene through the intervals in which the equations may change."""
    setup, sizes = samples.setup, sizes_of(samples)
    steps = numpy.diff(samples.t)
    joined = _switch_intervals(samples, found) | ~numpy.isfinite(found.bound)
    joints = numpy.flatnonzero(joined)
    found.bound[joined], found.reached[joined] = numpy.inf, 0.0
    looked_at = joints[:: math.ceil(len(joints) / MOST_JOINTS) or 1]
    omega = numpy.sqrt(dot(samples.q.omega, samples.q.omega))[:-1]
    looked_at = looked_at[numpy.cumsum((omega * steps)[looked_at]) <= MOST_TURN]
    aside = NEARBY * numpy.resize([1.0, -1.0], len(sizes)) * sizes
    for i in looked_at.tolist():
        row, span = numpy.array([entry[i] for entry in samples.state]), float(steps[i])
        end, reached, count = through_switches(setup.scene, row, span)
        beside = row + aside * (row != 0)  # an exact 0: the contact point rests
        apart = through_switches(setup.scene, beside, span)[0] - end
        growth = max(float((abs(apart) / sizes).max()) / NEARBY, 1.0)
        there, given = type(samples.state)(*end[:, None]), _at(samples.state, slice(i + 1, i + 2))
        mismatch = _functions(samples, given, sizes) - _functions(samples, there, sizes)
        mismatch += (span - reached) / setup.time  # rows behind a solution's end
        found.state[:, i], found.energy[i] = mismatch[:-4, 0], mismatch[-1, 0]
        found.momentum[:, i] = mismatch[-4:-1, 0]
        found.bound[i] = EPS * (ROUNDED + A_STEP * count) * growth
    return found._replace(joints=(len(looked_at), len(joints)))


def _switch_intervals(samples: Samples, found: Differences) -> Array:
    """Intervals in which the equations may have changed.

    The contact point has not come to rest or left it where it rests at both ends, and cannot have
    where, from either end, twice the rate of v_A would not have brought it to 0. Nor does the flow
    leave or touch the table, or the cone where it rests.
    """
    scene, body, state = samples.setup.scene, samples.setup.body, samples.state
    aloft, held = numpy.zeros((2, len(samples.t)), bool)
    change = numpy.zeros(len(samples.t))
    with numpy.errstate(all="ignore"):
        for rows, form in rows_under(scene, body, state):
            here = _at(state, rows)
            aloft[rows] = form.model == "flight"
            # just behind a loss of contact a row is still at the table, which would have to pull it
            held[rows] = margin(scene, body, form, here) >= 0
            if form.model != "rolling":
                slopes = form.rates(body, form.State(*here[: len(form.columns)]), numpy)
                change[rows] = 2 * numpy.hypot(slopes[6], slopes[7])
    steps = numpy.diff(samples.t)
    stays = (aloft[:-1] == aloft[1:]) & held[:-1] & held[1:] & (found.least > 0)
    if scene.may_stick:
        speed = numpy.hypot(state.vx, state.vy)
        glides = (speed[:-1] > change[:-1] * steps) & (speed[1:] > change[1:] * steps)
        stays &= glides | ((speed[:-1] == 0) & (speed[1:] == 0))
    joined: Array = ~stays
    return joined


def through_switches(scene: Scene, row: Array, span: float) -> tuple[Array, float, int]:
    """The motion from the state ``row`` on, through all changes of its equations.

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
            segments = backend.run(scene, setup, start, None)
    except InputError:  # the law does not say how the motion goes on
        return row, 0.0, 0
    last = segments[-1]
    there = (*last.columns.motion(last.end_row).state, 0, 0)
    end = [float(x * unit) for x, unit in zip(there, units, strict=False)]
    steps = sum(segment.run.steps for segment in segments)
    return numpy.array(end), float((last.begin + last.end_time) * start.units.time), steps
