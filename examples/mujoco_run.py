"""A Tippe Top in MuJoCo, written in its convention: qpos and qvel of a free joint.

python mujoco_run.py && tt-precise check run.npz --scene reference --friction other --from mujoco
"""

import mujoco
import numpy as np

m, R, alpha, g, mu, step = 0.02, 0.02, 0.3, 9.82, 0.3, 5e-5
I1, I3 = 131 / 350 * m * R**2, 2 / 5 * m * R**2
theta, omega_3 = 0.1, 155.0

# the body's origin is the centre of the sphere; the contact gets stiffer with smaller steps
model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{step}" integrator="RK4" cone="elliptic" impratio="10" gravity="0 0 -{g}"/>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body pos="0 0 {R}">
      <freejoint/>
      <inertial pos="0 0 {-alpha * R}" mass="{m}" diaginertia="{I1} {I1} {I3}"/>
      <geom type="sphere" size="{R}" friction="{mu} 0 0" solref="{2 * step} 1" priority="1"/>
    </body>
  </worldbody>
</mujoco>""")
data = mujoco.MjData(model)
data.qpos[3:] = [np.cos(theta / 2), 0, np.sin(theta / 2), 0]
k = np.array([np.sin(theta), 0, np.cos(theta)])
data.qvel[3:] = [0, 0, omega_3]
data.qvel[:3] = np.cross(omega_3 * k, [0, 0, R])  # the contact point rests at the start

rows = []
for n in range(10001):
    if n % 20 == 0:  # 1 kHz: rows that show the attitude and the momentum
        rows.append((data.time, data.qpos.copy(), data.qvel.copy()))
    mujoco.mj_step(model, data)
t, qpos, qvel = map(np.array, zip(*rows, strict=True))
np.savez("run.npz", t=t, qpos=qpos, qvel=qvel)
