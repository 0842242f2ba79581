"""Digits requested, claimed and true: ``python -m benchmarks.estimates``.

Seeded random tops and starts, gliding and rolling, each integrated with ``digits=`` some number;
the truth is a run in a finer arithmetic, at twenty samples. Writes
``reports/measured/estimates.csv``.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import pandas

from benchmarks.random_scenes import random_scene, stands
from benchmarks.work_precision.findings import TradeoffTables, findings
from tt_precise.integration import Trajectory, integrate
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.terminal import Progress, progress_bar, say, silent
from tt_precise.runtime.values import InputError, Json
from tt_precise.scene.scene import Scene

OUT = Path("reports/measured/estimates.csv")
SAMPLES = 1_000
# The truth is 49 bits finer or more: no scene here loses more than 10 of 15 digits.
TRUTH = {"double": ("double-double", None), "quad": ("mp", 170)}
BEYOND = 50
SAMPLES_OF_A_RUN = 20


@dataclass(frozen=True)
class Sample:
    """A random scene and the digits requested."""

    seed: int
    scene: Scene
    wanted: int


def sample(seed: int) -> Sample:
    """The sample of a seed: a top that stands on its table, up to 0.6 s; mostly 2 to 12 digits."""
    draws = random.Random(seed)
    while True:
        scene = random_scene(draws, f"case-{seed}")
        wanted = draws.randint(2, 12) if draws.random() < 0.9 else draws.randint(13, 28)
        if stands(scene):
            every = scene.until / SAMPLES_OF_A_RUN
            return Sample(seed, replace(scene, sample_every=every), wanted)


def row(sample: Sample) -> dict[str, Json]:
    """Return the choices for a sample, the digits it claims, and the digits that are right.

    ``estimated`` and ``right`` are the least of all samples, and missing where it raised.
    """
    known = {
        "seed": sample.seed,
        "model": sample.scene.model,
        "until": float(sample.scene.until),
        "wanted": sample.wanted,
    }
    try:
        trajectory = integrate(sample.scene, digits=sample.wanted)
    except InputError as error:
        return known | {"status": "raised", "note": str(error)}
    return known | {
        "status": trajectory.status,
        "formulation": trajectory.formulation,
        "precision": trajectory.precision.name,
        "bits": trajectory.precision.bits,
        "tolerance": f"{float(trajectory.tolerance):.1e}",
        "estimated": round(trajectory.digits_throughout, 2),
        "right": round(right_throughout(trajectory), 2),
        "note": "",
    }


def truth_of(trajectory: Trajectory) -> Trajectory:
    """Integrate the trajectory's scene in a finer arithmetic, without events."""
    own = trajectory.precision
    name, bits = TRUTH.get(own.name, ("mp", own.bits + BEYOND))
    return integrate(
        trajectory.scene, name, bits=bits, formulation=trajectory.formulation, events=()
    )


def right_throughout(trajectory: Trajectory, truth: Trajectory | None = None) -> float:
    """Digits of the worst entry at the worst sample that the truth confirms."""
    beside = truth or truth_of(trajectory)
    return float(trajectory.error_over_time(beside=beside)["digits"].min())


def table(seeds: Iterable[int] = range(SAMPLES), progress: Progress = silent) -> pandas.DataFrame:
    """A row for each seed."""
    every = list(seeds)
    rows = []
    for number, seed in enumerate(every):
        rows.append(row(sample(seed)))
        progress((number + 1) / len(every))
    return pandas.DataFrame(rows)


def main() -> None:
    """Measure, write ``reports/measured/estimates.csv``, and print the findings."""
    with progress_bar("estimating errors") as progress:
        estimates = table(progress=progress)
    atomic_write(OUT, estimates.to_csv(index=False, lineterminator="\n"))
    say(map(str, findings(TradeoffTables(None, estimates=estimates))))


if __name__ == "__main__":
    main()
