//! Compares small strain with large strain on every built-in sensor by indentation: the table of the book.
//!
//! ```sh
//! cargo run --release --workspace --example sensor_levels -- [DIAMETER_MM]
//! ```
//!
//! A ball is pressed into the tip, or the middle of the pad. Each row: indentation; force by both models, and the
//! relative error of the linear one; bulge by both. Then the indentation at which the linear force is 10 % off.

use std::error::Error;
use std::f64::consts::PI;

use fabkit_application::designs::{builtin_names, builtin_yaml};
use fabkit_application::fixtures::load;
use fabkit_elastic::{
    BallIndenter, BoundaryCondition, ElasticLayer, ElasticMaterial, ElasticStack, FiniteStack,
    LayeredBody, LiquidStack, MeshDensity, Press, PressOutcome, SoftStack,
};
use fabkit_geometry::{LiquidSkin, Point3, Sensor, TouchSurface, Vector3};

/// Relative error of the linear force that is reported.
const OFF: f64 = 0.1;
const STEPS: u32 = 8;

fn main() -> Result<(), Box<dyn Error>> {
    let diameter_mm = std::env::args().nth(1).map_or(Ok(8.0), |text| text.parse::<f64>())?;
    for sensor in builtin_names() {
        let yaml = builtin_yaml(sensor).ok_or("no such sensor")?;
        let project = load(&format!("{sensor}.yaml"), yaml, &[])?;
        let sensor = &project.design.sensor;
        let Some(touch) = &sensor.touch else {
            match &sensor.liquid {
                Some(skin) => plate(sensor, skin, diameter_mm)?,
                None => println!("{}: no surface of known shape", sensor.name),
            }
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
        let deepest_mm = touch.max_indentation_mm().min(0.45 * diameter_mm);
        rows(deepest_mm, |depths| Ok(soft.press_tip_both(0.5 * diameter_mm, depths)?));
    }
    Ok(())
}

/// Presses a round plate in place of a skin with liquid channels: the plate has the window's area and the skin's
/// thickness, is held at its rim, and has no channels, because the large-strain model is axisymmetric.
fn plate(sensor: &Sensor, skin: &LiquidSkin, diameter_mm: f64) -> Result<(), Box<dyn Error>> {
    let layers = LiquidStack::from_sensor(sensor, 3.0)?.layers;
    let top = layers.first().ok_or("no layers")?;
    let [x, y] = skin.window_mm;
    let (radius_mm, levels) = ((x * y / PI).sqrt(), &skin.levels_mm);
    let thickness_mm = levels.last().unwrap_or(&0.0) - levels.first().unwrap_or(&0.0);
    let material = ElasticMaterial::new(top.elasticity.young_mpa, top.elasticity.poissons_ratio)?;
    println!(
        "{}, a round plate instead of its skin: {thickness_mm:.2} mm of {}, {radius_mm:.1} mm in radius",
        sensor.name, top.material
    );
    let layer = ElasticLayer { name: "plate".to_owned(), material };
    let body = LayeredBody {
        inner: BoundaryCondition::Free,
        is_rim_bonded: true,
        ..LayeredBody::pad(radius_mm, vec![(layer, thickness_mm)])
    };
    let radius_mm = 0.5 * diameter_mm;
    let ball = BallIndenter::new(Point3::new(0.0, 0.0, thickness_mm + radius_mm + 1.0), radius_mm)?;
    rows(thickness_mm.min(0.9 * diameter_mm), |depths| {
        let deepest_mm = depths.iter().copied().fold(0.0, f64::max);
        let cut_mm =
            (deepest_mm.min(radius_mm) * (2.0 * radius_mm - deepest_mm.min(radius_mm))).sqrt();
        let division = MeshDensity::around_pole(cut_mm / 16.0, 2.5 * cut_mm, 0);
        let stack = ElasticStack::new(&body, &division, 1)?;
        let finite = FiniteStack::new(&body, &division)?.press(&ball, depths)?;
        let both = depths.iter().zip(finite).map(|(depth_mm, finite)| {
            let press = Press::along(-Vector3::z(), *depth_mm)?;
            Ok([stack.press(&ball, &press)?, finite])
        });
        both.collect()
    });
    Ok(())
}

/// Prints a row for each indentation.
fn rows(
    deepest_mm: f64,
    levels: impl Fn(&[f64]) -> Result<Vec<[PressOutcome; 2]>, Box<dyn Error>>,
) {
    // Each row solves all indentations up to its own. If one does not converge, the table ends there, not the program.
    let mut before: Option<(f64, f64)> = None;
    let mut is_off = false;
    for i in 1..=STEPS {
        let depths: Vec<f64> =
            (1..=i).map(|k| deepest_mm * f64::from(k) / f64::from(STEPS)).collect();
        let depth_mm = depths[depths.len() - 1];
        let both = match levels(&depths) {
            Ok(both) => both,
            Err(error) => {
                println!("  {depth_mm:.2} mm: {error}");
                break;
            }
        };
        let [linear, finite] = &both[both.len() - 1];
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
            println!("  linear force 10 % off at {:.2} mm", from_mm + part * (depth_mm - from_mm));
        }
        before = Some((depth_mm, off.abs()));
    }
}
