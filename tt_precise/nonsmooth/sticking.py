"""Motions with Coulomb friction: gliding, sticking and slipping.

Below a small gliding speed the state has polar form, and a regularised time in which the contact
approaches rest asymptotically and reaches v = 0 to the last bit. The top then rolls if the force
required for rolling lies within the cone |F_f| <= mu g_n ("stick"), until this force reaches the
cone ("slip"). Gliding then begins again with a power series, as from a rest at which rolling is
impossible. The Euler form integrates only fast gliding in Euler angles, all else in vectors.

At the onset of gliding the equations are singular, and tau of the polar form would begin at
-infinity. The solution is v(t), e(t), k(t), L(t) as power series, coefficient by coefficient:
(v e')_k = (n.v_A_dot)_k is linear in the next coefficient of e. The factor v_1 k - N of this
coefficient is not zero; N < 0 is the derivative of n.v_A_dot with respect to the angle of e. Where
rolling reaches the cone, v_1 = 0 (``cone`` in exact.identities): v begins with t^2, and the series
is asymptotic; its terms finally grow like factorials, and its error is below the least term. Where
the force of rolling lies outside the cone at once, v_1 > 0, and the series converges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy

from tt_precise.integration.columns import Row
from tt_precise.integration.equations import QUADRATURE_SCALE, QUADRATURES
from tt_precise.integration.precision import functions_of
from tt_precise.integration.setup import Setup
from tt_precise.integration.solution import Propagation, Segment
from tt_precise.integration.steps import of_power_series
from tt_precise.integration.zeros import FoundEvents, Zeros, nothing_found
from tt_precise.mechanics import friction, newton, rolling
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.nonsmooth.phases import (
    MOST_SEGMENTS,
    REST_SPEED,
    SLOW_SPEED,
    SegmentStart,
    slow,
    sticking,
)
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Functions, InputError, Scalar
from tt_precise.scene.scene import InitialState
from tt_precise.taylor.series import SeriesFunctions, TaylorSeries, convolution

GOES_ON = ("slow", "fast", "stick", "slip")
DIRECTIONS = 64  # directions in which gliding may begin, tested for sign changes


# ---- the onset of gliding ----------------------------------------------------------------------


class _Registered(TaylorSeries):
    """A series that is listed in ``all``, together with all series derived from this series."""

    __slots__ = ("all",)

    def __init__(
        self,
        every: list[TaylorSeries],
        step: Callable[[Any, int], Scalar],
        first: Sequence[Scalar] = (),
    ):
        super().__init__(step, first)
        self.all = every

    def new(self, step: Callable[[Any, int], Scalar]) -> TaylorSeries:
        self.all.append(_Registered(self.all, step))
        return self.all[-1]


@dataclass(frozen=True)
class OnsetSeries:
    """Series of k, L, v, e in the time t >= 0 since rest, valid up to ``until``.

    ``coefficients`` has shape (9, terms): kx ... Lz, v, ex, ey, numbers of one arithmetic.
    """

    coefficients: numpy.ndarray
    until: Scalar

    def at(self, t: Scalar, fn: Functions) -> tuple[Scalar, ...]:
        """kx ... Lz, v, ex, ey at the time t."""
        powers = [t**k for k in range(self.coefficients.shape[1])]
        return tuple(fn.fdot(row, powers) for row in self.coefficients)


def direction_on_the_cone(
    body: Parameters, state: NewtonState, fn: Functions
) -> tuple[Scalar, Scalar]:
    """The direction of gliding when rolling reaches the cone: against the force."""
    x, y, _ = rolling.constraint_force(body, state)
    size = fn.hypot(x, y)
    return -x / size, -y / size


def directions_from_rest(
    body: Parameters, state: NewtonState, fn: Functions
) -> list[tuple[Scalar, Scalar]]:
    """Unit directions e in which v_A can grow from zero: v_A_dot is along e."""

    def accelerations(
        angle: Scalar, body: Parameters, state: NewtonState, fn: Functions
    ) -> tuple[Scalar, Scalar, Scalar]:
        """v_A_dot along and across a direction, times the denominator of g_n; the denominator."""
        e = fn.cos(angle), fn.sin(angle)
        pushed = state._replace(vx=e[0], vy=e[1])
        rate = friction.along_direction(body, pushed)
        _, size = newton.contact_terms(body, pushed)
        x, y = size * rate.vx, size * rate.vy
        return e[0] * x + e[1] * y, e[0] * y - e[1] * x, size

    step = 2 * fn.pi / DIRECTIONS
    # an offset, so that no direction of symmetry lies on a bound
    angles = [step * (fn.mpf(i) + fn.mpf(1) / 3) for i in range(DIRECTIONS + 1)]
    mpfr = mpfr_of(fn)
    all_at_once = body.numbers(mpfr.number), NewtonState(*map(mpfr.number, state)), mpfr
    with mpfr.precision():
        values = accelerations(mpfr.array(angles), *all_at_once)[1]
    here = body, state, fn
    directions = []
    for i in range(DIRECTIONS):
        if (values[i] > 0) != (values[i + 1] > 0):
            between = angles[i], angles[i + 1]
            angle = fn.findroot(lambda at: accelerations(at, *here)[1], between, solver="anderson")
            along, _, size = accelerations(angle, *here)
            if along > 0 and size > 0:
                directions.append((fn.cos(angle), fn.sin(angle)))
    return directions


def onset(
    body: Parameters,
    state: NewtonState,
    e: tuple[Scalar, Scalar],
    terms: int,
    eps: Scalar,
    fn: Functions,
    on_the_cone: bool,
) -> OnsetSeries:
    """The series of ``terms`` coefficients, and the time until which its last terms stay below eps.

    ``state`` is at rest, of mpmath numbers of the context ``fn``; e is its first direction.
    """
    mpfr = mpfr_of(fn)
    with mpfr.precision():
        columns = _coefficients(
            body.numbers(mpfr.number), [*map(mpfr.number, (*state[:6], *e))], terms, on_the_cone
        )
    back = [list(map(mpfr.back, column)) for column in columns]
    speed, until = back[6], _valid_until(back, eps, fn)
    # where the contact point comes to rest again, the series ends before
    while next(filter(None, speed), 0) > 0 >= fn.polyval(speed[::-1], until):
        until /= 2
    return OnsetSeries(numpy.array(back, dtype=object), until)


def _coefficients(
    body: Parameters, start: Sequence[Scalar], terms: int, on_the_cone: bool
) -> list[list[Scalar]]:
    """Return the coefficients of k, L, v, e, from k, L, e in ``start``."""
    operations: list[TaylorSeries] = []
    # the next coefficients are known before they are needed
    entries = [_Registered(operations, lambda c, k: None, [x]) for x in start]
    e, zero = start[6:], start[0] * 0
    rate = friction.along_direction(body, NewtonState(*entries))
    ex, ey = entries[6:]
    along = ex * rate.vx + ey * rate.vy
    across = ex * rate.vy - ey * rate.vx
    v = [zero]
    turning: list[Scalar] = []  # coefficients of the rate of e's angle

    def across_after(k: int, prescribed: tuple[Scalar, Scalar], angle: Scalar) -> Scalar:
        """across_k where coefficient k of e is the known part turned by an angle."""
        for operation in operations:
            del operation.c[k:]
        ex.c[k:], ey.c[k:] = [prescribed[0] - angle * e[1]], [prescribed[1] + angle * e[0]]
        return across[k]

    slope = None
    for k in range(terms):
        if k:
            # e' = w n: the part of e_k that former coefficients of w give, then the newest one's
            x, y = (
                sum((turning[j] * m.c[k - 1 - j] for j in range(k - 1)), zero) / k for m in (ey, ex)
            )
            turned = -x, y
            rest = across_after(k, turned, 0)
            if slope is None:
                slope = across_after(k, turned, 1) - rest
            former = sum((v[j] * turning[k - j] for j in range(2, k + 1)), zero)
            turning.append((rest - former) / (v[1] - slope / k))
            across_after(k, turned, turning[-1] / k)
        # on the cone v_A_dot vanishes up to rounding
        v.append(zero if not k and on_the_cone else along[k] / (k + 1))
        for entry, part in zip(entries[:6], rate[:6], strict=True):
            entry.c.append(part[k] / (k + 1))
    columns = [entry.c[:terms] for entry in entries]
    return [*columns[:6], v[:terms], *columns[6:]]


def _valid_until(columns: list[list[Scalar]], eps: Scalar, fn: Functions) -> Scalar:
    """Return the time until which the last two terms of every series stay below eps."""
    bounds = []
    for i, c in enumerate(columns):
        first = next((k for k, x in enumerate(c) if x), 0) if i == 6 else 0
        size = abs(c[first]) if i == 6 else 1
        last = [(k, abs(c[k])) for k in (len(c) - 2, len(c) - 1) if c[k]]
        bounds += [fn.root(eps * size / term, k - first) for k, term in last]
    return min(bounds)


TERMS_OF_MP = 0.35  # for each bit: fewer series terms cost accuracy, more of them only time


def terms_for(bits: int) -> int:
    """The number of coefficients for an arithmetic with these bits."""
    return int(TERMS_OF_MP * bits) + 2


@dataclass(frozen=True, eq=False)
class OnsetSegment(Segment):
    """A segment that begins at rest, whose series has v in the place of ln v and of t."""

    def inside(self, times: Array, numbers: Any) -> list[Array]:
        """Evaluate the state of slow gliding."""
        columns, fn = self.series.at(times, numbers), functions_of(numbers)
        (*turning, v, ex, ey), recorded = columns[:9], columns[9:]
        return [*turning, fn.log(v), ex, ey, times.astype(v.dtype), *recorded]


def onset_segment(
    setup: Setup, start: InitialState, series: OnsetSeries, recorded: Row, begin: Scalar
) -> Segment:
    """Return the segment of an onset; ``recorded`` are the quadratures so far."""
    fn, until = setup.precision.context, min(series.until, start.until)
    columns = [*series.coefficients.tolist(), *_quadratures(setup, start, series, recorded)]

    def row(time: Scalar) -> Row:
        *turning, v, ex, ey = (fn.polyval(column[::-1], time) for column in columns[:9])
        glide = fn.log(v) if v > 0 else -fn.inf
        return (*turning, glide, ex, ey, time, *(fn.polyval(c[::-1], time) for c in columns[9:]))

    status = "complete" if series.until >= start.until else "fast"
    events = _events(setup, start, series, until, row)
    order = series.coefficients.shape[1] - 1
    run = Propagation(
        status, until, row(until), 1, order, events, lambda: of_power_series(columns, until)
    )
    return OnsetSegment(begin, setup, replace(start, row=row(until * 0)), run)


def _quadratures(
    setup: Setup, start: InitialState, series: OnsetSeries, recorded: Row
) -> list[list[Scalar]]:
    """Integrate the series of the rates of the recorded quadratures."""
    if not setup.record:
        return []
    state = [TaylorSeries(lambda c, k: c[0] * 0, column) for column in _in_vectors(series)]
    q = Motion(start.body, NewtonState(*state), SeriesFunctions(setup.precision.context))
    columns = []
    for name, before in zip(setup.record, recorded, strict=True):
        rate = QUANTITIES[QUADRATURES[name]].evaluate(q)
        terms = (rate[k] / (QUADRATURE_SCALE * (k + 1)) for k in range(len(state[0].c) - 1))
        columns.append([before, *terms])
    return columns


def _in_vectors(series: OnsetSeries) -> list[list[Scalar]]:
    """Return the series of k, L and v_A."""
    *entries, v, ex, ey = series.coefficients.tolist()
    return [*entries, *(convolution(v, e) for e in (ex, ey))]


def _events(
    setup: Setup, start: InitialState, series: OnsetSeries, until: Scalar,
    row: Callable[[Scalar], Row],
) -> FoundEvents:  # fmt: skip
    """Find the events in the series of k, L and v_A."""
    if not setup.events:
        return nothing_found(setup)
    form = formulation("gliding", "newton", setup.formulation.friction)
    zeros = Zeros(setup.but(formulation=form, record=()), start, continued=True)
    zeros.search(of_power_series(_in_vectors(series), until))
    events, numbers, precision = zeros.collect(), setup.precision.numbers, setup.precision
    times = events.hits.time.astype(float) if precision.is_float else events.hits.time
    exact = precision.context.mpf if precision.is_float else precision.mpfr.back
    rows = [row(exact(time)) for time in times.tolist()]
    columns = zip(*rows, strict=True) if rows else nothing_found(setup).hits.state
    state = tuple(map(numbers.array, columns))
    return events._replace(hits=replace(events.hits, state=state))


# ---- gliding, sticking and slipping ------------------------------------------------------------


def sticking_and_slipping(
    name: str, setup: Setup, start: InitialState, progress: Progress | None = None
) -> list[Segment]:
    """Return the segments of the motion of scene ``name`` from ``start`` to its end.

    Raises ``InputError``: more segments than ``MOST_SEGMENTS``, or gliding can begin in no
    direction, or in several.
    """
    segments: list[Segment] = []
    here, status = SegmentStart.of_run(setup, start), "rest"
    begin = start.until * 0
    if any(start.vectors.v):
        speed = here.q.fn.hypot(*start.vectors.v[:2])
        status = "slow" if speed < SLOW_SPEED else "fast"
        if speed <= REST_SPEED * setup.precision.eps and _sticks(here.q):
            here, status = here.at_rest(), "stick"
    while status in ("rest", *GOES_ON):
        if len(segments) == MOST_SEGMENTS:
            raise InputError(
                f"{name}: got more than {MOST_SEGMENTS} changes between gliding and rolling, "
                "expected fewer: ask for a shorter time"
            )
        if status in ("rest", "stick", "slip"):
            last = _from_rest(name, setup, here, status, begin)
        else:
            last = here.segment(slow(setup) if status == "slow" else setup, begin)
        status = last.run.status
        joint = status if status in ("stick", "slip") else ""
        segments.append(replace(last, ended=joint))
        if isinstance(last, OnsetSegment) and status != "complete":
            status = "slow"
        begin, here = begin + last.end_time, here.after(last)
        if status == "stick":
            here = here.at_rest()
        if progress and start.until:
            progress(float(begin / start.until))
    return segments


def _sticks(q: Motion) -> bool:
    """Return whether the force that keeps the top rolling lies within the cone of friction."""
    pressed = rolling.constraint_force(q.body, q.state)[2] > 0
    return bool(pressed and friction.cone_margin(q.body, q.state) >= 0)


def _from_rest(name: str, setup: Setup, here: SegmentStart, status: str, begin: Scalar) -> Segment:
    """Rolling if the force lies within the cone, otherwise the onset of gliding."""
    body, vectors, fn = here.q.body, here.q.state, here.q.fn
    if status != "slip" and _sticks(here.q):
        return here.segment(sticking(setup), begin)
    on_the_cone = status == "slip"
    directions = (
        [direction_on_the_cone(body, vectors, fn)]
        if on_the_cone
        else directions_from_rest(body, vectors, fn)
    )
    if len(directions) != 1:
        raise InputError(
            f"{name}: got {len(directions)} directions in which gliding could begin from rest, "
            "expected one: Coulomb's law does not determine how this motion continues"
        )
    precision = setup.precision
    # plane motion stays plane
    e = tuple(fn.chop(entry, tol=precision.eps) for entry in directions[0])
    series = onset(body, vectors, e, terms_for(precision.bits), precision.eps, fn, on_the_cone)
    begun = replace(here.start, model="gliding", vectors=vectors, until=here.until)
    return onset_segment(slow(setup), begun, series, here.recorded, begin)
