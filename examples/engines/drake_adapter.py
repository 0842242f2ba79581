"""Drake: compliant point contact with regularised friction, discrete plant.

Settings after its manual: the "lagged" approximation, recommended for Hunt-Crossley contact, with
dissipation 10 s/m; the stiffness follows from a penetration that falls with the step, and the
stiction tolerance with it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy
from program import Row, friction_of, samples, serve


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of Drake's motion."""
    from pydrake.common.eigen_geometry import Quaternion
    from pydrake.geometry import HalfSpace, Sphere
    from pydrake.math import RigidTransform, RotationMatrix
    from pydrake.multibody import plant as plants
    from pydrake.multibody import tree
    from pydrake.multibody.math import SpatialVelocity
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    mu, body, start = friction_of(job, "Drake", "coulomb"), job["body"], job["start"]
    builder = DiagramBuilder()
    plant, _ = plants.AddMultibodyPlantSceneGraph(builder, time_step=job["step"])
    plant.set_contact_model(plants.ContactModel.kPoint)
    plant.set_discrete_contact_approximation(plants.DiscreteContactApproximation.kLagged)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -job["gravity"]])
    inertia = tree.UnitInertia(*(body[name] / body["mass"] for name in ("I1", "I1", "I3")))
    centre: Any = numpy.zeros(3)
    spatial = tree.SpatialInertia(mass=body["mass"], p_PScm_E=centre, G_SP_E=inertia)
    top = plant.AddRigidBody("top", spatial)
    if job["contact"] != "none":
        friction = plants.CoulombFriction(mu, mu)
        plant.RegisterCollisionGeometry(
            plant.world_body(), RigidTransform(), HalfSpace(), "table", friction
        )
        centre = RigidTransform([0, 0, body["centre_offset"]])
        plant.RegisterCollisionGeometry(top, centre, Sphere(body["radius"]), "sphere", friction)
        plant.set_penetration_allowance(job["gravity"] * (4 * job["step"]) ** 2)
        plant.set_stiction_tolerance(job["step"])
    plant.Finalize()
    simulator = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    q = numpy.array(start["quaternion_wxyz"])
    turned = RotationMatrix(Quaternion(q / numpy.linalg.norm(q)))
    plant.SetFreeBodyPose(context, top, RigidTransform(turned, start["position"]))
    velocity = SpatialVelocity(start["angular_velocity"], start["velocity"])
    plant.SetFreeBodySpatialVelocity(context=context, body=top, V_JpJc=velocity)
    steps_done = 0

    def advance(steps: int) -> None:
        nonlocal steps_done
        steps_done += steps
        simulator.AdvanceTo(steps_done * job["step"])

    for t in samples(job, advance):
        pose = plant.EvalBodyPoseInWorld(context, top)
        moving = plant.EvalBodySpatialVelocityInWorld(context, top)
        q = pose.rotation().ToQuaternion().wxyz()
        yield t, q, moving.rotational(), moving.translational(), pose.translation()


if __name__ == "__main__":
    serve(simulate)
