"""The reference scene in every precision, on which sections of the report depend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.columns import VECTOR_COLUMNS
from tt_precise.integration.precision import KINDS
from tt_precise.runtime.values import Scalar

SCENE = "reference"


@dataclass(frozen=True)
class PrecisionRun:
    """The reference scene in one precision; the distance of its end from the finest run's."""

    trajectory: Trajectory
    state_error: Scalar | None

    @property
    def label(self) -> str:
        """The name of the precision."""
        return self.trajectory.precision.name

    @cached_property
    def drift(self) -> dict[str, Sequence[Scalar]]:
        """Relative drift of the scene's conserved quantities, at each sample."""
        return self.trajectory.drift_over_time()


@cache
def precision_runs() -> tuple[PrecisionRun, ...]:
    """Integrate the reference scene in every precision but mp, the finest last."""
    runs = [integrate(SCENE, name) for name in KINDS if name != "mp"]
    finest = runs[-1]
    errors = [*(state_distance(run, finest) for run in runs[:-1]), None]
    return tuple(PrecisionRun(run, error) for run, error in zip(runs, errors, strict=True))


def precisions() -> str:
    """Return the precisions and their steps, in words."""
    return ", ".join(f"{run.label} ({run.trajectory.steps} steps)" for run in precision_runs())


def state_distance(run: Trajectory, reference: Trajectory) -> Scalar:
    """Return the largest difference of the vector components at the end, dimensionless."""
    context, units = reference.precision.context, reference.start.units
    return max(
        abs(context.mpf(run.state.values[name]) - reference.state.values[name])
        / units.of_dimension(reference.run.columns.dimension(name))
        for name in VECTOR_COLUMNS
    )
