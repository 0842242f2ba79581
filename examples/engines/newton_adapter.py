"""Newton on Warp's CPU kernels (single precision): extended position-based dynamics.

Settings after its documentation: SolverXPBD with 10 iterations, no angular damping (its examples'
torsional and rolling friction off), contacts found anew each step.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from program import Row, friction_of, samples, serve


def simulate(job: dict[str, Any]) -> Iterator[Row]:
    """Rows of Newton's motion."""
    import newton
    import warp

    mu, body, start = friction_of(job, "Newton", "coulomb"), job["body"], job["start"]
    builder = newton.ModelBuilder(gravity=(0, 0, -job["gravity"]))
    config = newton.ModelBuilder.ShapeConfig(
        density=0.0, mu=mu, mu_torsional=0.0, mu_rolling=0.0, restitution=0.0
    )
    pose = warp.transform(start["position"], start["quaternion_xyzw"])
    inertia = warp.mat33(body["I1"], 0, 0, 0, body["I1"], 0, 0, 0, body["I3"])
    top = builder.add_body(xform=pose, mass=body["mass"], inertia=inertia, lock_inertia=True)
    if job["contact"] != "none":
        centre = warp.transform([0, 0, body["centre_offset"]], [0, 0, 0, 1])
        builder.add_shape_sphere(top, xform=centre, radius=body["radius"], cfg=config)
        builder.add_ground_plane(cfg=config)
    model = builder.finalize(device="cpu")
    solver = newton.solvers.SolverXPBD(model, iterations=10, angular_damping=0.0)
    now, then, control = model.state(), model.state(), model.control()
    now.body_qd.assign([[*start["velocity"], *start["angular_velocity"]]])
    contacts = model.contacts() if job["contact"] != "none" else None

    def advance(steps: int) -> None:
        nonlocal now, then
        for _ in range(steps):
            now.clear_forces()
            if contacts is not None:
                model.collide(now, contacts)
            solver.step(now, then, control, contacts, job["step"])
            now, then = then, now

    for t in samples(job, advance):
        *position, x, y, z, w = now.body_q.numpy()[0].tolist()
        moving = now.body_qd.numpy()[0].tolist()
        yield t, (w, x, y, z), moving[3:], moving[:3], position


if __name__ == "__main__":
    serve(simulate)
