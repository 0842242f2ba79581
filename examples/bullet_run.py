"""A Tippe Top in Bullet, quaternion scalar last, velocities in world axes.

python bullet_run.py && tt-precise check run.npz --scene reference --friction other --from bullet
"""

import numpy as np
import pybullet as p

m, R, alpha, g, mu, step = 0.02, 0.02, 0.3, 9.82, 0.3, 1e-4
I1, I3 = 131 / 350 * m * R**2, 2 / 5 * m * R**2
theta, omega_3 = 0.1, 155.0

p.connect(p.DIRECT)
p.setGravity(0, 0, -g)
p.setPhysicsEngineParameter(fixedTimeStep=step, numSubSteps=1, enableConeFriction=1)
table = p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
p.changeDynamics(table, -1, lateralFriction=1, restitution=0)
# Bullet's base is the centre of mass
sphere = p.createCollisionShape(p.GEOM_SPHERE, radius=R, collisionFramePosition=[0, 0, alpha * R])
k = np.array([np.sin(theta), 0, np.cos(theta)])
q = [0, np.sin(theta / 2), 0, np.cos(theta / 2)]
top = p.createMultiBody(m, sphere, -1, [0, 0, R - alpha * R * k[2]], q)
p.changeDynamics(
    top, -1, lateralFriction=mu, restitution=0, linearDamping=0, angularDamping=0,
    maxJointVelocity=1e9, activationState=4, localInertiaDiagonal=[I1, I1, I3], collisionMargin=0,
)  # fmt: skip
omega = omega_3 * k
p.resetBaseVelocity(top, -np.cross(omega, alpha * R * k - [0, 0, R]), omega)

rows = []
for n in range(5001):
    if n % 50 == 0:
        _, quaternion = p.getBasePositionAndOrientation(top)
        rows.append((n * step, quaternion, *p.getBaseVelocity(top)))
    p.stepSimulation()
t, quaternion, velocity, angular = map(np.array, zip(*rows, strict=True))
np.savez("run.npz", t=t, quaternion=quaternion, velocity=velocity, angular_velocity=angular)
