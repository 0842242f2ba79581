// cannon-es: contact equations of Lacoursiere's SPOOK, Gauss-Seidel, semi-implicit Euler steps.
// Settings after its guide: no damping, no sleeping, 50 iterations, a stiff contact (1e8) that
// relaxes over 3 steps; friction is bounded by mu times the weight, not by the normal force.
import * as CANNON from "cannon-es";
import { frictionOf, serve } from "./program.mjs";

await serve(async (job) => {
  const mu = frictionOf(job, "cannon-es");
  const { mass, radius, centre_offset, I1, I3 } = job.body;
  const { position, quaternion_xyzw: q, velocity, angular_velocity } = job.start;
  const vector = (v) => new CANNON.Vec3(...v);
  const world = new CANNON.World({ gravity: vector([0, 0, -job.gravity]) });
  world.allowSleep = false;
  world.solver.iterations = 50;
  world.solver.tolerance = 0;
  const material = new CANNON.Material();
  world.addContactMaterial(
    new CANNON.ContactMaterial(material, material, {
      friction: mu,
      restitution: 0,
      contactEquationStiffness: 1e8,
      contactEquationRelaxation: 3,
      frictionEquationStiffness: 1e8,
      frictionEquationRelaxation: 3,
    }),
  );
  const top = new CANNON.Body({ mass, material, linearDamping: 0, angularDamping: 0 });
  if (job.contact !== "none") {
    top.addShape(new CANNON.Sphere(radius), vector([0, 0, centre_offset]));
    world.addBody(new CANNON.Body({ mass: 0, material, shape: new CANNON.Plane() }));
  }
  top.position.set(...position);
  top.quaternion.set(...q);
  top.velocity.set(...velocity);
  top.angularVelocity.set(...angular_velocity);
  // adding a shape has made an inertia of its bounding box
  top.updateMassProperties = () => {};
  top.inertia.set(I1, I1, I3);
  top.invInertia.set(1 / I1, 1 / I1, 1 / I3);
  top.updateInertiaWorld(true);
  world.addBody(top);
  return {
    advance: (steps) => {
      for (let i = 0; i < steps; i++) world.step(job.step);
    },
    state: () => {
      const [r, w, v, s] = [top.quaternion, top.angularVelocity, top.velocity, top.position];
      return [[r.w, r.x, r.y, r.z], [w.x, w.y, w.z], [v.x, v.y, v.z], [s.x, s.y, s.z]];
    },
  };
});
