"""The checks, one entry each: what is asked of every row, where, and within which limit.

A check is skipped with a reason where scene or columns do not allow it. Otherwise ``watch`` is
given the first stretch and returns a function from stretches to one value a row, of which the
worst counts. Formulas are those of ``mechanics``, evaluated on arrays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy

from tt_precise.check.evolution import Evolution, Total
from tt_precise.check.stretch import Case, Stretch
from tt_precise.mechanics import quantities
from tt_precise.mechanics.conserved import INTEGRALS, Integral
from tt_precise.mechanics.vectors import dot

PAPER_LIMIT = 1e-6  # "constant with precision of order 10^-6 lambda", section 2.1

# The last row of a motion that leaves the table has g_n = 0, which rounding makes +- some eps.
LIFT_OFF = -1e-12

Watch = Callable[[Stretch], numpy.ndarray]
Sense = Literal["at most", "above", "at least"]


@dataclass(frozen=True)
class Check:
    """One check: its name, what it says, when it is skipped (a reason, else ""), and how.

    Values pass that are ``sense`` the limit. ``watch(case, first, limit)`` makes the function
    that is handed one stretch after the other; where it has a ``doubt``, limits below that
    cannot be told, and its ``note`` says why.
    """

    name: str
    meaning: str
    watch: Callable[[Case, Stretch, float], Watch]
    skipped: Callable[[Case, Stretch], str]
    limit: float = PAPER_LIMIT
    sense: Sense = "at most"


def _integral(integral: Integral) -> Check:
    def skipped(case: Case, first: Stretch) -> str:
        if not integral.holds(case.scene):
            return _why_not(integral.name)
        if integral.azimuth and not case.columns.azimuth:
            return "needs the direction of the axis, which Euler angles without phi leave open"
        if integral.name != "jellett" and not case.own_force:
            return "holds under the scene's own contact force only"
        if not numpy.isfinite(integral.evaluate(first.first)):
            return _no_velocity(case)
        return ""

    def watch(case: Case, first: Stretch, limit: float) -> Watch:
        start = integral.evaluate(first.first)
        scale = float(integral.scale(first.first)) or 1.0
        return lambda stretch: abs(integral.evaluate(stretch.q) - start) / scale

    return Check(integral.name, integral.meaning, watch, skipped)


def _why_not(name: str) -> str:
    if name in ("routh", "modified_energy"):
        return "an integral of rolling only"
    return "an integral of frictionless gliding only"


def _no_velocity(case: Case) -> str:
    return f"needs the velocity: columns {', '.join(case.columns.velocity)}"


def _energy(integral: Integral) -> Check:
    conserved = _integral(integral)

    def skipped(case: Case, first: Stretch) -> str:
        return "" if case.velocity_known else _no_velocity(case)

    def watch(case: Case, first: Stretch, limit: float) -> Watch:
        if integral.holds(case.scene) and case.own_force:
            return conserved.watch(case, first, limit)
        scale = float(integral.scale(first.first)) or 1.0
        lowest = numpy.inf

        def rise(stretch: Stretch) -> numpy.ndarray:
            nonlocal lowest
            energy = quantities.E(stretch.q)
            floor = numpy.minimum(numpy.minimum.accumulate(energy), lowest)
            lowest = float(floor[-1])
            return (energy - floor) / scale

        return rise

    return Check(
        "energy", "E, conserved without friction, never rising with it; section 1", watch, skipped
    )


def _contact_skipped(case: Case, first: Stretch) -> str:
    if not case.own_force:
        return "the normal force of another friction law does not follow from the state"
    return "" if case.velocity_known else _no_velocity(case)


def _contact(case: Case, first: Stretch, limit: float) -> Watch:
    weight = case.body.m * case.body.g
    return lambda stretch: quantities.g_n(stretch.q) / weight + 0 * stretch.t


def _slip_skipped(case: Case, first: Stretch) -> str:
    if not case.velocity_given:
        return _no_velocity(case)
    if case.columns.name != "rigid body" and not case.rolling:
        return f"the {case.columns.name} columns leave v_A no vertical part"
    return ""


def _slip(case: Case, first: Stretch, limit: float) -> Watch:
    q = first.first
    scale = float(case.body.R * numpy.sqrt(dot(q.omega, q.omega))) or 1.0
    return lambda stretch: stretch.slip / scale


def _axis(case: Case, first: Stretch, limit: float) -> Watch:
    return lambda stretch: abs(numpy.sqrt(dot(stretch.state.k, stretch.state.k)) - 1)


def _axis_skipped(case: Case, first: Stretch) -> str:
    given = case.columns.name == "vectors"
    return "" if given else f"|k| = 1 by construction in the {case.columns.name} columns"


def _quaternion_skipped(case: Case, first: Stretch) -> str:
    return "" if case.columns.name == "rigid body" else "no quaternion among the columns"


def _quaternion(case: Case, first: Stretch, limit: float) -> Watch:
    names = ("qw", "qx", "qy", "qz")

    def error(stretch: Stretch) -> numpy.ndarray:
        squared: Any = sum(stretch.given[name] ** 2 for name in names)
        return abs(numpy.sqrt(squared) - 1)

    return error


def _evolution_skipped(case: Case, first: Stretch) -> str:
    if not case.own_force:
        return "the force of another friction law does not follow from the state"
    return "" if case.velocity_known else _no_velocity(case)


def _balance_skipped(case: Case, first: Stretch) -> str:
    if case.rolling or case.scene.body.mu == 0:
        return "nothing is dissipated: see energy"
    return _evolution_skipped(case, first)


def _evolution(part: str) -> Callable[[Case, Stretch, float], Watch]:
    def watch(case: Case, first: Stretch, limit: float) -> Watch:
        if "evolution" not in first.shared:
            first.shared["evolution"] = Evolution(case, first)
        return Total(first.shared["evolution"], part, limit)

    return watch


def _time(case: Case, first: Stretch, limit: float) -> Watch:
    return lambda stretch: numpy.diff(stretch.t, prepend=-numpy.inf)


CHECKS = (
    Check(
        "time", "strictly increasing, and every number finite: anything else is refused (s)",
        _time, lambda case, first: "", 0.0, "above",
    ),
    _integral(INTEGRALS["jellett"]),
    _energy(INTEGRALS["energy"]),
    Check(
        "energy_balance", "E falls by the integral of mu g_n v_A^2; section 1",
        _evolution("energy"), _balance_skipped,
    ),
    Check(
        "equations", "the state changes by the integral of its rates; eq (1)",
        _evolution("state"), _evolution_skipped,
    ),
    Check(
        "contact", "g_n/(m g): the table pushes, it does not pull; eq (7)",
        _contact, _contact_skipped, LIFT_OFF, "at least",
    ),
    Check(
        "contact_velocity", "v_A.z = 0 (rolling: v_A = 0), in units of R omega at the start",
        _slip, _slip_skipped,
    ),
    Check("axis_norm", "|k| = 1", _axis, _axis_skipped),
    Check("quaternion_norm", "|q| = 1", _quaternion, _quaternion_skipped),
    *(
        _integral(INTEGRALS[name])
        for name in INTEGRALS
        if name not in ("jellett", "energy", "axis_norm")
    ),
)  # fmt: skip
