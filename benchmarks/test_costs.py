"""What calls and commands cost: ``make costs``.

Processor time, by group; the first entry of a group is the baseline of the others: a bare heyoka
loop for integrations, an integration for what is read off it, ``import numpy`` for commands.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import tt_precise as tt
from benchmarks.work_precision.heyoka_methods import bare
from benchmarks.work_precision.peers import Settings
from benchmarks.work_precision.problem import golden_problem
from tt_precise.integration import catalogue
from tt_precise.integration.precision import precision_named
from tt_precise.mechanics.quantities import QUANTITIES

REFERENCE = tt.load_scene("reference")
COMMANDS = {
    "run": ("run", "reference", "--out", "{folder}/reference.csv"),
    "check": ("check", "{folder}/reference.csv", "--scene", "reference"),
    "events": ("events", "reference"),
    "thresholds": ("thresholds", "reference"),
    "claims": ("claims", "NUM-22"),
}
READERS: dict[str, Callable[[Any], object]] = {
    "frame": lambda trajectory: trajectory.frame(*QUANTITIES),
    "text": lambda trajectory: trajectory.frame(*QUANTITIES, numbers="text"),
    "drift": lambda trajectory: trajectory.drift,
    "inversion": lambda trajectory: trajectory.inversion,
}


def of_children() -> float:
    """Processor time of the processes that this one has waited for, in s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def start(code: str, *argv: str) -> None:
    """Run Python code in a process of its own."""
    usual = {**os.environ, "PYTHONDONTWRITEBYTECODE": ""}
    command = [sys.executable, "-c", code, *argv]
    subprocess.run(command, check=True, env=usual, stdout=subprocess.DEVNULL)


integrations = pytest.mark.benchmark(group="integrate", timer=time.process_time)


@integrations
def test_bare_loop(benchmark: Any) -> None:
    problem, double = golden_problem("reference"), precision_named("double")
    solve = bare(problem, Settings(0.0, double))
    benchmark(solve, problem.clock(double, problem.times)[-1:])


@integrations
def test_integrate(benchmark: Any) -> None:
    benchmark(tt.integrate, REFERENCE)


@integrations
def test_integrate_with_all_events(benchmark: Any) -> None:
    benchmark(tt.integrate, REFERENCE, events=catalogue(REFERENCE.model))


@integrations
@pytest.mark.parametrize("digits", [6, 9, 12, 14, 28])
def test_integrate_to_digits(benchmark: Any, digits: int) -> None:
    benchmark(tt.integrate, REFERENCE, digits=digits)


@pytest.mark.benchmark(group="read", timer=time.process_time)
@pytest.mark.parametrize("what", READERS)
def test_reading(benchmark: Any, what: str) -> None:
    def fresh() -> tuple[tuple[Any], dict[str, Any]]:
        return (tt.integrate(REFERENCE),), {}

    benchmark.pedantic(READERS[what], setup=fresh, rounds=15)


@pytest.mark.benchmark(group="sweep", timer=time.process_time)
def test_sweep_of_256_rows(benchmark: Any) -> None:
    starts = tt.grid({"omega_3": "150:155:256"})
    benchmark.pedantic(tt.sweep, ("reference", starts), {"recheck": 0}, rounds=5)


commands = pytest.mark.benchmark(group="commands", timer=of_children)


@commands
def test_import_numpy(benchmark: Any) -> None:
    benchmark.pedantic(start, ("import numpy",), rounds=9, warmup_rounds=1)


@commands
@pytest.mark.parametrize("name", COMMANDS)
def test_command(benchmark: Any, name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.getbasetemp()
    argv = [word.format(folder=folder) for word in COMMANDS[name]]
    entry = "from tt_precise.cli import entry; entry()"
    if name == "check" and not Path(argv[1]).exists():
        start(entry, *(word.format(folder=folder) for word in COMMANDS["run"]))
    benchmark.pedantic(start, (entry, *argv), rounds=9, warmup_rounds=1)
