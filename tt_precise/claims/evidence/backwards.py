"""A gliding solution continued to negative times, where friction feeds it.

The scenes of this package run forwards, with mu >= 0; backwards the same equations are handed to
SciPy's DOP853, dimensionless and in double.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

from tt_precise.claims import evidence
from tt_precise.mechanics import newton
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import QUANTITIES, Motion
from tt_precise.runtime.arithmetic import Array

TOLERANCE = 1e-12
HORIZON = 1000.0  # in units of sqrt(R/g), some 45 s for the toy


@dataclass(frozen=True)
class Past:
    """Where the past of a solution ends: with contact lost, or at the horizon.

    ``t`` in s, theta in rad, the energy there in units of the start's.
    """

    contact_lost: bool
    t: float
    theta: float
    energy_ratio: float


@cache
def past(scene: evidence.SceneLike = "reference", tolerance: float = TOLERANCE) -> Past:
    """Follow a scene's start back to the horizon, or to where the contact was made."""
    from scipy.integrate import solve_ivp

    start = evidence.trajectory(scene).start
    exact = start.body
    body = exact.map(float)

    def rates(_: float, y: Array) -> Array:
        return newton.rates(body, NewtonState(*y))

    def carried(_: float, y: Array) -> Array:
        return newton.contact_terms(body, NewtonState(*y))[0]

    carried.terminal = True  # type: ignore[attr-defined]
    begin = [float(entry) for entry in start.vectors]
    found = solve_ivp(
        rates, (0, -HORIZON), begin, method="DOP853", rtol=tolerance, atol=tolerance / 100,
        events=carried,
    )  # fmt: skip
    if found.status < 0:
        raise ArithmeticError(f"the past of {scene}: SciPy's DOP853 gave up: {found.message}")
    first, last = (
        Motion(body, NewtonState(*found.y[:, column].tolist()), math) for column in (0, -1)
    )
    energies = [QUANTITIES["E"].evaluate(q) for q in (first, last)]
    return Past(
        contact_lost=found.status == 1,
        t=float(found.t[-1]) * float(start.units.time),
        theta=QUANTITIES["theta"].evaluate(last),
        energy_ratio=energies[1] / energies[0],
    )
