"""Events whose function is zero at the start itself, which are no events."""

from __future__ import annotations

from tt_precise.integration.events import EXTREMUM, Event
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.initial_state import InitialState


def vanishes(event: Event, setup: Setup, start: InitialState) -> bool:
    """Whether the event's function is zero at the start itself.

    Then whether heyoka finds a root just behind it is a matter of rounding (theta_dot(0) = 0 in
    the reference scene), and the rule is: the start is no event.
    """
    form, context = setup.formulation, setup.precision.context
    evaluate = event.function
    first = start.state(form)
    if event.slope or not event.name.startswith(EXTREMUM):
        q = form.motion(start.body, first, context, context.mpf(0))
        return bool(abs(evaluate(q)) < context.ldexp(1, -setup.precision.bits))
    h = context.ldexp(1, -setup.precision.bits // 3)
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
    return bool(abs(ahead - behind) / (2 * h) < context.ldexp(1, -setup.precision.bits // 2))
