"""heyoka's Taylor loop and nothing around it: what every other cost is compared with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

from tt_precise.integration.equations import Equations
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.integration.system import numeric_options
from tt_precise.mechanics.formulations import integrated
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array, Scalar
from tt_precise.runtime.untyped import Adaptive
from tt_precise.scene.scene import Scene


def bare_adaptive(setup: Setup, state: Sequence[Scalar], parameters: Sequence[Scalar]) -> Adaptive:
    """The equations as a ``taylor_adaptive``: no events, not even the end of contact."""
    import heyoka

    return heyoka.taylor_adaptive(
        Equations.of(setup.formulation).system,
        list(state),
        pars=list(parameters),
        fp_type=setup.precision.fp_type,
        **numeric_options(setup),
    )


def bare_batch(setup: Setup, state: Array, parameters: Array) -> Adaptive:
    """The same in SIMD lanes: a column of ``state`` and of ``parameters`` for each."""
    import heyoka

    return heyoka.taylor_adaptive_batch(
        Equations.of(setup.formulation).system,
        state.copy(),
        pars=parameters,
        **numeric_options(setup),
    )


@cache
def _compiled(setup: Setup) -> Adaptive:
    form, number = setup.formulation, setup.precision.number
    zero = setup.precision.context.mpf(0)
    return bare_adaptive(
        setup, [number(zero) for _ in form.columns], [number(zero + 1) for _ in form.parameters]
    )


def bare_loop(scene: Scene, tolerance: float = 0.0, precision: str = "double") -> Callable[[], int]:
    """A function that propagates the Newton form of ``scene`` to its horizon; returns the steps.

    ``tolerance`` 0 stands for full accuracy. It knows no contact: also where the table would have
    to pull it goes on.
    """
    working = precision_named(precision)
    form = integrated(scene.model, "newton", scene.body.law)
    setup = Setup(formulation=form, precision=working, tolerance=tolerance)
    adaptive, number = _compiled(setup), working.number
    start = InitialState.of(scene, working.arithmetic)
    state = list(map(number, start.state(form)))
    parameters = list(map(number, start.parameters(form)))
    until, zero = number(start.until), number(working.context.mpf(0))

    def loop() -> int:
        for i, value in enumerate(state):
            adaptive.state[i] = value
        for i, value in enumerate(parameters):
            adaptive.pars[i] = value
        adaptive.time = zero
        return int(adaptive.propagate_until(until)[3])

    return loop
