"""Error estimates: which runs a run is compared with, and the digits that their distance leaves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from tt_precise.integration.columns import State
from tt_precise.integration.precision import finer
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.digits import sizes
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.initial_state import InitialState
from tt_precise.runtime.arithmetic import Array, Functions, Scalar

# A reference run in the same arithmetic has the same rounding errors, so the run must be coarser by
# this many eps, that its truncation outweighs them. Double has a finer arithmetic for ten times its
# price; extended has none below 150 times. ``benchmarks/estimates.py`` compares with the truth.
COARSE = {"double": 1000}
COARSE_WIDE = 64
RATIO = 30  # of the tolerances of a run and of its reference run in the same arithmetic


class End(NamedTuple):
    """Where a run ended: its status, the time (s), and the entries of the state there (SI)."""

    status: str
    t: Scalar
    values: Mapping[str, Scalar | None]


def error_estimate(end: End, references: Iterable[End], fn: Functions) -> dict[str, Scalar]:
    """Absolute distance of each entry of an end, and of its time "t_end", from reference runs'.

    The largest of the distances, and infinite where a reference run ends in another way: then
    neither can be trusted.
    """
    estimate: dict[str, Scalar] = {}
    entries = {"t_end": end.t, **end.values}
    for reference in references:
        better = {"t_end": reference.t, **reference.values}
        for name, value in entries.items():
            if value is not None and better[name] is not None:
                same = reference.status == end.status
                found = abs(fn.mpf(value) - fn.mpf(better[name])) if same else fn.inf
                estimate[name] = max(found, estimate.get(name, found))
    return estimate


def reference_runs(setup: Setup) -> list[dict[str, Any]]:
    """The runs that a run with ``setup`` is compared with: what ``Trajectory.again`` changes.

    One with ``RATIO`` times smaller truncation errors, or in a finer arithmetic. A coarse run is
    compared in its own arithmetic, which costs less; as both round the start and the body, the
    reference run rounds each number the other way. In Euler form rounding may be what spoils a
    coarse run: its reference is no better, and may happen to come out close to it. So there a
    second one repeats the run itself, rounded the other way.
    """
    coarse = COARSE.get(setup.precision.name, COARSE_WIDE)
    if setup.tolerance >= coarse * setup.precision.eps:
        again = {"events": (), "rounded_otherwise": True}
        if setup.formulation.coordinates == "newton":
            # heyoka bounds a step by the events' functions too, which the reference does not have
            tolerance = 0.0 if setup.events else setup.tolerance / RATIO
            return [again | {"tolerance": tolerance}]
        return [again | {"tolerance": tolerance} for tolerance in (0.0, setup.tolerance)]
    return [{"events": (), "tolerance": 0.0, "precision": finer(setup.precision)}]


def digits_over_rows(
    columns: Mapping[str, Array], errors: Mapping[str, Array], start: InitialState, bits: int
) -> Array:
    """``worst_digits`` of many states at once: float64 arrays over rows in, one out."""
    import numpy

    unit = {n: float(start.units.of_dimension(STATE_DIMENSIONS[n])) for n in columns}
    with numpy.errstate(all="ignore"):
        own = {name: values / unit[name] for name, values in columns.items()}
        beside = sizes(start.body.map(float), own, numpy)
        # what is undefined in both, at a pole, has no error either
        worst = numpy.fmax.reduce([errors[n] / (unit[n] * beside[n]) for n in errors], initial=0)
        return numpy.clip(-numpy.log10(worst), 0.0, bits * math.log10(2))


def worst_digits(state: State, errors: Mapping[str, Scalar], start: InitialState) -> float:
    """Significant digits of the worst entry of ``state`` with these errors (SI).

    By the rule of ``mechanics.digits``; never more than the precision holds, never less than 0.
    """
    context = state.precision.context
    unit = {n: start.units.of_dimension(STATE_DIMENSIONS[n]) for n in state.values}
    own = {
        name: None if value is None else context.mpf(value) / unit[name]
        for name, value in state.values.items()
    }
    beside = sizes(start.body.map(context.mpf), own, context)
    found = [
        float(-context.log10(errors[name] / (unit[name] * size)))
        for name, size in beside.items()
        if errors.get(name)
    ]
    return max(0.0, min([*found, float(state.precision.bits * context.log10(2))]))
