"""From a scene to the dimensionless numbers that an integrator starts from."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from tt_precise.body import Parameters, Units
from tt_precise.errors import InputError
from tt_precise.integrate.events import EXTREMUM, event_named
from tt_precise.integrate.precision import Precision
from tt_precise.integrate.system import Key
from tt_precise.mechanics import newton, rolling
from tt_precise.mechanics.conversion import vectors_from_euler
from tt_precise.mechanics.euler import EulerState
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import dot
from tt_precise.scene import Scene

LEAN = 2.0**-7  # a tolerance relative to the largest entry costs a greater lean 2 digits at most


_ROUNDED = ("alpha", "I1", "I3", "mu")  # of a dimensionless body; the others are 1


@dataclass(frozen=True)
class Beginning:
    """Body, units and start of a scene in one precision: guarded mpmath numbers, dimensionless.

    ``units`` are in SI. ``vectors`` has the axis at azimuth 0; ``euler`` is the same start.
    """

    body: Parameters
    units: Units
    vectors: NewtonState
    euler: EulerState
    until: Any


def rounded_otherwise(start: Beginning, precision: Precision) -> Beginning:
    """The same start with every number on the other side of its rounding.

    What a run from it differs by contains what the rounding of start and body does to a run.
    """
    body = replace(
        start.body,
        **{name: precision.other_side(getattr(start.body, name)) for name in _ROUNDED},
    )
    return replace(
        start,
        body=body,
        vectors=NewtonState(*map(precision.other_side, start.vectors)),
        euler=EulerState(*map(precision.other_side, start.euler)),
    )


def beginning(scene: Scene, precision: Precision, contact: str = "unilateral") -> Beginning:
    """Body, units and start of ``scene``, rounded once to the guarded ``precision``.

    Raises
    ------
    InputError
        The top would not stay on the table at t = 0: g_n or its denominator is not positive.
        With ``contact`` "bilateral" g_n may be negative.
    """
    context, exact = precision.context, precision.exact
    body = scene.body.dimensionless(context, exact)
    units = Units.of(scene.body, context, exact)
    sine_cosine = scene.start.theta.sine_cosine(context, exact)
    euler = EulerState(
        theta=scene.start.theta.radians(context, exact),
        **{
            name: exact(getattr(scene.start, name)) / units.of_dimension(STATE_DIMENSIONS[name])
            for name in EulerState._fields[1:]
        },
    )
    vectors = vectors_from_euler(body, euler, context, sine_cosine=sine_cosine)
    vectors = NewtonState(*(context.mpf(value) for value in vectors))
    _require_contact(scene, body, vectors, context, contact)
    return Beginning(body, units, vectors, euler, exact(scene.until) / units.time)


def contact_terms(model: str, body: Parameters, vectors: NewtonState) -> tuple[Any, Any]:
    """Numerator and denominator of g_n; rolling has no denominator that could vanish."""
    if model == "rolling":
        return rolling.constraint_force(body, vectors)[2], 1
    return newton.contact_terms(body, vectors)


def _require_contact(
    scene: Scene, body: Parameters, vectors: NewtonState, context: Any, contact: str
) -> None:
    numerator, denominator = contact_terms(scene.model, body, vectors)
    if denominator <= 0:
        raise InputError(
            f"{scene.name}: the denominator of g_n is {context.nstr(denominator / body.I1, 6)} I1 "
            "at t = 0, expected above 0: no contact force exists; lower mu or nu_x"
        )
    if numerator <= 0 and contact == "unilateral":
        weight = numerator / denominator
        raise InputError(
            f"{scene.name}: g_n is {context.nstr(weight, 6)} m g at t = 0, expected above 0: "
            "the top is not on the table; lower the start's rates, or run the equations beyond "
            "their meaning with contact bilateral"
        )


def longest_step(body: Parameters, vectors: NewtonState, order: int, precision: Precision) -> Any:
    """Longest Taylor step that keeps the digits of a lean beside a pole; None for other starts.

    ``body`` and ``vectors`` are the dimensionless start.

    heyoka keeps the truncation error below eps of the largest entry. A lean of 1e-20 rad is not
    seen in that: its steps would become so long that it is off by a factor. As the lean obeys
    linear equations there, a term of its series is at most (frequency times step)^k/k!, with the
    frequency of the fastest mode, and the step follows from the first term left out.
    """
    context = precision.context
    spin = context.sqrt(dot(vectors.L, vectors.L))
    sideways = context.hypot(vectors.Lx, vectors.Ly) / max(1, spin)
    lean = max(context.hypot(*vectors.k[:2]), sideways, context.hypot(*vectors.v[:2]))
    if not 0 < lean < LEAN:
        return None
    height = 1 + body.alpha
    # nutation, the pendulum's frequency, and the decay of gliding, none of them underestimated
    frequency = (
        spin / body.I1
        + context.sqrt(body.alpha / body.I1)
        + body.mu * (1 + height * height / body.I1)
    )
    first_left_out = precision.eps * context.factorial(order + 1)
    return context.root(first_left_out, order + 1) / frequency


def vanishes(event: str, key: Key, start: Beginning) -> bool:
    """Whether the event's function is zero at the start itself.

    Then whether heyoka finds a root just behind it is a matter of rounding (theta_dot(0) = 0 in
    the reference scene), and the rule is: the start is no event.
    """
    form, context = key.formulation, key.precision.context
    known = event_named(event, form.model)
    evaluate = known.function
    first = tuple(form.start(start.body, start.vectors, start.euler))
    if known.slope or not event.startswith(EXTREMUM):
        q = form.motion(start.body, first, context, context.mpf(0))
        return bool(abs(evaluate(q)) < context.ldexp(1, -key.precision.bits))
    h = context.ldexp(1, -key.precision.bits // 3)
    rates = form.rates(start.body, form.State(*first), context)
    ahead, behind = (
        evaluate(
            form.motion(
                start.body,
                [x + sign * h * rate for x, rate in zip(first, rates, strict=True)],
                context,
                context.mpf(0),
            )
        )
        for sign in (1, -1)
    )
    return bool(abs(ahead - behind) / (2 * h) < context.ldexp(1, -key.precision.bits // 2))
