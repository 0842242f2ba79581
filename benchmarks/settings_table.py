"""The table behind ``integrate(digits=...)``: ``python -m benchmarks.settings_table``.

Every setting integrates every golden scene, and those cheaper than quad as many seeded ones: the
golden ones alone are harder than most. Recorded is how many digits are right in the worst entry at
the worst time, and, on the reference scene, what the run costs beside double at full accuracy in
the same minute. ``tt-precise tradeoff`` in its full form calls ``write``, which takes some
minutes. Writes ``tt_precise/integration/cost_table.csv``.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import islice
from typing import TYPE_CHECKING

from tt_precise.runtime.arithmetic import Scalar
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json

if TYPE_CHECKING:
    import pandas

    from tt_precise.integration import Trajectory
    from tt_precise.scene.scene import Scene

TOLERANCES = {
    # half decades: digits that are asked for are met by the first that suffices
    "double": (*(float(f"{m}e-{n}") for n in range(3, 14) for m in (1, 0.3)), 0.0),
    "extended": (1e-15, 1e-16, 1e-17, 0.0),
    "double-double": tuple(float(f"1e-{n}") for n in range(14, 29)),
    # golden data say nothing of what is beyond their 34 printed digits
    "triple-double": tuple(float(f"1e-{n}") for n in range(28, 36)),
    "quad": (1e-18, 1e-24, 1e-30, 0.0),
}
# the Euler form costs the same multiple in every arithmetic; quad would take it half an hour
EULER = ("double", "extended")
ROUNDS = {"double": 21, "extended": 7, "double-double": 7, "triple-double": 7, "quad": 1}
TIMED_EVERY = Fraction(1, 100)  # s; rows of a paired run
SEEDED, SEEDED_UNTIL_S, SEEDED_EVERY_S = 24, 8, Fraction(1, 20)
TIMED = "reference"  # a scene that stands still, or grazes a pole, says nothing about costs


@dataclass(frozen=True)
class MeasuredSetting:
    """One setting of the integrator; ``tolerance`` 0 stands for the eps."""

    formulation: str
    precision: str
    tolerance: float


BASE = MeasuredSetting("newton", "double", 0.0)
TRUTH = MeasuredSetting("newton", "triple-double", 0.0)  # of seeded scenes


@dataclass(frozen=True)
class Performance:
    """How a setting fared on a scene: right digits, order, and on one scene its cost."""

    digits: float
    order: int
    cost: float | None


def settings() -> Iterator[MeasuredSetting]:
    """Every setting that is measured."""
    for formulation in ("newton", "euler"):
        for precision, tolerances in TOLERANCES.items():
            if formulation == "newton" or precision in EULER:
                yield from (
                    MeasuredSetting(formulation, precision, tolerance) for tolerance in tolerances
                )


def table(
    scenes: Iterable[str] | None = None, seeded: int = SEEDED, progress: Progress = silent
) -> pandas.DataFrame:
    """A row for each setting: digits of the worst entry at its worst time, over the scenes.

    ``cost`` is relative to ``BASE``.
    """
    import pandas

    from benchmarks.random_scenes import gliding_scenes
    from tt_precise import golden
    from tt_precise.scene.scene import load_scene

    every = [load_scene(name) for name in (golden.scenes() if scenes is None else scenes)]
    drawn = islice(gliding_scenes(SEEDED_UNTIL_S), seeded)
    every += [replace(scene, sample_every=SEEDED_EVERY_S) for scene in drawn]
    found: dict[MeasuredSetting, list[Performance]] = {setting: [] for setting in settings()}
    for number, scene in enumerate(every):
        for setting, outcome in outcomes(scene, golden=number < len(every) - seeded):
            found[setting].append(outcome)
        progress((number + 1) / len(every))
    return pandas.DataFrame([_row(setting, of_way) for setting, of_way in found.items()])


def outcomes(scene: Scene, *, golden: bool) -> Iterator[tuple[MeasuredSetting, Performance]]:
    """Every setting on one scene; quad only where golden data say what is right.

    No Euler form where the scene starts at a pole, no several doubles where it comes in pieces.
    """
    from benchmarks.estimates import right_throughout
    from tt_precise.integration.precision import DOUBLES

    found: dict[MeasuredSetting, Trajectory] = {}
    for setting in settings():
        if setting.formulation == "euler" and scene.start.theta.at_pole:
            continue
        if setting.precision in DOUBLES and scene.in_pieces:
            continue
        if setting.precision == "quad" and not golden:
            continue
        record = ("phi",) if setting.formulation == "euler" else ()
        found[setting] = integrated(scene, setting, record)
    costs = _costs(found) if scene.name == TIMED else {}
    truth = None if golden else integrated(scene, TRUTH, ("phi",))
    for setting, run in found.items():
        digits = right_throughout(run, truth) if truth else right_digits(run)
        yield setting, Performance(digits, run.order, costs.get(setting))


def integrated(scene: Scene, setting: MeasuredSetting, record: tuple[str, ...]) -> Trajectory:
    """The run that ``integrate(digits=...)`` makes of a setting: with its reference run."""
    from tt_precise.integration.once import integrate_once

    return integrate_once(
        scene, setting.precision, bits=None, formulation=setting.formulation, events=(),
        record=record, contact="unilateral", tolerance=setting.tolerance, options=None,
        paired=True, progress=None,
    )  # fmt: skip


def right_digits(trajectory: Trajectory) -> float:
    """Digits of the worst entry, at the worst time, that golden data confirms.

    0 for another ending. Beside the pole, where Euler rates are undefined, the vectors count.
    """
    import numpy

    from tt_precise import golden
    from tt_precise.integration.accuracy import digits_over_rows

    known = golden.load(trajectory.scene.name, "text")
    if known.manifest["status"] != trajectory.status:
        return 0.0
    number = trajectory.precision.context.mpf
    names = [name for name in trajectory.state.values if name in known.columns]
    end = trajectory.state.values
    # the end of a model is another moment in each run: there ends are compared, not times
    inner = [t for t in known["t"][:-1] if number(t) < number(trajectory.t_end)]
    rows = trajectory.table(*names, times=inner)
    values, errors = {}, {}
    for name in names:
        own = [*rows[name], end[name]]
        truth = [*known[name][: len(inner)], known[name].iloc[-1]]
        values[name] = numpy.array([_float(x) for x in own])
        errors[name] = numpy.array(
            [
                math.nan
                if text is None or _float(x) != _float(x)
                else _float(abs(number(x) - number(text)))
                for x, text in zip(own, truth, strict=True)
            ]
        )
    bits = trajectory.precision.bits
    return float(digits_over_rows(values, errors, trajectory.start, bits).min())


def _float(value: Scalar) -> float:
    return math.nan if value is None else float(value)


def _costs(found: dict[MeasuredSetting, Trajectory]) -> dict[MeasuredSetting, float]:
    """Processor time of the propagation alone, beside ``BASE``; best of rounds taken in turn."""
    from tt_precise.integration.paired import Beginning, can_be_paired, propagate_pair
    from tt_precise.integration.paired_in_doubles import pair_in_doubles, run_in_doubles
    from tt_precise.integration.propagate import propagate

    best = dict.fromkeys(found, math.inf)
    starts = {one: Beginning(run.start, run.precision, run.scene) for one, run in found.items()}
    for number in range(max(ROUNDS.values())):
        for setting, trajectory in found.items():
            if number < ROUNDS[setting.precision]:
                begin = time.process_time()
                setup, start = trajectory.setup, trajectory.start
                begun = starts[setting]
                if setup.precision.doubles:
                    pair_in_doubles(run_in_doubles(setup, start), begun)
                elif not (can_be_paired(setup) and propagate_pair(setup, begun, TIMED_EVERY)):
                    propagate(setup, start)
                best[setting] = min(best[setting], time.process_time() - begin)
    return {setting: seconds / best[BASE] for setting, seconds in best.items()}


def _row(setting: MeasuredSetting, found: list[Performance]) -> dict[str, Json]:
    digits = [one.digits for one in found]
    (cost,) = (one.cost for one in found if one.cost is not None)
    return {
        "formulation": setting.formulation,
        "precision": setting.precision,
        "tolerance": f"{setting.tolerance:g}",
        "order": found[0].order,
        "digits_worst": round(min(digits), 1),
        "digits_median": round(statistics.median(digits), 1),
        "cost": float(f"{cost:.3g}"),
        "scenes": len(found),
    }


def write(progress: Progress = silent) -> pandas.DataFrame:
    """Measure, and write the table of the package."""
    from tt_precise.integration.cost_table import TABLE
    from tt_precise.runtime.files import atomic_write

    found = table(progress=progress)
    atomic_write(TABLE, found.to_csv(index=False, lineterminator="\n"))
    return found


def main() -> None:
    """Measure, write and show the table."""
    from tt_precise.runtime.progress import progress_bar

    with progress_bar("settings on golden scenes") as progress:
        print(write(progress).to_string(index=False))


if __name__ == "__main__":
    main()
