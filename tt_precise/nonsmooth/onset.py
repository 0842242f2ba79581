"""The onset of gliding under Coulomb's law: power series in the time since rest.

At v_A = 0 the equations are singular, and tau of ``polar`` would begin at -infinity. The solution
that glides from there is v(t), e(t), k(t), L(t) as power series, coefficient by coefficient:
(v e')_k = (n.v_A_dot)_k is linear in the next coefficient of e. The factor v_1 k - N of this
coefficient is not zero; N < 0 is the derivative of n.v_A_dot with respect to the angle of e. Where
rolling reaches the cone, v_1 = 0 (``cone`` in exact.identities): v begins with t^2, and the series
is asymptotic; its terms finally grow like factorials, and its error is below the least term. Where
the force of rolling lies outside the cone at once, v_1 > 0, and the series converges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy

from tt_precise.integration.columns import Row
from tt_precise.integration.dense_output import NOTHING_FOUND, FoundEvents, Propagation
from tt_precise.integration.equations import QUADRATURE_SCALE, QUADRATURES
from tt_precise.integration.setup import Setup
from tt_precise.integration.steps import of_series
from tt_precise.integration.zeros import Zeros
from tt_precise.mechanics import friction, newton, rolling
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.nonsmooth.segments import RowwiseOutput
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.runtime.terminal import Progress
from tt_precise.runtime.values import Array, Functions, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.taylor.series import TaylorSeries, convolution

DIRECTIONS = 64  # directions in which gliding may begin, tested for sign changes


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
            known = -x, y
            rest = across_after(k, known, 0)
            if slope is None:
                slope = across_after(k, known, 1) - rest
            former = sum((v[j] * turning[k - j] for j in range(2, k + 1)), zero)
            turning.append((rest - former) / (v[1] - slope / k))
            across_after(k, known, turning[-1] / k)
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


class OnsetOutput(RowwiseOutput):
    """Rows of an ``OnsetSeries`` over its time, with the states of the polar ``setup``."""

    def __init__(self, setup: Setup, start: InitialState, onset: OnsetSeries, quadratures: Row):
        self.onset, self.quadratures = onset, quadratures
        context = setup.precision.context
        self.arrives = onset.until >= start.until
        self._until = start.until if self.arrives else onset.until
        super().__init__(setup, start, None)  # type: ignore[arg-type]
        number = setup.precision.number
        self.propagation = Propagation(
            status="complete" if self.arrives else "fast",
            time=number(self._until),
            time_low=number(context.mpf(0)),
            state=tuple(map(number, self.end_row)),
            steps=1,
            order=onset.coefficients.shape[1] - 1,
            found=self._events(),
        )

    @cached_property
    def end_time(self) -> Scalar:
        """Dimensionless end of the series, or of the horizon if that comes first."""
        return self._until

    @cached_property
    def start_row(self) -> Row:
        """The row at rest, with ln v = -infinity."""
        return self._row(self.precision.context.mpf(0))

    @cached_property
    def end_row(self) -> Row:
        """The row at ``end_time``."""
        return self._row(self._until)

    def rows(self, times: Sequence[Scalar], progress: Progress | None = None) -> list[Row]:
        """Rows at guarded dimensionless ``times``."""
        return [self._row(time) for time in times]

    def _components(self, times: Sequence[Scalar], progress: Progress | None) -> tuple[Array, ...]:
        return tuple(map(self.precision.mpfr.array, zip(*self.rows(times), strict=True)))

    def _row(self, time: Scalar) -> Row:
        return (*self._state(time), *self._recorded(time))

    def _state(self, time: Scalar) -> Row:
        fn = self.precision.context
        *body, v, ex, ey = self.onset.at(time, fn)
        glide = fn.log(v) if v > 0 else -fn.inf
        return (*body, glide, ex, ey, time)

    def _recorded(self, time: Scalar) -> Row:
        if not time:
            return self.quadratures
        fn = self.precision.context

        def rate(name: str) -> Callable[[Scalar], Scalar]:
            return lambda t: QUANTITIES[QUADRATURES[name]].evaluate(self._vector_motion(t))

        return tuple(
            before + fn.quad(rate(name), [0, time], method="gauss-legendre") / QUADRATURE_SCALE
            for name, before in zip(self.setup.record, self.quadratures, strict=True)
        )

    def _vector_motion(self, time: Scalar) -> Motion:
        fn = self.precision.context
        *body, v, ex, ey = self.onset.at(time, fn)
        state = NewtonState(*(*body, v * ex, v * ey))
        return Motion(self.start.body, state, fn)

    def _events(self) -> FoundEvents:
        """Return the events, in the series of k, L and v_A."""
        if not self.setup.events:
            return NOTHING_FOUND
        form = formulation("gliding", "newton", self.setup.formulation.friction)
        mpfr, mpf = self.precision.mpfr, self.precision.context.mpf
        with mpfr.precision():
            *entries, v, ex, ey = ([*map(mpfr.number, c)] for c in self.onset.coefficients)
            series = [*entries, *(convolution(v, e) for e in (ex, ey))]
            steps = of_series(series, mpfr.number(self._until), self.setup)
        begun = replace(self.start, row=tuple(c[0] for c in self.onset.coefficients))
        zeros = Zeros(self.setup.but(formulation=form, record=()), begun)
        zeros.search(steps)
        found = zeros.collect()
        number = float if self.precision.is_float else mpf
        states = [[*map(number, self._row(mpf(time)))] for time in found.hits.time.tolist()]
        if not states:
            return found
        return found._replace(hits=replace(found.hits, state=numpy.array(states)))
