// Reads the reference data from Rust: the index, a file of test vectors, a trajectory; and computes
// the force of every state that glides on a rigid table with ten lines of physics.
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

// What stands behind the first `key` of a JSON text, up to the end of the list or of the line.
fn behind<'a>(text: &'a str, key: &str) -> &'a str {
    let quoted = format!("\"{key}\": ");
    let at = text.find(&quoted).unwrap_or_else(|| panic!("no {key}")) + quoted.len();
    let rest = &text[at..];
    let end = if rest.starts_with('[') { rest.find(']') } else { rest.find('\n') };
    &rest[..end.unwrap_or(rest.len())]
}

fn numbers(text: &str, key: &str) -> Vec<f64> {
    let strings = behind(text, key).split('"').skip(1).step_by(2);
    strings.map(|one| one.parse().unwrap_or_else(|_| panic!("{key}: {one}"))).collect()
}

fn number(text: &str, key: &str) -> f64 {
    numbers(text, key)[0]
}

fn vector(text: &str, key: &str) -> Vector {
    numbers(text, key).try_into().expect("three numbers")
}

// F = g_n (z - c v_A) at the contact point; c is mu, mu/|v_A| or regularised.
fn force(text: &str, law: &str) -> Vector {
    let names = ["m", "R", "alpha", "I1", "I3", "g", "mu"];
    let [m, r, alpha, i1, i3, g, mu] = names.map(|name| number(text, name));
    let (k, omega) = (vector(text, "k"), vector(text, "omega"));
    let l = sum((i3 - i1) * dot(omega, k), k, omega.map(|x| i1 * x));
    let a = sum(r * alpha, k, [0.0, 0.0, -r]);
    let v = sum(1.0, vector(text, "s_dot"), cross(omega, a));
    let epsilon = if law == "regularised" { number(text, "epsilon") } else { 0.0 };
    let c = if law == "viscous" { mu } else { mu / v[0].hypot(v[1]).hypot(epsilon) };
    let f = [-c * v[0], -c * v[1], 1.0];
    let (swung, driven) = (cross(l, cross(omega, k))[2], cross(cross(a, f), k)[2]);
    let lever = m * r * alpha;
    f.map(|part| part * (m * g * i1 - lever * swung) / (i1 + lever * driven))
}

fn main() {
    let folder = env::args().nth(1).unwrap_or("reference_data".into());
    let read = |path: &str| fs::read_to_string(format!("{folder}/{path}")).expect(path);
    let files = read("index.json").matches("\"path\": ").count();
    let (vectors, mut states, mut worst) = (read("vectors/states.json"), 0, 0.0_f64);
    for case in vectors.split("\"body\": {").skip(1) {
        let law = behind(case, "law").split('"').nth(1).expect("a law");
        let rigid = case.contains("\"rigid\""); // elsewhere: flight, elastic tables
        if rigid && law != "rolling" && law != "sticking" {
            let known = vector(&case[case.find("\"expected\"").expect("expected")..], "F");
            let off = sum(-1.0, known, force(case, law));
            worst = worst.max(dot(off, off).sqrt() / known[2]);
            states += 1;
        }
    }
    let rows = read("reference/trajectory.csv");
    let last: Vec<&str> = rows.trim().rsplit('\n').next().expect("rows").split(',').collect();
    let k = [1, 2, 3].map(|i| last[i].parse::<f64>().expect("t, kx, ky, kz come first"));
    println!("{files} files, {states} states: {worst:e}");
    exit(i32::from(states == 0 || worst > 1e-12 || (dot(k, k) - 1.0).abs() > 1e-15));
}
