//! How far small strain is from large strain on every built-in sensor, by depth: the table of the book.
//!
//! ```sh
//! cargo run --release --workspace --example sensor_levels -- [DIAMETER_MM]
//! ```
//!
//! A ball comes down on the tip, or on the middle of the pad. Each row: depth; force by both levels, and how far the
//! linear one is off; bulge by both. Then the depth at which the linear force is 10 % off.

use fabkit_application::designs::{builtin_names, builtin_yaml};
use fabkit_application::fixtures::load;
use fabkit_elastic::SoftStack;
use fabkit_geometry::TouchSurface;

/// What counts as off.
const OFF: f64 = 0.1;
const STEPS: u32 = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let diameter_mm = std::env::args().nth(1).map_or(Ok(8.0), |text| text.parse::<f64>())?;
    for sensor in builtin_names() {
        let yaml = builtin_yaml(sensor).ok_or("no such sensor")?;
        let project = load(&format!("{sensor}.yaml"), yaml, &[])?;
        let sensor = &project.design.sensor;
        let Some(touch) = &sensor.touch else {
            println!("{}: no surface of known shape", sensor.name);
            continue;
        };
        let soft = match SoftStack::at_tip(sensor) {
            Ok(soft) => soft,
            Err(error) => {
                println!("{}: {error}", sensor.name);
                continue;
            }
        };
        let round = matches!(touch, TouchSurface::Dome(_));
        let layers: Vec<String> = soft
            .layers
            .iter()
            .map(|layer| format!("{:.2} mm of {}", layer.thickness_mm, layer.material))
            .collect();
        let what = if round { "tip" } else { "middle" };
        println!("{}, {what}: {}", sensor.name, layers.join(", "));
        // One depth more at a time: what does not converge ends the table, not the program.
        let deepest_mm = touch.soft_mm().min(0.45 * diameter_mm);
        let mut before: Option<(f64, f64)> = None;
        let mut is_off = false;
        for i in 1..=STEPS {
            let depths: Vec<f64> =
                (1..=i).map(|k| deepest_mm * f64::from(k) / f64::from(STEPS)).collect();
            let depth_mm = depths[depths.len() - 1];
            let levels = match soft.levels(0.5 * diameter_mm, &depths) {
                Ok(levels) => levels,
                Err(error) => {
                    println!("  {depth_mm:.2} mm: {error}");
                    break;
                }
            };
            let [linear, finite] = &levels[levels.len() - 1];
            let off = linear.force_n.z / finite.force_n.z - 1.0;
            println!(
                "  {depth_mm:.2} mm: {:.3} N linear, {:.3} N finite, {:+.1} %; bulge {:.3} mm, {:.3} mm",
                -linear.force_n.z,
                -finite.force_n.z,
                100.0 * off,
                linear.bulge_mm,
                finite.bulge_mm
            );
            if off.abs() > OFF && !is_off {
                is_off = true;
                let (from_mm, from) = before.unwrap_or((0.0, 0.0));
                let part = (OFF - from) / (off.abs() - from);
                println!(
                    "  linear force 10 % off at {:.2} mm",
                    from_mm + part * (depth_mm - from_mm)
                );
            }
            before = Some((depth_mm, off.abs()));
        }
    }
    Ok(())
}
