"""Sweeps as tables: ``tt.sweep``, and the rows of any table of starts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tt_precise._version import __version__
from tt_precise.runtime.process import import_heyoka
from tt_precise.runtime.values import Array, InputError
from tt_precise.runtime.workers import Call, Failure, Pool, WorkerDiedError
from tt_precise.scene.scene import Inclination, Scene
from tt_precise.sweeps import run, spot_check
from tt_precise.sweeps.specification import Plan, specification

if TYPE_CHECKING:
    import pandas

Number = str | int | float
TASK_ROWS = 128
NO_BUGS = (InputError, WorkerDiedError, MemoryError, OSError)


def sweep(
    scene: str | Scene,
    *,
    vary: Mapping[str, str | Iterable[Number]] | None = None,
    box: Mapping[str, str | tuple[Number, Number]] | None = None,
    samples: int = 0,
    sampler: Literal["sobol", "latin"] = "sobol",
    seed: int = 0,
    record: Iterable[str] = (),
    until: str | int | None = None,
    contact: Literal["unilateral", "bilateral"] = "unilateral",
    out: str | Path | None = None,
    workers: int = 1,
    recheck: int = spot_check.ONE_IN,
) -> pandas.DataFrame:
    """Integrate ``scene`` from many starts; each start gives one row.

    Parameters
    ----------
    scene
        A shipped name, a path to a TOML file, or a scene: gliding with the viscous law, or rolling,
        on a rigid table.
    vary
        A grid: the values of each start value (rad, rad/s, m/s) or parameter (SI; I1 and I3 in
        units of m R^2), by name, as numbers or as text: "0.1,0.2", or "-200:200:801" for 801
        values, ends included.
    box, samples
        Ranges by name, as two numbers or as "low:high", and the number of samples.
    sampler, seed
        A Sobol sequence or a Latin hypercube, and its seed. The seed also draws the rows to
        recheck.
    record
        Further columns; see ``tt_precise.sweeps.columns``.
    until
        Horizon in s, instead of the scene's.
    contact
        "unilateral": a row ends where g_n reaches 0; "bilateral": it continues with g_n < 0.
    out
        A folder or URL for the rows; existing rows are not computed again.
    workers
        Processes; with more than one a script needs ``if __name__ == "__main__"``.
    recheck
        Integrate one row in ``recheck`` again in double-double; 0: none.

    Returns
    -------
    pandas.DataFrame
        ``index``, the varied values, ``outcome``, and the columns of ``tt_precise.sweeps.columns``,
        in SI; ``attrs["summary"]`` has results, missing rows and settings. Outcomes
        are ``inverts`` (has crossed the equator, and the axis is below it at the end),
        ``does_not_invert`` (energy and lambda at the end exclude that the axis reaches the
        equator), ``undecided`` (at the horizon neither is certain), ``contact_lost``,
        ``singular_contact`` and ``failed``.

    Raises
    ------
    InputError
        An argument cannot be used.
    """
    spec = specification(
        scene,
        vary=vary,
        box=box,
        until=until,
        samples=samples,
        sampler=sampler,
        seed=seed,
        record=tuple(record),
        contact=contact,
    )
    swept = run.sweep(spec, out=out, workers=workers, one_in=recheck)
    rows = swept.rows
    rows.attrs["summary"] = dict(swept.summary)
    return rows


# ---- tables of starts that are no grid and no box ---------------------------------------------


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
    heyoka = import_heyoka()
    import pandas

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
    for call, result in pool.perform(run.chunk_task, calls):
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
