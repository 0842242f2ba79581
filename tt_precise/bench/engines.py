"""Other people's engines on the reference top: ``python -m tt_precise.bench.engines``.

MuJoCo (soft contact, Coulomb friction) and Exudyn (penalty contact; its regularised friction,
with a wide regularisation, is the paper's own law). Neither knows of Jellett's integral. Writes
``reports/clients.csv``: the drift against the step size and the softness of the contact.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from tt_precise.body import Parameters
from tt_precise.mechanics.conversion import RigidBodyState
from tt_precise.mechanics.newton import arm
from tt_precise.progress import Progress, silent
from tt_precise.scene import load_scene

if TYPE_CHECKING:
    import pandas

SCENE = "reference"
OUT = Path("reports/clients.csv")
EVERY_S = 0.002
COLUMNS = ("t", *RigidBodyState._fields)

# The top of the paper, its axis along the body's z, the sphere's centre at the body's origin.
# The peg only says when it touches the table: there the model with one contact ends.
MJCF = """
<mujoco model="tippe top">
  <option timestep="{step}" integrator="{integrator}" cone="elliptic" tolerance="1e-15"
          gravity="0 0 -{g}"/>
  <worldbody>
    <geom name="table" type="plane" size="0 0 1"/>
    <body name="top" pos="0 0 {R}">
      <freejoint/>
      <inertial pos="0 0 -{lever}" mass="{m}" diaginertia="{I1} {I1} {I3}"/>
      <geom name="sphere" type="sphere" size="{R}" condim="3" friction="{friction} 0 0"
            solref="{softness} 1" solimp="0.9 0.95 0.001" priority="1"/>
      <geom name="peg" type="capsule" fromto="0 0 {R} 0 0 {peg}" size="{thickness}"/>
    </body>
  </worldbody>
</mujoco>
"""


@dataclass(frozen=True)
class EngineRun:
    """What an engine wrote: rigid-body columns up to ``t_peg`` (s; None: it never touched)."""

    frame: pandas.DataFrame
    t_peg: float | None
    seconds: float


@dataclass(frozen=True)
class EngineSetting:
    """An engine in one setting; ``friction`` as in ``check.conservation``."""

    engine: str
    setting: str
    step_s: float
    friction: str
    run: Callable[[], EngineRun]


def engines() -> Iterator[EngineSetting]:
    """All settings of all engines; an engine that is not installed raises when it is run."""
    for integrator, softness, steps in (
        ("Euler", 0.002, (1e-3, 5e-4, 2e-4, 1e-4)),
        ("RK4", 0.002, (1e-3, 5e-4, 2e-4, 1e-4, 5e-5)),
        ("RK4", 0.001, (1e-4,)),
    ):
        for step in steps:
            run = partial(mujoco_run, step, integrator, softness)
            yield EngineSetting(
                "MuJoCo", f"{integrator}, solref {softness:g} s", step, "other", run
            )
    hardness: tuple[tuple[float, tuple[float, ...]], ...] = (
        (1e4, (2e-4, 1e-4)),
        (1e5, (2e-4, 1e-4, 5e-5)),
        (1e6, (1e-4, 5e-5)),
    )
    for stiffness, widths in hardness:
        for step in widths:
            run = partial(exudyn_run, step, stiffness)
            contact = f"RK4, stiffness {stiffness:.0e} N/m"
            yield EngineSetting("Exudyn", contact, step, "scene", run)


def start(body: Parameters, theta: float) -> tuple[Any, Any, Any]:
    """Axis, angular velocity, and velocity of CM with v_A = 0, leaning by ``theta`` (SI)."""
    k = numpy.array([numpy.sin(theta), 0.0, numpy.cos(theta)])
    omega = float(load_scene(SCENE).start.omega_3) * k
    return k, omega, -numpy.cross(omega, arm(body, tuple(k)))


def mujoco_run(
    step_s: float,
    integrator: str = "RK4",
    softness: float = 0.002,
    until: float = 8.0,
    theta: float = 0.3,
    lever: float = 1.0,
    friction: float = 0.05,
) -> EngineRun:
    """MuJoCo's tippe top until its peg touches.

    ``softness`` is the time constant of its contact in s, ``theta`` (rad) the lean at the start;
    ``friction`` is Coulomb's, low enough for the contact to glide and the top to climb; ``lever``
    spoils alpha.
    """
    import mujoco

    body = load_scene(SCENE).body.numbers(float)
    arm_length = body.alpha * body.R
    model = mujoco.MjModel.from_xml_string(
        MJCF.format(
            step=step_s, integrator=integrator, softness=softness, friction=friction, g=body.g,
            m=body.m, R=body.R, I1=body.I1, I3=body.I3, lever=arm_length * lever,
            peg=1.4 * body.R, thickness=0.15 * body.R,
        )
    )  # fmt: skip
    data = mujoco.MjData(model)
    k, omega, _ = start(body, theta)
    data.qpos[3:] = [numpy.cos(theta / 2), 0.0, numpy.sin(theta / 2), 0.0]
    # Coulomb's friction holds a contact that rests, as the scene's does at t = 0: the top would
    # roll for ever. With its centre of mass at rest it glides, and climbs. A free joint moves the
    # body's origin (inertial frame), and turns in the body's frame.
    data.qvel[:3] = numpy.cross(omega, arm_length * k)
    data.qvel[3:] = [0.0, 0.0, float(omega @ k)]
    peg = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, "peg")
    stride, begin = round(EVERY_S / step_s), time.perf_counter()
    rows, w, t_peg = [], numpy.empty(3), None
    for row in range(round(until / EVERY_S) + 1):
        q = numpy.array(data.qpos[3:])
        mujoco.mju_rotVecQuat(w, data.qvel[3:], q)
        mujoco.mju_rotVecQuat(k, numpy.array([0.0, 0.0, 1.0]), q)
        rows.append([row * EVERY_S, *q, *w, *(data.qvel[:3] - numpy.cross(w, arm_length * k))])
        for _ in range(stride):
            mujoco.mj_step(model, data)
        if any(peg in contact.geom for contact in data.contact):
            t_peg = row * EVERY_S
            break
    return EngineRun(_frame(rows), t_peg, time.perf_counter() - begin)


def exudyn_run(
    step_s: float, stiffness: float = 1e5, until: float = 1.0, friction: float = 1.0
) -> EngineRun:
    """Exudyn's rigid body and contact. ``stiffness`` in N/m; ``friction`` spoils mu."""
    exu = importlib.import_module("exudyn")
    tools = importlib.import_module("exudyn.utilities")
    body = load_scene(SCENE).body.numbers(float)
    theta = float(load_scene(SCENE).start.theta.radians(numpy, float))
    k, omega, s_dot = start(body, theta)
    system = exu.SystemContainer().AddSystem()
    sunk = body.m * body.g / stiffness
    top = system.CreateRigidBody(
        inertia=tools.RigidBodyInertia(
            mass=body.m, com=[0, 0, 0], inertiaTensor=numpy.diag([body.I1, body.I1, body.I3])
        ),
        referencePosition=list(numpy.array([0, 0, body.R - sunk]) - body.R * body.alpha * k),
        referenceRotationMatrix=tools.RotationMatrixY(theta),
        initialAngularVelocity=list(omega),
        initialVelocity=list(s_dot),
        gravity=[0, 0, -body.g],
        nodeType=exu.NodeType.RotationRotationVector,  # explicit integrators need this one
    )
    centre = system.AddMarker(
        tools.MarkerBodyRigid(bodyNumber=top, localPosition=[0, 0, body.alpha * body.R])
    )
    table = system.AddMarker(
        tools.MarkerBodyRigid(bodyNumber=system.CreateGround(), localPosition=[0, 0, 0])
    )
    memory = system.AddNode(
        tools.NodeGenericData(initialCoordinates=[0] * 4, numberOfDataCoordinates=4)
    )
    # below this speed (m/s) its friction is proportional to the speed, as the paper's
    viscous = 100.0
    system.AddObject(
        tools.ObjectContactSphereTriangle(
            markerNumbers=[centre, table], nodeNumber=memory, sphereRadius=body.R,
            trianglePoints=exu.Vector3DList([[-99, -99, 0], [299, -99, 0], [-99, 299, 0]]),
            includeEdges=0, dynamicFriction=body.mu * friction * viscous,
            frictionProportionalZone=viscous, contactStiffness=stiffness,
            contactDamping=2 * float(numpy.sqrt(stiffness * body.m)), impactModel=0,
        )
    )  # fmt: skip
    kinds = exu.OutputVariableType
    sensors = [
        system.AddSensor(
            tools.SensorBody(bodyNumber=top, storeInternal=True, outputVariableType=kind)
        )
        for kind in (kinds.RotationMatrix, kinds.AngularVelocity, kinds.Velocity)
    ]
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(until / step_s)
    settings.timeIntegration.endTime = until
    settings.timeIntegration.verboseMode = 0
    settings.solution.sensors.writePeriod = EVERY_S
    settings.solution.file.write = False
    begin = time.perf_counter()
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
    seconds = time.perf_counter() - begin
    turned, spun, moved = (system.GetSensorStoredData(sensor) for sensor in sensors)
    from scipy.spatial.transform import Rotation

    quaternions = Rotation.from_matrix(turned[:, 1:].reshape(-1, 3, 3)).as_quat(scalar_first=True)
    times = EVERY_S * numpy.round(turned[:, :1] / EVERY_S)
    return EngineRun(
        _frame(numpy.hstack((times, quaternions, spun[:, 1:], moved[:, 1:]))), None, seconds
    )


def _frame(rows: Any) -> pandas.DataFrame:
    import pandas

    return pandas.DataFrame(numpy.array(rows, dtype=float), columns=list(COLUMNS))


def table(progress: Progress = silent) -> pandas.DataFrame:
    """A row for each engine and setting: the drifts, and how long it took.

    ``energy`` is the largest rise; ``energy_balance``, ``equations`` and ``golden_digits`` only
    where the engine has the scene's friction; ``contact_velocity`` says how soft the contact is.
    """
    import pandas

    from tt_precise.check import conservation

    every = list(engines())
    rows = []
    for number, client in enumerate(every):
        run = client.run()
        result = conservation(run.frame, SCENE, friction=client.friction)
        values = {finding.name: finding.value for finding in result.checks}
        rows.append(
            {
                "engine": client.engine,
                "version": importlib.metadata.version(client.engine.lower()),
                "setting": client.setting,
                "step_s": client.step_s,
                "until_s": result.t_last,
                "peg_s": run.t_peg,
                **{name: values[name] for name in ("jellett", "energy", "contact_velocity")},
                **{name: values[name] for name in ("energy_balance", "equations")},
                "golden_digits": values["golden"],
                "seconds": run.seconds,
            }
        )
        progress((number + 1) / len(every))
    return pandas.DataFrame(rows)


def main() -> None:
    """Measure, and write ``reports/clients.csv``."""
    from tt_precise.files import atomic_write
    from tt_precise.progress import progress_bar

    with progress_bar("running other people's engines") as progress:
        found = table(progress)
    atomic_write(OUT, found.to_csv(index=False, float_format="%.3g", lineterminator="\n"))
    print(found.to_string(index=False, float_format=lambda value: f"{value:.2g}"))


if __name__ == "__main__":
    main()
