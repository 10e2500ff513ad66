//! Compares meshing with and without the boolean kernel for small features: time and triangles of all printed parts and
//! molds of some sensors, and whether the results can be printed.
//!
//! `cargo run --release -p fabkit-application --example conforming -- rtac0 shadowtac`

use std::time::{Duration, Instant};

use fabkit_application::geometry::Solid;
use fabkit_application::mesh::{MeshError, TriMesh, mesh, mesh_by_booleans};
use fabkit_application::source::Target;

/// Chord tolerance of exports.
const TOLERANCE_MM: f64 = fabkit_application::mesh::DEFAULT_TOLERANCE_MM;

struct Outcome {
    time: Duration,
    triangles: usize,
    volume_mm3: f64,
    is_printable: bool,
}

/// Meshes a solid three times and returns the shortest run; the mesh is the same each time.
fn measured(solid: &Solid, by: fn(&Solid, f64) -> Result<TriMesh, MeshError>) -> Option<Outcome> {
    let mut best = None;
    for _ in 0..3 {
        let start = Instant::now();
        let made = by(solid, TOLERANCE_MM).ok()?;
        let print = made.to_print();
        let time = start.elapsed();
        if best.as_ref().is_none_or(|b: &Outcome| time < b.time) {
            let (triangles, volume_mm3) = (made.triangles.len(), made.volume_mm3());
            best = Some(Outcome { time, triangles, volume_mm3, is_printable: print.is_ok() });
        }
    }
    best
}

fn shown(outcome: &Option<Outcome>) -> String {
    match outcome {
        None => "fails".into(),
        Some(o) => {
            let print = if o.is_printable { "" } else { ", cannot be printed" };
            format!("{:9.2} ms {:8} triangles{print}", 1e3 * o.time.as_secs_f64(), o.triangles)
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let design = Target::new(&name).design(&[])?;
        let mut sums = [[0.0; 2]; 2];
        for part in design.sensor.parts() {
            let both = [measured(&part.solid, mesh), measured(&part.solid, mesh_by_booleans)];
            for (sum, outcome) in sums.iter_mut().zip(&both) {
                if let Some(o) = outcome {
                    *sum = [sum[0] + 1e3 * o.time.as_secs_f64(), sum[1] + o.triangles as f64];
                }
            }
            let volumes = match &both {
                [Some(a), Some(b)] => format!("{:+.1e}", a.volume_mm3 / b.volume_mm3 - 1.0),
                _ => String::new(),
            };
            let [conforming, booleans] = both.each_ref().map(shown);
            println!("{name}/{:34} {conforming} | {booleans} | volume {volumes}", part.name);
        }
        let [[ours_ms, ours], [theirs_ms, theirs]] = sums;
        println!(
            "{name}: {ours_ms:.0} ms and {ours} triangles conforming, {theirs_ms:.0} ms and {theirs} by \
             booleans alone: {:.1} times, {:.2} times\n",
            theirs_ms / ours_ms,
            theirs / ours
        );
    }
    Ok(())
}
