"""Long runs in double: errors of lambda and E over time, of seeded starts in SIMD lanes."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy
import pandas

from benchmarks.work_precision.findings import GROWING, LONG_SCENES
from benchmarks.work_precision.heyoka_methods import bare_batch
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.mechanics.conserved import INTEGRALS
from tt_precise.mechanics.formulations import Formulation, integration_form
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, Json
from tt_precise.scene.scene import InitialState, Scene, load_scene

LANES = 8
TIMES_A_DECADE = 4
FIRST_S = 1.0
SPREAD = Fraction(1, 100)  # Relative spread of theta(0) and omega_3(0) over the seeds.


class LongRuns(NamedTuple):
    """A number of seeds (a multiple of the lanes), and the time (s) up to which each runs."""

    seeds: int
    until_s: float


WHOLE = (LongRuns(8, 1e5), LongRuns(32, 1e4))


def table(spans: tuple[LongRuns, ...], progress: Progress = silent) -> pandas.DataFrame:
    """Rows of ``scene, seed, t_s, jellett, energy``: relative signed errors."""
    rows: list[dict[str, Json]] = []
    runs = [(name, span) for name in LONG_SCENES for span in spans]
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
    form = integration_form(scene.model, "newton", scene.body.friction)
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
    return {name: INTEGRALS[name].evaluate(q) for name in GROWING}
