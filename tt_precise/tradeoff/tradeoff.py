"""The measurement itself: group by group, one row a trial."""

from __future__ import annotations

import itertools
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.util import find_spec
from statistics import median
from typing import TYPE_CHECKING, NamedTuple

from tt_precise.runtime.errors import InputError
from tt_precise.runtime.progress import Progress, silent
from tt_precise.runtime.untyped import Json
from tt_precise.tradeoff.compiled_trial import CompiledTrial, prepare
from tt_precise.tradeoff.methods import method_named
from tt_precise.tradeoff.plan import SCENE, Group, Trial
from tt_precise.tradeoff.timing import Action, Timings, Turn, interleaved, timed

if TYPE_CHECKING:
    import pandas

WORKLOAD = "reference workload"
WORKLOAD_ROUNDS = 40
IMPORT = "import"
IMPORTED = ("heyoka", "scipy.integrate", "numba", "diffrax", "CyRK", "sksundae.cvode", "mpmath")

Notify = Callable[[str], None]


class Tradeoff(NamedTuple):
    """All rows, and what was left out and why."""

    rows: pandas.DataFrame
    skipped: tuple[str, ...]


def measure(groups: Iterable[Group], notify: Notify, progress: Progress = silent) -> Tradeoff:
    """Run the groups; ``notify`` is called with what is left out, and with what each group took."""
    import pandas

    every = list(groups)
    total = sum(len(group.trials) for group in every)
    yardstick = prepare(Trial("heyoka", 0.0, scene=SCENE)).run
    rows, skipped, done = [_workload(yardstick, "start"), *_imports()], _Skipped(notify), 0
    with _compiled_anew() as forget:
        for group in every:
            forget()
            share = _part(progress, done / total, len(group.trials) / total)
            rows += _group(group, yardstick, skipped, notify, share)
            done += len(group.trials)
    rows.append(_workload(yardstick, "end"))
    return Tradeoff(pandas.DataFrame(rows), tuple(skipped.lines))


def _part(progress: Progress, base: float, share: float) -> Progress:
    return lambda part: progress(base + share * part)


def _group(
    group: Group, yardstick: Action, skipped: _Skipped, notify: Notify, progress: Progress
) -> list[dict[str, Json]]:
    moments = [time.monotonic()]
    ready = list(_prepared(group.trials, skipped))
    moments.append(time.monotonic())
    times = interleaved(
        [Turn(partial(getattr, one, "run"), yardstick) for one in ready],
        rounds=group.rounds,
        budget_s=group.budget_s,
        progress=progress,
    )
    moments.append(time.monotonic())
    rows = [_row(one, mine) for one, mine in zip(ready, times, strict=True)]
    moments.append(time.monotonic())
    took = [f"{after - before:.0f} s" for before, after in itertools.pairwise(moments)]
    notify(
        f"{group.name}: {len(ready)} settings, prepared in {took[0]}, timed in {took[1]}, "
        f"compared in {took[2]}"
    )
    return rows


class _Skipped:
    """Lines about what was left out, each once."""

    def __init__(self, notify: Notify):
        self.lines: list[str] = []
        self._notify = notify

    def add(self, line: str) -> None:
        if line not in self.lines:
            self.lines.append(line)
            self._notify(f"skipped: {line}")


def _prepared(trials: Iterable[Trial], skipped: _Skipped) -> Iterator[CompiledTrial]:
    for trial in trials:
        missing = method_named(trial.method).missing
        if missing:
            skipped.add(f"{trial.method}: needs {', '.join(missing)} (the extra peers)")
            continue
        try:
            yield prepare(trial)
        except (ArithmeticError, InputError) as error:
            skipped.add(f"{trial.scene}, {trial.method}, {_setting(trial)}: {error}")


@contextmanager
def _compiled_anew() -> Iterator[Callable[[], None]]:
    """Without heyoka's cache on disk; what it yields clears what is in memory.

    So the first compilation of a group is what it costs at first, and a later one of the same
    system, for another scene, costs nothing.
    """
    import heyoka

    state = heyoka.llvm_state
    enabled = state.get_diskcache_enabled()
    state.set_diskcache_enabled(False)
    try:
        yield state.clear_memcache
    finally:
        state.set_diskcache_enabled(enabled)


def _row(one: CompiledTrial, times: Timings) -> dict[str, Json]:
    trial, end, errors = one.trial, one.ended, one.errors()
    return {
        "scene": trial.scene,
        "horizon_s": float(one.problem.until),
        "method": trial.method,
        "setting": _setting(trial),
        "precision": trial.precision,
        "bits": trial.arithmetic.bits,
        "formulation": trial.coordinates,
        "tolerance": trial.tolerance,
        "peer": method_named(trial.method).peer,
        "error": float(errors.error),
        "error_on_way": None if errors.error_on_way is None else float(errors.error_on_way),
        "seconds": times.least / end.lanes,
        "seconds_median": times.median / end.lanes,
        "ratio": times.ratio / end.lanes,
        "rounds": len(times.seconds),
        "setup_s": one.setup_s,
        "steps": end.steps or None,
        "work": end.work or None,
        "order": end.order,
        "jellett_drift": float(errors.jellett_drift),
    }


def _setting(trial: Trial) -> str:
    width = f"{trial.bits} bits, " if trial.bits else ""
    tolerance = f"tol {trial.tolerance:g}" if trial.tolerance else "default tolerance"
    return f"{width}{tolerance}, {trial.coordinates}"


def _workload(yardstick: Action, when: str) -> dict[str, Json]:
    """The bare heyoka loop, many times: the drift of the machine from start to end."""
    seconds = [timed(yardstick) for _ in range(WORKLOAD_ROUNDS)]
    return {
        "method": WORKLOAD,
        "setting": when,
        "seconds": min(seconds),
        "seconds_median": median(seconds),
        "rounds": WORKLOAD_ROUNDS,
    }


def _imports() -> Iterator[dict[str, Json]]:
    """Seconds to start Python and import a package, in a process of its own; and without one."""
    for name in ("", *(one for one in IMPORTED if find_spec(one.partition(".")[0]))):
        command = [sys.executable, "-c", f"import {name}" if name else ""]
        seconds = timed(partial(subprocess.run, command, check=True))
        yield {"method": IMPORT, "setting": name or "nothing", "seconds": seconds, "rounds": 1}
