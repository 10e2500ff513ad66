//! The pose solver beside OpenCV's `fisheye.solvePnP` on the same pixels: accuracy, and the median
//! time of one solve.
//!
//! `cargo bench -p fabkit-calibration`; `FABKIT_PYTHON` names a Python that has
//! `opencv-python-headless` and numpy.

#[path = "../tests/solver/support/trials.rs"]
mod trials;

use std::error::Error;
use std::io::Write;
use std::process::{Command, Stdio};
use std::time::Instant;

use fabkit_calibration::extrinsics::{Loss, solve_pose};
use fabkit_calibration::model::Observation;
use fabkit_geometry::sequences::SplitMix64;
use nalgebra::Vector3;
use serde_json::{Value, json};
use trials::{RANGES, camera, position, trial};

const TRIALS: usize = 1000;
const PEER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peers/opencv_pnp.py");

fn main() -> Result<(), Box<dyn Error>> {
    let camera = camera();
    let intrinsics = camera.lens().intrinsics();
    println!("{TRIALS} trials, 40 points on a 15 mm dome, {} px", trials::SIGMA_PX);
    for (depth_mm, _) in RANGES {
        let mut noise = SplitMix64::new(7);
        let cases: Vec<_> = (0..TRIALS).map(|_| trial(&camera, depth_mm, &mut noise)).collect();
        let mut micros = Vec::with_capacity(TRIALS);
        let mut solve = |(_, observations): &(_, Vec<Observation>)| {
            let start = Instant::now();
            let fit = solve_pose(&camera, observations, None, Loss::Squares);
            micros.push(start.elapsed().as_secs_f64() * 1e6);
            Some(position(&fit.ok()?.model.camera_from_sensor))
        };
        let ours: Vec<Option<Vector3<f64>>> = cases.iter().map(&mut solve).collect();
        micros.sort_by(f64::total_cmp);
        let micros = micros[TRIALS / 2];
        let truth: Vec<Vector3<f64>> = cases.iter().map(|(pose, _)| position(pose)).collect();
        println!("\nrim at {:.0} degrees", 15f64.atan2(depth_mm).to_degrees());
        print_row("fabkit", &truth, &ours, micros);
        let scene = json!({
            "camera_matrix": [
                [intrinsics.fx_px, 0.0, intrinsics.cx_px],
                [0.0, intrinsics.fy_px, intrinsics.cy_px],
                [0.0, 0.0, 1.0],
            ],
            "distortion": camera.lens().coefficients(),
            "trials": cases.iter().map(|(_, observations)| json!({
                "points": observations.iter().map(|o| <[f64; 3]>::from(o.contact.contact_in_sensor_mm)).collect::<Vec<_>>(),
                "pixels": observations.iter().map(|o| [o.pixel.x, o.pixel.y]).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
        });
        let answer = ask_peer(&scene)?;
        let methods = answer["methods"].as_object().ok_or("no methods")?;
        for (name, result) in methods {
            let positions: Vec<Option<[f64; 3]>> =
                serde_json::from_value(result["positions"].clone())?;
            let found: Vec<Option<Vector3<f64>>> =
                positions.into_iter().map(|p| p.map(Vector3::from)).collect();
            let name = format!("OpenCV {} {name}", answer["opencv"].as_str().unwrap_or("?"));
            print_row(&name, &truth, &found, result["micros"].as_f64().unwrap_or(f64::NAN));
        }
    }
    Ok(())
}

fn print_row(name: &str, truth: &[Vector3<f64>], found: &[Option<Vector3<f64>>], micros: f64) {
    let mut errors: Vec<f64> = truth
        .iter()
        .zip(found)
        .map(|(truth, found)| found.map_or(f64::INFINITY, |found| (found - truth).norm()))
        .collect();
    errors.sort_by(f64::total_cmp);
    let failed = found.iter().filter(|found| found.is_none()).count();
    let (median, high) = (errors[errors.len() / 2], errors[errors.len() * 95 / 100]);
    println!(
        "  {name:24} median {median:9.4} mm  95 % {high:9.4} mm  {failed:4} failed  {micros:7.0} us"
    );
}

fn ask_peer(scene: &Value) -> Result<Value, Box<dyn Error>> {
    let python = std::env::var("FABKIT_PYTHON").unwrap_or_else(|_| "python3".into());
    let mut peer = Command::new(&python)
        .arg(PEER)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|e| format!("{python}: {e}"))?;
    let mut input = peer.stdin.take().ok_or("no standard input")?;
    writeln!(input, "{scene}")?;
    drop(input);
    let output = peer.wait_with_output()?;
    if !output.status.success() {
        return Err("the Python peer failed; does it have opencv-python-headless?".into());
    }
    Ok(serde_json::from_slice(&output.stdout)?)
}
