"""A scene's equations as a compiled heyoka integrator, built once and used again.

Everything is integrated in dimensionless units (m = R = g = 1).
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

from tt_precise.integration.equations import Equations
from tt_precise.integration.events import EXTREMUM, ZERO, Event, event_named
from tt_precise.integration.idle import Idle
from tt_precise.integration.setup import Setup, full_tolerance
from tt_precise.mechanics import compliant, friction, newton
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.untyped import Adaptive
from tt_precise.taylor.series import Series

if TYPE_CHECKING:
    from types import ModuleType

# in units of sqrt(g R): below it Coulomb's law is integrated in polar form, until twice as much
SLOW_SPEED = 2.0**-4
REST_SPEED = 2.0**-8  # of eps; v = 0 is less than an ulp of time away from there
SINGULAR_DENOMINATOR = 1e-6  # of I1; from there the blow-up is about 1e-12 sqrt(R/g) away


class Hit(NamedTuple):
    """One event as it happened: dimensionless time and state in heyoka's numbers."""

    name: str
    time: Scalar
    direction: int
    state: tuple[Scalar, ...]


@dataclass
class Integrator:
    """A ``heyoka.taylor_adaptive``, its events, and the lists that their callbacks fill.

    ``losses`` holds the latest time at which g_n fell through 0 in a run that went on there.
    """

    adaptive: Adaptive
    terminal: tuple[str, ...]
    events: dict[str, Event]
    hits: list[Hit] = field(default_factory=list)
    losses: list[Scalar] = field(default_factory=list)

    def begin(self, setup: Setup, start: InitialState) -> None:
        """Go to ``start``, at time zero, and forget earlier events."""
        key = ("begin", setup.formulation, setup.record, setup.precision)
        zero, state, parameters = start.once(key, lambda: _first_numbers(setup, start))
        for i, value in enumerate(state):
            self.adaptive.state[i] = value
        for i, value in enumerate(parameters):
            self.adaptive.pars[i] = value
        self.adaptive.time = zero
        self.adaptive.reset_cooldowns()
        self.hits.clear()
        self.losses.clear()


def _first_numbers(setup: Setup, start: InitialState) -> tuple[Scalar, list[Scalar], list[Scalar]]:
    """Time, state and parameters of ``start`` in heyoka's numbers."""
    form, number = setup.formulation, setup.precision.number
    horizon = (start.until,) if form.own_time else ()
    parameters = (*start.parameters(form), *horizon)
    return (
        number(setup.precision.context.mpf(0)),
        list(map(number, start.first_row(form, setup.record))),
        list(map(number, parameters)),
    )


MOST_EVENTS = 1_000_000  # each takes half a kB


def build(setup: Setup) -> Integrator:
    """Compile the integrator for ``setup``."""
    import heyoka

    # what heyoka would log is in a trajectory's status and its suspect_events
    heyoka.set_logger_level_critical()
    form, fp_type = setup.formulation, setup.precision.fp_type
    equations = Equations.of(form, setup.record)
    terminal = terminal_functions(form, equations.motion, equations.variables[0])
    events = {name: event_named(name, form.model, form.friction) for name in setup.events}
    if form.own_time:
        terminal |= _ends_in_own_time(setup, equations, heyoka.par[len(form.parameters)])
    hits: list[Hit] = []
    losses: list[Scalar] = []
    noted = []
    if setup.contact == "bilateral":
        noted = [_loss(heyoka, terminal.pop("contact_lost"), fp_type, losses)]
    number = setup.precision.number
    zero = setup.precision.context.mpf(0)
    made = heyoka.taylor_adaptive(
        equations.system,
        [number(zero) for _ in equations.variables],
        pars=[number(zero + 1) for _ in range(len(form.parameters) + form.own_time)],
        fp_type=fp_type,
        t_events=[
            heyoka.t_event(
                ex, fp_type=fp_type, direction=heyoka_direction(-1), **_condition(form, name)
            )
            for name, ex in terminal.items()
        ],
        nt_events=[
            *_events(heyoka, setup, events, equations, hits),
            *noted,
        ],
        **numeric_options(setup),
    )
    return Integrator(made, tuple(terminal), events, hits, losses)


_idle = Idle(build)


def integrator(setup: Setup) -> AbstractContextManager[Integrator]:
    """An integrator for ``setup``: an idle one of an earlier run, or one that is compiled now."""
    return _idle.lent(setup)


def terminal_functions(form: Formulation, q: Motion, theta: Scalar) -> dict[str, Scalar]:
    """Functions that are positive where the model holds; it ends where one falls to zero."""
    if form.model == "flight":
        found = {"landing": q.state.height}
        if form.spring:
            found["sinking"] = compliant.reach(q.body, q.state.height, q.state.rise)
    elif form.spring:
        found = {} if form.own_time else {"separation": q.force[2]}
    elif form.model == "rolling":
        found = {"contact_lost": q.force[2]}
    else:
        numerator, denominator = newton.contact_terms(q.viscous, q.state)
        margin = SINGULAR_DENOMINATOR * q.body.I1
        found = {"contact_lost": numerator, "singular_contact": denominator - margin}
    if form.model == "rolling" and not form.friction.smooth_at_rest:
        found["slip"] = friction.cone_margin(q.body, q.state)
    elif not (form.friction.smooth_at_rest or form.own_time):
        square = q.state.vx * q.state.vx + q.state.vy * q.state.vy
        found["slow"] = square - SLOW_SPEED * SLOW_SPEED
    if form.coordinates == "euler":
        found["pole"] = q.fn.sin(theta)
    return found


GRAZING = 2.0**-20  # in units of sqrt(g R): nothing lands as slowly as this, but it may take off


def _condition(form: Formulation, name: str) -> dict[str, Any]:
    """When the end of a flight is one: a callback that lets the others pass."""
    if form.model != "flight" or name not in ("landing", "sinking"):
        return {}
    height, rise = form.columns.index("height"), form.columns.index("rise")

    def goes_on(adaptive: Any, sign: int) -> bool:
        if name == "landing":
            return bool(adaptive.state[rise] > -GRAZING)
        return bool(adaptive.state[height] >= 0)

    return {"callback": goes_on}


def _ends_in_own_time(setup: Setup, equations: Equations, horizon: Any) -> dict[str, Any]:
    state = dict(zip(setup.formulation.columns, equations.variables, strict=False))
    if "zeta" in state:
        pressing = 1 - equations.motion.body.damping * state["rise"]
        return {
            "separation": state["zeta"], "release": pressing, "complete": horizon - state["t"],
        }  # fmt: skip
    number, context = setup.precision.number, setup.precision.context
    rest = context.log(REST_SPEED * setup.precision.eps)
    return {
        "stick": state["log_v"] - number(rest),
        "fast": number(context.log(2 * SLOW_SPEED)) - state["log_v"],
        "complete": horizon - state["t"],
    }


def numeric_options(setup: Setup) -> dict[str, Any]:
    """Keyword arguments of ``heyoka.taylor_adaptive`` that fix tolerance and compilation."""
    number = setup.precision.number
    # compact_mode compiles wide types in under a second instead of 26 s, and runs as fast; double
    # then takes twice as long, but the slopes of some quantities compile for minutes without
    slopes = any(name.startswith((EXTREMUM, ZERO)) for name in setup.events)
    # and what is integrated for short
    form = setup.formulation
    sticks = form.model == "rolling" and not form.friction.smooth_at_rest
    brief = form.own_time or form.spring or form.model == "flight" or sticks
    options: dict[str, Any] = {
        "compact_mode": bool(brief) or slopes or setup.precision.name != "double"
    }
    tolerance = setup.precision.context.mpf(setup.tolerance) or full_tolerance(setup.precision)
    options["tol"] = number(tolerance)
    return options | dict(setup.options)


def along(expression: Scalar, equations: Equations) -> Scalar:
    """The rate of an expression along the motion."""
    import heyoka

    slopes = (heyoka.diff(expression, v) * rate for v, rate in equations.system)
    return sum(slopes, start=heyoka.expression(0.0))


def event_expression(event: Event, equations: Equations) -> Scalar:
    """The heyoka expression whose zeros are the event, or a number where it is constant."""
    if not event.name.startswith(EXTREMUM) or event.slope:
        return event.function(equations.motion)
    value = event.function(equations.moving())
    return value[1] if isinstance(value, Series) else 0


def heyoka_direction(direction: int) -> Any:
    """heyoka's name for an event's direction."""
    import heyoka

    kinds = heyoka.event_direction
    return {0: kinds.any, 1: kinds.positive, -1: kinds.negative}[direction]


def _events(
    heyoka: ModuleType,
    setup: Setup,
    events: dict[str, Event],
    equations: Equations,
    hits: list[Hit],
) -> list[Any]:
    """heyoka's events; a function that is constant has none."""
    found = []
    for event in events.values():
        expression = event_expression(event, equations)
        if isinstance(expression, heyoka.expression) and heyoka.get_variables([expression]):
            found.append(_event(heyoka, event, expression, setup.precision.fp_type, hits))
    return found


def _event(
    heyoka: ModuleType, event: Event, expression: Scalar, fp_type: type, hits: list[Hit]
) -> Any:
    direction = heyoka_direction(event.direction)

    def callback(adaptive: Adaptive, time: Scalar, sign: int) -> None:
        # sign 0: the function vanishes identically (a scene in a plane), so nothing changes sign
        if not sign:
            return
        if len(hits) >= MOST_EVENTS:
            raise InputError(
                f"events: got more than {MOST_EVENTS}, expected fewer: ask for a shorter time or "
                "for fewer kinds of them"
            )
        # the state of the integrator is at the end of the step; the event's is interpolated
        hits.append(Hit(event.name, time, sign, tuple(adaptive.update_d_output(time))))

    return heyoka.nt_event(expression, callback, direction=direction, fp_type=fp_type)


def _loss(heyoka: ModuleType, numerator: Scalar, fp_type: type, losses: list[Scalar]) -> Any:
    def callback(adaptive: Adaptive, time: Scalar, sign: int) -> None:
        losses[:] = [time]

    return heyoka.nt_event(numerator, callback, direction=heyoka_direction(-1), fp_type=fp_type)
