"""The measurement itself: bout by bout, one row a case."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from typing import TYPE_CHECKING, Any

from tt_precise.errors import InputError
from tt_precise.measure.tradeoff.methods import Method, Run, Settings, Solve, method_named
from tt_precise.measure.tradeoff.plan import SCENE, Bout, Case
from tt_precise.measure.tradeoff.problem import Problem, golden_problem
from tt_precise.measure.tradeoff.timing import Times, interleaved, timed
from tt_precise.progress import Progress, silent

if TYPE_CHECKING:
    import pandas

WORKLOAD = "reference workload"
WORKLOAD_ROUNDS = 40
IMPORT = "import"
IMPORTED = ("heyoka", "scipy.integrate", "numba", "diffrax", "CyRK", "sksundae.cvode", "mpmath")


@dataclass(frozen=True)
class Measured:
    """All rows, and what was left out and why."""

    rows: pandas.DataFrame
    skipped: tuple[str, ...]


@dataclass
class _Ready:
    """A case that is prepared, and what its runs gave."""

    case: Case
    method: Method
    problem: Problem
    solve: Solve
    setup_s: float
    times: list[Any]
    end: Run | None = None
    grid: Run | None = None
    wide: bool = field(default=False)

    def run(self) -> None:
        """What is timed: to the end; in wide arithmetics, where it costs nothing, with samples."""
        self.end = self.solve(self.times if self.wide else self.times[-1:])


def measure(
    bouts: Iterable[Bout], tell: Callable[[str], None], progress: Progress = silent
) -> Measured:
    """Run the bouts; ``tell`` hears what is left out, and what each bout took."""
    import pandas

    every = list(bouts)
    total = sum(len(bout.cases) for bout in every)
    yardstick = _yardstick()
    rows, skipped, done = [_workload(yardstick, "start"), *_imports()], _Skipped(tell), 0
    with _compiled_anew() as forget:
        for bout in every:
            forget()
            begin = time.monotonic()
            ready = list(_prepared(bout.cases, skipped))
            prepared_s = time.monotonic() - begin
            times = interleaved(
                {str(i): one.run for i, one in enumerate(ready)},
                yardstick,
                rounds=bout.rounds,
                budget_s=bout.budget_s,
                progress=_part(progress, done / total, len(bout.cases) / total),
            )
            run_s = time.monotonic() - begin - prepared_s
            rows += [_row(one, times[str(i)]) for i, one in enumerate(ready)]
            done += len(bout.cases)
            judged_s = time.monotonic() - begin - prepared_s - run_s
            tell(
                f"{bout.name}: {len(ready)} settings, prepared in {prepared_s:.0f} s, "
                f"timed in {run_s:.0f} s, judged in {judged_s:.0f} s"
            )
    rows.append(_workload(yardstick, "end"))
    return Measured(pandas.DataFrame(rows), tuple(skipped.lines))


def _part(progress: Progress, base: float, share: float) -> Progress:
    return lambda part: progress(base + share * part)


class _Skipped:
    """Lines about what was left out, each told once."""

    def __init__(self, tell: Callable[[str], None]):
        self.lines: list[str] = []
        self._tell = tell

    def add(self, line: str) -> None:
        if line not in self.lines:
            self.lines.append(line)
            self._tell(f"skipped: {line}")


@cache
def _problem(scene: str, coordinates: str, until: str | None, truth_bits: int) -> Problem:
    return golden_problem(scene, coordinates, until, truth_bits)


def _yardstick() -> Callable[[], object]:
    problem = _problem(SCENE, "newton", None, 0)
    settings = Settings(0.0, Case("heyoka", 0.0).arithmetic)
    solve = method_named("heyoka").prepare(problem, settings)
    end = problem.clock(settings.precision, problem.times[-1:])
    return lambda: solve(end)


def _prepared(cases: Iterable[Case], skipped: _Skipped) -> Iterator[_Ready]:
    for case in cases:
        method = method_named(case.method)
        if method.missing:
            skipped.add(f"{method.name}: needs {', '.join(method.missing)} (the extra peers)")
            continue
        try:
            ready = _prepare(case, method)
        except (ArithmeticError, InputError) as error:
            skipped.add(f"{case.scene}, {case.method}, {_setting(case)}: {error}")
        else:
            yield ready


def _prepare(case: Case, method: Method) -> _Ready:
    problem = _problem(case.scene, case.coordinates, case.until, case.truth_bits)
    settings = Settings(case.tolerance, case.arithmetic)
    made: list[Solve] = []
    setup_s = timed(lambda: made.append(method.prepare(problem, settings)))
    times = problem.clock(settings.precision, problem.times)
    wide = settings.precision.name in ("quad", "mp")
    ready = _Ready(case, method, problem, made[0], setup_s, times, wide=wide)
    if not wide:
        ready.run()
        ready.grid = ready.solve(times)
    return ready


@contextmanager
def _compiled_anew() -> Iterator[Callable[[], None]]:
    """Without heyoka's cache on disk; what it lends forgets what is in memory.

    So the first compilation of a bout is what it costs at first, and a later one of the same
    system, for another scene, costs nothing.
    """
    import heyoka

    state = heyoka.llvm_state
    kept = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    try:
        yield state.clear_memcache
    finally:
        state.set_diskcache_enabled(kept)


def _row(one: _Ready, times: Times) -> dict[str, Any]:
    case, end = one.case, one.end
    assert end is not None
    precision = case.arithmetic
    given = None if end.published else one.times[len(one.times) - len(end.states) :]
    truth = one.problem.truth
    judged = truth.judge(end.states, precision, given)
    way, drift = judged.error_on_way, judged.jellett_drift
    if one.grid is not None and len(one.grid.states) > 1:
        on_grid = truth.judge(one.grid.states, precision, one.times)
        way, drift = max(way, on_grid.error_on_way), max(drift, on_grid.jellett_drift)
    return {
        "scene": case.scene,
        "horizon_s": float(one.problem.until),
        "method": case.method,
        "setting": _setting(case),
        "precision": case.precision,
        "bits": precision.bits,
        "formulation": case.coordinates,
        "tolerance": case.tolerance,
        "peer": one.method.peer,
        "error": float(judged.error),
        "error_on_way": float(way) if len(end.states) > 1 or one.grid is not None else None,
        "seconds": times.least / end.lanes,
        "seconds_median": times.median / end.lanes,
        "ratio": times.ratio / end.lanes,
        "rounds": len(times.seconds),
        "setup_s": one.setup_s,
        "steps": end.steps or None,
        "work": end.work or None,
        "order": end.order,
        "jellett_drift": float(drift),
    }


def _setting(case: Case) -> str:
    width = f"{case.bits} bits, " if case.bits else ""
    tolerance = f"tol {case.tolerance:g}" if case.tolerance else "default tolerance"
    return f"{width}{tolerance}, {case.coordinates}"


def _workload(yardstick: Callable[[], object], when: str) -> dict[str, Any]:
    """The bare heyoka loop, many times: the drift of the machine from start to end."""
    from statistics import median

    seconds = [timed(yardstick) for _ in range(WORKLOAD_ROUNDS)]
    return {
        "method": WORKLOAD,
        "setting": when,
        "seconds": min(seconds),
        "seconds_median": median(seconds),
        "rounds": WORKLOAD_ROUNDS,
    }


def _imports() -> Iterator[dict[str, Any]]:
    """Seconds to start Python and import a package, in a process of its own; and without one."""
    from importlib.util import find_spec

    for name in ("", *(one for one in IMPORTED if find_spec(one.partition(".")[0]))):
        command = [sys.executable, "-c", f"import {name}" if name else ""]
        seconds = timed(partial(subprocess.run, command, check=True))
        yield {"method": IMPORT, "setting": name or "nothing", "seconds": seconds, "rounds": 1}
