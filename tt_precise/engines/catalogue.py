"""The engines that adapters exist for."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

ADAPTERS = Path(__file__).with_name("adapters")
NODE = ADAPTERS / "node"


@dataclass(frozen=True)
class Engine:
    """An engine: its package, its adapter, what friction it has, and how the adapter sets it up."""

    name: str
    package: str
    program: str  # a module of ``adapters``, or a file of ``adapters/node``
    friction: str
    settings: str
    precision: str = "double"
    law: str = "coulomb"

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
    Engine(
        "MuJoCo", "mujoco", "mujoco_adapter", "elliptic cone, soft",
        "RK4, elliptic cone, impratio 10, contact time constant two steps",
    ),
    Engine(
        "Exudyn", "exudyn", "exudyn_adapter", "proportional below 1 mm/s",
        "RK44, penalty contact, stiffness m (0.5/step)^2, critical damping",
    ),
    Engine(
        "Drake", "drake", "drake_adapter", "regularised cone",
        "discrete plant, lagged contact, stiction tolerance and penetration fall with the step",
    ),
    Engine(
        "Bullet", "pybullet", "bullet_adapter", "implicit cone",
        "50 iterations, no damping, no velocity limit",
    ),
    Engine(
        "DART", "dartpy", "dart_adapter", "pyramid", "Dantzig's solver, its own detector",
    ),
    Engine(
        "ODE", "panda3d", "ode_adapter", "pyramid",
        "step (not quickStep), Approx1, ERP 0.2, CFM 1e-9", precision="single",
    ),
    Engine(
        "Newton", "newton", "newton_adapter", "cone, position-based",
        "SolverXPBD on the CPU, 10 iterations, no angular damping", precision="single",
    ),
    Engine(
        "Rapier", "@dimforge/rapier3d-compat", "rapier.mjs", "cone, solved in turns",
        "length unit 2 R, defaults otherwise", precision="single",
    ),
    Engine(
        "cannon-es", "cannon-es", "cannon.mjs", "box of mu times the weight",
        "Gauss-Seidel with 50 iterations, stiffness 1e8, relaxation 3",
    ),
    Engine(
        "Jolt", "jolt-physics", "jolt.mjs", "cone, solved in turns",
        "gyroscopic force on, 20 velocity steps, no velocity limit", precision="single",
    ),
)  # fmt: skip
