"""The ladder: tests with their references, and an engine's order and error floor on each test."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal

import numpy
import pandas

from tt_precise import golden
from tt_precise.engines.protocol import (
    DOUBLE,
    NO_FRICTION,
    TIME_LIMIT_S,
    ProgramRun,
    SampledMotion,
    friction_of,
    job,
    run,
)
from tt_precise.golden.table import correct_digits
from tt_precise.integration import integrate
from tt_precise.mechanics import quantities
from tt_precise.mechanics.flight import fly
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.mechanics.newton import NewtonState, angular_momentum
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import RigidBodyState, rotate
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Json
from tt_precise.scene.scene import InitialState, Scene, load_scene

UNTIL_S, INVERSION_UNTIL_S = "0.5", "4"
LARGEST_STEP = Fraction(1, 1000)  # Default of the largest step in s.
LEAST_ORDER = 0.5  # A smaller observed order is none: halving the step wins nothing.
SLOWER = 0.5  # Tolerance of an observed order below the order of the method.
HIGHEST_ORDER = 4.0  # Highest order of the engines; a coarse run that blew up shows a larger one.
EPS = 2.0**-52
VERDICTS = {
    "rounding": "differs from the reference by rounding alone",
    "converges": "converges to the reference",
    "slow": "converges to the reference, but at a lower order than its method has",
    "floor": "converges, but to another motion: an error of its model remains",
    "no order": "a smaller step does not bring it closer to itself",
    "measured": "there is no reference",
    "refused": "the engine cannot express it",
    "failed": "it did not get to the end",
}


@dataclass(frozen=True)
class LadderTest:
    """A test: a scene, the requested friction, and the source of its reference.

    ``friction`` is None for the scene's friction. ``conserved`` names the conserved quantities of
    an exact motion: entries of ``CONSERVED``. ``reference`` is None if there is no motion with
    which all engines can be compared.
    """

    name: str
    meaning: str
    scene: Scene
    conserved: tuple[str, ...]
    reference: Callable[[Scene], SampledMotion] | None
    friction: dict[str, Json] | None = None
    contact: Literal["rigid", "none"] = "rigid"

    def job(self, step: Fraction) -> dict[str, Json]:
        """Return the job for a step in s."""
        return job(self.scene, step, self.friction or friction_of(self.scene), self.contact)

    @cached_property
    def start(self) -> Motion:
        """The start, SI, double."""
        return InitialState.in_si(self.scene, DOUBLE).motion(numpy)

    @property
    def spin(self) -> float:
        """|omega| at the start in rad/s: the unit of differences."""
        return float(numpy.linalg.norm(numpy.array(self.start.omega, dtype=float)))

    @cached_property
    def truth(self) -> SampledMotion | None:
        """The reference at the sample times."""
        return self.reference(self.scene) if self.reference else None

    def distance(self, motion: SampledMotion, other: SampledMotion) -> float:
        """Return the largest distance of two motions; 1 is the size of the motion."""
        scales = (1.0, self.spin, self.spin * float(self.start.body.R))
        return max(
            float(numpy.linalg.norm(a - b, axis=1).max()) / scale
            for a, b, scale in zip(motion, other, scales, strict=True)
        )


def fly_freely(scene: Scene) -> SampledMotion:
    """Return the free flight from the scene's start, in closed form."""
    content = job(scene, LARGEST_STEP, NO_FRICTION, "none")
    start, body = content["start"], InitialState.in_si(scene, DOUBLE).body
    initial = RigidBodyState(
        *start["quaternion_wxyz"], *start["angular_velocity"], *start["velocity"]
    )
    rows = [fly(body, initial, t, numpy) for t in content["sample_times"]]
    table = numpy.array(rows, dtype=float)
    axes = [rotate(row[:4], (0, 0, 1)) for row in rows]
    return SampledMotion(numpy.array(axes, dtype=float), table[:, 4:7], table[:, 7:10])


def sleep_vertically(scene: Scene) -> SampledMotion:
    """Return the steady spin about the vertical: the start at all times."""
    q, rows = InitialState.in_si(scene, DOUBLE).motion(numpy), len(scene.sample_times)
    return SampledMotion(
        *(numpy.tile([float(x) for x in vector], (rows, 1)) for vector in (q.k, q.omega, q.s_dot))
    )


def integrate_in_double(scene: Scene) -> SampledMotion:
    """Return the scene's solution, integrated in double to its full accuracy."""
    trajectory = integrate(scene, events=(), record=())
    return _of_columns(scene, trajectory.frame(*NewtonState._fields, numbers="float"))


def load_golden(scene: Scene) -> SampledMotion:
    """Return the scene's golden data."""
    return _of_columns(scene, golden.load(scene.name))


def _of_columns(scene: Scene, frame: pandas.DataFrame) -> SampledMotion:
    body = InitialState.in_si(scene, DOUBLE).body
    columns = [frame[name].to_numpy(dtype=float) for name in NewtonState._fields]
    q = Motion(body, NewtonState(*columns), numpy, scene.model)
    vectors = (numpy.broadcast_arrays(*vector) for vector in (q.k, q.omega, q.s_dot))
    return SampledMotion(*(numpy.stack(vector, axis=1).astype(float) for vector in vectors))


def ladder_tests(law: Law = COULOMB) -> tuple[LadderTest, ...]:
    """Return the ladder for an engine with the friction ``law``; no job has another friction."""
    short: dict[str, Any] = {"until": UNTIL_S, "record": (), "events": ()}
    own = load_scene(law.scene)
    gliding, tilted = own.varied(**short), {"theta": "0.3", **short}
    flying = load_scene("frictionless").varied(theta="0.5", theta_dot="40", **short)
    upright, inverted = (load_scene(name).varied(**short) for name in ("upright", "inverted"))
    ice, rolling = (load_scene(name).varied(**tilted) for name in ("frictionless", "rolling"))
    friction = friction_of(own.varied(mu="0.3"))
    small = {
        "theta": "0.1", "nu_y": "0.27", "omega_3": "180", "mu": "0.1", "until": INVERSION_UNTIL_S,
        "m": "0.006", "R": "0.015", "alpha": "1/5", "I1": "16/27", "I3": "14/27", "g": "9.81",
    }  # fmt: skip
    # the reference turns over; under dry friction a small, fast top does
    whole = own if law.constant else gliding.varied(**small)
    free, energy = ("angular_momentum", "rotational_energy"), ("jellett", "energy")
    flight = "inertia, gyroscopic term, frames: no contact, closed form"
    sleep = "a spin about the vertical that contact and friction leave alone"
    raised = "the same with the centre of mass above the centre"
    glide = "the engine's own friction while the contact glides"
    stick = "a contact that sticks: mu = 1, more than rolling needs"
    invert = "the whole motion: does the top turn over, and when"
    solve, end = integrate_in_double, load_golden if law.constant else None
    ladder = [
        LadderTest("flight", flight, flying, free, fly_freely, contact="none"),
        LadderTest("sleeping upright", sleep, upright, energy, sleep_vertically, friction),
        LadderTest("sleeping inverted", raised, inverted, energy, sleep_vertically, friction),
        LadderTest("ice", "the normal force alone: mu = 0", ice, energy, solve),
        LadderTest("gliding", glide, gliding, ("jellett",), solve),
        LadderTest("rolling", stick, rolling, energy, solve, {"law": law.name, "mu": 1.0}),
        LadderTest("inversion", invert, whole, ("jellett",), end),
    ]
    return tuple(test for test in ladder if test.name != "rolling" or not law.smooth_at_rest)


@dataclass(frozen=True)
class LadderResult:
    """The result of an engine on a test, with one number a step size.

    ``errors`` are distances from the reference (1: the size of the motion), ``drift`` the largest
    relative changes of conserved quantities. The error is about C step^``order`` + ``floor``.
    """

    engine: str
    test: str
    verdict: str
    message: str = ""
    errors: tuple[float, ...] = ()
    digits: tuple[float, ...] = ()
    drift: dict[str, tuple[float, ...]] = field(default_factory=dict)
    order: float | None = None
    floor: float | None = None

    @property
    def line(self) -> str:
        """The result in one line of a table."""
        digits = " ".join(f"{digits:5.1f}" for digits in self.digits)
        order = "" if self.order is None else f"{self.order:.2f}"
        floor = "" if self.floor is None else f"{self.floor:.1e}"
        cells = f"{self.test:17} {self.verdict:10} {digits:>17} {order:>6} {floor:>8}"
        return f"{cells}  {self.message}".rstrip()


HEADING = f"{'test':17} {'verdict':10} {'digits':>17} {'order':>6} {'floor':>8}"


def run_ladder(
    engine: str,
    command: Sequence[str],
    tests: Sequence[LadderTest],
    step: Fraction = LARGEST_STEP,
    *,
    order: float | None = None,
    time_limit: float = TIME_LIMIT_S,
    workers: int = 1,
    progress: Progress = silent,
) -> Iterator[LadderResult]:
    """Run the program on every test at ``step``, its half and its quarter; yield the results.

    ``step`` and ``time_limit`` are in s; ``order`` is that of the program's method, if known.
    """
    steps = (step, step / 2, step / 4)
    stop, pool = threading.Event(), ThreadPoolExecutor(workers)
    try:
        futures = [
            [pool.submit(run, command, test.job(step), time_limit, stop) for step in steps]
            for test in tests
        ]
        for done, (test, runs) in enumerate(zip(tests, futures, strict=True), start=1):
            yield judge_runs(engine, test, steps, [future.result() for future in runs], order)
            progress(done / len(tests))
    finally:  # an interruption does not wait for the programs
        stop.set()
        pool.shutdown(cancel_futures=True)


def judge_runs(
    engine: str,
    test: LadderTest,
    steps: Sequence[Fraction],
    runs: Sequence[ProgramRun],
    promised: float | None = None,
) -> LadderResult:
    """Derive the verdict from runs at three halved steps (s), for a promised order."""
    engine = next((program.name for program in runs if program.name), engine)
    motions = []
    for step, program in zip(steps, runs, strict=True):
        if program.motion is None:
            verdict = "refused" if program.status == "refused" else "failed"
            message = f"step {float(step):g} s: {program.status}: {program.message}"
            return LadderResult(engine, test.name, verdict, message)
        motions.append(program.motion)
    coarse, middle, fine = motions
    changes = test.distance(coarse, middle), test.distance(middle, fine)
    order = float(numpy.log2(changes[0] / changes[1])) if all(changes) else None
    drift = {name: tuple(_drift(test, m, name) for m in motions) for name in test.conserved}
    message = _equator(test, motions) if test.name == "inversion" else ""
    if test.truth is None:
        return LadderResult(engine, test.name, "measured", message, drift=drift, order=order)
    errors = tuple(test.distance(motion, test.truth) for motion in motions)
    floor = None
    # one rounding a step, of a few numbers of the size of the motion
    if max(errors) <= 16 * EPS * float(test.scene.until / steps[-1]):
        verdict = "rounding"
    elif order is None or order < LEAST_ORDER:
        verdict, floor = "no order", min(errors)
    else:
        floor = test.distance(_extrapolate(middle, fine, min(order, HIGHEST_ORDER)), test.truth)
        slow = promised is not None and order < promised - SLOWER
        # a coarse run that blew up shows too large an order: no order above 1 is assumed here
        resolved = changes[1] / (2 ** min(order, 1.0) - 1)
        verdict = "floor" if floor > resolved else "slow" if slow else "converges"
    digits = tuple(map(correct_digits, errors))
    return LadderResult(engine, test.name, verdict, message, errors, digits, drift, order, floor)


def _extrapolate(middle: SampledMotion, fine: SampledMotion, order: float) -> SampledMotion:
    """Extrapolate the motions at two halved steps to the step 0 by Richardson's formula."""
    weight = 1 / (2**order - 1)
    pairs = zip(fine, middle, strict=True)
    return SampledMotion(*(last + weight * (last - previous) for last, previous in pairs))


def _equator(test: LadderTest, motions: Sequence[SampledMotion]) -> str:
    """Say when the axis is horizontal at each step size, to a sampling interval."""
    times = []
    for motion in motions:
        below = numpy.sign(motion.k[:, 2]) != numpy.sign(motion.k[0, 2])
        t = float(test.scene.sample_times[int(below.argmax())])
        times.append(f"{t:.2f}" if below.any() else "never")
    return f"axis horizontal at {', '.join(times)} s"


CONSERVED: dict[str, Callable[[Motion], Any]] = {
    "jellett": quantities.jellett,
    "energy": quantities.E,
    "rotational_energy": quantities.E_rot,
    "angular_momentum": lambda q: q.state.L,
}


def _drift(test: LadderTest, motion: SampledMotion, name: str) -> float:
    """Return the largest relative change of a conserved quantity."""
    body = test.start.body
    L = angular_momentum(body, tuple(motion.k.T), tuple(motion.omega.T))
    vectors = NewtonState(*(*motion.k.T, *L, 0.0, 0.0))
    q = Motion(body, vectors, numpy, s_dot=lambda: tuple(motion.s_dot.T))
    values = numpy.atleast_2d(CONSERVED[name](q))
    change = numpy.linalg.norm(values - values[:, :1], axis=0).max()
    return float(change / numpy.linalg.norm(values[:, 0]))
