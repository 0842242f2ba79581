"""A case made ready to be timed: everything imported and compiled, run once, and judged later."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

from tt_precise.measure.tradeoff.methods import Run, Settings, Solve, method_named
from tt_precise.measure.tradeoff.plan import Case
from tt_precise.measure.tradeoff.problem import Problem, golden_problem
from tt_precise.measure.tradeoff.timing import timed


class Judged(NamedTuple):
    """Errors as in ``Judgement``; ``error_on_way`` None where only the end is known."""

    error: Any
    error_on_way: Any
    jellett_drift: Any


@dataclass
class Prepared:
    """A case, its compiled solver, and what its last runs gave.

    ``setup_s`` is what importing and compiling took. ``grid`` is a run with samples on the way,
    which is not timed; in the wide arithmetics samples cost nothing beside the steps, and the
    timed run itself takes them.
    """

    case: Case
    problem: Problem
    solve: Solve
    setup_s: float
    times: list[Any]
    grid: Run | None = None
    _end: Run | None = None

    @property
    def wide(self) -> bool:
        """Whether it computes in software, in seconds where double takes milliseconds."""
        return self.case.precision in ("quad", "mp")

    def run(self) -> None:
        """What is timed: from the start to the end."""
        self._end = self.solve(self.times if self.wide else self.times[-1:])

    @property
    def ended(self) -> Run:
        """The last timed run."""
        if self._end is None:
            raise RuntimeError("a case is judged after it was run")
        return self._end

    def judged(self) -> Judged:
        """The error at the end, and the largest error and drift that are known of the way."""
        truth, precision, end = self.problem.truth, self.case.arithmetic, self.ended
        given = None if end.published else self.times[len(self.times) - len(end.states) :]
        found = truth.judge(end.states, precision, given)
        way, drift = found.error_on_way, found.jellett_drift
        if self.grid is not None and len(self.grid.states) > 1:
            on_grid = truth.judge(self.grid.states, precision, self.times)
            way, drift = max(way, on_grid.error_on_way), max(drift, on_grid.jellett_drift)
        elif len(end.states) == 1:
            way = None
        return Judged(found.error, way, drift)


def prepare(case: Case) -> Prepared:
    """Import and compile what a case needs, and run it once.

    Raises
    ------
    ArithmeticError, InputError
        The method does not get through, or cannot be asked for this.
    """
    problem = _problem(case.scene, case.coordinates, case.until, case.truth_bits)
    settings = Settings(case.tolerance, case.arithmetic)
    made: list[Solve] = []
    setup_s = timed(lambda: made.append(method_named(case.method).prepare(problem, settings)))
    times = problem.clock(settings.precision, problem.times)
    ready = Prepared(case, problem, made[0], setup_s, times)
    if not ready.wide:
        ready.run()
        ready.grid = ready.solve(times)
    return ready


@cache
def _problem(scene: str, coordinates: str, until: str | None, truth_bits: int) -> Problem:
    return golden_problem(scene, coordinates, until, truth_bits)
