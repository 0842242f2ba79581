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
from typing import TYPE_CHECKING

from benchmarks.random_scenes import random_scene, stands
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Json

if TYPE_CHECKING:
    import pandas

    from tt_precise.integration import Trajectory
    from tt_precise.scene.scene import Scene

OUT = Path("reports/measured/estimates.csv")
SAMPLES = 1_000
# 11 bits finer than double's, 49 or more than every other: no scene here loses more than 10 of 15
# digits
TRUTH = {"double": ("extended", None), "extended": ("quad", None), "quad": ("mp", 170)}
BEYOND = 50
SAMPLES_OF_A_RUN = 20
OPTIMISM = 0.3  # digits by which an estimate may exceed the truth


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
    from tt_precise.integration import integrate

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
    from tt_precise.integration import integrate

    own = trajectory.precision
    name, bits = TRUTH.get(own.name, ("mp", own.bits + BEYOND))
    return integrate(
        trajectory.scene, name, bits=bits, formulation=trajectory.formulation, events=()
    )


def right_throughout(trajectory: Trajectory, truth: Trajectory | None = None) -> float:
    """Digits of the worst entry at the worst sample that the truth confirms."""
    beside = [truth or truth_of(trajectory)]
    return float(trajectory.error_over_time(beside=beside)["digits"].min())


def table(seeds: Iterable[int] = range(SAMPLES), progress: Progress = silent) -> pandas.DataFrame:
    """A row for each seed."""
    import pandas

    every = list(seeds)
    rows = []
    for number, seed in enumerate(every):
        rows.append(row(sample(seed)))
        progress((number + 1) / len(every))
    return pandas.DataFrame(rows)


def summary(estimates: pandas.DataFrame) -> str:
    """The table in a few sentences."""
    ran = estimates[estimates["status"] != "raised"]
    excess = ran["estimated"] - ran["right"]
    return "\n".join(
        [
            f"{len(estimates)} scenes: {len(estimates) - len(ran)} raised, "
            f"{int((ran['right'] >= ran['wanted']).sum())} of {len(ran)} delivered.",
            f"The estimate exceeds the truth by {excess.max():.2f} digits at most; "
            f"the median is {abs(excess.median()):.2f} off, the lowest {-excess.min():.2f} below.",
            f"{int((excess > OPTIMISM).sum())} are more than {OPTIMISM:g} digits above it.",
        ]
    )


def main() -> None:
    """Measure, and write ``reports/measured/estimates.csv``."""
    from tt_precise.runtime.files import atomic_write
    from tt_precise.runtime.terminal import progress_bar

    with progress_bar("estimating errors") as progress:
        estimates = table(progress=progress)
    atomic_write(OUT, estimates.to_csv(index=False, lineterminator="\n"))
    print(summary(estimates))


if __name__ == "__main__":
    main()
