"""The exact initial value problem that is to be enclosed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import flint
from flint import arb

from tt_precise.certify.balls import Balls, ball
from tt_precise.certify.tape import Tape
from tt_precise.certify.verdict import NotProved
from tt_precise.integration.equations import extended_rates
from tt_precise.mechanics.formulations import Formulation, integrated
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Arithmetic, Functions, Scalar
from tt_precise.scene.body import Parameters, Units
from tt_precise.scene.scene import Scene

BALLS = Arithmetic(Balls, ball)


@dataclass(frozen=True)
class Problem:
    """y' = rates(parameters, y, fn), y(0) = start, for exact real parameters and start.

    ``rates`` is generic in the arithmetic, analytic, and free of time. ``parameters`` and
    ``start`` return balls around the exact numbers, in the working precision of the moment: as
    tight as one asks. ``scene`` is where it comes from, if it does.
    """

    name: str
    columns: tuple[str, ...]
    rates: Callable[[Sequence[Scalar], Sequence[Scalar], Functions], Sequence[Scalar]]
    parameters: Callable[[], Sequence[arb]]
    start: Callable[[], Sequence[arb]]
    until: Callable[[], arb]
    scene: Scene | None = None

    @cached_property
    def tape(self) -> Tape:
        """``rates`` with each operation once, for arithmetics in which they are long."""
        return Tape.of(self.rates, len(self.parameters()), len(self.columns))


def problem_of(scene: Scene) -> Problem:
    """The scene in vectors and dimensionless units (m = R = g = 1), the axis at azimuth 0.

    The state is that of ``form_of``; recorded quadratures follow, scaled down as in
    ``integrate.quadratures``.

    Raises
    ------
    NotProved
        The scene changes its equations on the way (flight, an elastic table), or they contain a
        function that balls lack.
    """
    if scene.lifts:
        raise NotProved(
            "equations", "flight and elastic tables change them on the way; proofs cover one set"
        )
    missing = scene.body.friction.missing(Balls)
    if missing:
        raise NotProved(
            "equations",
            f"{scene.body.law} friction needs {' and '.join(missing)}, proofs have none",
        )
    form = form_of(scene)

    def rates(
        parameters: Sequence[Scalar], state: Sequence[Scalar], fn: Functions
    ) -> Sequence[Scalar]:
        return extended_rates(form, scene.record, body_of(scene, parameters), tuple(state), fn)

    known: dict[int, Sequence[arb]] = {}

    def parameters() -> Sequence[arb]:
        precision = flint.ctx.prec
        if precision not in known:
            known[precision] = InitialState.of(scene, BALLS).parameters(form)
        return known[precision]

    def start() -> Sequence[arb]:
        state = InitialState.of(scene, BALLS).state(form)
        return [*map(arb, state), *(arb(0) for _ in scene.record)]

    def until() -> arb:
        return dimensionless_time(scene, scene.until)

    return Problem(
        scene.name, (*form.columns, *scene.record), rates, parameters, start, until, scene
    )


def form_of(scene: Scene) -> Formulation:
    """The equations that are enclosed: those that heyoka integrates, in vectors."""
    return integrated(scene.model, "newton", scene.body.friction)


def body_of(scene: Scene, parameters: Sequence[Scalar]) -> Parameters:
    """The dimensionless body whose open parameters are given."""
    return form_of(scene).body(parameters)


def units_of(scene: Scene) -> Units:
    """Mass, length and time units of the scene's dimensionless form in SI, as balls."""
    return Units.of(scene.body, Balls, ball)


def dimensionless_time(scene: Scene, seconds: Fraction) -> arb:
    """An exact time in s as a ball in units of sqrt(R/g)."""
    return ball(seconds) / units_of(scene).time
