//! Varies one value of a built-in sensor and computes a consequence, without writing a file:
//! `cargo run --release -p fabkit-application --example sweep_gel`.

use std::error::Error;

use fabkit_application::designs::{builtin_yaml, parameters::InvalidDesign};
use fabkit_application::fixtures;
use fabkit_application::geometry::{CompiledSolid, measure::ray_volume};

/// Number of rays for a volume; its relative error is about 1e-4.
const LINES: u32 = 20_000;

/// Computes the volume of R-Tac0's translucent gel for each thickness, cm3, or returns why there is no such sensor.
pub fn run(thicknesses: &[&str]) -> Result<Vec<Result<f64, InvalidDesign>>, Box<dyn Error>> {
    let yaml = builtin_yaml("rtac0").ok_or("no such sensor")?;
    let volume = |thickness: &&str| {
        let set = [format!("translucent_gel.thickness={thickness}")];
        // Equivalent to `fabkit show rtac0 --set translucent_gel.thickness=2mm`.
        let design = match fixtures::load("rtac0.yaml", yaml, &set) {
            Ok(project) => project.design,
            Err(invalid) => return Ok(Err(invalid)),
        };
        let gel = design.sensor.body("translucent-gel").ok_or("no such layer")?;
        let volume = ray_volume(&CompiledSolid::new(&gel.solid)?, LINES)?;
        Ok(Ok(volume.value_mm3 / 1e3))
    };
    thicknesses.iter().map(volume).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let thicknesses = ["1.4 mm", "1.5 mm", "1.6 mm", "0.7 mm"];
    for (thickness, volume) in thicknesses.iter().zip(run(&thicknesses)?) {
        match volume {
            Ok(cm3) => println!("{thickness}: {cm3:.2} cm3 of gel"),
            // All problems at once, each with its remedy.
            Err(invalid) => {
                for problem in invalid.problems {
                    let hint = problem.hint.unwrap_or_default();
                    println!("{thickness}: {}; {hint}", problem.message);
                }
            }
        }
    }
    Ok(())
}
