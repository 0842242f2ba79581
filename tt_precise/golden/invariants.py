"""What the printed rows conserve: evidence that knows nothing of how they were computed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mpmath

from tt_precise.exact.jellett import jellett_along
from tt_precise.golden.digits import DIGITS
from tt_precise.golden.table import Table
from tt_precise.mechanics.conserved import conserved, drift
from tt_precise.mechanics.lifted import LiftedState
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.mpfr import mpfr_of
from tt_precise.scene.numerals import to_mpmath
from tt_precise.scene.scene import Scene

WORKING_DIGITS = 60

# A row of 34 digits is rounded by 5e-35 in each of its entries, and the terms of an integral add
# up a few of them; one digit is left for that.
CONSTANT_TO = DIGITS - 1


@dataclass(frozen=True)
class Constancy:
    """To how many digits an integral is the same in all rows, and in which row it is worst."""

    name: str
    digits: float
    worst_row: int


def constancies(scene: Scene, trajectory: Table) -> list[Constancy]:
    """For everything that the scene conserves, from the printed vectors alone.

    ``jellett_euler`` is lambda once more, from the printed Euler columns and compared with its
    exact value at the start.
    """
    context = mpmath.MPContext()
    context.dps = WORKING_DIGITS
    wide = mpfr_of(context)
    kind: Any = LiftedState if scene.lifts else NewtonState
    found = []
    with wide.precision():
        body = scene.body.numbers(lambda value: wide.number(to_mpmath(value, context)))
        entries = [wide.of_texts(trajectory.column(name)) for name in kind._fields]
        first, rows = (
            Motion(body, kind(*state), wide, scene.model)
            for state in ([entry[0] for entry in entries], entries)
        )
        for integral in conserved(scene.model, scene.body):
            drifts: list[Scalar] = list(map(wide.back, drift(integral, [first, rows])[1]))
            worst = max(range(len(drifts)), key=drifts.__getitem__)
            digits = -context.log10(drifts[worst]) if drifts[worst] else context.mpf(DIGITS)
            found.append(Constancy(integral.name, min(float(digits), float(DIGITS)), worst))
    euler = _jellett_euler(scene, trajectory)
    return [*found, euler] if euler else found


def _jellett_euler(scene: Scene, trajectory: Table) -> Constancy | None:
    needed = ("theta", "phi_dot", "omega_3")
    if any("" in trajectory.column(name) for name in needed):
        return None  # a pole
    track = jellett_along(trajectory.columns, trajectory.rows, scene, WORKING_DIGITS, "Euler")
    if track.drift is None:
        return None  # a scene with lambda = 0
    digits = -track.context.log10(track.drift) if track.drift else DIGITS
    return Constancy("jellett_euler", min(float(digits), float(DIGITS)), track.worst)
