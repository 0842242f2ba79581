"""ODE, as panda3d brings it along (single precision): rigid contact, first-order steps.

Settings after its manual: the accurate ``step`` instead of ``quickStep``, ``Approx1`` so that
friction is a pyramid bounded by mu times the normal force, not by a constant, ERP 0.2, CFM 1e-9.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from program import Row, friction_of, samples, serve

if TYPE_CHECKING:
    from types import ModuleType

APPROX1 = 0x3000  # friction is proportional to the normal force, in both directions


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of ODE's motion."""
    from panda3d import core, ode

    mu, body, start = friction_of(job, "ODE", "coulomb"), job["body"], job["start"]
    world = ode.OdeWorld()
    world.setGravity(0, 0, -job["gravity"])
    world.setErp(0.2)
    world.setCfm(1e-9)
    world.setAutoDisableFlag(False)
    mass = ode.OdeMass()
    mass.setParameters(body["mass"], 0, 0, 0, body["I1"], body["I1"], body["I3"], 0, 0, 0)
    top = ode.OdeBody(world)
    top.setMass(mass)
    top.setPosition(*start["position"])
    top.setQuaternion(core.LQuaternionf(*start["quaternion_wxyz"]))
    top.setLinearVel(*start["velocity"])
    top.setAngularVel(*start["angular_velocity"])
    top.setFiniteRotationMode(1)
    geometry = _geometry(ode, core, top, body) if job["contact"] != "none" else None
    surface = ode.OdeSurfaceParameters(APPROX1, mu)

    def advance(steps: int) -> None:
        for _ in range(steps):
            joints = _touch(ode, world, top, geometry, surface)
            world.step(job["step"])
            joints.empty()

    for t in samples(job, advance):
        yield (
            t, tuple(top.getQuaternion()), top.getAngularVel(), top.getLinearVel(),
            top.getPosition(),
        )  # fmt: skip


def _geometry(ode: ModuleType, core: ModuleType, top: Any, body: dict[str, float]) -> Any:
    sphere = ode.OdeSphereGeom(body["radius"])
    sphere.setBody(top)
    sphere.setOffsetPosition(0, 0, body["centre_offset"])
    return sphere, ode.OdePlaneGeom(core.LVecBase4f(0, 0, 1, 0))


def _touch(ode: ModuleType, world: Any, top: Any, geometry: Any, surface: Any) -> Any:
    joints = ode.OdeJointGroup()
    if geometry:
        entry = ode.OdeUtil.collide(*geometry, 1)
        for i in range(entry.getNumContacts()):
            contact = ode.OdeContact()
            contact.setGeom(entry.getContactGeom(i))
            contact.setSurface(surface)
            ode.OdeContactJoint(world, joints, contact).attachBody(top, 0)
    return joints


if __name__ == "__main__":
    serve(simulate)
