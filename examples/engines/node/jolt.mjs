// Jolt (WebAssembly, single precision): sequential impulses, semi-implicit Euler steps.
// Settings after its documentation: the gyroscopic force on, no damping, no sleeping, no limit to
// the angular velocity (its default is 47 rad/s), 20 velocity steps.
import initJolt from "jolt-physics";
import { frictionOf, serve } from "./program.mjs";

await serve(async (job) => {
  const mu = frictionOf(job, "Jolt");
  const { mass, radius, centre_offset, I1, I3 } = job.body;
  const { position, quaternion_xyzw: q, velocity, angular_velocity } = job.start;
  const Jolt = await initJolt();
  const vector = (v) => new Jolt.Vec3(...v);
  const settings = new Jolt.JoltSettings();
  const pairs = new Jolt.ObjectLayerPairFilterTable(1);
  pairs.EnableCollision(0, 0);
  const layers = new Jolt.BroadPhaseLayerInterfaceTable(1, 1);
  layers.MapObjectToBroadPhaseLayer(0, new Jolt.BroadPhaseLayer(0));
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new Jolt.ObjectVsBroadPhaseLayerFilterTable(
    layers, 1, pairs, 1,
  );
  const jolt = new Jolt.JoltInterface(settings);
  const system = jolt.GetPhysicsSystem();
  const bodies = system.GetBodyInterface();
  system.SetGravity(vector([0, 0, -job.gravity]));
  const physics = system.GetPhysicsSettings();
  physics.mNumVelocitySteps = 20;
  system.SetPhysicsSettings(physics);
  const add = (shape, at, turned, motion) => {
    const made = new Jolt.BodyCreationSettings(shape, new Jolt.RVec3(...at), turned, motion, 0);
    made.mFriction = mu;
    made.mRestitution = 0;
    made.mLinearDamping = made.mAngularDamping = 0;
    made.mMaxAngularVelocity = made.mMaxLinearVelocity = 1e6;
    made.mAllowSleeping = false;
    made.mApplyGyroscopicForce = true;
    return made;
  };
  const still = new Jolt.Quat(0, 0, 0, 1);
  if (job.contact !== "none") {
    const slab = new Jolt.BoxShape(vector([3, 3, 0.5]), 0);
    const table = add(slab, [0, 0, -0.5], still, Jolt.EMotionType_Static);
    bodies.CreateAndAddBody(table, Jolt.EActivation_Activate);
  }
  const sphere = new Jolt.SphereShapeSettings(radius);
  // Jolt takes the sphere's centre for the centre of mass and for the origin until it is moved
  const away = new Jolt.OffsetCenterOfMassShapeSettings(vector([0, 0, -centre_offset]), sphere);
  const shape = away.Create().Get();
  const made = add(shape, position, new Jolt.Quat(...q), Jolt.EMotionType_Dynamic);
  made.mOverrideMassProperties = Jolt.EOverrideMassProperties_MassAndInertiaProvided;
  made.mMassPropertiesOverride.mMass = mass;
  made.mMassPropertiesOverride.mInertia = Jolt.Mat44.prototype.sScaleVec3(vector([I1, I1, I3]));
  const top = bodies.CreateBody(made);
  bodies.AddBody(top.GetID(), Jolt.EActivation_Activate);
  top.SetLinearVelocity(vector(velocity));
  top.SetAngularVelocity(vector(angular_velocity));
  return {
    advance: (steps) => {
      for (let i = 0; i < steps; i++) jolt.Step(job.step, 1);
    },
    state: () => {
      const [r, w, v] = [top.GetRotation(), top.GetAngularVelocity(), top.GetLinearVelocity()];
      const s = top.GetCenterOfMassPosition();
      const xyz = (u) => [u.GetX(), u.GetY(), u.GetZ()];
      return [[r.GetW(), ...xyz(r)], xyz(w), xyz(v), xyz(s)];
    },
  };
});
