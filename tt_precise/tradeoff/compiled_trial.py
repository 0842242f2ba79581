"""A trial made ready to be timed: everything imported and compiled, run once, compared later."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from tt_precise.runtime.arithmetic import Scalar
from tt_precise.tradeoff.methods import Settings, Solve, SolverResult, method_named
from tt_precise.tradeoff.plan import Trial
from tt_precise.tradeoff.problem import GoldenProblem, StateErrors, golden_problem
from tt_precise.tradeoff.timing import timed


@dataclass
class CompiledTrial:
    """A trial, its compiled solver, and what its last runs gave.

    ``setup_s`` is what importing and compiling took. ``grid`` is a run with samples on the way,
    which is not timed; in the wide arithmetics samples cost nothing beside the steps, and the
    timed run itself takes them.
    """

    trial: Trial
    problem: GoldenProblem
    solve: Solve
    setup_s: float
    times: list[Scalar]
    grid: SolverResult | None = None
    _end: SolverResult | None = None

    @property
    def wide(self) -> bool:
        """Whether it computes in software, in seconds where double takes milliseconds."""
        return self.trial.precision in ("quad", "mp")

    def run(self) -> None:
        """What is timed: from the start to the end."""
        self._end = self.solve(self.times if self.wide else self.times[-1:])

    @property
    def ended(self) -> SolverResult:
        """The last timed run."""
        if self._end is None:
            raise RuntimeError("a trial is compared with the truth after it was run")
        return self._end

    def errors(self) -> StateErrors:
        """The error at the end, and the largest error and drift that are known of the way."""
        truth, precision, end = self.problem.truth, self.trial.arithmetic, self.ended
        given = None if end.published else self.times[len(self.times) - len(end.states) :]
        found = truth.errors(end.states, precision, given)
        way, drift = found.error_on_way, found.jellett_drift
        if self.grid is not None and len(self.grid.states) > 1:
            on_grid = truth.errors(self.grid.states, precision, self.times)
            way, drift = max(way, on_grid.error_on_way), max(drift, on_grid.jellett_drift)
        elif len(end.states) == 1:
            way = None
        return StateErrors(found.error, way, drift)


def prepare(trial: Trial) -> CompiledTrial:
    """Import and compile what a trial needs, and run it once.

    Raises
    ------
    ArithmeticError, InputError
        The method does not get through, or cannot be asked for this.
    """
    problem = _problem(trial.scene, trial.coordinates, trial.until, trial.truth_bits)
    settings = Settings(trial.tolerance, trial.arithmetic)
    made: list[Solve] = []
    setup_s = timed(lambda: made.append(method_named(trial.method).prepare(problem, settings)))
    times = problem.clock(settings.precision, problem.times)
    ready = CompiledTrial(trial, problem, made[0], setup_s, times)
    if not ready.wide:
        ready.run()
        ready.grid = ready.solve(times)
    return ready


@cache
def _problem(scene: str, coordinates: str, until: str | None, truth_bits: int) -> GoldenProblem:
    return golden_problem(scene, coordinates, until, truth_bits)
