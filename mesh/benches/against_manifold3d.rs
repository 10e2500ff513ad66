//! Builds the scenes here and with manifold3d in Python, in turns, and prints the ratio of the
//! median times. Both times cover building the part and making the bytes of a binary STL.
//!
//! `cargo bench -p fabkit-mesh`; `FABKIT_PYTHON` names a Python that has manifold3d and numpy.

mod scenes;

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

use fabkit_mesh::{DEFAULT_TOLERANCE_MM, PrintMesh, mesh};
use scenes::Scene;

/// Runs of each side; the first warms up and does not count.
const RUNS: usize = 8;

/// One way to build a scene.
struct Run {
    seconds: f64,
    volume_mm3: f64,
    triangles: usize,
}

fn binary_stl(mesh: &PrintMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles().len() as u32).to_le_bytes());
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|v| mesh.vertices()[v as usize]);
        let (u, v): ([f32; 3], [f32; 3]) =
            (std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i]));
        let normal =
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = normal.iter().map(|n| n * n).sum::<f32>().sqrt().max(f32::MIN_POSITIVE);
        for value in normal.map(|n| n / length).iter().chain(&a).chain(&b).chain(&c) {
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn here(scene: &Scene) -> Run {
    let start = Instant::now();
    let triangles = mesh(&scene.solid, DEFAULT_TOLERANCE_MM).expect("the scene is a solid");
    let file = triangles.to_print().expect("the scene can be printed");
    let bytes = binary_stl(&file);
    let seconds = start.elapsed().as_secs_f64();
    let triangles = (bytes.len() - 84) / 50;
    Run { seconds, volume_mm3: file.volume_mm3(), triangles }
}

/// manifold3d in a Python that stays alive, so that its start is not part of the time.
struct Peer {
    process: Child,
}

impl Peer {
    fn start() -> Option<Self> {
        let python = std::env::var("FABKIT_PYTHON").unwrap_or_else(|_| "python3".into());
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/manifold3d_scenes.py");
        let has_it = Command::new(&python).args(["-c", "import manifold3d, numpy"]).output();
        if !has_it.is_ok_and(|output| output.status.success()) {
            return None;
        }
        let mut command = Command::new(python);
        command.arg(script).stdin(Stdio::piped()).stdout(Stdio::piped());
        command.spawn().ok().map(|process| Self { process })
    }

    fn build(&mut self, scene: &Scene) -> Option<Run> {
        writeln!(self.process.stdin.as_mut()?, "{}", scene.name).ok()?;
        let mut line = String::new();
        BufReader::new(self.process.stdout.as_mut()?).read_line(&mut line).ok()?;
        let mut words = line.split_whitespace();
        let seconds = words.next()?.parse().ok()?;
        let volume_mm3 = words.next()?.parse().ok()?;
        Some(Run { seconds, volume_mm3, triangles: words.next()?.parse().ok()? })
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        drop(self.process.stdin.take());
        let _ = self.process.wait();
    }
}

fn report(name: &str, scene: &Scene, runs: &[Run]) -> f64 {
    let mut seconds: Vec<f64> = runs.iter().skip(1).map(|r| r.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let median = seconds[seconds.len() / 2];
    let error = runs[0].volume_mm3 / scene.exact_mm3 - 1.0;
    println!(
        "  {name:<10} {:8.1} ms  {:6} triangles  volume {:.4} mm3, {error:+.1e} of the exact",
        median * 1e3,
        runs[0].triangles,
        runs[0].volume_mm3
    );
    median
}

fn main() {
    // `cargo test --benches` asks only whether it runs.
    let runs = if std::env::args().any(|a| a == "--bench") { RUNS } else { 2 };
    let mut peer = Peer::start();
    for scene in scenes::all() {
        println!("{} at {DEFAULT_TOLERANCE_MM} mm, median of {} runs", scene.name, runs - 1);
        let (mut ours, mut theirs) = (Vec::new(), Vec::new());
        for _ in 0..runs {
            ours.push(here(&scene));
            theirs.extend(peer.as_mut().and_then(|p| p.build(&scene)));
        }
        let fabkit = report("fabkit", &scene, &ours);
        if theirs.len() == ours.len() {
            let other = report("manifold3d", &scene, &theirs);
            println!("  ratio {:.2}", fabkit / other);
        } else {
            println!("  manifold3d is not there: pip install manifold3d numpy, set FABKIT_PYTHON");
        }
    }
}
