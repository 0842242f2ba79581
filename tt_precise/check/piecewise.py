"""Which equations each row obeys, where a motion may change them on the way; and where it does not.

A row glides, rests on the table (Coulomb's friction), flies, or is pressed into an elastic table.
Between two rows nothing changes where neither row's own solution comes to what would change it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy

from tt_precise.mechanics import compliant, quantities
from tt_precise.mechanics.flight import LiftedState
from tt_precise.mechanics.formulations import Formulation, elastic_in_time, formulation, raised
from tt_precise.mechanics.friction import cone_margin
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.taylor import SeriesFunctions, TaylorSeries, solution
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.scene.body import Parameters
from tt_precise.scene.scene import Scene

ON_TABLE = 1e-9  # of R: below this a rigid table is touched
POINTS = 9  # of an interval, at which a solution is looked at
State = NewtonState | LiftedState


class RowsUnder(NamedTuple):
    """Rows (a mask, or all of them) that obey one formulation, in vectors."""

    rows: Array | slice
    form: Formulation


def rows_under(scene: Scene, body: Parameters, state: State) -> list[RowsUnder]:
    """The rows of ``state`` by the equations that they obey; none of them is empty."""
    lifted = isinstance(state, LiftedState)
    if scene.model == "flight" and lifted:
        return [RowsUnder(slice(None), raised("newton"))]
    gliding = formulation(scene.model, "newton", scene.body.friction)
    on_table = numpy.ones(len(state.kx), bool)
    if isinstance(state, LiftedState):
        on_table, gliding = _on_table(body, state, gliding)
    rests = numpy.zeros(len(on_table), bool)
    if scene.may_stick:
        rests = on_table & (state.vx == 0) & (state.vy == 0)
    found = (
        (on_table & ~rests, gliding),
        (rests, formulation("rolling", "newton")),
        (~on_table, raised("newton")),
    )
    there = [(rows, form) for rows, form in found if rows.any()]
    if len(there) == 1:  # all rows
        return [RowsUnder(slice(None), there[0][1])]
    return [RowsUnder(*one) for one in there]


def _on_table(
    body: Parameters, state: LiftedState, rigid: Formulation
) -> tuple[Array, Formulation]:
    spring = body.spring
    if not spring:
        return state.height <= ON_TABLE * body.R, rigid
    pushed = compliant.reach(body, state.height, state.rise) < 0
    return (state.height < 0) & pushed, elastic_in_time(spring, body.friction)


def rates_of(
    form: Formulation, body: Parameters
) -> Callable[[tuple[Scalar, ...]], Sequence[Scalar]]:
    """The equations of ``form`` for series."""
    return lambda entries: form.rates(body, form.State(*entries), SeriesFunctions)


class SolvedRows:
    """The Taylor series of the solution through every row, each by its own equations."""

    def __init__(self, scene: Scene, body: Parameters, state: State, order: int):
        self._body, self._order = body, order
        self.parts = rows_under(scene, body, state)
        self._count = len(state.kx)
        solved = [self._solved(state, part) for part in self.parts]
        self.state = solved[0]
        if len(solved) > 1:
            self.state = type(state)(*map(self._together, zip(*solved, strict=True)))

    def _solved(self, state: State, part: RowsUnder) -> State:
        start = [entry[part.rows] for entry in state]
        width = len(part.form.columns)
        series = [*solution(rates_of(part.form, self._body), start[:width], self._order)]
        for constant in start[width:]:
            series.append(TaylorSeries(numpy.zeros_like(series[0].c)))
            series[-1].c[0] = constant
        return type(state)(*series)

    def _together(self, series: Sequence[TaylorSeries]) -> TaylorSeries:
        whole = numpy.empty((self._order + 1, self._count))
        for part, found in zip(self.parts, series, strict=True):
            whole[:, part.rows] = found.c
        return TaylorSeries(whole)

    def _motions(self) -> Iterator[tuple[RowsUnder, Motion]]:
        for part in self.parts:
            state = type(self.state)(*(TaylorSeries(x.c[:, part.rows]) for x in self.state))
            yield part, Motion(self._body, state, SeriesFunctions, part.form.model)

    @property
    def power(self) -> Array:
        """Coefficients of the rate of the energy."""
        found = numpy.zeros((self._order + 1, self._count))
        for part, q in self._motions():
            if part.form.model not in ("rolling", "flight"):
                found[:, part.rows] = quantities.E_dot(q).c
        return found

    def stays(self, steps: Array) -> Array:
        """Intervals (of ``steps`` s) in which the top neither leaves the table nor touches it.

        Seen from either end: the force pushes all along, and stays within the cone where the
        contact rests, or the height is above zero.
        """
        margins, which = numpy.zeros((self._order + 1, self._count)), numpy.zeros(self._count)
        for part, q in self._motions():
            flies = part.form.model == "flight"
            margin = q.state.height if flies else q.force[2]
            if part.form.model == "rolling":
                margin = cone_margin(self._body, q.state)
            margins[:, part.rows] = margin.c
            which[part.rows] = flies
        # just behind a loss of contact a row is still at the table, which would have to pull it
        held = margins[0] >= 0
        found: Array = (which[:-1] == which[1:]) & held[:-1] & held[1:]
        for end, sign in ((slice(None, -1), 1), (slice(1, None), -1)):
            for fraction in numpy.linspace(0, 1, POINTS)[1:-1]:
                h = sign * fraction * steps
                found = found & (numpy.polynomial.polynomial.polyval(h, margins[:, end], False) > 0)
        return found
