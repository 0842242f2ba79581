"""The ladder: tests with their references, and an engine's order and error floor on each test."""

from __future__ import annotations

import itertools
import math
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal

import numpy
import pandas

from tt_precise import golden
from tt_precise.check.result import CheckRecord
from tt_precise.check.run import conservation
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
from tt_precise.engines.results import LEAST_ORDER, LadderResult
from tt_precise.golden.digits import correct_digits
from tt_precise.integration import integrate
from tt_precise.mechanics import flight, quantities
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.mechanics.newton import NewtonState, angular_momentum
from tt_precise.mechanics.quantities import Motion
from tt_precise.mechanics.vectors import rotate
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Array, Check, InputError, Json
from tt_precise.scene.initial_state import InitialState
from tt_precise.scene.scene import Scene, load_scene

UNTIL, INVERSION_UNTIL = "0.5", "4"  # s
STEP_SIZES = (Fraction(1, 1000), Fraction(1, 2000), Fraction(1, 4000))  # s
SLOWER = 0.5  # tolerance of an observed order below the method's order
HIGHEST_ORDER = 4.0  # highest order of the engines' methods; a coarse run that blew up shows more
EPS = 2.0**-52
ROWS = 10  # most output rows in a sampling interval; checks of motions need close rows
EVERY_LAW = ("kinematics", "contact_momentum")  # checks that hold under every friction law


@dataclass(frozen=True)
class LadderTest:
    """A test: a scene, the requested friction, and the source of its reference.

    ``friction`` is None for the scene's friction. ``conserved`` names the conserved quantities of
    an exact motion: entries of ``ladder.DRIFTS``. ``reference`` is None if there is no motion with
    which all engines can be compared.
    """

    name: str
    meaning: str
    scene: Scene
    conserved: tuple[str, ...]
    reference: Callable[[Scene], SampledMotion] | None
    friction: dict[str, Json] | None = None
    contact: Literal["rigid", "none"] = "rigid"

    def job(self, step: Fraction, rows: int = 1) -> dict[str, Json]:
        """The job for one step size, with ``rows`` of output in a sampling interval."""
        scene = self.scene.varied(sample_every=str(self.scene.sample_every / rows))
        friction = self.friction or friction_of(self.scene)
        return job(scene, step, friction, contact=self.contact)

    def rows(self, step: Fraction) -> int:
        """Most rows in a sampling interval, up to ``ROWS``, that lie at multiples of ``step``."""
        return math.gcd(int(self.scene.sample_every / step), ROWS)

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


def fly_freely(scene: Scene) -> SampledMotion:
    """Free flight from the scene's start, in closed form."""
    content = job(scene, STEP_SIZES[0], NO_FRICTION, contact="none")
    start, body = content["start"], InitialState.in_si(scene, DOUBLE).body
    initial = RigidBodyState(
        *start["quaternion_wxyz"], *start["angular_velocity"], *start["velocity"]
    )
    rows = [flight.flown(body, initial, t, numpy) for t in content["sample_times"]]
    table = numpy.array(rows, dtype=float)
    axes = [rotate(row[:4], (0, 0, 1)) for row in rows]
    return SampledMotion(numpy.array(axes, dtype=float), table[:, 4:7], table[:, 7:10])


def integrate_in_double(scene: Scene) -> SampledMotion:
    """The scene's solution, integrated in double to its full accuracy."""
    trajectory = integrate(scene, events=(), record=())
    return _of_columns(scene, trajectory.frame(*NewtonState._fields, numbers="float"))


def load_golden(scene: Scene) -> SampledMotion:
    """The scene's golden data."""
    return _of_columns(scene, golden.load(scene.name))


def _of_columns(scene: Scene, frame: pandas.DataFrame) -> SampledMotion:
    body = InitialState.in_si(scene, DOUBLE).body
    columns = [frame[name].to_numpy(dtype=float) for name in NewtonState._fields]
    q = Motion(body, NewtonState(*columns), numpy, scene.model)
    vectors = (numpy.broadcast_arrays(*vector) for vector in (q.k, q.omega, q.s_dot))
    return SampledMotion(*(numpy.stack(vector, axis=1).astype(float) for vector in vectors))


def sleep_vertically(scene: Scene) -> SampledMotion:
    """A steady spin about the vertical: the start at all times."""
    q, rows = InitialState.in_si(scene, DOUBLE).motion(numpy), len(scene.sample_times)
    return SampledMotion(
        *(numpy.tile([float(x) for x in vector], (rows, 1)) for vector in (q.k, q.omega, q.s_dot))
    )


def ladder_tests(law: Law = COULOMB) -> tuple[LadderTest, ...]:
    """The ladder for an engine with the friction ``law``; other laws are not requested."""
    short: dict[str, Any] = {"until": UNTIL, "record": (), "events": ()}
    own = load_scene(law.scene)
    gliding, tilted = own.varied(**short), {"theta": "0.3", **short}
    friction = friction_of(own.varied(mu="0.3"))
    small = {
        "theta": "0.1", "nu_y": "0.27", "omega_3": "180", "mu": "0.1", "until": INVERSION_UNTIL,
        "m": "0.006", "R": "0.015", "alpha": "1/5", "I1": "16/27", "I3": "14/27", "g": "9.81",
    }  # fmt: skip
    # the reference turns over; a small, fast top does so under dry friction
    whole = own if law.constant else gliding.varied(**small)
    ladder = [
        LadderTest(
            "flight",
            "inertia, gyroscopic term, frames: no contact, closed form",
            load_scene("frictionless").varied(theta="0.5", theta_dot="40", **short),
            ("angular_momentum", "rotational_energy"),
            fly_freely,
            contact="none",
        ),
        LadderTest(
            "sleeping upright",
            "a spin about the vertical that contact and friction leave alone",
            load_scene("upright").varied(**short),
            ("jellett", "energy"),
            sleep_vertically,
            friction,
        ),
        LadderTest(
            "sleeping inverted",
            "the same with the centre of mass above the centre",
            load_scene("inverted").varied(**short),
            ("jellett", "energy"),
            sleep_vertically,
            friction,
        ),
        LadderTest(
            "ice",
            "the normal force alone: mu = 0",
            load_scene("frictionless").varied(**tilted),
            ("jellett", "energy"),
            integrate_in_double,
        ),
        LadderTest(
            "gliding",
            "the engine's own friction while the contact glides",
            gliding,
            ("jellett",),
            integrate_in_double,
        ),
        LadderTest(
            "rolling",
            "a contact that sticks: mu = 1, more than rolling needs",
            load_scene("rolling").varied(**tilted),
            ("jellett", "energy"),
            integrate_in_double,
            {"law": law.name, "mu": 1.0},
        ),
        LadderTest(
            "inversion",
            "the whole motion: does the top turn over, and when",
            whole,
            ("jellett",),
            load_golden if law.constant else None,
        ),
    ]
    return tuple(test for test in ladder if test.name != "rolling" or not law.smooth_at_rest)


# ---- running the tests -----------------------------------------------------------------------


def run_ladder(
    engine: str,
    command: Sequence[str],
    tests: Sequence[LadderTest],
    steps: Sequence[Fraction] = STEP_SIZES,
    *,
    order: float | None = None,
    time_limit: float = TIME_LIMIT_S,
    workers: int = 1,
    progress: Progress = silent,
) -> Iterator[LadderResult]:
    """Run the program on every test at every step, and return the results.

    ``steps`` (s) are three or more, each half of the previous one. ``order`` is the order of its
    method, if known.

    Raises
    ------
    InputError
        The program cannot be started.
    ValueError
        The steps are not three or more halved steps.
    """
    if len(steps) < 3 or any(after * 2 != before for before, after in itertools.pairwise(steps)):
        raise ValueError(
            f"steps: got {', '.join(map(str, steps))}, expected three or more, each half of the "
            "one before: an order is seen in two differences"
        )
    stop = threading.Event()
    pool = ThreadPoolExecutor(workers)
    try:
        asked = [
            [
                pool.submit(run, command, test.job(step, test.rows(steps[0])), time_limit, stop)
                for step in steps
            ]
            for test in tests
        ]
        for done, (test, futures) in enumerate(zip(tests, asked, strict=True)):
            runs = [future.result() for future in futures]
            yield judge_runs(engine, test, steps, runs, order)
            progress((done + 1) / len(tests))
    finally:  # who interrupts does not wait for the programs
        stop.set()
        pool.shutdown(cancel_futures=True)


def judge_runs(
    engine: str,
    test: LadderTest,
    steps: Sequence[Fraction],
    runs: Sequence[ProgramRun],
    promised: float | None = None,
) -> LadderResult:
    """Derive the result of runs at halved steps (as in ``run_ladder``), for a promised order."""
    engine = next((run.name for run in runs if run.name), engine)
    for step, outcome in zip(steps, runs, strict=True):
        if outcome.status != "done":
            verdict = "refused" if outcome.status == "refused" else "failed"
            where = "" if verdict == "refused" else f"step {float(step):g} s: {outcome.status}: "
            return LadderResult(engine, test.name, verdict, f"{where}{outcome.message}")
    written = [run.states for run in runs if run.states is not None]
    rows = (len(written[0].k) - 1) // (len(test.scene.sample_times) - 1)
    states = [motion.every(rows) for motion in written]
    known: dict[str, Json] = {
        "steps": tuple(map(float, steps)),
        "drift": {
            name: tuple(DRIFTS[name](test, state) for state in states) for name in test.conserved
        },
        "equator": tuple(_equator(test, state) for state in states),
        "checks": _checks(test, runs),
    }
    order, resolved = _order(states, test)
    known |= {"order": order, "resolved": resolved}
    if test.truth is None:
        return LadderResult(engine, test.name, "measured", **known)
    errors = tuple(_difference(state, test.truth, test) for state in states)
    course = states[-1].distance(test.truth, test.spin, float(test.start.body.R))
    known |= {
        "errors": errors,
        "digits": tuple(map(correct_digits, errors)),
        "digits_over_time": tuple(map(correct_digits, course[:: max(len(course) // 10, 1)])),
    }
    # one rounding a step, of a few numbers of the size of the motion
    if max(errors) <= 16 * EPS * float(test.scene.until / steps[-1]):
        return LadderResult(engine, test.name, "rounding", limit=2 * max(errors), **known)
    if order is None or order < LEAST_ORDER:
        return LadderResult(engine, test.name, "no order", floor=min(errors), **known)
    assert resolved is not None
    of_method = min(order, HIGHEST_ORDER)
    extrapolated = _extrapolated(states, of_method)
    floor = _difference(extrapolated, test.truth, test)
    left = _difference(states[-2], states[-1], test) / (2**of_method - 1)
    verdict = "converges" if floor <= resolved else "floor"
    if verdict == "converges" and promised is not None and order < promised - SLOWER:
        verdict = "slow"
    return LadderResult(
        engine, test.name, verdict,
        constant=left / float(steps[-1]) ** of_method, floor=floor, limit=2 * (left + floor),
        **known,
    )  # fmt: skip


def _checks(test: LadderTest, runs: Sequence[ProgramRun]) -> dict[str, Json]:
    """The findings ``EVERY_LAW`` at the smallest step, and their values at all steps."""
    if test.contact == "none":
        return {}
    try:
        results = [conservation(run.columns, test.scene, friction="other") for run in runs]
    except InputError as error:  # rows that seem to have other units
        unread = Check("", "skipped", note=str(error))
        return {name: _summarise(unread, []) for name in EVERY_LAW}
    causes = "; ".join(cause.text for cause in results[-1].causes)
    return {
        name: _summarise(
            results[-1][name], [CheckRecord.of(result[name]).value for result in results], causes
        )
        for name in EVERY_LAW
    }


def _summarise(last: Check, values: list[float | None], causes: str = "") -> dict[str, Json]:
    note = causes if causes and last.verdict == "fail" else last.note
    return {"values": values, "limit": last.limit, "verdict": last.verdict, "note": note}


def _difference(states: SampledMotion, other: SampledMotion, test: LadderTest) -> float:
    return float(states.distance(other, test.spin, float(test.start.body.R)).max())


def _order(states: Sequence[SampledMotion], test: LadderTest) -> tuple[float | None, float | None]:
    """Observed order, and a bound on the distance of the smallest step from the engine's limit.

    The bound takes no order above 1 for granted: a coarse run outside the asymptotic range makes
    the observed one too large.
    """
    coarse, fine = (
        _difference(coarser, other, test)
        for coarser, other in ((states[-3], states[-2]), (states[-2], states[-1]))
    )
    if not coarse or not fine:
        return None, None
    order = float(numpy.log2(coarse / fine))
    return order, fine / (2 ** min(order, 1.0) - 1) if order >= LEAST_ORDER else None


def _extrapolated(states: Sequence[SampledMotion], order: float) -> SampledMotion:
    weight = 1 / (2**order - 1)
    before, last = states[-2], states[-1]
    return SampledMotion(
        *(
            getattr(last, name) + weight * (getattr(last, name) - getattr(before, name))
            for name in ("k", "omega", "s_dot")
        )
    )


def _equator(test: LadderTest, states: SampledMotion) -> float | None:
    below = numpy.flatnonzero(numpy.sign(states.k[:, 2]) != numpy.sign(states.k[0, 2]))
    return float(test.scene.sample_times[int(below[0])]) if len(below) else None


def _momentum(test: LadderTest, states: SampledMotion) -> Array:
    """L at each row, axes (row, component)."""
    L = angular_momentum(test.start.body, tuple(states.k.T), tuple(states.omega.T))
    return numpy.stack(L, axis=1)


def _motion(test: LadderTest, states: SampledMotion) -> Motion:
    vectors = NewtonState(*(*states.k.T, *_momentum(test, states).T, 0.0, 0.0))
    return Motion(test.start.body, vectors, numpy, s_dot=lambda: tuple(states.s_dot.T))


def _relative(values: Array) -> float:
    return float((abs(values - values[0]) / abs(values[0])).max())


DRIFTS: dict[str, Callable[[LadderTest, SampledMotion], float]] = {
    "jellett": lambda test, states: _relative(quantities.jellett(_motion(test, states))),
    "energy": lambda test, states: _relative(quantities.E(_motion(test, states))),
    "rotational_energy": lambda test, states: _relative(quantities.E_rot(_motion(test, states))),
    "angular_momentum": lambda test, states: float(
        numpy.linalg.norm((L := _momentum(test, states)) - L[0], axis=1).max()
        / numpy.linalg.norm(L[0])
    ),
}
