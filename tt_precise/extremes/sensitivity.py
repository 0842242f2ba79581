"""The growth of rounding errors: variational equations against golden data."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import numpy

from tt_precise.extremes.case import CaseOutcome, Findings, case, finite, within
from tt_precise.extremes.runs import EPS, Integrate, integrating
from tt_precise.extremes.variational import Sensitivity, sensitivity
from tt_precise.golden import load, scenes
from tt_precise.integration import Trajectory, integrate
from tt_precise.mechanics import quantities
from tt_precise.mechanics.formulations import STATE_DIMENSIONS
from tt_precise.mechanics.newton import NewtonState
from tt_precise.mechanics.parameters import Parameters, of_numbers
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Array, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene

VARIED = {"alpha": "parameter", "mu": "parameter", "omega_3": "start", "nu_y": "start"}
CHANGE = Fraction(1, 10**12)


@cache
def _sensitivity(scene: str) -> Sensitivity:
    run = integrate(scene)
    sampled = run.sample_times if run.status == "complete" else run.sample_times[:-1]
    return sensitivity(scene, sampled)


@case(
    "double on the golden scene {scene}, at every sample",
    source="golden data; variational equations, with one rounding error of eps a step",
    # derivatives jump at mode switches
    over={"scene": tuple(name for name in scenes() if not load_scene(name).in_pieces)},
    control={"integrate": lambda scene: integrate(scene, tolerance=1e-12)},
)
def error_against_condition(scene: str, integrate: Integrate = integrate) -> Findings:
    """The error is at most sqrt(sum over the steps of (condition x eps)^2)."""
    how = _sensitivity(scene)
    run: Trajectory = integrate(scene)
    errors = _errors(run, scene, how)
    # where nothing moves there are no steps, but the start was rounded once
    a_sample = max(1.0, run.steps / max(1, len(how.times) - 1))
    possible = EPS * how.rounding * a_sample**0.5
    ratio = errors / possible
    finite([*errors, *possible])
    return (
        within(ratio.max(), 1, "of what the condition allows"),
        CaseOutcome(
            f"condition up to {how.condition.max():.2g}, {how.condition[-1]:.2g} at the end; "
            f"at the worst time {-numpy.log10(errors.max()):.1f} digits"
        ),
    )


def _errors(run: Trajectory, scene: str, how: Sensitivity) -> Array:
    """Largest error of any entry at each time, relative to the largest entry of the state."""
    golden = load(scene, "exact")
    frame = run.frame(*how.columns, times=list(golden["t"][: len(how.times)]), numbers="exact")
    largest = numpy.zeros(len(how.times))
    for name in how.columns:
        unit = run.start.units.of_dimension(STATE_DIMENSIONS[name])
        pairs = zip(frame[name], golden[name][: len(how.times)], strict=True)
        errors = [float(abs(run.precision.context.mpf(x) - exact) / unit) for x, exact in pairs]
        largest = numpy.maximum(largest, errors)
    return largest / how.sizes


@case(
    "derivatives of the integral lambda on {scene}",
    source="lambda(x(t)) = lambda(x(0)) for every start and every top; the chain rule",
    over={"scene": ("reference", "contact-lost", "frictionless", "rolling", "tippetopsim")},
    control={"spoil": 1e-9},
)
def lambda_propagated(scene: str, spoil: float = 0.0) -> Findings:
    """Derivatives of lambda(x(t)) by the start and by alpha are the same at all times."""
    how = _sensitivity(scene)
    start = InitialState.of(load_scene(scene), integrate(scene).precision.arithmetic)
    numbers = start.body.numbers_by_name
    numbers |= {n: float(x) for n, x in zip(how.parameters, how.values, strict=True)}
    body = of_numbers(numbers, start.body.friction, start.body.spring, Parameters)

    def value(state: Array, alpha: float) -> float:
        vectors = NewtonState(*state, *(0,) * (8 - len(state)))
        motion = Motion(replace(body, alpha=alpha), vectors, numpy, "gliding")
        return float(quantities.jellett(motion))

    # lambda is linear in each single entry and in alpha: differences over any length are exact
    units = numpy.eye(len(how.columns))
    where = how.parameters.index("alpha")
    worst, largest = 0.0, numpy.array([1.0, 1.0])
    first: tuple[Array, float] | None = None
    for now, state in enumerate(how.states):
        alpha = body.alpha
        gradient = [(value(state + e, alpha) - value(state - e, alpha)) / 2 for e in units]
        propagated = numpy.array(gradient) @ how.by_start[now] * (1 + spoil * (now > 0))
        by_alpha = value(state, alpha + 0.5) - value(state, alpha - 0.5)
        by_alpha += float(numpy.array(gradient) @ how.by_parameters[now][:, where])
        if first is None:
            first = (propagated, by_alpha)
        # an error of a matrix, made in proportion to it when it was largest, stays in lambda
        sums = [numpy.abs(gradient) @ numpy.abs(m[now]) for m in (how.by_start, how.by_parameters)]
        largest = numpy.maximum(largest, [sums[0].max(), sums[1][where]])
        here = numpy.abs(propagated - first[0]).max(), abs(by_alpha - first[1])
        worst = max(worst, *finite(here / largest))
    # a random walk over the samples, of the few eps of a product of 8 x 8 matrices
    limit = 10 * float(len(how.times)) ** 0.5
    return within(worst / EPS, limit, "eps")


@case(
    "derivative by {name} at the reference scene's most sensitive time",
    source="higher precision",
    over={"name": tuple(VARIED)},
    control={"varied": integrating(alpha="1e-6")},
)
def derivative_by_differences(name: str, varied: Integrate = integrate) -> Findings:
    """It is the difference quotient of two runs in triple-double."""
    how = _sensitivity("reference")
    now = int(how.condition.argmax())
    scene = replace(load_scene("reference"), until=Fraction(round(how.times[now] * 100), 100))
    runs = [varied(_nudged(scene, name, sign * CHANGE), "triple-double") for sign in (1, -1)]
    context = runs[0].precision.context
    starts, ends = ([_row(run, at) for run in runs] for at in (0, 1))
    nudge = context.mpf(CHANGE.numerator) / CHANGE.denominator
    quotient = numpy.array([float((a - b) / (2 * nudge)) for a, b in zip(*ends, strict=True)])
    start = numpy.array([float((a - b) / (2 * nudge)) for a, b in zip(*starts, strict=True)])
    expected = how.by_start[now] @ start
    if VARIED[name] == "parameter":
        where = how.parameters.index(name)
        expected = expected + how.by_parameters[now][:, where] * how.values[where]
    distance = float(numpy.abs(quotient - expected).max() / numpy.abs(quotient).max())
    # the matrices' rounding errors grow as those of the state do
    limit = float(how.condition[now])
    return within(distance / EPS, limit, "eps")


def _nudged(scene: Scene, name: str, relative: Fraction) -> Scene:
    if VARIED[name] == "parameter":
        value = getattr(scene.body, name) * (1 + relative)
        return replace(scene, body=replace(scene.body, **{name: value}))
    value = (getattr(scene.start, name) or Fraction(1, 100)) * relative + getattr(scene.start, name)
    return replace(scene, start=replace(scene.start, **{name: value}))


def _row(run: Trajectory, at: int) -> list[Scalar]:
    """Vectors at the start (0) or the end (1), dimensionless."""
    context = run.precision.context
    state = run.state if at else run.at("0")
    return [
        context.mpf(getattr(state, name)) / run.start.units.of_dimension(STATE_DIMENSIONS[name])
        for name in NewtonState._fields
    ]
