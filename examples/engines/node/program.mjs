// For engines in JavaScript: an adapter as a program of the engine protocol.
import { readFileSync, writeSync } from "node:fs";

const COLUMNS = "t,qw,qx,qy,qz,wx,wy,wz,vcx,vcy,vcz,x,y,z";
const REFUSED = 3; // exit status of a program that cannot express the job

// simulate(job) returns { advance(steps), state() }; state() is
// [quaternion scalar first, inertial angular velocity, velocity and position of the centre of mass].
export async function serve(simulate) {
  // what an engine logs must not get into the CSV
  console.log = console.info = console.warn = console.error;
  const job = JSON.parse(readFileSync(0, "utf8"));
  const engine = await simulate(job);
  const lines = [COLUMNS];
  let done = 0;
  for (const t of job.sample_times) {
    const wanted = Math.round(t / job.step);
    engine.advance(wanted - done);
    done = wanted;
    lines.push([t, ...engine.state().flat()].join(","));
  }
  writeSync(1, lines.join("\n") + "\n");
}

// The coefficient of Coulomb's friction, or 0 where there is none; other laws are refused.
export function frictionOf(job, engine) {
  const { law, mu } = job.friction;
  if (law === "none" || job.contact === "none") return 0;
  if (law === "coulomb") return mu;
  writeSync(2, `${engine} has no ${law} friction\n`);
  process.exit(REFUSED);
}
