//! Presses a layered pad or dome described in JSON on standard input, and prints what it does as JSON.
//!
//! ```sh
//! echo '{"radius_mm": 12, "layers": [{"young_mpa": 0.07, "poisson": 0.495, "thickness_mm": 1.5}],
//!        "presser": {"ball_mm": 4}, "depth_mm": 0.5, "spacing_mm": 0.1}' |
//!     cargo run --release -p fabkit-elastic --example press_json
//! ```
//!
//! `presser` is `{"ball_mm": R}` or `{"pin_mm": R}`, a rod with a round end. Optional: `max_harmonic` (0: the axis
//! alone), `at_mm` ([x, y] of the presser), `reach_mm` (how far from the pole nodes are that fine).

use std::error::Error;
use std::io::Read;
use std::time::Instant;

use fabkit_elastic::{Body, Division, Layer, Material, Outcome, Press, SolidPresser, Stack};
use fabkit_geometry::{CompiledSolid, Pose, Solid, Vector3};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text)?;
    let asked: Value = serde_json::from_str(&text)?;
    let number = |key: &str| asked[key].as_f64().ok_or_else(|| format!("{key} is missing"));

    let mut layers = Vec::new();
    for layer in asked["layers"].as_array().ok_or("layers are missing")? {
        let number = |key: &str| layer[key].as_f64().ok_or_else(|| format!("a layer lacks {key}"));
        let material = Material::new(number("young_mpa")?, number("poisson")?)?;
        let name = format!("layer {}", layers.len() + 1);
        layers.push((Layer { name, material }, number("thickness_mm")?));
    }
    let body = Body::pad(number("radius_mm")?, layers);
    let max_harmonic = asked["max_harmonic"].as_u64().unwrap_or(0) as usize;
    let division = Division {
        reach_mm: asked["reach_mm"].as_f64().unwrap_or(f64::INFINITY),
        growth: 1.15,
        ..Division::even(number("spacing_mm")?, max_harmonic)
    };
    let start = Instant::now();
    let stack = Stack::new(&body, &division, 1)?;
    let setup_s = start.elapsed().as_secs_f64();

    let at = |i: usize| asked["at_mm"][i].as_f64().unwrap_or(0.0);
    let solid = match (asked["presser"]["ball_mm"].as_f64(), asked["presser"]["pin_mm"].as_f64()) {
        (Some(radius_mm), _) => Solid::sphere(radius_mm).at(0.0, 0.0, radius_mm),
        (_, Some(radius_mm)) => {
            Solid::sphere(radius_mm).plus(Solid::cylinder(radius_mm, 20.0)).at(0.0, 0.0, radius_mm)
        }
        _ => return Err("presser is missing: ball_mm or pin_mm".into()),
    };
    let presser =
        SolidPresser::new(CompiledSolid::new(&solid)?, &Pose::translation(at(0), at(1), 50.0));
    let press = Press::along(-Vector3::z(), number("depth_mm")?)?;
    let start = Instant::now();
    let outcome = stack.press(&presser, &press)?;
    let press_s = start.elapsed().as_secs_f64();
    println!("{}", described(&stack, &outcome, setup_s, press_s));
    Ok(())
}

fn described(stack: &Stack, outcome: &Outcome, setup_s: f64, press_s: f64) -> Value {
    // Along the ray at azimuth 0: what an axisymmetric solution can be compared with.
    let profile = |interface: usize| {
        let at = |s: &f64| {
            let place = outcome.place_mm(interface, 0.0, *s);
            let moved = outcome.displacement_mm(interface, 0.0, *s);
            json!([place.x, place.z, moved.x, moved.z])
        };
        outcome.columns().iter().map(at).collect::<Vec<Value>>()
    };
    json!({
        "contact_level": outcome.level.name(),
        "force_n": outcome.force_n.as_slice(),
        "moment_nmm": outcome.moment_nmm.as_slice(),
        "contact_radius_mm": outcome.contact_radius_mm,
        "contact_area_mm2": outcome.contact_area_mm2,
        "max_indentation_mm": outcome.max_indentation_mm,
        "bulge_mm": outcome.bulge_mm,
        "volume_change_mm3": outcome.volume_change_mm3,
        "surface_nodes": stack.surface_nodes(),
        "iterations": outcome.iterations,
        "setup_s": setup_s,
        "press_s": press_s,
        "profiles": (0..outcome.interfaces()).map(profile).collect::<Vec<Vec<Value>>>(),
    })
}
