"""What every method of the trade-off integrates, and the truth that it is compared with.

All methods get the same dimensionless numbers (m = R = g = 1) and the same text of the equations.
The truth is golden data, 34 digits; where more are needed, a run with more bits takes its place.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, cached_property

from tt_precise import golden
from tt_precise.integration import integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.precision import Precision, precision_named
from tt_precise.mechanics.conserved import INTEGRALS, drift
from tt_precise.mechanics.formulations import (
    STATE_DIMENSIONS,
    Formulation,
    formulation,
    integration_form,
)
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Functions, InputError, Scalar
from tt_precise.scene.scene import InitialState, Scene, load_scene

GOLDEN_BITS = 160  # holds the 34 decimals of golden data with room for the differences
MOST_SAMPLES = 40  # Number of golden rows, evenly spaced, with which a method is compared.


@dataclass(frozen=True)
class GoldenProblem:
    """A golden scene up to a horizon, in one formulation; ``until`` and ``times`` in s.

    ``truth_bits`` makes a run of so many bits the truth instead of the golden data.
    """

    scene: Scene
    coordinates: str
    until: Fraction
    times: tuple[Fraction, ...]
    truth_bits: int = 0

    @property
    def form(self) -> Formulation:
        """State and equations that everybody integrates."""
        return integration_form(self.scene.model, self.coordinates, self.scene.body.friction)

    @property
    def published(self) -> Formulation:
        """The state that users get."""
        return formulation(self.scene.model, self.coordinates, self.scene.body.friction)

    def start(self, precision: Precision) -> InitialState:
        """Body, units and start, rounded once to the guarded ``precision``."""
        return InitialState.of(self.scene, precision.arithmetic)

    def state(self, precision: Precision) -> list[Scalar]:
        """The start in heyoka's numbers."""
        start = self.start(precision)
        first = start.state(self.form)
        return list(map(precision.number, first))

    def parameters(self, precision: Precision) -> list[Scalar]:
        """The parameters that the equations contain, in heyoka's numbers."""
        body = self.start(precision).body
        return [precision.number(body.numbers_by_name[name]) for name in self.form.parameters]

    def clock(self, precision: Precision, times: Sequence[Fraction]) -> list[Scalar]:
        """Times in s as dimensionless numbers of heyoka's."""
        unit = self.start(precision).units.time
        return [precision.number(precision.exact(t) / unit) for t in times]

    @cached_property
    def truth(self) -> Truth:
        """The right states at ``times``."""
        bits = self.truth_bits or GOLDEN_BITS
        precision = precision_named("mp", bits)
        if self.truth_bits:
            rows = integrate(replace(self.scene, until=self.until), "mp", bits=bits).frame(
                *VECTOR_COLUMNS, times=self.times, numbers="text"
            )
        else:
            frame = golden.load(self.scene.name, "text")
            rows = frame[frame["t"].map(Fraction).isin(self.times)]
        start = InitialState.of(self.scene, precision.arithmetic)
        units = [start.units.of_dimension(STATE_DIMENSIONS[name]) for name in VECTOR_COLUMNS]
        states = [
            NewtonState(
                *(precision.context.mpf(x) / unit for x, unit in zip(row, units, strict=True))
            )
            for row in rows[list(VECTOR_COLUMNS)].itertuples(index=False)
        ]
        return Truth(self, precision, start, tuple(states))


@dataclass(frozen=True)
class StateErrors:
    """The errors of a run, dimensionless, and its relative drift of lambda.

    ``error`` is the largest absolute error of an entry of k, L, v in units of 1, m R sqrt(g R),
    sqrt(g R) at the end; ``error_on_way`` the largest at any sample (None where only the end is
    known), ``jellett_drift`` likewise.
    """

    error: Scalar
    error_on_way: Scalar
    jellett_drift: Scalar


@dataclass(frozen=True)
class Truth:
    """The right vector states (dimensionless, guarded mpmath numbers) at a problem's times."""

    problem: GoldenProblem
    precision: Precision
    start: InitialState
    states: tuple[NewtonState, ...]

    def errors(
        self, rows: Sequence[Sequence[Scalar]], precision: Precision, times: Sequence[Scalar] | None
    ) -> StateErrors:
        """The errors of states at the last ``len(rows)`` of the problem's times.

        ``times`` are the dimensionless numbers that the method was given: the truth is moved to
        them, so that their rounding, worth 1e-13 at 8 s in double, is not an error of the method.
        None stands for the exact times, and states as users get them. An Euler state leaves the
        azimuth open; there it is that of the truth.
        """
        context, problem = self.precision.context, self.problem
        form = problem.form if times is not None else problem.published
        body, first = self.start.body, self.start.vectors
        off, motions = [], [Motion(body, first, context, form.model)]
        exact_times = problem.times[len(problem.times) - len(rows) :]
        right_states = self.states[len(self.states) - len(rows) :]
        for i, (row, exact, right) in enumerate(zip(rows, exact_times, right_states, strict=True)):
            if times is not None:
                clock = self.precision.exact(exact) / self.start.units.time
                right = self._shift(right, self._number(times[i], precision) - clock)
            mine = form.State(*(self._number(x, precision) for x in row))
            phi = context.atan2(right.ky, right.kx) if form.coordinates == "euler" else 0
            q = form.motion(body, mine, context, phi)
            errors = [abs(a - b) for a, b in zip(q.state, right, strict=True)]
            off.append(_largest(errors, context))
            motions.append(q)
        drifts = drift(INTEGRALS["jellett"], motions)[1:]
        return StateErrors(off[-1], max(off), _largest(drifts, context))

    def _number(self, value: Scalar, precision: Precision) -> Scalar:
        number = value if hasattr(value, "_mpf_") else precision.with_guard_bits(value)
        return self.precision.context.mpf(number)

    def _shift(self, state: NewtonState, delay: Scalar) -> NewtonState:
        form = formulation(self.problem.scene.model, "newton", self.problem.scene.body.friction)
        rates = form.rates(self.start.body, form.State(*state[: len(form.columns)]), None)
        moved = [x + rate * delay for x, rate in zip(state, rates, strict=False)]
        return NewtonState(*moved, *state[len(moved) :])


def _largest(errors: Sequence[Scalar], context: Functions) -> Scalar:
    """The largest; infinite if one is NaN, which ``max`` ignores."""
    return context.inf if any(map(context.isnan, errors)) else max(errors)


@cache
def golden_problem(
    scene: str, coordinates: str = "newton", until: str | None = None, truth_bits: int = 0
) -> GoldenProblem:
    """A golden scene, up to its end or to ``until`` (a sample time, s).

    The end of a scene that loses contact is the moment at which it does.
    """
    every = [Fraction(t) for t in golden.load(scene, "text")["t"] if Fraction(t) > 0]
    wanted = [t for t in every if until is None or t <= Fraction(until)]
    if not wanted or (until is not None and wanted[-1] != Fraction(until)):
        raise InputError(f"until: got {until}, expected a time of the golden data of {scene}")
    stride = -(-len(wanted) // MOST_SAMPLES)
    times = tuple(reversed(wanted[::-1][::stride]))
    return GoldenProblem(load_scene(scene), coordinates, wanted[-1], times, truth_bits)
