"""The reference scene in every precision, on which sections of the report depend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.precision import KINDS, is_available
from tt_precise.runtime.values import Scalar

SCENE = "reference"


@dataclass(frozen=True)
class PrecisionRun:
    """The reference scene in one precision, and the distance of its end from the finest run's."""

    trajectory: Trajectory
    # largest of the vector entries, dimensionless; None for the reference run itself
    state_error: Scalar | None

    @property
    def label(self) -> str:
        """The label, such as "quad" or "200 bits"."""
        precision = self.trajectory.precision
        return f"{precision.bits} bits" if precision.name == "mp" else precision.name

    @cached_property
    def drift(self) -> dict[str, Sequence[Scalar]]:
        """Relative drift of the scene's conserved quantities, at each sample."""
        return self.trajectory.drift_over_time()


@cache
def precision_runs() -> tuple[PrecisionRun, ...]:
    """The reference scene in every precision this machine has, the finest last.

    That is triple-double, whose 46 digits are more than anything here needs; mp would take a
    hundred times as long.
    """
    names = [name for name in KINDS if is_available(name) and name != "mp"]
    runs = [integrate(SCENE, name) for name in names]
    reference = runs[-1]
    return (
        *(PrecisionRun(run, state_distance(run, reference)) for run in runs[:-1]),
        PrecisionRun(reference, None),
    )


def precisions() -> str:
    """The precisions and their steps, in words."""
    return ", ".join(f"{run.label} ({run.trajectory.steps} steps)" for run in precision_runs())


def state_distance(run: Trajectory, reference: Trajectory) -> Scalar:
    """Largest difference of the vector entries of two final states, in dimensionless units."""
    context, units = reference.precision.context, reference.start.units
    differences = []
    for name in VECTOR_COLUMNS:
        scale = units.of_dimension(reference.dimension(name))
        mine, better = (context.mpf(t.state.values[name]) for t in (run, reference))
        differences.append(abs(mine - better) / scale)
    return max(differences)
