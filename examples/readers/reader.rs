// Reads the reference data from Rust, a file of test vectors and a trajectory, and computes the
// contact force of every state, under every law, with a dozen lines of physics.
//
//     rustc --edition 2021 -O examples/readers/reader.rs && ./reader reference_data
use std::{env, fs, process::exit};

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn cross(a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3])
}

fn sum(c: f64, a: Vector, b: Vector) -> Vector {
    [0, 1, 2].map(|i| c * a[i] + b[i])
}

// The numbers behind a key, which are printed as strings; none where a law has no such key.
fn numbers<'a>(text: &'a str, key: &str) -> impl Iterator<Item = f64> + 'a {
    let behind = text.split_once(&format!("\"{key}\": ")).map_or("", |(_, rest)| rest);
    behind.split('"').skip(1).step_by(2).map_while(|one| one.parse().ok())
}

fn number(text: &str, key: &str) -> f64 {
    numbers(text, key).next().unwrap_or(0.0)
}

fn vector(text: &str, key: &str) -> Vector {
    let three: Vec<f64> = numbers(text, key).take(3).collect();
    three.try_into().unwrap_or_else(|_| panic!("expected three numbers: {key}"))
}

// A force F accelerates the contact by b + p F - (a.F) a/I1 + d (n.F) n, which rolling makes 0.
fn force(text: &str) -> Vector {
    let law = text.split('-').next().unwrap_or(""); // the name of hunt-crossley-1: "hunt"
    let [m, r, alpha, i1, i3, g] = ["m", "R", "alpha", "I1", "I3", "g"].map(|x| number(text, x));
    let (k, omega, depth) = (vector(text, "k"), vector(text, "omega"), -number(text, "height"));
    let (a, k_dot) = (sum(r * alpha, k, [0.0, 0.0, -r]), cross(omega, k));
    let v = sum(1.0, vector(text, "s_dot"), cross(omega, a));
    let (n, d, p) = (cross(k, a), 1.0 / i3 - 1.0 / i1, 1.0 / m + dot(a, a) / i1);
    let turned = sum(d * i3 * dot(omega, k), cross(k_dot, a), [0.0, 0.0, -g]);
    let b = sum(r * alpha, cross(omega, k_dot), turned);
    let slip = if law == "viscous" { 1.0 } else { v[0].hypot(v[1]).hypot(number(text, "epsilon")) };
    let c = number(text, "mu") / slip;
    let f = [-c * v[0], -c * v[1], 1.0];
    let (stiffness, damping) = (number(text, "stiffness"), number(text, "damping"));
    let pushed = match law {
        "rolling" | "sticking" => {
            let along_n = sum(d * dot(n, b) / (p + d * dot(n, n)), n, b.map(|x| -x));
            return sum(-m / i1 * dot(a, b), a, along_n).map(|x| x / p);
        }
        "none" => 0.0,
        "linear" => (stiffness * depth - damping * v[2]).max(0.0),
        "hunt" => stiffness * depth.powf(1.5) * (1.0 - damping * v[2]).max(0.0),
        _ => b[2] / (dot(a, f) * a[2] / i1 - p),
    };
    f.map(|part| pushed * part)
}

fn main() {
    let folder = env::args().nth(1).unwrap_or("reference_data".into());
    let read = |path: &str| fs::read_to_string(format!("{folder}/{path}")).expect(path);
    let (vectors, mut states, mut worst) = (read("vectors/states.json"), 0, 0.0_f64);
    for case in vectors.split("\"name\": \"").skip(1) {
        let off = sum(-1.0, vector(case, "F"), force(case));
        let size = dot(off, off).sqrt() / number(case, "m") / number(case, "g");
        let missed = f64::from(u8::from(size < 1e-9)); // an invalid case has to differ
        worst = worst.max(if case.contains("\"invalid\"") { missed } else { size });
        states += 1;
    }
    let rows = read("reference/trajectory.csv");
    let lines: Vec<&str> = rows.trim().split('\n').collect();
    let last: Vec<&str> = lines[lines.len() - 1].split(',').collect();
    let k = [1, 2, 3].map(|i| last[i].parse::<f64>().expect("t, kx, ky, kz come first"));
    println!("{states} states, {} rows: {worst:e}", lines.len() - 1);
    exit(i32::from(states == 0 || worst > 1e-12 || (dot(k, k) - 1.0).abs() > 1e-15));
}
