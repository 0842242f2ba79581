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
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import metadata
from pathlib import Path

from tt_precise.engines.ladder import STEP_SIZES, LadderTest, ladder_tests, run_ladder
from tt_precise.engines.results import LadderResult, document, lines
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.runtime.files import atomic_write
from tt_precise.runtime.records import encode
from tt_precise.runtime.terminal import Progress, progress_bar, say, silent
from tt_precise.runtime.values import Json
from tt_precise.runtime.workers import cores

TIME_LIMIT_S = 120.0  # Time limit of one motion.
# Texts of an engine in a row of the scoreboard.
DESCRIBED = ("name", "version", "precision", "friction", "settings")
ROOT = Path(__file__).parents[1]
OUT = ROOT / "reports/measured/engines.json"
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
    steps: Sequence[Fraction],
    *,
    chosen: Callable[[LadderTest], bool] = lambda test: True,
    time_limit: float,
    workers: int,
    note: Callable[[str], None] = lambda line: None,
    progress: Progress = silent,
) -> dict[str, Json]:
    """Run every installed engine on every chosen test; others are skipped with a line."""
    rows: list[LadderResult] = []
    skipped: list[str] = []
    present = []
    for engine in engines:
        if engine.version is None:
            skipped.append(engine.missing)
            note(f"skipped: {engine.missing}")
        else:
            present.append(engine)
    for done, engine in enumerate(present):
        ladder = [test for test in ladder_tests(engine.law) if chosen(test)]
        results = run_ladder(
            engine.name, engine.command, ladder, steps, time_limit=time_limit, workers=workers
        )
        for count, result in enumerate(results, start=1):
            rows.append(result)
            progress((done + count / len(ladder)) / len(present))
    described = [{name: getattr(engine, name) for name in DESCRIBED} for engine in present]
    return document(
        [(one.name, one.meaning) for one in ladder_tests()], steps, rows, described, skipped
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure all installed engines, or those named, and write the scoreboard."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.engines")
    parser.add_argument(
        "names", nargs="*", metavar="ENGINE", help=", ".join(engine.name for engine in ENGINES)
    )
    parser.add_argument("--out", type=Path, default=OUT, help="the scoreboard")
    asked = parser.parse_args(arguments)
    by_name = {engine.name: engine for engine in ENGINES}
    for name in asked.names:
        if name not in by_name:
            parser.error(f"engine: got {name!r}, expected one of: {', '.join(by_name)}")
    with progress_bar("engines") as progress:
        content = measure(
            [by_name[name] for name in asked.names] or list(ENGINES), STEP_SIZES,
            time_limit=TIME_LIMIT_S, workers=cores(),
            note=lambda text: print(text, file=sys.stderr), progress=progress,
        )  # fmt: skip
    atomic_write(asked.out, encode(content))
    say(lines(content["rows"], content["steps"]))


if __name__ == "__main__":
    main()
