// Reads the reference data from JavaScript, a file of test vectors and a trajectory, and computes
// the contact force of every state, under every law, with a dozen lines of physics.
//
//     node examples/readers/reader.mjs reference_data
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

// Force of an elastic table on the lowest point, which is in it by `depth`.
function pushed({ force, stiffness, damping }, depth, rise) {
  if (force === "linear") return Math.max(0, stiffness * depth - damping * rise);
  return stiffness * depth ** 1.5 * Math.max(0, 1 - damping * rise);
}

// A force F accelerates the contact by b + p F - (a.F) a/I1 + d (n.F) n, which rolling makes 0.
function force({ m, R, alpha, I1, I3, g }, { law, mu, epsilon = 0 }, contact, state) {
  const { k, omega, s_dot, height } = state;
  const a = sum(scaled(R * alpha, k), [0, 0, -R]);
  const v = sum(s_dot, cross(omega, a));
  const k_dot = cross(omega, k);
  const [d, n, p] = [1 / I3 - 1 / I1, cross(k, a), 1 / m + dot(a, a) / I1];
  const turned = sum(scaled(d * I3 * dot(omega, k), cross(k_dot, a)), [0, 0, -g]);
  const b = sum(scaled(R * alpha, cross(omega, k_dot)), turned);
  if (["rolling", "sticking"].includes(law)) {
    const along_n = scaled((d * dot(n, b)) / (p + d * dot(n, n)), n);
    return scaled(-1 / p, sum(b, sum(scaled((m / I1) * dot(a, b), a), scaled(-1, along_n))));
  }
  if (law === "none") return [0, 0, 0];
  const c = law === "viscous" ? mu : mu / Math.hypot(v[0], v[1], epsilon);
  const f = [-c * v[0], -c * v[1], 1];
  if (contact.law === "compliant") return scaled(pushed(contact, -height, v[2]), f);
  return scaled(b[2] / ((dot(a, f) * a[2]) / I1 - p), f);
}

const number = (value) => (Array.isArray(value) ? value.map(Number) : Number(value));
const numbers = (record) =>
  Object.fromEntries(
    Object.entries(record).map(([name, value]) => [
      name,
      name === "law" || name === "force" ? value : number(value),
    ]),
  );

let worst = 0;
const vectors = JSON.parse(read("vectors/states.json")).cases;
for (const { body, friction, contact, state, expected, result } of vectors) {
  const mine = force(...[body, friction, contact, state].map(numbers));
  const off = mine.map((x, i) => x - Number(expected.F[i]));
  const size = Math.hypot(...off) / (body.m * body.g);
  worst = Math.max(worst, result === "valid" ? size : Number(size < 1e-9));
}
const [header, ...rows] = read("reference/trajectory.csv").trim().split("\n");
const names = header.split(",");
const last = rows.at(-1).split(",").map(Number);
const k = ["kx", "ky", "kz"].map((name) => last[names.indexOf(name)]);
if (Math.abs(dot(k, k) - 1) > 1e-15) fail("the axis of the last row is no unit vector");
if (worst > 1e-12) fail(`forces differ by ${worst}`);
console.log(`${vectors.length} states, ${rows.length} rows: ${worst}`);
