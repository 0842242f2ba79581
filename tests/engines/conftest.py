"""The tests of the ladder by their names, and the example engine in C, compiled."""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tt_precise.engines.ladder import LadderResult, LadderTest, ladder_tests, run_ladder
from tt_precise.mechanics.laws import COULOMB, Law

EXAMPLES = Path(__file__).parents[2] / "examples"
ENGINE_C = (EXAMPLES / "engine.c").read_text("utf-8")
ORDER = 4  # Order of Runge and Kutta's method, which both examples have.
PATIENCE_S = 1200  # Time limit on a busy machine.


def ladder_test(name: str, law: Law = COULOMB) -> LadderTest:
    (test,) = (test for test in ladder_tests(law) if test.name == name)
    return test


def measured_on(command: Sequence[str], test: LadderTest, **options: Any) -> LadderResult:
    (result,) = run_ladder("engine", command, [test], time_limit=PATIENCE_S, **options)
    return result


def compiled_c(folder: Path, text: str = ENGINE_C, *flags: str) -> list[str]:
    """Compile a program in C."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler on this machine")
    source, program = folder / "engine.c", folder / "engine"
    source.write_text(text)
    subprocess.run([compiler, *flags, "-O1", "-o", program, source, "-lm"], check=True)
    return [str(program)]
