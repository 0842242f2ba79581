"""DART: rigid contact as a boxed linear complementarity problem, semi-implicit Euler steps.

Its defaults (Dantzig's pivoting solver, friction as a pyramid) and no restitution; its own
detector has the contact of sphere and box exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy
from program import Row, friction_of, samples, serve

if TYPE_CHECKING:
    from types import ModuleType


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of DART's motion."""
    import dartpy as dart

    mu, body, start = friction_of(job, "DART", "coulomb"), job["body"], job["start"]
    world = dart.simulation.World()
    world.setGravity([0, 0, -job["gravity"]])
    world.setTimeStep(job["step"])
    detector = dart.collision.DARTCollisionDetector()
    world.getConstraintSolver().setCollisionDetector(detector)
    top = dart.dynamics.Skeleton("top")
    joint, node = top.createFreeJointAndBodyNodePair()
    inertia = dart.dynamics.Inertia(
        body["mass"], [0, 0, 0], numpy.diag([body["I1"], body["I1"], body["I3"]])
    )
    node.setInertia(inertia)
    if job["contact"] != "none":
        _sphere(dart, node, body, mu)
        world.addSkeleton(_table(dart, body["radius"]))
    world.addSkeleton(top)
    pose = dart.math.Isometry3()
    pose.set_quaternion(dart.math.Quaternion(*start["quaternion_wxyz"]))
    pose.set_translation(start["position"])
    joint.setTransform(pose)
    spatial = [*start["angular_velocity"], *start["velocity"]]
    joint.setSpatialVelocity(spatial, dart.dynamics.Frame.World(), dart.dynamics.Frame.World())

    def advance(steps: int) -> None:
        for _ in range(steps):
            world.step()

    for t in samples(job, advance):
        q = node.getTransform().quaternion()
        omega, velocity = node.getAngularVelocity(), node.getCOMLinearVelocity()
        yield t, (q.w(), q.x(), q.y(), q.z()), omega, velocity, node.getTransform().translation()


def _sphere(dart: ModuleType, node: ModuleType, body: dict[str, float], mu: float) -> None:
    shape = node.createShapeNode(dart.dynamics.SphereShape(body["radius"]))
    shape.createCollisionAspect()
    shape.createDynamicsAspect().setFrictionCoeff(mu)
    shape.setRelativeTranslation([0, 0, body["centre_offset"]])


def _table(dart: ModuleType, radius: float) -> Any:
    table = dart.dynamics.Skeleton("table")
    _, node = table.createWeldJointAndBodyNodePair()
    shape = node.createShapeNode(dart.dynamics.BoxShape([1e3 * radius, 1e3 * radius, radius]))
    shape.createCollisionAspect()
    shape.createDynamicsAspect().setFrictionCoeff(1.0)
    shape.setRelativeTranslation([0, 0, -radius / 2])
    return table


if __name__ == "__main__":
    serve(simulate)
