"""The engines with adapters, and the scoreboard: their results on the ladder."""

from __future__ import annotations

import json
import platform
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib import metadata
from pathlib import Path

from tt_precise._version import __version__
from tt_precise.engines.ladder import VERDICTS, Rung, RungResult, climb, rungs
from tt_precise.mechanics.laws import COULOMB, Law
from tt_precise.runtime.terminal import Progress, silent
from tt_precise.runtime.values import Json

SCHEMA = "tt_precise.engines/1"
DESCRIBED = ("name", "version", "precision", "friction", "settings")  # of an engine
ADAPTERS = Path(__file__).with_name("adapters")
NODE = ADAPTERS / "node"


@dataclass(frozen=True)
class Engine:
    """An engine: its package, its adapter, its friction, and its settings."""

    name: str
    package: str
    program: str  # a module of ``adapters``, or a file of ``adapters/node``
    friction: str
    settings: str
    precision: str = "double"
    law: Law = COULOMB

    @property
    def in_node(self) -> bool:
        """Whether the adapter is a program for node."""
        return self.program.endswith(".mjs")

    @property
    def command(self) -> tuple[str, ...]:
        """The program of the engine protocol."""
        if self.in_node:
            return ("node", str(NODE / self.program))
        return (sys.executable, "-m", f"tt_precise.engines.adapters.{self.program}")

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
        """How to install it, in one line."""
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
    chosen: Callable[[Rung], bool] = lambda rung: True,
    time_limit: float,
    workers: int,
    note: Callable[[str], None] = lambda line: None,
    progress: Progress = silent,
) -> dict[str, Json]:
    """Run every installed engine on every chosen rung; others are skipped with a line."""
    rows: list[RungResult] = []
    skipped: list[str] = []
    present = []
    for engine in engines:
        if engine.version is None:
            skipped.append(engine.missing)
            note(f"skipped: {engine.missing}")
        else:
            present.append(engine)
    for done, engine in enumerate(present):
        ladder = [rung for rung in rungs(engine.law) if chosen(rung)]
        results = climb(
            engine.name, engine.command, ladder, steps, time_limit=time_limit, workers=workers
        )
        for climbed, result in enumerate(results, start=1):
            rows.append(result)
            progress((done + climbed / len(ladder)) / len(present))
    return as_dict(present, rungs(), steps, rows, skipped)


def as_dict(
    engines: Sequence[Engine],
    ladder: Sequence[Rung],
    steps: Sequence[Fraction],
    rows: Sequence[RungResult],
    skipped: Sequence[str] = (),
) -> dict[str, Json]:
    """The scoreboard as plain values, without times of day."""
    return {
        "schema": SCHEMA,
        "tt_precise": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "steps": [float(step) for step in steps],
        "verdicts": VERDICTS,
        "engines": [{name: getattr(engine, name) for name in DESCRIBED} for engine in engines],
        "rungs": [{"name": rung.name, "meaning": rung.meaning} for rung in ladder],
        "rows": [row.as_dict() for row in rows],
        "skipped": list(skipped),
    }


def line(row: dict[str, Json]) -> str:
    """One row of the scoreboard in one line of a terminal."""
    parts = [f"{row['engine']:10} {row['rung']:18} {row['verdict']:10}"]
    if row["message"]:
        parts.append(row["message"])
    if row["digits"]:
        parts.append("digits " + " ".join(f"{digits:.1f}" for digits in row["digits"]))
    known = (name for name in ("order", "floor", "limit") if row[name] is not None)
    parts.extend(f"{name} {row[name]:.3g}" for name in known)
    if row["drift"]:
        drifts = (f"{name} {values[-1]:.1e}" for name, values in row["drift"].items())
        parts.append("drift " + ", ".join(drifts))
    parts.extend(f"{name} {check_of(row, name)}" for name in row["checks"])
    if row["rung"] == "inversion" and row["equator"]:
        moments = ("never" if t is None else f"{t:.2f}" for t in row["equator"])
        parts.append(f"axis horizontal at {' '.join(moments)} s")
    return "  ".join(parts)


def check_of(row: dict[str, Json], name: str) -> str:
    """A row's result of a check for every friction law: verdict, values of all steps, reason."""
    check = row.get("checks", {}).get(name)
    if check is None:
        return ""
    values = ", ".join("-" if value is None else f"{value:.1e}" for value in check["values"])
    why = f" ({check['note']})" if check["verdict"] != "pass" else ""
    return f"{check['verdict']} {values}{why}"
