"""One scene at its edges: tilts down to 1e-300, spin and friction times powers of ten.

Each change is integrated in several precisions. The digits are those of the worst sample, estimated
by runs in finer arithmetic (``Trajectory.digits_throughout``); the status tells whether contact or
the model ended.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Annotated, NamedTuple

from tt_precise.integration import integrate
from tt_precise.integration.setup import refused_in_doubles
from tt_precise.runtime.records import Record, means
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError
from tt_precise.scene.scene import Scene

TILTS = ("1e-1", "1e-3", "1e-6", "1e-10", "1e-16", "1e-30", "1e-100", "1e-300")  # Tilts in rad.
POWERS_OF_SPIN = (-6, -3, -2, -1, 1, 2, 3)
POWERS_OF_FRICTION = (-12, -6, -3, -1, 1, 2, 3, 4)
LONGEST_S = Fraction(10)  # Longest horizon of a run in s; a shorter one of the scene stays.
# A horizon is shortened where the fastest rate, of spin or friction, exceeds this many times that
# of the scene itself: so a run takes at most about ten times the steps.
MORE_STEPS = 10
REFUSED = "refused"


class EdgeOutcome(Record, frozen=True):
    """The outcome of a change in one precision."""

    change: Annotated[str, means("what differs from the scene; empty for the scene itself")]
    precision: Annotated[str, means("the arithmetic")]
    status: Annotated[str, means("status of the run, or refused")]
    until_s: Annotated[float, means("the horizon in s")]
    t_end_s: Annotated[float | None, means("where the run ends in s")]
    digits: Annotated[float | None, means("correct digits at the worst sample, estimated")]
    theta: Annotated[float | None, means("theta at the end in rad; null: undefined")]
    steps: Annotated[int | None, means("steps taken")]
    note: Annotated[str, means("why it is refused")] = ""


class Edge(NamedTuple):
    """A change in words, and the scene with it."""

    change: str
    scene: Scene


def precisions(scene: Scene) -> tuple[str, ...]:
    """Double, and the wider arithmetic that costs least on ``scene``."""
    return ("double", "extended" if refused_in_doubles(scene) else "double-double")


def edges(scene: Scene) -> Iterator[Edge]:
    """The scene itself, and its changes, except changes without meaning in its model."""
    short = scene.varied(until=min(scene.until, LONGEST_S))
    yield Edge("", short)
    for pole in ("", "pi - "):
        for tilt in TILTS:
            yield Edge(f"theta = {pole}{tilt}", short.varied(theta=f"{pole}{tilt}"))
    for power in POWERS_OF_SPIN if scene.start.omega_3 else ():
        spin = scene.start.omega_3 * Fraction(10) ** power
        yield Edge(f"omega_3 times 1e{power}", shortened(short, short.varied(omega_3=spin)))
    for power in POWERS_OF_FRICTION if scene.body.mu and scene.model == "gliding" else ():
        changed = short.varied(mu=scene.body.mu * Fraction(10) ** power)
        yield Edge(f"mu times 1e{power}", shortened(short, changed))


def shortened(scene: Scene, changed: Scene) -> Scene:
    """``changed`` with a horizon of at most about ``MORE_STEPS`` times the steps of ``scene``."""
    ratio = _rate(changed) / _rate(scene)
    return (
        changed if ratio <= MORE_STEPS else changed.varied(until=changed.until * MORE_STEPS / ratio)
    )


def _rate(scene: Scene) -> Fraction:
    """The fastest rate of a motion, 1/s: of the spin, of gliding (viscous), or of falling."""
    body, start = scene.body, scene.start
    rates = [abs(rate) for rate in (start.omega_3, start.phi_dot, start.theta_dot)]
    if body.friction.constant:
        rates.append(body.mu * body.g * (1 + body.m * body.R**2 / body.I3))
    return Fraction(max(*rates, Fraction(float(body.g / body.R) ** 0.5)))


def explore(scene: Scene, progress: Progress = silent) -> tuple[EdgeOutcome, ...]:
    """The outcome of every change in every precision."""
    every = [(edge, precision) for edge in edges(scene) for precision in precisions(scene)]
    outcomes = []
    for done, (edge, precision) in enumerate(every, start=1):
        outcomes.append(outcome(edge, precision))
        progress(done / len(every))
    return tuple(outcomes)


def outcome(edge: Edge, precision: str) -> EdgeOutcome:
    """Integrate an edge in a precision."""
    until = float(edge.scene.until)
    try:
        run = integrate(edge.scene, precision, events=(), record=())
    except InputError as error:  # such as a start that the table would have to pull
        return EdgeOutcome(
            edge.change, precision, REFUSED, until, None, None, None, None, str(error)
        )
    theta = run.state.theta
    return EdgeOutcome(
        edge.change, precision, run.status, until, float(run.t_end),
        float(run.digits_throughout), None if theta is None else float(theta), run.steps,
    )  # fmt: skip


# What a status says of a scene at its edge.
ENDINGS = {
    "contact_lost": "contact is lost",
    "singular_contact": "the model ends, no contact force exists",
    "pole": "the formulation ends at a pole",
    "failed": "the integration fails",
    REFUSED: "no motion, the start is refused",
}


def findings(outcomes: Sequence[EdgeOutcome]) -> Iterator[str]:
    """Sentences: where digits, contact or the model are lost."""
    for precision in dict.fromkeys(one.precision for one in outcomes):
        known = [one for one in outcomes if one.precision == precision and one.digits is not None]
        if known:
            worst = min(known, key=lambda one: one.digits or 0.0)
            where = worst.change or "the scene itself"
            yield f"fewest digits in {precision}: {worst.digits:.1f}, {where}"
    first = [one for one in outcomes if one.precision == outcomes[0].precision]
    for status, words in ENDINGS.items():
        ended = [one for one in first if one.status == status]
        if ended:
            soonest = min(ended, key=lambda one: one.t_end_s or 0.0)
            where = soonest.change or "the scene itself"
            when = "" if soonest.t_end_s is None else f" at {soonest.t_end_s:.4g} s"
            why = f" ({soonest.note})" if soonest.note else ""
            yield f"{words}: {len(ended)} of {len(first)}, first {where}{when}{why}"


def table(outcomes: Sequence[EdgeOutcome]) -> Iterator[str]:
    """A table for a terminal, with a row for each change and the digits in each precision."""
    names = tuple(dict.fromkeys(one.precision for one in outcomes))
    heads = "".join(f"{name:>{len(name) + 2}}" for name in names)
    yield f"{'digits in':22}{heads}{'steps':>8}{'theta':>10}  end"
    for start in range(0, len(outcomes), len(names)):
        row = outcomes[start : start + len(names)]
        digits = "".join(
            f"{'-' if one.digits is None else f'{one.digits:.1f}':>{len(one.precision) + 2}}"
            for one in row
        )
        one = row[0]
        steps = "-" if one.steps is None else str(one.steps)
        theta = "-" if one.theta is None else f"{one.theta:.3g}"
        end = one.status + ("" if one.t_end_s is None else f" at {one.t_end_s:.4g} s")
        yield f"{one.change or 'the scene itself':22}{digits}{steps:>8}{theta:>10}  {end}"
