"""MuJoCo: soft contact of convex optimisation, elliptic Coulomb cone, RK4.

Settings as its documentation recommends: RK4 for conservative systems, the elliptic cone as the
closer model of friction, ``impratio`` 10 against slip, and a contact time constant of twice the
step, the shortest that it allows, so that the contact hardens as the step falls.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from program import Row, friction_of, samples, serve

MODEL = """
<mujoco>
  <option timestep="{step}" integrator="RK4" cone="elliptic" impratio="10" tolerance="1e-12"
          gravity="0 0 -{gravity}"/>
  <worldbody>
    {table}
    <body name="top" pos="0 0 0">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{I1} {I1} {I3}"/>
      <geom type="sphere" size="{radius}" pos="0 0 {offset}" condim="{dimension}"
            friction="{mu} 0 0" solref="{softness} 1" priority="1"/>
    </body>
  </worldbody>
</mujoco>
"""


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of MuJoCo's motion."""
    import mujoco
    import numpy

    mu, body, start = friction_of(job, "MuJoCo", "coulomb"), job["body"], job["start"]
    model = mujoco.MjModel.from_xml_string(
        MODEL.format(
            step=job["step"], gravity=job["gravity"], mass=body["mass"], radius=body["radius"],
            I1=body["I1"], I3=body["I3"], offset=body["centre_offset"], mu=mu,
            dimension=3 if mu else 1, softness=2 * job["step"],
            table="" if job["contact"] == "none" else '<geom type="plane" size="0 0 1"/>',
        )
    )  # fmt: skip
    data = mujoco.MjData(model)

    def turned(vector: Any, q: Any) -> Any:
        result = numpy.zeros(3)
        mujoco.mju_rotVecQuat(result, numpy.array(vector), numpy.array(q))
        return result

    w, x, y, z = start["quaternion_wxyz"]
    # a free joint moves its origin in the inertial frame and turns in the body's
    data.qpos[:] = [*start["position"], w, x, y, z]
    data.qvel[:] = [*start["velocity"], *turned(start["angular_velocity"], (w, -x, -y, -z))]

    def advance(steps: int) -> None:
        mujoco.mj_step(model, data, nstep=steps)

    for t in samples(job, advance):
        q = data.qpos[3:].copy()
        yield t, q, turned(data.qvel[3:], q), data.qvel[:3].copy(), data.qpos[:3].copy()


if __name__ == "__main__":
    serve(simulate)
