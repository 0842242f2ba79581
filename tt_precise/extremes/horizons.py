"""Long and short times, returns to the start, and events that come close to each other."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache

import numpy

from tt_precise.extremes.case import CaseOutcome, Findings, case, equal, finite, within
from tt_precise.extremes.runs import EPS, Integrate, distance, integrating, triple_double, varied
from tt_precise.extremes.variational import sensitivity
from tt_precise.integration import integrate
from tt_precise.integration.columns import Columns
from tt_precise.integration.dense_output import SampleTimes, shift_arrays
from tt_precise.integration.heyoka_backend import pooled_integrator, status_of
from tt_precise.integration.precision import precision_named
from tt_precise.integration.setup import Setup
from tt_precise.mechanics import quantities
from tt_precise.mechanics.formulations import formulation
from tt_precise.mechanics.quantities import Motion
from tt_precise.runtime.values import Array, Functions, Scalar
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene

STEP = "1e-3"  # Step of the search in rad; the potentials of the scenes have one valley, far wider.
# Growth over the start's size beyond which rounding errors leave nothing of the start.
HOPELESS = 1e3
STEPS_EACH_S = 170  # Approximate Taylor steps in 1 s; the theory needs their order of magnitude.
LONG = {"frictionless": ("lambda", "E", "L_z", "omega_3"), "rolling": ("lambda", "D", "E_tilde")}
PRECISIONS = ("double", "extended", "quad", "mp")
REVOLUTION = 6.283185307179586


@case(
    "{scene}: {seconds} s in double",
    source="the period as an integral, to 30 digits; Brouwer 1937: unbiased rounding is a random "
    "walk in the integrals, and its sum in the phase",
    over={"scene": tuple(LONG), "seconds": ("1e3", "1e5")},
    control={"period_off": Fraction(1, 10**11)},
    limit_s=240,
)
def long_run(scene: str, seconds: str, period_off: Fraction = Fraction(0)) -> Findings:
    """After each period, by a quadrature, theta is back, late by at most 2 eps t sqrt(steps).

    The integrals drift by at most 2 eps sqrt(steps).
    """
    known = swing(scene)
    periods = int(Fraction(seconds) / known.period) // 100
    every = periods * known.period * (1 + period_off)
    status, t, columns = _sampled(
        replace(load_scene(scene), until=100 * every, sample_every=every),
        ("theta_dot", *LONG[scene]),
    )
    finite([value for column in columns.values() for value in column])
    walk = EPS * numpy.sqrt(numpy.maximum(1, STEPS_EACH_S * t))
    delay = numpy.abs(columns["theta_dot"] / known.acceleration)
    late = float((delay / (walk * numpy.maximum(t, 1e-3))).max())
    changes = [numpy.abs(columns[name] / columns[name][0] - 1) / walk for name in LONG[scene]]
    drift = float(numpy.max(changes))
    turns = float(100 * every) * 155 / REVOLUTION  # omega_3 of both scenes
    return (
        within(late, 2, "eps t sqrt(steps) late"),
        within(drift, 2, "eps sqrt(steps) of drift"),
        equal(status, "complete"),
        CaseOutcome(f"{turns:.2g} turns"),
    )


def _sampled(scene: Scene, names: tuple[str, ...]) -> tuple[str, Array, dict[str, Array]]:
    """Status, and times (s) and columns at the samples, of a run whose steps are not stored."""
    setup = Setup.of(scene, events=(), record=())
    start = InitialState.of(scene, setup.precision.arithmetic)
    times = SampleTimes.of(scene, start).doubles
    with pooled_integrator(setup) as made:
        made.begin(setup, start)
        outcome, *_, rows = made.adaptive.propagate_grid(times.rounded)
        status = status_of(outcome, made.terminal)
    entries = shift_arrays(setup, start.body.numbers(float), tuple(rows.T), times.delay)
    return status, times.seconds, Columns(setup, start).of_arrays(names, entries)


@case(
    "reference: {until} s forward and back in {precision}",
    source="variational equations; one rounding error of eps a step",
    # 8 s in mp take minutes: tests/extremes/test_controls.py
    over=[
        *({"until": "1", "precision": precision} for precision in PRECISIONS),
        *({"until": "8", "precision": precision} for precision in PRECISIONS[:-1]),
    ],
    control={"tolerance": 1e-9},
)
def there_and_back(until: str, precision: str, tolerance: float = 0.0) -> Findings:
    """The start comes back, to sqrt(2 sum over the steps of (condition back to 0 x eps)^2).

    Nothing of it comes back where that is above 1000.
    """
    scene, working = varied(until=until), precision_named(precision)
    start, form = InitialState.of(scene, working.arithmetic), formulation("gliding", "newton")
    number, with_guard_bits = working.number, working.with_guard_bits
    first = list(map(number, start.state(form)))
    setup = Setup(formulation=form, precision=working, tolerance=tolerance)
    with pooled_integrator(setup) as made:
        made.begin(setup, start)
        _, _, _, steps, *_ = made.adaptive.propagate_until(number(start.until))
        made.adaptive.propagate_until(number(working.context.mpf(0)))
        last = [with_guard_bits(made.adaptive.state[i]) for i in range(len(first))]
    finite(last)
    distance = max(abs(a - with_guard_bits(b)) for a, b in zip(last, first, strict=True))
    how = sensitivity(scene)
    size = max(abs(with_guard_bits(x)) for x in first)
    allowed = how.returning * (steps / (len(how.times) - 1)) ** 0.5
    digits = max(0.0, float(working.context.log10(size / distance)))
    if allowed * working.eps > HOPELESS:
        # what comes back all the same has not been integrated
        return CaseOutcome(f"{digits:.1f} digits come back, where none can", digits < 1, digits)
    least = max(0.0, -math.log10(float(allowed * working.eps)))
    return (
        within(distance / size / working.eps / allowed, 1, "of what the condition allows"),
        CaseOutcome(f"{digits:.1f} digits come back, at least {least:.1f} have to"),
    )


@case(
    "reference: sampled every {every} s up to {until} s",
    source="higher precision",
    over=[
        *({"every": every, "until": until} for every in ("7", "1e300")
          for until in ("1e-15", "1e-6", "0.1")),
        {"every": "1e-18", "until": "1e-15"},
        {"every": "1e-9", "until": "1e-6"},
        {"every": "1e-4", "until": "0.1"},
    ],
    control={"integrate": integrating(omega_3="1e-12")},
)  # fmt: skip
def sampling(every: str, until: str, integrate: Integrate = integrate) -> Findings:
    """The first, the second, the middle and the last sample have the state of triple-double."""
    horizon, step = Fraction(until), Fraction(every)
    scene = replace(load_scene("reference"), until=horizon, sample_every=step)
    run, fine = integrate(scene), triple_double(scene)
    times = scene.sample_times
    chosen = {times[0], times[min(1, len(times) - 1)], times[len(times) // 2], times[-1]}
    worst = float(max(distance(run, fine, t) for t in chosen))
    # rounded once at the start and once in each step; 20 steps to 0.1 s, condition below 10
    return (
        within(worst / EPS, 4 + 4 * run.steps, "eps"),
        equal(len(times), int(horizon / step) + 1 + (horizon % step != 0)),
        equal(run.status, "complete"),
    )


@case(
    "horizon of {until} s in {precision}",
    source="the start itself",
    over={"until": ("0", "1e-300"), "precision": PRECISIONS},
    control={"run_of": integrating(omega_3="1e-12")},
)
def no_time_at_all(until: str, precision: str, run_of: Integrate = integrate) -> Findings:
    """The run is complete without an event.

    It has the start, rounded once, and moved by less than eps.
    """
    scene = varied(until=until)
    run = run_of(scene, precision, events=("theta_min", "theta_max", "nu_x_zero"))
    # not exact strings of the state, but exact in any precision
    errors = [
        abs(run.precision.context.mpf(getattr(run.state, name)) - float(getattr(scene.start, name)))
        for name in ("theta_dot", "phi_dot", "omega_3", "nu_x", "nu_y")
    ]
    worst = max(finite(errors)) / float(scene.start.omega_3)
    return (
        within(worst / run.precision.eps, 4, "eps"),
        equal(run.status, "complete"),
        equal(len(run.events), 0),
        equal(float(run.t_end), float(scene.until)),
        equal(run.drift["jellett"] < 4 * run.precision.eps, True),
    )


@case(
    "an event {beyond} s before the horizon, in {precision}",
    source="the period as an integral, to 30 digits",
    over={"beyond": ("1e-3", "1e-9", "1e-12"), "precision": ("double", "quad")},
    control={"until_off": Fraction(-1, 100)},
)
def event_at_the_end(beyond: str, precision: str, until_off: Fraction = Fraction(0)) -> Findings:
    """The event is recorded, and is not where the horizon comes so much before it."""
    period, gap = swing("frictionless").period, Fraction(beyond)
    counts, times = [], []
    for end in (period - gap, period + gap + until_off):
        scene = replace(load_scene("frictionless"), until=end)
        events = integrate(scene, precision, events=("theta_max",)).events
        counts.append(len(events))
        times += list(events["t"])
    late = max((abs(float(t - float(period))) for t in times), default=1.0)
    # theta_dot is rounded to eps of the largest rate, omega_3, and theta_ddot is 39 rad/s^2
    allowed = 20 * EPS * 155 / abs(swing("frictionless").acceleration)
    return (
        equal(counts, [0, 1]),
        within(late / float(period), max(allowed / float(period), 4 * EPS), "of the period late"),
    )


@case(
    "two zeros of phi_dot {apart} s apart",
    source="phi_dot = epsilon + phi_dddot t^2/2 beside the start's cusp, a period later",
    over={"apart": ("1e-3", "1e-6", "1e-9", "1e-12")},
    control={"sign": 1},
)
def zeros_close_together(apart: str, sign: int = -1) -> Findings:
    """Both are found, in quad; none where phi_dot just stays away from zero; none is suspect."""
    base, known = load_scene("frictionless"), swing("frictionless")
    working = precision_named("quad")
    fn, start = working.context, InitialState.of(base, working.arithmetic)
    # phi_dot = (L.z - I3 omega_3 cos theta)/(I1 sin^2 theta), so with theta_dot = 0 at the cusp
    # its second derivative is I3 omega_3 theta_ddot/(I1 sin theta)
    sine = fn.sin(start.euler.theta)
    spin = working.exact(base.start.omega_3)
    curvature = start.body.I3 / start.body.I1 * spin * known.acceleration / sine
    split = float(curvature) * float(Fraction(apart)) ** 2 / 8
    counts, gaps, suspects = [], [], []
    for side in (sign, -sign):
        exact = Fraction(split).limit_denominator(10**40) if split > 1e-3 else Fraction(repr(split))
        phi_dot = side * exact
        scene = replace(
            base, start=replace(base.start, phi_dot=phi_dot), until=known.period * Fraction(3, 2)
        )
        run = integrate(scene, "quad", events=("phi_dot_zero",))
        near = [t for t in run.events["t"] if abs(float(t) - float(known.period)) < 5e-3]
        counts.append(len(near))
        gaps += [float(near[-1] - near[0])] if len(near) > 1 else []
        suspects += list(run.suspect_events)
    error = abs(gaps[0] / float(Fraction(apart)) - 1) if gaps else 1.0
    # the next term of the series, (rate x apart)^2, and the double constants
    allowed = 100 * (200 * float(Fraction(apart))) ** 2 + 1e-6
    return (within(error, allowed, "off the distance"), equal(counts, [2, 0]), equal(suspects, []))


# ---- the period of a swing, as an integral --------------------------------------------------


@dataclass(frozen=True)
class ThetaSwing:
    """One swing of theta and back, in SI: its ``period``, and theta_ddot at its turning point."""

    period: Fraction
    acceleration: float


@cache
def swing(scene: str) -> ThetaSwing:
    """The swing of a shipped scene that starts with theta_dot = 0, to 30 digits."""
    working = precision_named("mp", 140)
    fn, start = working.context, InitialState.of(load_scene(scene), working.arithmetic)
    mass, potential = (_rolling if scene == "rolling" else _frictionless)(fn, start)
    low = start.euler.theta
    energy = potential(low)

    def rate(theta: Scalar) -> Scalar:
        return fn.sqrt(2 * (energy - potential(theta)) / mass(theta))

    force = -fn.diff(potential, low)
    step = fn.mpf(STEP) * fn.sign(force)
    high = low + step
    while potential(high) < energy:
        high += step
    # the nearer end of the bracket is not the start, which is a root too
    nearer = high - step if high - step != low else low + step / 1000
    high = fn.findroot(lambda x: energy - potential(x), (nearer, high), solver="anderson")
    middle, half = (low + high) / 2, (high - low) / 2

    def moment(s: Scalar) -> Scalar:
        # theta = middle - half cos s takes the square root out of the ends
        return abs(half) * fn.sin(s) / rate(middle - half * fn.cos(s))

    period = (
        2 * fn.quad(moment, fn.linspace(0, fn.pi, 9), method="gauss-legendre") * start.units.time
    )
    numerator, denominator = int(fn.nint(period * fn.mpf(10) ** 35)), 10**35
    return ThetaSwing(
        Fraction(numerator, denominator), float(force / mass(low) / start.units.time**2)
    )


Function = Callable[[Scalar], Scalar]


def _frictionless(fn: Functions, start: InitialState) -> tuple[Function, Function]:
    """L.z and omega_3 are constant, and the centre of mass only rises and sinks; eq (1)."""
    body, spin = start.body, start.body.I3 * start.euler.omega_3
    vertical = start.vectors.Lz

    def mass(theta: Scalar) -> Scalar:
        return body.I1 + body.alpha**2 * fn.sin(theta) ** 2

    def potential(theta: Scalar) -> Scalar:
        s, c = fn.sin(theta), fn.cos(theta)
        return (vertical - spin * c) ** 2 / (2 * body.I1 * s * s) - body.alpha * c

    return mass, potential


def _rolling(fn: Functions, start: InitialState) -> tuple[Function, Function]:
    """The Main Equation E~ = g(cos theta) theta_dot^2 + V(cos theta, D, lambda); eq (17)."""
    motion = Motion(start.body, start.vectors, fn, "rolling")
    routh, jellett = quantities.D(motion), quantities.jellett(motion)

    def mass(theta: Scalar) -> Scalar:
        return 2 * quantities.effective_mass(start.body, fn.cos(theta))

    def potential(theta: Scalar) -> Scalar:
        return quantities.effective_potential(start.body, fn.cos(theta), routh, jellett, fn)

    return mass, potential
