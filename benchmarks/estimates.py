"""Digits requested, claimed and true: ``python -m benchmarks.estimates``.

Seeded random tops and starts, gliding and rolling, each integrated with ``digits=`` some number;
the truth is a run in a finer arithmetic, at twenty samples. Writes
``reports/measured/estimates.csv``.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction

import pandas

from benchmarks.evidence import MEASURED, write
from benchmarks.work_precision.findings import TradeoffTables, findings
from tt_precise.integration import Trajectory, integrate
from tt_precise.integration.errors import Errors
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import require_contact
from tt_precise.runtime.cache import code_of
from tt_precise.runtime.terminal import Progress, progress_bar, say, silent
from tt_precise.runtime.values import InputError, Json
from tt_precise.scene.body import TippeTop
from tt_precise.scene.scene import Inclination, InitialState, Scene, Start

SAMPLES = 1_000
# Bits by which the truth is finer: no scene here loses more than 10 of 15 digits.
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


def random_scene(draws: random.Random, name: str) -> Scene:
    """A top and a start, gliding or rolling, for 0.05 to 0.6 s."""

    def number(low: float, high: float) -> Fraction:
        return Fraction(round(1e6 * draws.uniform(low, high)), 10**6)

    I1 = number(0.2, 0.6)
    body = TippeTop.from_ratios(
        m=number(0.01, 0.03), R=number(0.01, 0.03), alpha=number(0.02, 0.6), I1=I1,
        I3=min(number(0.2, 0.6), 2 * I1), g="9.82", mu=number(0, 1),
    )  # fmt: skip
    rolling = draws.random() < 0.15
    tilt = number(0.02, 3.1)
    if draws.random() < 0.1:  # near a pole, where the Euler rates are ill conditioned
        tilt /= 10 ** draws.randint(2, 6)
    gliding = {} if rolling else {"nu_x": number(-0.2, 0.2), "nu_y": number(-0.2, 0.2)}
    start = Start(
        Inclination.parse(str(tilt)), theta_dot=number(-5, 5), phi_dot=number(-5, 5),
        omega_3=number(-200, 200), **gliding,
    )  # fmt: skip
    until = number(0.05, 0.6)
    return Scene(
        name=name, model="rolling" if rolling else "gliding", body=body, start=start,
        until=until, sample_every=until,
    )  # fmt: skip


def stands(scene: Scene) -> bool:
    """Test that the table has to push at the start."""
    double = precision_named("double")
    start = InitialState.of(scene, double.arithmetic)
    try:
        require_contact(scene.name, start, double.context, "unilateral")
    except InputError:
        return False
    return True


def row(sample: Sample) -> dict[str, Json]:
    """Return the choices for a sample, the digits it claims, and the digits that are right.

    ``estimated`` and ``right`` are the least of all samples, and missing where it raised.
    """
    request = {
        "seed": sample.seed,
        "model": sample.scene.model,
        "until": float(sample.scene.until),
        "wanted": sample.wanted,
    }
    try:
        trajectory = integrate(sample.scene, digits=sample.wanted)
    except InputError as error:
        return request | {"status": "raised", "note": str(error)}
    return request | {
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
    own, scene, form = trajectory.precision, trajectory.scene, trajectory.formulation
    if own.name == "double":
        return integrate(scene, "double-double", formulation=form, events=())
    return integrate(scene, "mp", bits=own.bits + BEYOND, formulation=form, events=())


def right_throughout(trajectory: Trajectory, truth: Trajectory | None = None) -> float:
    """Digits of the worst entry at the worst sample that the truth confirms."""
    beside = truth or truth_of(trajectory)
    return float(Errors(trajectory.run, beside.run).over_time()["digits"].min())


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
    code = code_of("../benchmarks/estimates.py")
    text = estimates.to_csv(index=False, lineterminator="\n")
    write(MEASURED / "estimates.json", {}, [], code, estimates=text)
    say(map(str, findings(TradeoffTables(None, estimates=estimates))))


if __name__ == "__main__":
    main()
