"""Integrating tables of start values, for sweeps that are no grid and no box."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from tt_precise._version import __version__
from tt_precise.runtime.arithmetic import Array
from tt_precise.runtime.errors import InputError
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError
from tt_precise.scene.scene import Inclination, Scene
from tt_precise.sweeps.specification import Plan

if TYPE_CHECKING:
    import pandas

TASK_ROWS = 128
NO_BUGS = (InputError, WorkerDiedError, MemoryError, OSError)


def integrated(pool: Pool, plan: Plan, tables: list[tuple[str, Array, Array]]) -> pandas.DataFrame:
    """The rows of some tables, in order: ``series``, ``contact``, ``index``, starts, results.

    ``tables`` holds (series, index, values of shape (rows, ``plan.names``)).

    Raises
    ------
    InputError
        A task fails again and again: a start cannot be used, or the system does not let it go on.
    RuntimeError
        It fails for another reason.
    """
    import heyoka
    import pandas

    from tt_precise.sweeps.run import chunk_task

    pieces = [
        (name, index[first : first + TASK_ROWS], values[first : first + TASK_ROWS])
        for name, index, values in tables
        for first in range(0, len(index), TASK_ROWS)
    ]
    lanes = heyoka.recommended_simd_size()
    calls = (
        Call(number, (plan, __version__, piece[2], lanes)) for number, piece in enumerate(pieces)
    )
    frames = {}
    for call, result in pool.perform(chunk_task, calls):
        name, index, values = pieces[call.key]
        if isinstance(result, Failure):
            kind = InputError if isinstance(result.error, NO_BUGS) else RuntimeError
            raise kind(f"sweep of {name}: {result.reason}") from result.error
        columns = {"series": name, "contact": plan.contact, "index": index}
        columns |= {start: values[:, position] for position, start in enumerate(plan.names)}
        frames[call.key] = pandas.DataFrame({**columns, **result["columns"]})
    return pandas.concat([frames[number] for number in sorted(frames)], ignore_index=True)


def lambda_of_start(scene: Scene, theta: float) -> float:
    """Dimensionless lambda of a start with this inclination, omega_3 = 1 rad/s and no other rate.

    lambda is linear in omega_3.
    """
    from tt_precise.integration.precision import precision_named
    from tt_precise.mechanics.initial_state import InitialState
    from tt_precise.mechanics.quantities import Motion, jellett

    start = replace(
        scene.start, theta=Inclination(Fraction(theta)), omega_3=Fraction(1), phi_dot=Fraction(0)
    )
    double = precision_named("double")
    initial = InitialState.of(replace(scene, start=start), double.arithmetic)
    return float(jellett(Motion(initial.body, initial.vectors, double.context)))
