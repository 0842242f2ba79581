"""The longest Taylor step from a start beside a pole."""

from __future__ import annotations

from tt_precise.integration.precision import Precision
from tt_precise.integration.system import SLOW_SPEED
from tt_precise.mechanics.formulations import Formulation
from tt_precise.mechanics.friction import largest_coefficient
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.vectors import dot
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.scene.body import Parameters

# a tolerance relative to the largest entry costs a greater tilt 2 digits at most
LARGE_TILT = 2.0**-7


def longest_step(
    body: Parameters,
    vectors: NewtonState,
    order: int,
    precision: Precision,
    form: Formulation | None = None,
) -> Scalar | None:
    """Longest Taylor step that keeps the digits of a tilt beside a pole; None for other starts.

    ``body`` and ``vectors`` are the dimensionless start; ``form`` counts where it has a time of
    its own.

    heyoka keeps the truncation error below eps of the largest entry. A tilt of 1e-20 rad is not
    seen in that: its steps would become so long that it is off by a factor. As the tilt obeys
    linear equations there, a term of its series is at most (frequency times step)^k/k!, with the
    frequency of the fastest mode, and the step follows from the first term left out.
    """
    if max(map(abs, vectors.k[:2])) >= LARGE_TILT:  # most starts of a sweep, decided in no time
        return None
    context = precision.context
    spin = context.sqrt(dot(vectors.L, vectors.L))
    sideways = context.hypot(vectors.Lx, vectors.Ly) / max(1, spin)
    tilt = max(context.hypot(*vectors.k[:2]), sideways, context.hypot(*vectors.v[:2]))
    if not 0 < tilt < LARGE_TILT:
        return None
    height = 1 + body.alpha
    # nutation, the pendulum's frequency, and the decay of gliding, none of them underestimated
    frequency = spin / body.I1 + context.sqrt(body.alpha / body.I1)
    decay = 1 + height * height / body.I1
    if (
        form and form.own_time
    ):  # in which a rate is v times as large, at most at the highest v there
        frequency = 2 * SLOW_SPEED * frequency + body.mu * decay
    elif body.friction.smooth_at_rest or any(vectors.v):
        frequency += largest_coefficient(body, context.hypot(*vectors.v[:2])) * decay
    first_left_out = precision.eps * context.factorial(order + 1)
    return context.root(first_left_out, order + 1) / frequency
