"""How rounding grows in long runs: the errors of lambda and E against Brouwer's square-root law.

Without truncation, each step leaves an integral off by a rounding; if their signs are as good as
random, the sum of n of them grows as sqrt(n), so as t^(1/2) (D. Brouwer, Astron. J. 46, 1937).
A systematic part grows as t. Seeded starts run in SIMD lanes of heyoka, in double.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import numpy

from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.formulations import Formulation, integrated
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, Json
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene
from tt_precise.tradeoff.heyoka_methods import bare_batch

if TYPE_CHECKING:
    import pandas

SCENES = ("frictionless", "rolling")
INTEGRALS_SHOWN = ("jellett", "energy")
LANES = 8
TIMES_A_DECADE = 4
FIRST_S = 1.0
SPREAD = Fraction(1, 100)  # of theta(0) and omega_3(0) over the seeds


class LongRuns(NamedTuple):
    """So many seeds (a multiple of the lanes) up to a time in s."""

    seeds: int
    until_s: float


WHOLE = (LongRuns(8, 1e5), LongRuns(32, 1e4))
QUICK = (LongRuns(16, 1e3),)


def table(spans: tuple[LongRuns, ...], progress: Progress = silent) -> pandas.DataFrame:
    """Rows of ``scene, seed, t_s, jellett, energy``: relative signed errors."""
    import pandas

    rows: list[dict[str, Json]] = []
    runs = [(name, span) for name in SCENES for span in spans]
    work = sum(span.seeds * span.until_s for _, span in runs)
    done = 0.0
    for name, span in runs:
        first = sum(earlier.seeds for earlier in spans[: spans.index(span)])
        for seed in range(first, first + span.seeds, LANES):
            rows += _lanes(load_scene(name), range(seed, seed + LANES), span.until_s)
            done += LANES * span.until_s
            progress(done / work)
    return pandas.DataFrame(rows)


def log_spaced(until_s: float) -> list[float]:
    """Times from ``FIRST_S``, the same number in each decade, up to ``until_s``."""
    count = round(TIMES_A_DECADE * math.log10(until_s / FIRST_S))
    return [FIRST_S * 10 ** (i / TIMES_A_DECADE) for i in range(count + 1)]


def seeded(scene: Scene, seed: int) -> Scene:
    """The scene with another theta(0) and omega_3(0), within ``SPREAD``."""
    draw = random.Random(f"{scene.name} {seed}")
    factors = [1 + SPREAD * Fraction(draw.randrange(-1000, 1001), 1000) for _ in range(2)]
    start, theta = scene.start, scene.start.theta
    begin = replace(
        start, theta=theta._replace(offset=theta.offset * factors[0]),
        omega_3=start.omega_3 * factors[1],
    )  # fmt: skip
    return replace(scene, start=begin)


def _lanes(scene: Scene, seeds: range, until_s: float) -> list[dict[str, Json]]:
    precision = precision_named("double")
    form = integrated(scene.model, "newton", scene.body.friction)
    starts = [InitialState.of(seeded(scene, seed), precision.arithmetic) for seed in seeds]
    state = numpy.array([list(map(float, start.state(form))) for start in starts]).T
    values = {name: float(getattr(starts[0].body, name)) for name in form.parameters}
    batch = bare_batch(
        Setup(formulation=form, precision=precision),
        state,
        numpy.outer(list(values.values()), numpy.ones(len(seeds))),
    )
    # of the rounded body and start, so that only the errors of the steps count
    first = integrals(form, values, state)
    unit = float(starts[0].units.time)
    rows = []
    for t in log_spaced(until_s):
        batch.propagate_until([t / unit] * len(seeds))
        values_now = integrals(form, values, batch.state)
        errors = {name: (values_now[name] - first[name]) / abs(first[name]) for name in values_now}
        rows += [
            {"scene": scene.name, "seed": seed, "t_s": t}
            | {name: float(error[lane]) for name, error in errors.items()}
            for lane, seed in enumerate(seeds)
        ]
    return rows


def integrals(form: Formulation, values: dict[str, float], state: Array) -> dict[str, Array]:
    """Lambda and E of columns of states, in 80-bit numbers: double would add its own rounding."""
    wide = numpy.longdouble
    body = form.body([wide(values[name]) for name in form.parameters])
    q = form.motion(body, form.State(*numpy.asarray(state, dtype=wide)), numpy)
    return {name: INTEGRALS[name].evaluate(q) for name in INTEGRALS_SHOWN}


class Exponent(NamedTuple):
    """The exponent of rms error ~ t^exponent, and its standard error over the seeds."""

    exponent: float
    error: float
    seeds: int
    rms_at_end: float


def exponent(rows: pandas.DataFrame, scene: str, integral: str, until_s: float) -> Exponent:
    """The growth of one integral's error up to ``until_s``, over all seeds that reach it.

    The slope of log rms (over the seeds) against log t by least squares; its standard error from
    leaving out one seed after the other (the jackknife), as the points of one run are correlated.
    """
    mine = rows[(rows["scene"] == scene) & (rows["t_s"] <= until_s * 1.001)]
    errors = mine.pivot(index="seed", columns="t_s", values=integral).dropna().to_numpy()
    times, seeds = numpy.unique(mine["t_s"]), len(errors)

    def steepness(chosen: Array) -> float:
        rms = numpy.sqrt((chosen**2).mean(axis=0))
        return slope(times, numpy.maximum(rms, 1e-20))

    others = numpy.array([steepness(numpy.delete(errors, i, axis=0)) for i in range(seeds)])
    spread = math.sqrt((seeds - 1) / seeds * float(((others - others.mean()) ** 2).sum()))
    rms_at_end = float(numpy.sqrt((errors[:, -1] ** 2).mean()))
    return Exponent(steepness(errors), spread, seeds, rms_at_end)


def slope(x: Array, y: Array) -> float:
    """Exponent p of y = c x^p by least squares in logarithms; at least two points."""
    return float(numpy.polyfit(numpy.log(x), numpy.log(y), 1)[0])
