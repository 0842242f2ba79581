"""Bullet (PyBullet): impulses of a sequential solver, semi-implicit Euler steps.

Settings after its guide: an implicit cone, no damping (its default is 0.04 a second), 50
iterations, and no limit to the velocities (its default is 100).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from program import Row, friction_of, samples, serve


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of Bullet's motion."""
    import pybullet as p

    mu, body, start = friction_of(job, "Bullet", "coulomb"), job["body"], job["start"]
    p.connect(p.DIRECT)
    p.setGravity(0, 0, -job["gravity"])
    p.setPhysicsEngineParameter(
        fixedTimeStep=job["step"], numSolverIterations=50, numSubSteps=1, enableConeFriction=1,
        restitutionVelocityThreshold=0, deterministicOverlappingPairs=1,
    )  # fmt: skip
    if job["contact"] != "none":
        table = p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
        p.changeDynamics(table, -1, lateralFriction=1, restitution=0)
    sphere = p.createCollisionShape(
        p.GEOM_SPHERE, radius=body["radius"],
        collisionFramePosition=[0, 0, body["centre_offset"]],
    )  # fmt: skip
    q = start["quaternion_xyzw"]
    top = p.createMultiBody(body["mass"], sphere, -1, start["position"], q)
    p.changeDynamics(
        top, -1, lateralFriction=mu, spinningFriction=0, rollingFriction=0, restitution=0,
        linearDamping=0, angularDamping=0, maxJointVelocity=1e9, activationState=4,
        localInertiaDiagonal=[body["I1"], body["I1"], body["I3"]],
        contactProcessingThreshold=0, collisionMargin=0,
    )  # fmt: skip
    p.resetBaseVelocity(top, start["velocity"], start["angular_velocity"])

    def advance(steps: int) -> None:
        for _ in range(steps):
            p.stepSimulation()

    for t in samples(job, advance):
        position, (x, y, z, w) = p.getBasePositionAndOrientation(top)
        velocity, omega = p.getBaseVelocity(top)
        yield t, (w, x, y, z), omega, velocity, position


if __name__ == "__main__":
    serve(simulate)
