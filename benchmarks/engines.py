"""Ten physics engines on the ladder of tests: ``python -m benchmarks.engines``.

Their adapters are programs of the engine protocol in ``examples/engines``. Those with a Python
interface come with the extra ``engines``, the others with ``npm install --prefix
examples/engines/node``. The report reads the scoreboard, ``reports/measured/engines.json``.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.evidence import MEASURED, write
from tt_precise.engines.ladder import (
    HEADING,
    LARGEST_STEP,
    LadderResult,
    LadderTest,
    ladder_tests,
    run_ladder,
)
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.report import style
from tt_precise.report.style import Numbers
from tt_precise.runtime.cache import code_of
from tt_precise.runtime.terminal import Progress, progress_bar, say, silent
from tt_precise.runtime.values import Json
from tt_precise.runtime.workers import cores

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TIME_LIMIT_S = 120.0  # Time limit of one motion.
COMMAND = "python -m benchmarks.engines"
# The code behind the scoreboard.
SOURCES = ("runtime/records.py", "exact", "engines", "golden", "../benchmarks/engines.py")
# Texts of an engine in the scoreboard.
DESCRIPTION = ("name", "version", "precision", "friction", "settings")
MOST_DIGITS = 10.0  # Digits of the brightest colour.
MARKS = {"refused": "–", "failed": "✗", "measured": ""}
ROOT = Path(__file__).parents[1]
OUT = MEASURED / "engines.json"
ADAPTERS = ROOT / "examples/engines"
NODE = ADAPTERS / "node"


@dataclass(frozen=True)
class Engine:
    """An engine: its package, its adapter, its friction, and its settings."""

    name: str
    package: str
    program: str  # a module of ``examples/engines``, or a file of its ``node``
    friction: str
    settings: str
    precision: str = "double"
    law: Law = COULOMB

    @property
    def in_node(self) -> bool:
        """True if the adapter is a program for node."""
        return self.program.endswith(".mjs")

    @property
    def command(self) -> tuple[str, ...]:
        """The program of the engine protocol."""
        if self.in_node:
            return ("node", str(NODE / self.program))
        return (sys.executable, str(ADAPTERS / f"{self.program}.py"))

    @property
    def version(self) -> str | None:
        """The installed version; None if it is not installed."""
        if self.in_node:
            described = NODE / "node_modules" / self.package / "package.json"
            if shutil.which("node") is None or not described.is_file():
                return None
            return str(json.loads(described.read_text("utf-8"))["version"])
        try:
            return metadata.version(self.package)
        except metadata.PackageNotFoundError:
            return None

    @property
    def missing(self) -> str:
        """The line that says how to install the engine."""
        if self.in_node:
            return f"{self.name}: not installed; npm install --prefix {NODE}"
        return f'{self.name}: not installed; pip install "tt-precise[engines]"'


ENGINES = (
    Engine("MuJoCo", "mujoco", "mujoco_adapter", "elliptic cone, soft",
           "RK4, elliptic cone, impratio 10, contact time constant two steps"),
    Engine("Exudyn", "exudyn", "exudyn_adapter", "proportional below 1 mm/s",
           "RK44, penalty contact, stiffness m (0.5/step)^2, critical damping"),
    Engine("Drake", "drake", "drake_adapter", "regularised cone",
           "discrete plant, lagged contact, stiction tolerance and penetration fall with the step"),
    Engine("Bullet", "pybullet", "bullet_adapter", "implicit cone",
           "50 iterations, no damping, no velocity limit"),
    Engine("DART", "dartpy", "dart_adapter", "pyramid", "Dantzig's solver, its own detector"),
    Engine("ODE", "panda3d", "ode_adapter", "pyramid",
           "step (not quickStep), Approx1, ERP 0.2, CFM 1e-9", precision="single"),
    Engine("Newton", "newton", "newton_adapter", "cone, position-based",
           "SolverXPBD on the CPU, 10 iterations, no angular damping", precision="single"),
    Engine("Rapier", "@dimforge/rapier3d-compat", "rapier.mjs", "cone, solved in turns",
           "length unit 2 R, defaults otherwise", precision="single"),
    Engine("cannon-es", "cannon-es", "cannon.mjs", "box of mu times the weight",
           "Gauss-Seidel with 50 iterations, stiffness 1e8, relaxation 3"),
    Engine("Jolt", "jolt-physics", "jolt.mjs", "cone, solved in turns",
           "gyroscopic force on, 20 velocity steps, no velocity limit", precision="single"),
)  # fmt: skip


def measure(
    engines: Sequence[Engine],
    *,
    select: Callable[[LadderTest], bool] = lambda test: True,
    time_limit: float,
    workers: int,
    progress: Progress = silent,
) -> dict[str, Json]:
    """Run every installed engine on every selected test; others are skipped with a line."""
    present = [engine for engine in engines if engine.version is not None]
    rows: list[dict[str, Json]] = []
    for done, engine in enumerate(present):
        ladder = [test for test in ladder_tests(engine.law) if select(test)]
        results = run_ladder(
            engine.name, engine.command, ladder, time_limit=time_limit, workers=workers
        )
        for count, result in enumerate(results, start=1):
            rows.append(asdict(result))
            progress((done + count / len(ladder)) / len(present))
    return {
        "schema": "tt_precise.engines/3",
        "command": COMMAND,
        "steps": [float(LARGEST_STEP / part) for part in (1, 2, 4)],
        "engines": [{name: getattr(engine, name) for name in DESCRIPTION} for engine in present],
        "tests": [{"name": test.name, "meaning": test.meaning} for test in ladder_tests()],
        "rows": rows,
        "skipped": [engine.missing for engine in engines if engine.version is None],
    }


@style.figure("engines", lambda board: [0.3 * len(board["engines"]) + 0.9])
def scoreboard(axes: list[Axes], board: dict[str, Json]) -> Numbers:
    """Draw the digits at the smallest step of every engine on every test."""
    engines = [engine["name"] for engine in board["engines"]]
    tests = [test["name"] for test in board["tests"] if test["name"] != "inversion"]
    rows = {(row["engine"], row["test"]): row for row in board["rows"]}
    cells = [[rows.get((engine, test)) for test in tests] for engine in engines]
    digits = [
        [max(0.0, *row["digits"][-1:]) if row and row["digits"] else 0.0 for row in line]
        for line in cells
    ]
    (panel,) = axes
    panel.imshow(digits, cmap="viridis", vmin=0, vmax=MOST_DIGITS, aspect="auto")
    for i, line in enumerate(cells):
        for j, row in enumerate(line):
            colour = "white" if digits[i][j] < MOST_DIGITS / 2 else "black"
            panel.text(j, i, _label(row), ha="center", va="center", color=colour)
    panel.set_xticks(range(len(tests)), [name.replace(" ", "\n") for name in tests])
    panel.set_yticks(range(len(engines)), engines)
    panel.set_xlabel("test; digits of the reference at the smallest step")
    panel.grid(visible=False)
    return {
        "step": board["steps"][-1], "engines": len(engines), "tests": len(tests),
        "best": max(map(max, digits)),
    }  # fmt: skip


def _label(row: dict[str, Json] | None) -> str:
    if row is None:
        return ""
    if not row["digits"]:
        return MARKS[row["verdict"]]
    digits = f"{row['digits'][-1]:.1f}"
    return (
        f"$\\mathbf{{{digits}}}$" if row["verdict"] in ("converges", "rounding") else f"({digits})"
    )


def lines(board: dict[str, Json]) -> Iterator[str]:
    """Yield a line for each engine on each test, and for each skipped engine."""
    yield f"{'engine':10} {HEADING}"
    for row in board["rows"]:
        yield f"{row['engine']:10} {LadderResult(**row).line}"
    yield from (f"skipped: {text}" for text in board["skipped"])


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure all installed engines, or those named; write the scoreboard and its figure."""
    parser = argparse.ArgumentParser(prog=COMMAND)
    by_name = {engine.name: engine for engine in ENGINES}
    parser.add_argument("names", nargs="*", metavar="ENGINE", help=", ".join(by_name))
    parser.add_argument("--out", type=Path, default=OUT, help="the scoreboard")
    options = parser.parse_args(arguments)
    for name in options.names:
        if name not in by_name:
            parser.error(f"engine: got {name!r}, expected one of: {', '.join(by_name)}")
    engines = [by_name[name] for name in options.names or by_name]
    with progress_bar("engines") as progress:
        board = measure(engines, time_limit=TIME_LIMIT_S, workers=cores(), progress=progress)
    write(options.out, board, [scoreboard(board)], code_of(*SOURCES))
    say(lines(board))


if __name__ == "__main__":
    main()
