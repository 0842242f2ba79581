"""Exudyn: penalty contact of a sphere with a triangle, explicit Runge-Kutta of order 4.

The stiffness is the largest that the step resolves well, m (0.5/step)^2, critically damped. Its
friction is Coulomb's above a speed and proportional to the speed below: with that speed small it
is Coulomb's, with it large it is the viscous law.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from typing import Any

import numpy
from program import Row, friction_of, serve

FAST = 100.0  # m/s: below it the friction is proportional to the speed
SLOW = 1e-3  # m/s


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of Exudyn's motion."""
    exu = importlib.import_module("exudyn")
    tools = importlib.import_module("exudyn.utilities")
    from scipy.spatial.transform import Rotation

    mu, body, start = friction_of(job, "Exudyn", "coulomb", "viscous"), job["body"], job["start"]
    viscous = job["friction"]["law"] == "viscous"
    stiffness = body["mass"] * (0.5 / job["step"]) ** 2
    system = exu.SystemContainer().AddSystem()
    inertia = numpy.diag([body["I1"], body["I1"], body["I3"]])
    rotation = Rotation.from_quat(start["quaternion_xyzw"]).as_matrix()
    top = system.CreateRigidBody(
        inertia=tools.RigidBodyInertia(mass=body["mass"], com=[0, 0, 0], inertiaTensor=inertia),
        referencePosition=start["position"], referenceRotationMatrix=rotation,
        initialAngularVelocity=start["angular_velocity"], initialVelocity=start["velocity"],
        gravity=[0, 0, -job["gravity"]],
        nodeType=exu.NodeType.RotationRotationVector,  # explicit integrators need this one
    )  # fmt: skip
    if job["contact"] != "none":
        offset = [0, 0, body["centre_offset"]]
        centre = system.AddMarker(tools.MarkerBodyRigid(bodyNumber=top, localPosition=offset))
        ground = system.CreateGround()
        table = system.AddMarker(tools.MarkerBodyRigid(bodyNumber=ground, localPosition=[0, 0, 0]))
        memory = tools.NodeGenericData(initialCoordinates=[0] * 4, numberOfDataCoordinates=4)
        corners = exu.Vector3DList([[-99, -99, 0], [299, -99, 0], [-99, 299, 0]])
        system.AddObject(
            tools.ObjectContactSphereTriangle(
                markerNumbers=[centre, table], nodeNumber=system.AddNode(memory),
                sphereRadius=body["radius"], trianglePoints=corners, includeEdges=0,
                dynamicFriction=mu * FAST if viscous else mu,
                frictionProportionalZone=FAST if viscous else SLOW, contactStiffness=stiffness,
                contactDamping=2 * float(numpy.sqrt(stiffness * body["mass"])), impactModel=0,
            )
        )  # fmt: skip
    kinds = exu.OutputVariableType
    wanted = (kinds.RotationMatrix, kinds.AngularVelocity, kinds.Velocity, kinds.Position)
    sensors = [
        system.AddSensor(tools.SensorBody(bodyNumber=top, storeInternal=True, outputVariableType=k))
        for k in wanted
    ]
    system.Assemble()
    times, settings = job["sample_times"], exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps = round(times[-1] / job["step"])
    settings.timeIntegration.endTime = times[-1]
    settings.timeIntegration.verboseMode = 0
    settings.solution.sensors.writePeriod = job["step"]
    settings.solution.file.write = False
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)
    turned, *others = (system.GetSensorStoredData(sensor) for sensor in sensors)
    for t in times:
        i = round(t / job["step"])
        q = Rotation.from_matrix(turned[i, 1:].reshape(3, 3)).as_quat(scalar_first=True)
        yield t, q, *(table[i, 1:] for table in others)


if __name__ == "__main__":
    serve(simulate)
