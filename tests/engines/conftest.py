"""The tests of the ladder by their names, and the example engine in C, compiled."""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tt_precise.engines.ladder import LadderTest, ladder_tests, run_ladder
from tt_precise.engines.results import LadderResult
from tt_precise.mechanics.laws import COULOMB, Law

EXAMPLES = Path(__file__).parents[2] / "examples"
ORDER = 4  # Order of Runge and Kutta's method, which both examples have.
PATIENCE_S = 1200  # however busy the machine is


def ladder_test(name: str, law: Law = COULOMB) -> LadderTest:
    (test,) = (test for test in ladder_tests(law) if test.name == name)
    return test


def measured_on(command: Sequence[str], test: LadderTest, **options: Any) -> LadderResult:
    (found,) = run_ladder("engine", command, [test], time_limit=PATIENCE_S, **options)
    return found


def compiled_c(text: str, folder: Path, *flags: str) -> list[str]:
    """A program of that text in C."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler on this machine")
    source, program = folder / "engine.c", folder / "engine"
    source.write_text(text)
    subprocess.run([compiler, *flags, "-O1", "-o", program, source, "-lm"], check=True)
    return [str(program)]
