"""The integrated equations of motion, with recorded quadratures after the state.

heyoka's tolerance is relative to the largest component of the state. Quadratures may grow large;
therefore they are scaled down by a power of two, so that the tolerance stays tight.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from tt_precise.integration.events import Event
from tt_precise.integration.precision import Precision
from tt_precise.mechanics import newton
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.friction import largest_coefficient
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.values import Adaptive, Functions, Scalar
from tt_precise.taylor.series import SeriesFunctions, TaylorSeries, rate, solution

QUADRATURES = {"phi": "phi_dot", "psi": "psi_dot", "x": "s_dot_x", "y": "s_dot_y"}
QUADRATURE_SCALE = 1024
# A motion ends at this denominator of g_n, in units of I1: the blow-up is 1e-12 sqrt(R/g) away.
SINGULAR_DENOMINATOR = 1e-6
# a tolerance relative to the largest entry costs a larger tilt at most 2 digits
LARGE_TILT = 2.0**-7


class Layout(NamedTuple):
    """A row of an integration: the state of ``form``, then the quadratures ``record``, scaled."""

    form: Formulation
    record: tuple[str, ...] = ()

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the entries of a row."""
        return (*self.form.columns, *self.record)

    def rates(self, body: Parameters, row: Sequence[Scalar], fn: Functions) -> list[Scalar]:
        """The rates of the entries."""
        state = self.form.State(*row[: len(self.form.columns)])
        rates = list(self.form.rates(body, state, fn))
        if self.record:
            q = self.motion(body, row, fn)
            recorded = [
                QUANTITIES[QUADRATURES[name]].evaluate(q) / QUADRATURE_SCALE for name in self.record
            ]
            rates += state.along(recorded, fn)
        return rates

    def motion(self, body: Parameters, row: Sequence[Scalar], fn: Functions) -> Motion:
        """The ``Motion`` of a row; the azimuth is the recorded phi, or 0."""
        size = len(self.form.columns)
        phi: Scalar = 0
        if self.form.coordinates == "euler" and "phi" in self.record:
            phi = row[size + self.record.index("phi")] * QUADRATURE_SCALE
        return self.form.motion(body, self.form.State(*row[:size]), fn, phi)

    def moving(
        self, body: Parameters, row: Sequence[Scalar], fn: Functions
    ) -> tuple[tuple[TaylorSeries, ...], Motion]:
        """Power series in time of the entries from ``row``, and their ``Motion``."""
        functions = SeriesFunctions(fn)
        entries = solution(lambda series: self.rates(body, series, functions), row)
        return entries, self.motion(body, entries, functions)


def event_value(event: Event, q: Motion) -> Scalar:
    """An event's function of the power series ``q``: a series, or a number for a constant."""
    value = event.function(q)
    if event.of_rate:
        return rate(value) if isinstance(value, TaylorSeries) else 0
    return value


class HeyokaFunctions:
    """heyoka's functions; the root of a plain 0 is 0, as for the speed of a rolling top."""

    def __getattr__(self, name: str) -> Any:
        import heyoka

        return getattr(heyoka, name)

    def sqrt(self, value: Scalar) -> Scalar:
        """The positive root."""
        zero = isinstance(value, int) and not value
        return 0 if zero else self.__getattr__("sqrt")(value)


@dataclass(frozen=True)
class Equations:
    """Variables of a formulation and of recorded quadratures, their rates, and their ``Motion``.

    Dimensionless (m = R = g = 1). The body's ``parameters`` are heyoka's open ones, in the order
    of the formulation, so that one compilation serves every body.
    """

    variables: tuple[Scalar, ...]
    rates: tuple[Scalar, ...]
    motion: Motion
    layout: Layout

    @classmethod
    def of(cls, form: Formulation, record: tuple[str, ...] = ()) -> Equations:
        """The equations of ``form``, followed by the quadratures ``record``."""
        heyoka, layout, fn = import_heyoka(), Layout(form, record), HeyokaFunctions()
        variables = tuple(heyoka.make_vars(*layout.columns))
        body = form.body([heyoka.par[i] for i in range(len(form.parameters))])
        rates = tuple(layout.rates(body, variables, fn))
        return cls(variables, rates, layout.motion(body, variables, fn), layout)

    @property
    def system(self) -> list[tuple[Scalar, Scalar]]:
        """Pairs of a variable and its rate, as heyoka's integrators take them."""
        return list(zip(self.variables, self.rates, strict=True))


Ends = dict[str, Scalar]
Condition = Callable[[Adaptive, int], bool]


def fastest_tilt(body: Parameters, speed: Scalar, frequency: Scalar, decay: Scalar) -> Scalar:
    """The largest rate of a small tilt.

    ``frequency`` is that of its oscillations, ``decay`` that of gliding for a coefficient of
    friction 1, and ``speed`` that of the contact point.
    """
    if body.friction.smooth_at_rest or speed:
        frequency += largest_coefficient(body, speed) * decay
    return frequency


@dataclass(frozen=True)
class Phase:
    """A motion under one set of equations for heyoka: the ends and the steps.

    ``ends(equations, horizon, precision)`` are functions that are positive while it lasts; it ends
    where one falls to zero, unless ``condition(formulation, end, eps, tolerance)``, a callback of
    heyoka's event, says that it goes on. Code for ``brief`` motions compiles fast. Where time is an
    entry of the state (``has_clock``), the horizon is a parameter of the equations.
    ``first_step``, if not 0, is that of the variable of integration.
    """

    ends: Callable[[Equations, Scalar, Precision], Ends]
    condition: Callable[[Formulation, str, float, float], Condition] | None = None
    brief: bool = False
    has_clock: bool = False
    first_step: float = 0.0
    fastest: Callable[[Parameters, Scalar, Scalar, Scalar], Scalar] = fastest_tilt


def rigid_ends(equations: Equations, horizon: Scalar, precision: Precision) -> Ends:
    """The ends of a motion on a rigid table."""
    return terminal_functions(equations.layout.form, equations.motion)


RIGID_CONTACT = Phase(rigid_ends)


def terminal_functions(form: Formulation, q: Motion) -> dict[str, Scalar]:
    """Functions that are positive while a top stays on a rigid table, in angles off the poles."""
    if form.model == "rolling":
        functions = {"contact_lost": q.force[2]}
    else:
        numerator, denominator = newton.contact_terms(q.viscous, q.state)
        margin = SINGULAR_DENOMINATOR * q.body.I1
        functions = {"contact_lost": numerator, "singular_contact": denominator - margin}
    if form.coordinates == "euler":
        functions["pole"] = q.fn.sin(q.euler.theta)
    return functions


def along(expression: Scalar, equations: Equations) -> Scalar:
    """The rate of an expression along the motion."""
    import heyoka

    slopes = (heyoka.diff(expression, v) * rate for v, rate in equations.system)
    return sum(slopes, start=heyoka.expression(0.0))


def longest_step(
    body: Parameters,
    vectors: NewtonState,
    order: int,
    precision: Precision,
    phase: Phase = RIGID_CONTACT,
) -> Scalar | None:
    """Longest Taylor step that keeps the digits of a tilt near a pole; None for other starts.

    ``body`` and ``vectors`` are the dimensionless start.

    heyoka keeps the truncation error below eps of the largest entry, which does not control a tilt
    of 1e-20 rad: the steps would become so long that the tilt is wrong by a factor. The tilt obeys
    linear equations there, so a term of its series is at most (frequency times step)^k/k!, with the
    frequency of the fastest mode; the step follows from the first omitted term.
    """
    if max(map(abs, vectors.k[:2])) >= LARGE_TILT:  # most starts of a sweep, decided in no time
        return None
    context = precision.context
    spin = context.sqrt(dot(vectors.L, vectors.L))
    sideways = context.hypot(vectors.Lx, vectors.Ly) / max(1, spin)
    tilt = max(context.hypot(*vectors.k[:2]), sideways, context.hypot(*vectors.v[:2]))
    if not 0 < tilt < LARGE_TILT:
        return None
    longest_arm = 1 + body.alpha
    # nutation, the pendulum's frequency, and the decay of gliding, none of them underestimated
    frequency = spin / body.I1 + context.sqrt(body.alpha / body.I1)
    decay = 1 + longest_arm * longest_arm / body.I1
    speed = context.hypot(*vectors.v[:2])
    frequency = phase.fastest(body, speed, frequency, decay)
    first_left_out = precision.eps * context.factorial(order + 1)
    return context.root(first_left_out, order + 1) / frequency
