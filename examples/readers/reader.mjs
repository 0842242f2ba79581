// Reads the reference data from JavaScript: the index, a file of test vectors, a trajectory; and
// computes the contact force of every gliding state of the vectors with ten lines of physics.
//
//     node examples/readers/reader.mjs reference_data
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { join } from "node:path";

const folder = process.argv[2];
const read = (path) => readFileSync(join(folder, path), "utf8");
const fail = (message) => {
  console.error(message);
  process.exit(1);
};

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const sum = (a, b) => a.map((x, i) => x + b[i]);
const scaled = (c, a) => a.map((x) => c * x);

// Normal force of an elastic table, which the lowest point is in by -height.
function pushed({ force, stiffness, damping }, height, rise) {
  if (force === "linear") return -stiffness * height - damping * rise;
  return stiffness * (-height) ** 1.5 * (1 - damping * rise);
}

// Force on the top at the contact point, g_n (z - c v_A); c is mu, mu/|v_A| or regularised.
function force({ m, R, alpha, I1, I3, g }, { law, mu, epsilon = 0 }, contact, state) {
  const { k, omega, s_dot, height } = state;
  const L = sum(scaled(I1, omega), scaled((I3 - I1) * dot(omega, k), k));
  const a = sum(scaled(R * alpha, k), [0, 0, -R]);
  const v = sum(s_dot, cross(omega, a));
  const c = law === "viscous" ? mu : mu / Math.hypot(v[0], v[1], epsilon);
  const direction = [-c * v[0], -c * v[1], 1];
  if (contact.law === "compliant") return scaled(pushed(contact, height, v[2]), direction);
  const swung = cross(L, scaled(1 / I1, cross(L, k)))[2];
  const driven = cross(cross(a, direction), k)[2];
  const lever = m * R * alpha;
  return scaled((m * g * I1 - lever * swung) / (I1 + lever * driven), direction);
}

const number = (value) => (Array.isArray(value) ? value.map(Number) : Number(value));
const numbers = (record) =>
  Object.fromEntries(
    Object.entries(record).map(([name, value]) => [
      name,
      name === "law" || name === "force" ? value : number(value),
    ]),
  );

const index = JSON.parse(read("index.json"));
for (const { path, sha256 } of index.files) {
  const found = createHash("sha256").update(readFileSync(join(folder, path))).digest("hex");
  if (found !== sha256) fail(`${path} is not the file of the index`);
}
let worst = 0;
const gliding = ["viscous", "regularised", "coulomb"];
const vectors = JSON.parse(read("vectors/states.json")).cases;
for (const { body, friction, contact, state, expected } of vectors) {
  if (!gliding.includes(friction.law)) continue;
  const mine = force(...[body, friction, contact, state].map(numbers));
  const known = expected.F.map(Number);
  mine.forEach((x, i) => (worst = Math.max(worst, Math.abs(x - known[i]) / Math.hypot(...known))));
}
const [header, ...rows] = read("reference/trajectory.csv").trim().split("\n");
const names = header.split(",");
const last = rows.at(-1).split(",").map(Number);
const k = ["kx", "ky", "kz"].map((name) => last[names.indexOf(name)]);
if (Math.abs(dot(k, k) - 1) > 1e-15) fail("the axis of the last row is no unit vector");
if (worst > 1e-12) fail(`forces differ by ${worst}`);
console.log(`${index.files.length} files, ${vectors.length} states, ${rows.length} rows: ${worst}`);
