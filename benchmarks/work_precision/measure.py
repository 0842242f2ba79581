"""Measure speed against accuracy: the plan, the timing, one row a trial."""

from __future__ import annotations

import operator
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from statistics import median
from timeit import timeit
from typing import NamedTuple

import heyoka
import pandas

from benchmarks.work_precision.findings import EVENTS, LADDER, RECORDS, SCENE, SHORT, WORKLOAD
from benchmarks.work_precision.heyoka_methods import OWN
from benchmarks.work_precision.peers import PEERS, Settings, Solve, SolverResult
from benchmarks.work_precision.problem import GoldenProblem, StateErrors, golden_problem
from tt_precise import golden
from tt_precise.integration.precision import Precision, precision_named
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import InputError, Json, Scalar
from tt_precise.scene.scene import load_scene

METHODS = {method.name: method for method in (*OWN, *PEERS)}
DECADES = tuple(float(f"1e-{n}") for n in range(3, 16))
COARSE = (1e-3, 1e-6, 1e-9, 1e-12)
SHORTEST = "0.02"  # s; mpmath's odefun
TRUTH_BITS = 232  # for errors below golden data's 1e-33, on the whole horizon


@dataclass(frozen=True)
class Trial:
    """One method at one setting on one problem; ``until`` None is the scene's horizon."""

    method: str
    tolerance: float
    precision: str = "double"
    bits: int | None = None
    coordinates: str = "newton"
    scene: str = SCENE
    until: str | None = None
    truth_bits: int = 0

    @property
    def arithmetic(self) -> Precision:
        """The precision with its bits."""
        return precision_named(self.precision, self.bits)


class Group(NamedTuple):
    """Trials that are timed in turn: at most so many rounds, and seconds for each trial."""

    name: str
    trials: tuple[Trial, ...]
    rounds: int
    budget_s: float


# tolerances of each peer that it takes at all and bears: RK45 needs a minute for 1e-12
TOLERANCES: dict[str, tuple[float, ...]] = {
    "SciPy DOP853, numba": DECADES, "SciPy RK45, numba": DECADES[:7],
    "SciPy LSODA, numba": DECADES[:10], "SciPy odeint, numba": (0.0, *DECADES[:11]),
    "SciPy Radau, numba": (1e-3, 1e-4, 1e-5), "SciPy DOP853, Python": COARSE,
    "SciPy RK45, Python": (1e-3, 1e-6), "SciPy LSODA, Python": (1e-3, 1e-6, 1e-9),
    "SciPy odeint, Python": (0.0, 1e-9, 1e-12), "SciPy Radau, Python": (1e-3,),
    "diffrax Dopri8": DECADES, "diffrax Tsit5": DECADES[:11], "CyRK DOP853": DECADES,
    "CyRK VERN8": DECADES, "CyRK TSIT5": DECADES[:10], "CyRK LSODA": DECADES[:11],
    "SUNDIALS CVODE Adams": DECADES[:11], "SUNDIALS CVODE BDF": (1e-3, 1e-6),
}  # fmt: skip
# with these alone the other scenes are measured
BEST_PEERS = ("SciPy DOP853, numba", "diffrax Dopri8", "CyRK DOP853", "CyRK VERN8")


def whole() -> Iterator[Group]:
    """Everything; under half an hour."""
    yield Group("double, Newton form", tuple(_double("newton")), 9, 1.0)
    yield Group("double, Euler form", tuple(_double("euler")), 5, 1.0)
    yield Group("wide arithmetics", tuple(_wide()), 3, 15.0)
    yield Group("digits", tuple(_digits(LADDER)), 3, 20.0)
    yield Group("mpmath", tuple(_odefun((60, 113, 200))), 3, 10.0)
    yield Group("golden scenes", tuple(_other_scenes()), 5, 0.5)


def _double(coordinates: str) -> Iterator[Trial]:
    def at(method: str, tolerances: Iterable[float]) -> Iterator[Trial]:
        return (Trial(method, tolerance, coordinates=coordinates) for tolerance in tolerances)

    yield from at("heyoka", (*DECADES, 0.0))
    for option in ("high_accuracy", "fast_math", "compact_mode", "4 lanes", "8 lanes"):
        yield from at(f"heyoka, {option}", (*COARSE[1:], 0.0))
    for extra in (*EVENTS, *RECORDS):
        yield from at(f"heyoka, {extra}", (1e-9, 0.0))
    yield from at("tt_precise, tolerance", (*COARSE, 0.0))
    if coordinates == "newton":
        yield from at("tt_precise, digits", COARSE)
    for name, tolerances in TOLERANCES.items():
        yield from at(name, tolerances)


def _wide() -> Iterator[Trial]:
    for tolerance in (1e-15, 1e-20, 1e-25, 1e-28, 1e-30, 1e-32, 0.0):
        yield Trial("heyoka", tolerance, "quad")
    yield Trial("heyoka", 0.0, "quad", coordinates="euler")
    yield Trial("heyoka", 0.0, "mp", 113)
    for bits, tolerance in ((176, 0.0), (184, 1e-52), (200, 1e-40), (200, 1e-52), (200, 0.0)):
        yield Trial("heyoka", tolerance, "mp", bits, truth_bits=TRUTH_BITS)


def _digits(bits: tuple[int, ...]) -> Iterator[Trial]:
    truth = bits[-1] + 40
    for name in ("double", "quad"):
        yield Trial("heyoka", 0.0, name, until=SHORT, truth_bits=truth)
    for width in bits:
        yield Trial("heyoka", 0.0, "mp", width, until=SHORT, truth_bits=truth)
    for width in bits[3::3]:
        yield Trial("heyoka, parallel_mode", 0.0, "mp", width, until=SHORT, truth_bits=truth)


def _odefun(bits: tuple[int, ...]) -> Iterator[Trial]:
    for method in ("heyoka", "mpmath odefun"):
        for width in bits:
            yield Trial(method, 0.0, "mp", width, until=SHORTEST, truth_bits=bits[-1] + 40)


def _other_scenes() -> Iterator[Trial]:
    for scene in golden.scenes():
        loaded = load_scene(scene)
        # a bare integrator stalls where equations change; the peers' have no further numbers
        if scene == SCENE or loaded.in_pieces or loaded.body.friction.further:
            continue
        at_pole = loaded.start.theta.at_pole
        for coordinates in ("newton",) if at_pole else ("newton", "euler"):
            for tolerance in (*COARSE[1:], 0.0):
                yield Trial("heyoka", tolerance, coordinates=coordinates, scene=scene)
            for name in BEST_PEERS:
                for tolerance in COARSE[1:]:
                    yield Trial(name, tolerance, coordinates=coordinates, scene=scene)
        yield Trial("tt_precise, digits", 1e-9, scene=scene)


Action = Callable[[], object]


@dataclass
class Timings:
    """Seconds of one action, and of the baseline just before each of them."""

    seconds: list[float] = field(default_factory=list)
    baselines: list[float] = field(default_factory=list)

    @property
    def median(self) -> float:
        """The median of the seconds."""
        return median(self.seconds)

    @property
    def ratio(self) -> float:
        """The median of the ratios to the baseline before each: a slow minute slows both."""
        return median(map(operator.truediv, self.seconds, self.baselines))


def interleaved(
    actions: Sequence[Action],
    baseline: Action,
    *,
    rounds: int,
    budget_s: float,
    progress: Progress = silent,
) -> list[Timings]:
    """Time every action in turn, ``rounds`` times, and each just after the baseline.

    An action has at least one turn, and no further one that would bring it above ``budget_s``.
    """
    times = [Timings() for _ in actions]
    for number in range(rounds):
        for place, (action, mine) in enumerate(zip(actions, times, strict=True)):
            if number and (number + 1) * mine.median > budget_s:
                continue
            mine.baselines.append(timed(baseline))
            mine.seconds.append(timed(action))
            progress((number + (place + 1) / len(actions)) / rounds)
    return times


def timed(action: Action) -> float:
    """Seconds that an action takes, without the collection of garbage."""
    return timeit(action, number=1)


@dataclass
class CompiledTrial:
    """A trial, its compiled solver, and what its last runs gave.

    ``setup_s`` is what importing and compiling took. ``grid`` is a run with samples on the way,
    which is not timed; in the wide arithmetics samples cost nothing next to the steps, and the
    timed run itself takes them.
    """

    trial: Trial
    problem: GoldenProblem
    solve: Solve
    setup_s: float
    times: list[Scalar]
    ended: SolverResult = field(init=False)  # the last timed run
    grid: SolverResult | None = None

    @property
    def wide(self) -> bool:
        """True if it computes in software, in seconds where double takes milliseconds."""
        return self.trial.precision in ("quad", "mp")

    def run(self) -> None:
        """Run the timed part, from the start to the end."""
        self.ended = self.solve(self.times if self.wide else self.times[-1:])

    def errors(self) -> StateErrors:
        """The error at the end, and the largest error and drift that are known of the way."""
        truth, precision, end = self.problem.truth, self.trial.arithmetic, self.ended
        given = None if end.published else self.times[len(self.times) - len(end.states) :]
        at_end = truth.errors(end.states, precision, given)
        way, drift = at_end.error_on_way, at_end.jellett_drift
        if self.grid is not None and len(self.grid.states) > 1:
            on_grid = truth.errors(self.grid.states, precision, self.times)
            way, drift = max(way, on_grid.error_on_way), max(drift, on_grid.jellett_drift)
        elif len(end.states) == 1:
            way = None
        return StateErrors(at_end.error, way, drift)


def prepare(trial: Trial) -> CompiledTrial:
    """Import and compile what a trial needs, and run it once.

    Raises
    ------
    ArithmeticError, InputError
        The method fails, or does not support this request.
    """
    problem = golden_problem(trial.scene, trial.coordinates, trial.until, trial.truth_bits)
    settings = Settings(trial.tolerance, trial.arithmetic)
    made: list[Solve] = []
    setup_s = timed(lambda: made.append(METHODS[trial.method].prepare(problem, settings)))
    times = problem.clock(settings.precision, problem.times)
    ready = CompiledTrial(trial, problem, made[0], setup_s, times)
    if not ready.wide:
        ready.run()
        ready.grid = ready.solve(times)
    return ready


WORKLOAD_ROUNDS = 40

Notify = Callable[[str], None]


Row = dict[str, Json]  # of the table: a method at a setting, or the speed of the machine


class Tradeoff(NamedTuple):
    """Rows of methods, rows of the machine, and what was left out and why."""

    rows: tuple[Row, ...]
    machine: tuple[Row, ...]
    skipped: tuple[str, ...]

    @property
    def table(self) -> pandas.DataFrame:
        """Rows of methods, then of the machine."""
        return pandas.DataFrame([*self.rows, *self.machine])


def measure(groups: Iterable[Group], notify: Notify, progress: Progress = silent) -> Tradeoff:
    """Run the groups; ``notify`` is called with what is left out, and with what each group took."""
    every = list(groups)
    total = sum(len(group.trials) for group in every)
    baseline = prepare(Trial("heyoka", 0.0)).run
    machine = [_workload(baseline, "start")]
    rows: list[Row] = []
    skipped: list[str] = []
    done = 0.0

    def report(part: float) -> None:
        progress(done + share * part)

    def skip(line: str) -> None:
        if line not in skipped:
            skipped.append(line)
            notify(f"skipped: {line}")

    with _compiled_anew() as forget:
        for group in every:
            forget()
            began, share = time.monotonic(), len(group.trials) / total
            ready = list(_prepared(group.trials, skip))
            times = interleaved(
                [trial.run for trial in ready],
                baseline,
                rounds=group.rounds,
                budget_s=group.budget_s,
                progress=report,
            )
            rows += map(_row, ready, times)
            done += share
            notify(f"{group.name}: {len(ready)} settings, {time.monotonic() - began:.0f} s")
    machine.append(_workload(baseline, "end"))
    return Tradeoff(tuple(rows), tuple(machine), tuple(skipped))


def _prepared(trials: Iterable[Trial], skip: Notify) -> Iterator[CompiledTrial]:
    for trial in trials:
        missing = METHODS[trial.method].missing
        if missing:
            skip(f"{trial.method}: needs {', '.join(missing)} (the extra peers)")
            continue
        try:
            yield prepare(trial)
        except (ArithmeticError, InputError) as error:
            skip(f"{trial.scene}, {trial.method}, {_setting(trial)}: {error}")


@contextmanager
def _compiled_anew() -> Iterator[Callable[[], None]]:
    """Without heyoka's cache on disk; what it yields clears what is in memory.

    So the first compilation of a group is what it costs at first, and a later one of the same
    system, for another scene, costs nothing.
    """
    state = heyoka.llvm_state
    enabled = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    try:
        yield state.clear_memcache
    finally:
        state.set_diskcache_enabled(enabled)


def _row(compiled: CompiledTrial, times: Timings) -> Row:
    """A row of the table.

    Errors are absolute, dimensionless, of k, L, v: at the end, and the largest at the golden times.
    ``seconds`` is the least, ``ratio`` the median of ratios to a bare heyoka loop timed just
    before; ``setup_s`` is compiling, done once; ``work`` counts right-hand sides, or Taylor
    coefficients.
    """
    trial, end, errors = compiled.trial, compiled.ended, compiled.errors()
    return {
        "scene": trial.scene,
        "horizon_s": float(compiled.problem.until),
        "method": trial.method,
        "setting": _setting(trial),
        "precision": trial.precision,
        "bits": trial.arithmetic.bits,
        "formulation": trial.coordinates,
        "tolerance": trial.tolerance,
        "peer": METHODS[trial.method].peer,
        "error": float(errors.error),
        "error_on_way": None if errors.error_on_way is None else float(errors.error_on_way),
        "seconds": min(times.seconds) / end.lanes,
        "seconds_median": times.median / end.lanes,
        "ratio": times.ratio / end.lanes,
        "rounds": len(times.seconds),
        "setup_s": compiled.setup_s,
        "steps": end.steps or None,
        "work": end.work or None,
        "order": end.order,
        "jellett_drift": float(errors.jellett_drift),
    }


def _setting(trial: Trial) -> str:
    width = f"{trial.bits} bits, " if trial.bits else ""
    tolerance = f"tol {trial.tolerance:g}" if trial.tolerance else "default tolerance"
    return f"{width}{tolerance}, {trial.coordinates}"


def _workload(baseline: Action, when: str) -> Row:
    """The bare heyoka loop, many times: the drift of the machine from start to end."""
    seconds = [timed(baseline) for _ in range(WORKLOAD_ROUNDS)]
    return {
        "method": WORKLOAD,
        "setting": when,
        "seconds": min(seconds),
        "seconds_median": median(seconds),
        "rounds": WORKLOAD_ROUNDS,
    }
