// Rapier (WebAssembly, single precision): contact constraints, a solver of small steps.
// Settings after its guide: mass properties given, no damping, no sleeping, its defaults otherwise.
import RAPIER from "@dimforge/rapier3d-compat";
import { frictionOf, serve } from "./program.mjs";

await serve(async (job) => {
  const mu = frictionOf(job, "Rapier");
  const { mass, radius, centre_offset, I1, I3 } = job.body;
  const { position, quaternion_xyzw: q, velocity, angular_velocity } = job.start;
  const vector = ([x, y, z]) => ({ x, y, z });
  await RAPIER.init();
  const world = new RAPIER.World({ x: 0, y: 0, z: -job.gravity });
  world.timestep = job.step;
  world.lengthUnit = 2 * radius; // the size of a typical body, which its tolerances scale with
  const properties = [mass, vector([0, 0, 0]), vector([I1, I1, I3]), { x: 0, y: 0, z: 0, w: 1 }];
  const top = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic()
      .setTranslation(...position)
      .setRotation({ x: q[0], y: q[1], z: q[2], w: q[3] })
      .setLinvel(...velocity)
      .setAngvel(vector(angular_velocity))
      .setAdditionalMassProperties(...properties)
      .setCanSleep(false)
      .setLinearDamping(0)
      .setAngularDamping(0),
  );
  if (job.contact !== "none") {
    const rule = RAPIER.CoefficientCombineRule.Min;
    const rough = (shape) =>
      shape.setFriction(mu).setFrictionCombineRule(rule).setRestitution(0).setDensity(0);
    const ball = RAPIER.ColliderDesc.ball(radius).setTranslation(0, 0, centre_offset);
    world.createCollider(rough(ball), top);
    const table = new RAPIER.ColliderDesc(new RAPIER.HalfSpace(vector([0, 0, 1])));
    world.createCollider(rough(table));
  }
  return {
    advance: (steps) => {
      for (let i = 0; i < steps; i++) world.step();
    },
    state: () => {
      const [r, w, v, s] = [top.rotation(), top.angvel(), top.linvel(), top.translation()];
      return [[r.w, r.x, r.y, r.z], [w.x, w.y, w.z], [v.x, v.y, v.z], [s.x, s.y, s.z]];
    },
  };
});
